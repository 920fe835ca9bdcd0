"""Compiled parts of a sample that every plant of the rig shares: encoders, observer, law, score, log."""

from math import isfinite, nan

import numpy as np

from cabledrive.control.law_kernels import law_step
from cabledrive.control.numbers import LawNumbers
from cabledrive.control.observer_kernels import correct, predict
from cabledrive.control.observer_numbers import ObserverNumbers
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.rig.closed_loop.loop_numbers import Array, Integers, LoopState, RigNumbers


@njit_in_place
def read_encoders(
    encoders: Integers,
    counts: Array,
    phases: Array,
    blind: Integers,
    angles: Array,
    sample: int,
    readings: Array,
) -> None:
    """Angles in whole counts, each encoder with its own phase; NaN from one that is blind."""
    for j in range(readings.size):
        angle = angles[encoders[j]]
        if counts[j] > 0.0:
            readings[j] = counts[j] * np.rint(angle / counts[j] + phases[j])
        else:
            readings[j] = angle
    if blind[0] >= 0 and blind[1] <= sample <= blind[2]:
        readings[blind[0]] = nan


@njit_in_place
def keep_score(score: Array, early: bool, error: float, own: float, wanted: float, command: float) -> None:
    """Peaks and sums of a run, as `cabledrive.rig.closed_loop.loop_numbers.SUMMARY` names them."""
    size = abs(error)
    score[0] = max(score[0], size)
    if early:
        score[1] = max(score[1], size)
    else:
        score[2] = max(score[2], size)
    score[3] += size * size
    score[4] = max(score[4], abs(command))
    if wanted != command:
        score[5] += 1.0
    score[8] = max(score[8], abs(own))


@njit_in_place
def write_row(
    row: Array,
    x: Array,
    readings: Array,
    command: float,
    slip: int,
    sigma: float,
    parameters: Array,
    regressor: Array,
    states: Array,
) -> None:
    """One row of the log."""
    c = _put(row, 0, x)
    c = _put(row, c, readings)
    row[c], row[c + 1], row[c + 2] = command, slip, sigma
    c = _put(row, c + 3, parameters)
    c = _put(row, c, regressor)
    _put(row, c, states)


@njit_in_place
def _put(row: Array, start: int, values: Array) -> int:
    for i in range(values.size):
        row[start + i] = values[i]
    return start + values.size


@njit_in_place
def decide(
    observer: ObserverNumbers,
    law: LawNumbers,
    rig: RigNumbers,
    reference: Array,
    k: int,
    x: Array,
    s: LoopState,
) -> tuple[float, float, float]:
    """One sample of the controller, from angles (and speeds) ``x``: command wanted, limited command, sigma.

    The commands on their way to the motor move up by one, and the filter is carried to the next sample. Where
    the law has no states it keeps its last command.
    """
    read_encoders(rig.encoders, rig.counts, rig.phases, rig.blind, x, k, s.readings)
    if observer.kind == 0:
        seen = True
        for j in range(s.readings.size):
            seen = seen and isfinite(s.readings[j])
        for i in range(s.states.size):
            s.states[i] = x[observer.chosen[i]] if seen else nan
    else:
        correct(
            observer.kind, observer.chosen, observer.output, observer.gains, observer.scalars, s.discrete[1],
            s.estimate, s.readings, s.states, s.work,
        )  # fmt: skip
    s.discrete[1] += 1
    wanted, sigma, valid = law_step(
        law.kind, law.matrix, law.rows, law.learning, law.scalars, s.parameters, s.memory, s.states,
        reference, k, s.held[1], s.regressor, s.work, s.table,
    )  # fmt: skip
    if valid:
        if observer.scalars[8] > 0.0:
            wanted -= s.estimate[observer.places[1]]
        s.held[1] = wanted
    else:
        s.summary[6] += 1.0
    command = min(max(wanted, -rig.torque_limit), rig.torque_limit)
    newest = s.commands.size - 1
    for i in range(newest):
        s.commands[i] = s.commands[i + 1]
    s.commands[newest] = command
    if observer.kind == 2:
        predict(
            observer.model, observer.scalars, observer.places[0], s.estimate, s.held, s.commands[0],
            s.commands[1], s.work,
        )  # fmt: skip
    return wanted, command, sigma


@njit_in_place
def farthest(target: Array) -> float:
    """Load angle beyond which the plant has run away: ten times what is wanted, and 10 rad [rad]."""
    largest = 0.0
    for k in range(target.size):
        largest = max(largest, abs(target[k]))
    return 10.0 * (1.0 + largest)
