"""Frozen numbers of a reference generator: what makes a law's reference row from the time alone."""

from collections.abc import Sequence
from math import exp
from typing import NamedTuple

import numpy as np

from cabledrive.control.load_row_numbers import NO_LOAD, LoadRowNumbers, LoadRowState, new_load_row_state
from cabledrive.parameters.arrays import Array, Integers

AT_ONCE = ((0.0, 1.0),)


class ReferenceNumbers(NamedTuple):
    """How a row follows from the wanted load angle and its derivatives y to y^(K)."""

    taps: Array  # (t, 2): delay [s] and weight of each copy of the motion; of an input shaper two, else one
    lags: Array  # (l, 3): first-order filters, exact for lines: shares of newest and last value, fading
    sources: Integers  # (l,): stage of each filter's input: 0 is the motion, i the output of filter i - 1
    output: Array  # (columns, (l + 1) (K + 1)): the row from all stages, stage after stage
    constant: Array  # (columns,): what is added to the row
    friction: Array  # (f, 2): c [N m] and K [s/rad] of each Coulomb friction c tanh(K w), added to a column
    places: Integers  # (f, 2): that column, and the column of the speed w
    load: LoadRowNumbers = NO_LOAD  # further columns, of a law that learns the load's torque

    @property
    def columns(self) -> int:
        """Columns of a row."""
        return len(self.output) + self.load.columns

    @property
    def derivatives(self) -> int:
        """Highest derivative K of the load angle."""
        return self.output.shape[1] // (len(self.lags) + 1) - 1


class MotionNumbers(NamedTuple):
    """Pulses of the load: coefficients of the rise from the constant up; angle [rad], rise, dwell [s], count.

    The angle is at the first shaft.
    """

    coefficients: Array
    scalars: Array


class ReferenceState(NamedTuple):
    """What a generator keeps: whether it has begun, of each filter and derivative; and scratch, by stages."""

    begun: Integers
    memory: Array
    stages: Array
    load: LoadRowState


def lag_coefficients(time: float, interval: float) -> tuple[float, float, float]:
    """Shares of the newest and of the last value, and fading, of 1/(1 + T s) between samples."""
    if time == 0.0:
        return 1.0, 0.0, 0.0
    fading = exp(-interval / time)
    mean = time / interval * (1.0 - fading)
    return 1.0 - mean, mean - fading, fading


def reference_numbers(
    output: Array,
    times: Sequence[float] = (),
    interval: float = 1.0,
    *,
    sources: Sequence[int] | None = None,
    taps: Sequence[tuple[float, float]] = AT_ONCE,
    constant: Array | None = None,
    friction: Sequence[tuple[float, float, int, int]] = (),
) -> ReferenceNumbers:
    """Numbers of a generator; unless ``sources`` say else, each filter takes the one before it.

    ``output``, (columns, c): of all stages, or of the last one alone; ``times``: time constant of each filter
    [s]; ``friction``: c, K, column that it is added to, column of the speed, of each.
    """
    stages = len(times) + 1
    if sources is None:  # a series of filters, of which only the end is used
        output = np.hstack([np.zeros((len(output), (stages - 1) * output.shape[1])), output])
        sources = range(stages - 1)
    return ReferenceNumbers(
        taps=np.array(taps, dtype=float),
        lags=np.array([lag_coefficients(float(time), interval) for time in times]).reshape(-1, 3),
        sources=np.array(sources, dtype=np.int64),
        output=np.ascontiguousarray(output),
        constant=np.zeros(len(output)) if constant is None else constant,
        friction=np.array([one[:2] for one in friction], dtype=float).reshape(-1, 2),
        places=np.array([one[2:] for one in friction], dtype=np.int64).reshape(-1, 2),
    )


def new_reference_state(numbers: ReferenceNumbers) -> ReferenceState:
    """A generator at rest at angle zero."""
    width, lags = numbers.derivatives + 1, len(numbers.lags)
    begun = np.zeros(1, dtype=np.int64)
    return ReferenceState(
        begun=begun,
        memory=np.zeros((lags, width)),
        stages=np.zeros((lags + 1, width)),
        load=new_load_row_state(numbers.load),
    )
