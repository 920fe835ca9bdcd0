"""Frozen numbers of the columns that a law takes which learns the load's torque."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
TORQUES = 3
"""Friction of Coulomb, viscous friction, inertia."""


class LoadRowNumbers(NamedTuple):
    """How columns follow from a wanted motion; without elements where a law has none.

    Attributes
    ----------
    sign : ndarray, shape (r, 2h + 1)
        Weights that smooth the sign of the speed over the samples around, and give its derivatives.
    lags, sources : ndarray
        Filters of the chain's dampers, as of `cabledrive.control.reference_numbers.ReferenceNumbers`.
    output : ndarray, shape (2n + 1, (l + 1) r)
        Angles, speeds and motor torque that a torque of the load asks for, from all stages.
    transition : ndarray, shape (states, states + 1)
        Of the filter; the last column is what a torque of the load does between two samples.
    seen : ndarray, shape (m, states)
        Readings from the filter's states.
    gains : ndarray, shape (states, m)
        On which the filter settles.
    chosen : ndarray of int, shape (2n,)
        States of the filter that the law takes.
    white : ndarray, shape (m, m)
        What makes innovations white.
    scalars : ndarray, shape (2,)
        Sample time [s]; K of tanh(K w / largest w).
    """

    sign: Array
    lags: Array
    sources: Integers
    output: Array
    transition: Array
    seen: Array
    gains: Array
    chosen: Integers
    white: Array
    scalars: Array

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
