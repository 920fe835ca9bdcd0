"""What the closed loop of the rig needs to run, as its compiled form takes it."""

from math import isfinite, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.control.controller_kernels import controller_step
from cabledrive.control.numbers import (
    ESTIMATES,
    ControllerState,
    LawNumbers,
    ObserverNumbers,
    new_controller_state,
)
from cabledrive.mechanics.compiled import njit_in_place, njit_part
from cabledrive.parameters.arrays import Array

Integers = NDArray[np.int64]
__all__ = ["ESTIMATES", "SUMMARY", "Array", "ControllerState", "Integers", "LoopState", "RigNumbers"]
DIVERGED, WENT_SLACK = 1, 2
SUMMARY = (
    "peak",
    "first_peak",
    "later_peak",
    "square",
    "peak_torque",
    "saturated",
    "invalid",
    "twist",
    "own_peak",
    "slack",
    "loose",
    "aside",
    "swing",
)


class RigNumbers(NamedTuple):
    """Sensors, actuator and disturbances.

    ``encoders`` (m,): inertia that each encoder reads; ``counts`` (m,): one count at the first shaft [rad],
    0: ideal; ``phases`` (m,): where in its count each encoder starts, from -1/2 to 1/2. ``torque_limit`` [N
    m]; ``late_samples`` and ``late_part`` [s]: the delay. ``jitter`` (samples,): how late each sample is
    taken [s]. ``forces`` (samples, 2): torque on motor and load from this sample to the next [N m].
    ``first_end``: sample at which the first pulse and its dwell are over. ``dropout``: sensor, first and last
    sample at which it gives NaN.
    """

    interval: float
    encoders: Integers
    counts: Array
    phases: Array
    torque_limit: float
    late_samples: int
    late_part: float
    jitter: Array
    forces: Array
    first_end: int
    dropout: Integers


class Control(NamedTuple):
    """What runs a plant: filter and law, sensors and limits, what the law follows, the wanted load angle."""

    observer: ObserverNumbers
    law: LawNumbers
    rig: RigNumbers
    reference: Array
    target: Array


class LoopState(NamedTuple):
    """Everything that moves, and scratch; arrays, so that a run can go on where another ended.

    ``x``: angles, speeds and shaft torque, then whatever else the plant keeps. ``discrete``: slip, and why
    the run ended (`DIVERGED`, `WENT_SLACK`; 0: it did not). ``controller``: what the controller keeps.
    """

    x: Array
    discrete: Integers
    controller: ControllerState
    readings: Array
    terms: Array
    work: Array
    summary: Array


def new_state(
    plant_states: int,
    observer: ObserverNumbers,
    law: LawNumbers,
    rig: RigNumbers,
    start: Array,
    memory: Array | None = None,
) -> LoopState:
    """A loop at rest at angle zero; ``start``: of the estimates; ``memory``: of a user's controller."""
    readings, own = len(rig.encoders), np.zeros(0) if memory is None else memory
    return LoopState(
        x=np.zeros(plant_states),
        discrete=np.zeros(2, dtype=np.int64),
        controller=new_controller_state(observer, law, readings, rig.late_samples, start, own),
        readings=np.zeros(readings),
        terms=np.zeros((5, plant_states)),
        work=np.zeros(plant_states),
        summary=np.zeros(len(SUMMARY)),
    )


@njit_in_place
def read_encoders(rig: RigNumbers, angles: Array, sample: int, readings: Array) -> None:
    """Angles in whole counts, each encoder with its own phase; NaN from one that drops out."""
    for j in range(readings.size):
        angle = angles[rig.encoders[j]]
        if rig.counts[j] > 0.0:
            readings[j] = rig.counts[j] * np.rint(angle / rig.counts[j] + rig.phases[j])
        else:
            readings[j] = angle
    if rig.dropout[0] >= 0 and rig.dropout[1] <= sample <= rig.dropout[2]:
        readings[rig.dropout[0]] = nan


@njit_in_place
def _put(row: Array, start: int, values: Array) -> int:
    for i in range(values.size):
        row[start + i] = values[i]
    return start + values.size


@njit_part
def finish_sample(
    c: Control, k: int, s: LoopState, log: Array, shafts: Array, issued: tuple[float, float, float]
) -> None:
    """Score and log of a sample: command wanted, limited command, sigma; ``shafts``: angles, speeds, torque.

    The score is that of `SUMMARY`.
    """
    counts, phases, score = c.rig.counts, c.rig.phases, s.summary
    error, (wanted, command, sigma) = shafts[shafts.size // 2 - 1] - c.target[k], issued
    part = 1 if k < c.rig.first_end else 2
    score[0] = max(score[0], abs(error))
    score[part] = max(score[part], abs(error))
    score[3] += error * error
    score[4] = max(score[4], abs(command))
    score[5] += 1.0 if wanted != command else 0.0
    score[8] = max(score[8], abs(error + counts[counts.size - 1] * phases[phases.size - 1]))
    if log.shape[0] > 0:
        row, kept = log[k], s.controller
        i = _put(row, _put(row, 0, shafts), s.readings)
        row[i], row[i + 1], row[i + 2] = command, s.discrete[0], sigma
        _put(row, _put(row, _put(row, i + 3, kept.parameters), kept.regressor), kept.states)


@njit_part
def sense(observer: ObserverNumbers, rig: RigNumbers, k: int, x: Array, s: LoopState) -> None:
    """Read the encoders at angles (and speeds) ``x``; ideal sensors and lost readings go into the states."""
    read_encoders(rig, x, k, s.readings)
    if observer.kind == 0:
        seen, states = True, s.controller.states
        for j in range(s.readings.size):
            seen = seen and isfinite(s.readings[j])
        for i in range(states.size):
            states[i] = x[observer.chosen[i]] if seen else nan


@njit_part
def decide(c: Control, k: int, x: Array, s: LoopState) -> tuple[float, float, float]:
    """Command wanted, limited command and sigma of one sample; without states the last command is kept."""
    sense(c.observer, c.rig, k, x, s)
    wanted, command, sigma, valid = controller_step(
        c.observer, c.law, c.rig.torque_limit, s.controller, s.readings, c.reference, k
    )
    if not valid:
        s.summary[6] += 1.0
    return wanted, command, sigma


@njit_in_place
def farthest(target: Array) -> float:
    """Load angle beyond which the plant has run away: ten times what is wanted, and 10 rad [rad]."""
    largest = 0.0
    for k in range(target.size):
        largest = max(largest, abs(target[k]))
    return 10.0 * (1.0 + largest)
