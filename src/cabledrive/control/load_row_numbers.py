"""Frozen numbers of the columns that a law takes which learns the load's torque."""

from typing import NamedTuple

import numpy as np

from cabledrive.parameters.arrays import Array, Integers

TORQUES = 3
"""Friction of Coulomb, viscous friction, inertia."""


class LoadRowNumbers(NamedTuple):
    """How columns follow from a wanted motion; without elements where a law has none."""

    sign: Array
    """(r, 2h + 1): weights that smooth the sign of the speed over samples around, and its derivatives."""
    lags: Array  # filters of the chain's dampers, as of `reference_numbers.ReferenceNumbers`
    sources: Integers  # of these filters
    output: Array
    """(2n + 1, (l + 1) r): angles, speeds and motor torque that a torque of the load asks for, from all
    stages."""
    transition: Array
    """(states, states + 1): of the filter; the last column is what a torque of the load does between two
    samples."""
    seen: Array  # (m, states): readings from the filter's states
    gains: Array  # (states, m): on which the filter settles
    chosen: Integers  # (2n,): states of the filter that the law takes
    white: Array  # (m, m): what makes innovations white
    scalars: Array  # (2,): sample time [s]; K of tanh(K w / largest w)

    @property
    def columns(self) -> int:
        """How many columns there are."""
        return TORQUES * (len(self.chosen) + 1 + len(self.white)) if len(self.sign) else 0

    @property
    def turning(self) -> float:
        """Time over which the sign turns [s]; zero where there is none."""
        return float((self.sign.shape[1] - 1) * self.scalars[0]) if len(self.sign) else 0.0


class LoadRowState(NamedTuple):
    """What the generator keeps: signs about the next sample, torques now and next, filters, filter error.

    ``window`` (2h + 1,), ``now``, ``next`` (3, r), ``memory`` (3, l, r), ``error`` (3, states); scratch:
    ``stages`` (l + 1, r), ``wanted`` (r + 2,), ``innovation`` (m,), ``fresh`` (states,).
    """

    window: Array
    now: Array
    next: Array
    memory: Array
    stages: Array
    error: Array
    wanted: Array
    innovation: Array
    fresh: Array


NO_LOAD = LoadRowNumbers(
    sign=np.zeros((0, 0)),
    lags=np.zeros((0, 3)),
    sources=np.zeros(0, dtype=np.int64),
    output=np.zeros((0, 0)),
    transition=np.zeros((0, 0)),
    seen=np.zeros((0, 0)),
    gains=np.zeros((0, 0)),
    chosen=np.zeros(0, dtype=np.int64),
    white=np.zeros((0, 0)),
    scalars=np.zeros(0),
)


def new_load_row_state(load: LoadRowNumbers) -> LoadRowState:
    """A generator before its first row."""
    r, taps = load.sign.shape
    held = TORQUES if r else 0
    return LoadRowState(
        window=np.zeros(taps),
        now=np.zeros((held, r)),
        next=np.zeros((held, r)),
        memory=np.zeros((held, len(load.lags), r)),
        stages=np.zeros((len(load.lags) + 1 if r else 0, r)),
        error=np.zeros((held, len(load.transition))),
        wanted=np.zeros(r + 2 if r else 0),
        innovation=np.zeros(len(load.white)),
        fresh=np.zeros(len(load.transition)),
    )
