"""A controller as firmware calls it, compiled: start at any angle, hold on what is not a number.

`start_target` and `target_step` are what `cabledrive export` writes in C; the rig calls the step inside them.
"""

from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.control.controller_kernels import LAST_SAMPLE, controller_step, issue, observe
from cabledrive.control.controller_state import ControllerState, new_controller_state
from cabledrive.control.numbers import LawNumbers
from cabledrive.control.observer_numbers import ObserverNumbers
from cabledrive.control.reference_kernels import reference_row
from cabledrive.control.reference_numbers import MotionNumbers, ReferenceNumbers, ReferenceState
from cabledrive.mechanics.compiled import njit_part
from cabledrive.parameters.arrays import Array


class TargetState(NamedTuple):
    """A controller with what it keeps on a target.

    ``datum`` (m,): reading of each encoder at the start, NaN where there was none; ``readings`` (m,): less
    that; ``missed`` (1,): samples since a command was computed.
    """

    controller: ControllerState
    datum: Array
    readings: Array
    missed: NDArray[np.int64]


class PathState(NamedTuple):
    """A motion and the generator that follows it."""

    motion: MotionNumbers
    generator: ReferenceState


def new_target_state(observer: ObserverNumbers, law: LawNumbers, late_samples: int) -> TargetState:
    """A controller before its start; ``late_samples``: whole samples of the delay."""
    m, none = len(observer.output), np.zeros(0)
    controller = new_controller_state(observer, law, m, late_samples, none, none)
    return TargetState(controller, np.zeros(m), np.zeros(m), np.zeros(1, dtype=np.int64))


@njit_part
def start_target(start: Array, t: TargetState, readings: Array) -> None:
    """Start at rest at the angles read, which become zero; ``start``: estimates to begin with."""
    for i in range(start.size):
        t.controller.parameters[i] = start[i]
    for j in range(readings.size):
        t.datum[j] = readings[j]


@njit_part
def target_step(
    observer: ObserverNumbers,
    law: LawNumbers,
    limit: float,
    t: TargetState,
    readings: Array,
    reference: Array,
) -> tuple[float, bool]:
    """One sample: limited command [N m], and whether it was computed; else the last one is held.

    ``readings``, shape (m,): angles at the first shaft [rad]; ``reference``, shape (1, columns). A reading or
    a reference that is not finite holds the command; the filter goes on with it.
    """
    known = True
    for i in range(reference.shape[1]):
        known = known and isfinite(reference[0, i])
    for j in range(readings.size):
        if not isfinite(t.datum[j]) and isfinite(readings[j]):
            t.datum[j] = readings[j]
        t.readings[j] = readings[j] - t.datum[j]
    command, valid = 0.0, False
    if known:
        last = reference.shape[0] - 1  # the only row; a plain 0 would have all of the law compiled once more
        _, command, _, valid = controller_step(
            observer, law, limit, t.controller, t.readings, reference, last
        )
    else:
        observe(observer, t.controller, t.readings)
        _, command = issue(observer, limit, t.controller, 0.0, False)
    t.missed[0] = 0 if valid else min(t.missed[0] + 1, LAST_SAMPLE)
    return command, valid


@njit_part
def path_row(numbers: ReferenceNumbers, p: PathState, time: float, row: Array) -> None:
    """The reference row at a time [s], to be called once a sample; writes ``row``, shape (columns,)."""
    reference_row(numbers, p.motion, p.generator, time, row)
