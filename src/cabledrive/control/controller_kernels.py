"""The sampled controller, compiled: as the rig runs it and as firmware calls it.

One state, one step: readings and a reference in, a torque out. The rig reads the encoders and moves
the plant.

`start_target` and `target_step` are what `cabledrive export` writes in C; the rig calls the step inside them.
"""

from collections.abc import Callable
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.control.law_kernels import law_step
from cabledrive.control.load_schedule import announced_load, grid_place
from cabledrive.control.numbers import (
    SCHEDULED,
    ControllerState,
    LawNumbers,
    ObserverNumbers,
    new_controller_state,
)
from cabledrive.control.observers import correct, predict
from cabledrive.control.reference import MotionNumbers, ReferenceNumbers, ReferenceState
from cabledrive.control.reference_kernels import LAST_SAMPLE, reference_row
from cabledrive.mechanics.compiled import njit_in_place, njit_part
from cabledrive.parameters.arrays import Array


@njit_in_place
def place_of(observer: ObserverNumbers, c: ControllerState) -> float:
    """Place in the tables of a filter: number of the sample, or that of the announced load."""
    if observer.kind == 3:
        scalars = observer.scalars
        return grid_place(scalars[9], scalars[10], observer.gains.shape[0], 1.0 / c.parameters[0])
    return float(c.sample[0])


@njit_part
def observe(observer: ObserverNumbers, c: ControllerState, readings: Array) -> bool:
    """Angles and speeds from the readings, or as the rig wrote them; false where one is not a number."""
    if observer.kind != 0:
        correct(observer, place_of(observer, c), c.estimate, readings, c.states, c.work)
    c.sample[0] = min(c.sample[0] + 1, LAST_SAMPLE)
    seen = True
    for i in range(c.states.size):
        seen = seen and isfinite(c.states[i])
    return seen


@njit_part
def issue(
    observer: ObserverNumbers, limit: float, c: ControllerState, torque: float, valid: bool
) -> tuple[float, float]:
    """Limit the law's torque, or hold the last, and carry the filter on: command wanted, limited."""
    wanted = torque
    if valid:
        if observer.scalars[8] > 0.0:
            wanted -= c.estimate[observer.places[1]]
        c.held[1] = wanted
    else:
        wanted = c.held[1]
    command = min(max(wanted, -limit), limit)
    newest = c.commands.size - 1
    for i in range(newest):
        c.commands[i] = c.commands[i + 1]
    c.commands[newest] = command
    if observer.kind == 2:
        predict(observer, 0.0, c.estimate, c.held, c.commands, c.work)
    elif observer.kind == 3:
        predict(observer, place_of(observer, c), c.estimate, c.held, c.commands, c.work)
    return wanted, command


@njit_part
def controller_step(
    observer: ObserverNumbers,
    law: LawNumbers,
    limit: float,
    c: ControllerState,
    readings: Array,
    reference: Array,
    k: int,
) -> tuple[float, float, float, bool]:
    """One sample by row k: command wanted, limited command, sigma, and whether the law had states."""
    if law.kind == SCHEDULED:  # the filter goes by the load of this sample as well
        c.parameters[0] = announced_load(law, reference, k)
    observe(observer, c, readings)
    torque, sigma, valid = law_step(law, c, reference, k)
    wanted, command = issue(observer, limit, c, torque, valid)
    return wanted, command, sigma, valid


class TargetState(NamedTuple):
    """A controller with what it keeps on a target."""

    controller: ControllerState
    datum: Array  # (m,): reading of each encoder at the start, NaN where there was none
    readings: Array  # (m,): less that
    missed: NDArray[np.int64]  # (1,): samples since a command was computed
    memory: Array  # this and what follows: copies that the step of a user's own controller may change
    measurement: Array
    row: Array


class PathState(NamedTuple):
    """A motion and the generator that follows it."""

    motion: MotionNumbers
    generator: ReferenceState


def new_target_state(
    observer: ObserverNumbers, law: LawNumbers, late_samples: int, own: tuple[int, int, int] = (0, 0, 0)
) -> TargetState:
    """A controller before its start; ``own``: numbers that a user's keeps, measures and follows."""
    m, none, copies = len(observer.output), np.zeros(0), tuple(np.zeros(size) for size in own)
    controller = new_controller_state(observer, law, m, late_samples, none, np.zeros(own[0]))
    return TargetState(controller, np.zeros(m), np.zeros(m), np.zeros(1, dtype=np.int64), *copies)


@njit_part
def start_target(start: Array, t: TargetState, readings: Array) -> None:
    """Start at rest at the angles read, which become zero; ``start``: estimates or memory to begin with."""
    for i in range(start.size):
        if t.memory.size > 0:
            t.controller.memory[i] = start[i]
        else:
            t.controller.parameters[i] = start[i]
    for j in range(readings.size):
        t.datum[j] = readings[j]


@njit_part
def take_in(t: Any, readings: Array, reference: Array) -> bool:
    """Readings less the angles of the start, an encoder's first ones; whether the reference is finite."""
    known = True
    for i in range(reference.shape[1]):
        known = known and isfinite(reference[0, i])
    for j in range(readings.size):
        if not isfinite(t.datum[j]) and isfinite(readings[j]):
            t.datum[j] = readings[j]
        t.readings[j] = readings[j] - t.datum[j]
    return known


@njit_part
def target_step(
    observer: ObserverNumbers,
    law: LawNumbers,
    limit: float,
    t: TargetState,
    readings: Array,
    reference: Array,
) -> tuple[float, bool]:
    """One sample: limited command [N m], and whether it was computed; else the last one is held."""
    known = take_in(t, readings, reference)
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


def own_target_step(step: Any, filtered: bool) -> Callable[..., tuple[float, bool]]:
    """The kernel of a target around a step of the user's; ``filtered``: it takes states, not readings."""

    def own_step(
        observer: Any, own_gains: Any, limit: float, t: Any, readings: Array, reference: Array
    ) -> tuple[float, bool]:
        """One sample: limited command [N m], and whether it was computed; else the last one is held."""
        known = take_in(t, readings, reference)
        for j in range(readings.size):
            known = known and isfinite(t.readings[j])
        seen = observe(observer, t.controller, t.readings)
        torque, valid = 0.0, False
        if known and seen:
            for i in range(t.memory.size):
                t.memory[i] = t.controller.memory[i]
            for i in range(t.measurement.size):
                t.measurement[i] = t.controller.states[i] if filtered else t.readings[i]
            for i in range(t.row.size):
                t.row[i] = reference[0, i]
            fresh, torque = step(own_gains, t.memory, t.measurement, t.row)
            valid = isfinite(torque)
            for i in range(t.memory.size):
                valid = valid and isfinite(fresh[i])
            if valid:
                for i in range(t.memory.size):
                    t.controller.memory[i] = fresh[i]
        _, command = issue(observer, limit, t.controller, torque, valid)
        t.missed[0] = 0 if valid else min(t.missed[0] + 1, LAST_SAMPLE)
        return command, valid

    return own_step
