"""The closed loop of the rig, compiled: plant, encoders, observer and law in one pass over the samples."""

from math import isfinite, nan

import numpy as np

from cabledrive.control.law_kernels import law_step
from cabledrive.control.numbers import LawNumbers
from cabledrive.control.observer_kernels import correct, predict
from cabledrive.control.observer_numbers import ObserverNumbers
from cabledrive.mechanics.compiled import njit
from cabledrive.rig.loop_numbers import Array, Integers, LoopState, RigNumbers
from cabledrive.rig.plant_kernels import PlantNumbers, advance


@njit
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


@njit
def keep_score(score: Array, early: bool, error: float, own: float, wanted: float, command: float) -> None:
    """Peaks and sums of a run, as `cabledrive.rig.loop_numbers.SUMMARY` names them."""
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


@njit
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
    c = x.size
    row[:c] = x
    row[c : c + readings.size] = readings
    c += readings.size
    row[c], row[c + 1], row[c + 2] = command, slip, sigma
    c += 3
    row[c : c + parameters.size] = parameters
    c += parameters.size
    row[c : c + regressor.size] = regressor
    c += regressor.size
    row[c : c + states.size] = states


@njit
def run_loop(
    plant: PlantNumbers,
    observer: ObserverNumbers,
    law: LawNumbers,
    rig: RigNumbers,
    reference: Array,
    target: Array,
    first: int,
    last: int,
    twist_limit: float,
    s: LoopState,
    log: Array,
) -> int:
    """Run samples ``first`` to ``last`` - 1; returns the sample at which the run ended.

    ``target`` is the wanted load angle at the samples. ``log`` has a row per sample, or none at all: true
    angles and speeds, shaft torque, readings, limited command, slip, sigma, estimates (12), regressor (12),
    states of the law.
    """
    rates, tables, plant_scalars = plant.rates, plant.tables, plant.scalars
    observed, chosen, output = observer.kind, observer.chosen, observer.output
    model, gains, filtering = observer.model, observer.gains, observer.scalars
    motor_speed, disturbance = observer.places[0], observer.places[1]
    kind, matrix, rows, learning, law_scalars = law.kind, law.matrix, law.rows, law.learning, law.scalars
    encoders, counts, phases, blind = rig.encoders, rig.counts, rig.phases, rig.blind
    jitter, forces, limit, late = rig.jitter, rig.forces, rig.torque_limit, rig.late_part
    x, estimate, held, parameters, memory = s.x, s.estimate, s.held, s.parameters, s.memory
    commands, states, readings, regressor = s.commands, s.states, s.readings, s.regressor
    terms, work, score = s.terms, s.work, s.summary
    slip, seen = s.discrete[0], s.discrete[1]
    n, newest = x.size // 2, commands.size - 1
    own_offset = counts[counts.size - 1] * phases[counts.size - 1]
    ended = last
    for k in range(first, last):
        twist = abs(x[n - 2] - x[n - 1]) if n > 1 else 0.0
        score[7] = max(score[7], twist)
        if not isfinite(x[n - 1]) or abs(x[n - 1]) > 1e6 or twist > twist_limit:
            ended = k
            break
        read_encoders(encoders, counts, phases, blind, x, k, readings)
        if observed == 0:
            for i in range(states.size):
                states[i] = x[chosen[i]] if isfinite(readings[readings.size - 1]) else nan
        else:
            correct(observed, chosen, output, gains, filtering, seen, estimate, readings, states, work)
        seen += 1
        wanted, sigma, valid = law_step(
            kind,
            matrix,
            rows,
            learning,
            law_scalars,
            parameters,
            memory,
            states,
            reference,
            k,
            held[1],
            regressor,
            work,
        )
        if valid:
            if filtering[8] > 0.0:
                wanted -= estimate[disturbance]
            held[1] = wanted
        else:
            score[6] += 1.0
        command = min(max(wanted, -limit), limit)
        for i in range(newest):
            commands[i] = commands[i + 1]
        commands[newest] = command
        if observed == 2:
            predict(model, filtering, motor_speed, estimate, held, commands[0], commands[1], work)
        error = x[n - 1] - target[k]
        keep_score(score, k < rig.first_end, error, error + own_offset, wanted, command)
        if log.shape[0] > 0:
            write_row(log[k], x, readings, command, slip, sigma, parameters, regressor, states)
        span = rig.interval
        if jitter.size > 0:
            span += jitter[k + 1] - jitter[k]
        if late > 0.0:
            slip = advance(
                rates,
                tables,
                plant_scalars,
                x,
                slip,
                commands[0],
                forces[k, 0],
                forces[k, 1],
                late,
                terms,
                work,
            )
        slip = advance(
            rates,
            tables,
            plant_scalars,
            x,
            slip,
            commands[1],
            forces[k, 0],
            forces[k, 1],
            span - late,
            terms,
            work,
        )
    s.discrete[0], s.discrete[1] = slip, seen
    return ended
