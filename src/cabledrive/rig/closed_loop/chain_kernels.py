"""Compiled motion of inertias joined by links, with friction that sticks, backlash, slack, disturbances.

What a loop needs to run comes first: sensors, state, score. An internal step is drift, kick and drift, of
order 2; the kick is made twice, so that dampers and smoothed friction see the mean speed. Friction is
set-valued: a speed that it would turn over, it stops. The torque loop's mean over the step acts, so that the
momentum it gives is exact.
"""

from math import exp, isfinite, nan, sin, tanh
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.control.controller_kernels import controller_step
from cabledrive.control.numbers import ControllerState, LawNumbers, ObserverNumbers
from cabledrive.control.observers import FlankLaw
from cabledrive.mechanics.compiled import njit_in_place, njit_part
from cabledrive.parameters.arrays import Array

Integers = NDArray[np.int64]
DIVERGED, WENT_SLACK = 1, 2
SUMMARY = (
    *("peak", "first_peak", "later_peak", "square", "peak_torque", "saturated", "invalid", "twist"),
    *("own_peak", "slack", "loose", "aside", "swing"),
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


class PairNumbers(NamedTuple):
    """Law and sensors of a pair; ``start``: half the angle between the motors when switched on [rad].

    ``record``, shape (samples or 0, 6), takes torques of both flanks, of both motors, of both flanks as
    observed.
    """

    law: FlankLaw
    phase: float
    start: float
    joint: Integers
    record: Array


class Control(NamedTuple):
    """What runs a plant: filter and law, sensors and limits, what the law follows, the wanted load angle.

    ``gone``: load angle beyond which the plant has run away [rad]; ``pair``: of two motors.
    """

    observer: ObserverNumbers
    law: LawNumbers
    rig: RigNumbers
    reference: Array
    target: Array
    gone: float
    pair: PairNumbers


class LoopState(NamedTuple):
    """Everything that moves, and scratch; arrays, so that a run can go on where another ended.

    ``x``: angles, speeds and shaft torque, then whatever else the plant keeps. ``shafts``: the first of these
    at a sample, two motors as one, and ``work`` as the encoders see them. ``discrete``: slip, and why
    the run ended (`DIVERGED`, `WENT_SLACK`; 0: it did not). ``controller``: what the controller keeps.
    """

    x: Array
    shafts: Array
    discrete: Integers
    controller: ControllerState
    readings: Array
    terms: Array
    work: Array
    summary: Array


@njit_part
def counted(value: float, count: float, phase: float) -> float:
    """What an encoder reads: whole counts from where it was switched on; without a count the value itself."""
    return count * np.rint(value / count + phase) if count > 0.0 else value


@njit_in_place
def read_encoders(rig: RigNumbers, angles: Array, sample: int, readings: Array) -> None:
    """Angles in whole counts, each encoder with its own phase; NaN from one that drops out."""
    for j in range(readings.size):
        readings[j] = counted(angles[rig.encoders[j]], rig.counts[j], rig.phases[j])
    if rig.dropout[0] >= 0 and rig.dropout[1] <= sample <= rig.dropout[2]:
        readings[rig.dropout[0]] = nan


@njit_in_place
def _put(row: Array, start: int, values: Array) -> int:
    for i in range(values.size):
        row[start + i] = values[i]
    return start + values.size


@njit_part
def finish_sample(
    rig: RigNumbers, target: float, k: int, s: LoopState, log: Array, issued: tuple[float, float, float]
) -> None:
    """Score and log of a sample: command wanted, limited command, sigma; the score is that of `SUMMARY`."""
    counts, phases, score, shafts = rig.counts, rig.phases, s.summary, s.shafts
    error, (wanted, command, sigma) = shafts[shafts.size // 2 - 1] - target, issued
    part = 1 if k < rig.first_end else 2
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
def sense(observer: ObserverNumbers, rig: RigNumbers, k: int, s: LoopState) -> None:
    """Read the encoders at a sample; ideal sensors and lost readings go into the states."""
    read_encoders(rig, s.work, k, s.readings)
    if observer.kind == 0:
        seen, states = True, s.controller.states
        for j in range(s.readings.size):
            seen = seen and isfinite(s.readings[j])
        for i in range(states.size):
            states[i] = s.work[observer.chosen[i]] if seen else nan


@njit_part
def decide(machine: Any, c: Control, k: int, s: LoopState) -> tuple[float, float, float]:
    """Command wanted, limited command and sigma of one sample; without states the last command is kept."""
    sense(c.observer, c.rig, k, s)
    wanted, command, sigma, valid = controller_step(
        c.observer, c.law, c.rig.torque_limit, s.controller, s.readings, c.reference, k
    )
    if not valid:
        s.summary[6] += 1.0
    return wanted, command, sigma


# Rows of scratch: speeds in a step, after it, torques, torques of the motors.
SPEED, AFTER, TORQUE, DRIVE = range(4)
# What a pair keeps, counted from the end of 2n + 1 states: torques of both flanks, the least of each, open.
FLANKS, LEAST, OPENED, MEMORY = 3, 5, 7, 8


class ChainPlant(NamedTuple):
    """Inertias in a row, at the first shaft; each of the ``motors`` has a link to the first that is none.

    ``inertia, viscous, coulomb, offset``, shape (n,); of the link behind each inertia but the last, (n - 1,):
    ``stiffness, damping``, half the ``play``, the twist beyond which one span of two is ``slack`` [rad].
    ``smooth``: K of friction c tanh(K w), 0: it sticks. ``excess, fading``: friction at standstill over
    Coulomb friction, the speed at which it is gone. ``cogging, ripple`` with periods per radian;
    ``eccentricity`` of the load's encoder. ``softening, warming``: loss of the last link and of friction per
    second. The load's inertia takes ``load_factor`` from ``load_time`` on. ``field``: largest torque of a
    stepper whose command is the angle of its field, with ``field_periods`` per radian of lag; 0: the command
    is a torque. ``step``: longest internal step [s]; ``twist_limit``: of the last link, at which a run ends.
    """

    inertia: Array
    viscous: Array
    coulomb: Array
    offset: Array
    stiffness: Array
    damping: Array
    play: Array
    slack: Array
    phases: Array
    motors: int
    current_rate: float
    step: float
    twist_limit: float
    smooth: float = 0.0
    excess: float = 0.0
    fading: float = 1.0
    cogging: float = 0.0
    cogging_lines: float = 0.0
    ripple: float = 0.0
    ripple_lines: float = 0.0
    eccentricity: float = 0.0
    turning: float = 0.0
    softening: float = 0.0
    warming: float = 0.0
    load_factor: float = 1.0
    load_time: float = 0.0
    field: float = 0.0
    field_periods: float = 0.0


@njit_in_place
def link_torque(
    twist: float, rate: float, stiffness: float, damping: float, play: float, slack: float
) -> float:
    """Torque of a link with backlash, or with two spans of which one goes slack beyond a twist."""
    if abs(twist) <= play:
        return 0.0
    if play > 0.0:
        torque = stiffness * (twist - play if twist > 0.0 else twist + play) + damping * rate
        return max(torque, 0.0) if twist > 0.0 else min(torque, 0.0)
    if abs(twist) > slack:  # one span is left, with half the stiffness and the damping of both
        taut = slack if twist > 0.0 else -slack
        return stiffness * (taut + 0.5 * (twist - taut)) + 0.5 * damping * rate
    return stiffness * twist + damping * rate


@njit_in_place
def rubbed(speed: float, change: float) -> float:
    """A speed after friction that may stop it and never turns it."""
    return max(speed - change, 0.0) if speed > 0.0 else min(speed + change, 0.0)


@njit_part
def add_torques(p: ChainPlant, x: Array, motor: float, load: float, time: float, terms: Array) -> None:
    """Torque on every inertia but for its friction, into its row of scratch."""
    n, last = p.inertia.size, p.stiffness.size - 1
    w, torque = terms[SPEED], terms[TORQUE]
    for i in range(n):
        torque[i] = p.offset[i] - p.viscous[i] * w[i]
    for m in range(p.motors):
        given = terms[DRIVE, m]
        if p.field > 0.0:
            given = p.field * sin(p.field_periods * (given - x[m]))
            x[2 * n] = given
        if p.ripple > 0.0:
            given *= 1.0 + p.ripple * sin(p.ripple_lines * x[m] + p.phases[1])
        if p.cogging > 0.0:
            given += p.cogging * sin(p.cogging_lines * x[m] + p.phases[0])
        torque[m] += given + motor / p.motors
    torque[n - 1] += load
    for j in range(last + 1):
        a, b, stiffness = j, max(j + 1, p.motors), p.stiffness[j]
        if j == last:
            stiffness *= max(1.0 - p.softening * time, 0.05)
        carried = link_torque(x[a] - x[b], w[a] - w[b], stiffness, p.damping[j], p.play[j], p.slack[j])
        torque[a] -= carried
        torque[b] += carried
        if p.motors > 1 and j < 2:
            x[2 * n - 1 + FLANKS + j] = carried * (1.0 - 2.0 * j)


@njit_part
def chain_step(
    p: ChainPlant, x: Array, motor: float, load: float, time: float, h: float, terms: Array
) -> None:
    """One internal step from ``time`` on; the row of the motors' torques is filled."""
    n = p.inertia.size
    w, after, torque = terms[SPEED], terms[AFTER], terms[TORQUE]
    for i in range(n):
        x[i] += 0.5 * h * x[n + i]
        w[i] = x[n + i]
    warm = max(1.0 - p.warming * time, 0.0)
    for _ in range(2):
        add_torques(p, x, motor, load, time, terms)
        for i in range(n):
            inertia, rubs = p.inertia[i], warm * p.coulomb[i]
            if i == n - 1 and time >= p.load_time:
                inertia *= p.load_factor
            if p.excess > 0.0:
                rubs *= 1.0 + p.excess * exp(-abs(w[i]) / p.fading)
            if p.smooth > 0.0:
                after[i] = x[n + i] + h * (torque[i] - rubs * tanh(p.smooth * w[i])) / inertia
            else:
                after[i] = rubbed(x[n + i] + h * torque[i] / inertia, h * rubs / inertia)
        for i in range(n):
            w[i] = 0.5 * (x[n + i] + after[i])
    for i in range(n):
        x[n + i] = after[i]
        x[i] += 0.5 * h * x[n + i]


@njit_part
def move(
    p: ChainPlant,
    s: LoopState,
    total: float,
    turning: float,
    apart: float,
    motor: float,
    load: float,
    begin: float,
    time: float,
) -> None:
    """Move the chain on under a command that changes by ``turning`` a second."""
    steps = int(time / p.step + 1.0 - 1e-9)
    if steps < 1:  # jitter may take the next sample before this command acts
        return
    x, n, h = s.x, p.inertia.size, time / steps
    keep, mean = 0.0, 0.0
    if p.current_rate > 0.0:
        keep = exp(-p.current_rate * h)
        mean = (1.0 - keep) / (p.current_rate * h)
    for k in range(steps):
        for m in range(p.motors):
            command = total / p.motors + (1.0 - 2.0 * m) * apart
            if p.field > 0.0:
                s.terms[DRIVE, m] = command + (k + 0.5) * h * turning
                continue
            behind = x[2 * n + m] - command
            s.terms[DRIVE, m] = command + mean * behind
            x[2 * n + m] = command + keep * behind
        chain_step(p, x, motor, load, begin + k * h, h, s.terms)
        if p.motors > 1:
            kept = x[2 * n - 1 :]
            for j in range(2):
                kept[LEAST + j] = min(kept[LEAST + j], kept[FLANKS + j])
                if kept[FLANKS + j] <= 0.0:
                    kept[OPENED] = 1.0
