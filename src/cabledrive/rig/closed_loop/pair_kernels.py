"""Closed loop of two motors on one shaft, each behind the backlash of its own gear, compiled.

The loop's states are those of the chain with the mean angle of both motors as its first; behind them stand
the difference and the law that holds the preload. Internal steps are drift, kick and drift, as those of a
chain with disturbances: dead zones exact, friction set-valued at either motor.
"""

from math import exp, inf, isfinite
from typing import NamedTuple

import numpy as np

from cabledrive.control.controller_kernels import controller_step
from cabledrive.control.flank_torque import COMMANDS, FlankLaw, preload_step
from cabledrive.control.numbers import LawNumbers, ObserverNumbers
from cabledrive.mechanics.compiled import njit_in_place, njit_part
from cabledrive.rig.closed_loop.disturbed_kernels import link_torque, rubbed
from cabledrive.rig.closed_loop.loop_numbers import (
    DIVERGED,
    WENT_SLACK,
    Array,
    Integers,
    LoopState,
    RigNumbers,
)
from cabledrive.rig.closed_loop.sample_kernels import farthest, finish_sample, sense

# What stands behind the 2n + 1 states of the chain: half the difference of the motors' angles and its speed,
# half the difference of their torques, torques of both flanks in the sense of the preload, the least of each,
# whether a flank was open since the last sample; then the memory of the law.
DIFFERENCE, SPEED, SHAFT, FLANKS, LEAST, OPENED, MEMORY = 0, 1, 2, 3, 5, 7, 8
# Columns of a record: torques of both flanks, torques of both motors, torques of both flanks as observed.
RECORDED = 6


class PairPlant(NamedTuple):
    """Two motors on the first shaft of a chain of n - 1 inertias, at the first shaft.

    Attributes
    ----------
    inertia, viscous, coulomb, offset : ndarray, shape (2,)
        Of each motor [kg m^2], [N m s/rad], [N m], [N m].
    stiffness, damping, play : ndarray, shape (2,)
        Of each joint [N m/rad], [N m s/rad]; half its backlash [rad].
    inertias, shaft_viscous, shaft_coulomb, offsets : ndarray, shape (n - 1,)
        Of the shaft and what it drives.
    links, link_damping : ndarray, shape (n - 2,)
        Of the chain behind the shaft.
    current_rate : float
        Bandwidth of the torque loops [rad/s]; 0: none.
    step : float
        Longest internal step [s].
    twist_limit : float
        Twist of the last link at which a run ends, for a span is slack [rad].
    """

    inertia: Array
    viscous: Array
    coulomb: Array
    offset: Array
    stiffness: Array
    damping: Array
    play: Array
    inertias: Array
    shaft_viscous: Array
    shaft_coulomb: Array
    offsets: Array
    links: Array
    link_damping: Array
    current_rate: float
    step: float
    twist_limit: float


class PairNumbers(NamedTuple):
    """Plant, law and sensors of a pair.

    ``phase``: of the second motor's encoder; ``start``: angle of the difference at which both encoders are
    switched on [rad]; ``joint``: states of the filter whose difference is the twist of the joint; -1: that of
    the encoders of motor and shaft.
    """

    plant: PairPlant
    law: FlankLaw
    phase: float
    start: float
    joint: Integers


@njit_part
def kicked(p: PairPlant, x: Array, motor: float, load: float, h: float, fresh: Array) -> None:
    """Speeds of both motors and of every inertia behind them after an internal step, shape (n + 1,).

    ``fresh``: takes them, and holds those with which dampers are to be reckoned on the way in.
    """
    n = p.inertias.size + 1
    own = x[2 * n + 1 :]
    carried, shaft = 0.0, fresh[2]
    for m in range(2):
        sign = 1.0 - 2.0 * m
        angle, speed, now = x[0] + sign * own[DIFFERENCE], x[n] + sign * own[SPEED], fresh[m]
        link = link_torque(angle - x[1], now - shaft, p.stiffness[m], p.damping[m], p.play[m], inf)
        torque = 0.5 * (x[2 * n] + motor) + sign * own[SHAFT] - link + p.offset[m] - p.viscous[m] * now
        fresh[m] = rubbed(speed + h * torque / p.inertia[m], h * p.coulomb[m] / p.inertia[m])
        own[FLANKS + m] = sign * link
        carried += link
    for i in range(1, n):
        link, j, now = 0.0, i - 1, fresh[1 + i]
        if i < n - 1:
            link = p.links[j] * (x[i] - x[i + 1]) + p.link_damping[j] * (now - fresh[2 + i])
        elif n > 2:
            carried += load
        torque = carried - link + p.offsets[j] - p.shaft_viscous[j] * now
        fresh[1 + i] = rubbed(x[n + i] + h * torque / p.inertias[j], h * p.shaft_coulomb[j] / p.inertias[j])
        carried = link


@njit_part
def pair_step(
    p: PairPlant,
    x: Array,
    total: float,
    difference: float,
    motor: float,
    load: float,
    h: float,
    fresh: Array,
) -> None:
    """One internal step under both commands; ``motor``, ``load``: further torques [N m]."""
    n = p.inertias.size + 1
    own = x[2 * n + 1 :]
    gained = 1.0 - exp(-0.5 * p.current_rate * h) if p.current_rate > 0.0 else 1.0
    for i in range(n):
        x[i] += 0.5 * h * x[n + i]
    own[DIFFERENCE] += 0.5 * h * own[SPEED]
    x[2 * n] += gained * (total - x[2 * n])
    own[SHAFT] += gained * (difference - own[SHAFT])
    fresh[0], fresh[1] = x[n] + own[SPEED], x[n] - own[SPEED]
    for i in range(1, n):
        fresh[1 + i] = x[n + i]
    kicked(p, x, motor, load, h, fresh)
    # Once more with the mean speeds: dampers are then of order 2 as well.
    fresh[0], fresh[1] = 0.5 * (fresh[0] + x[n] + own[SPEED]), 0.5 * (fresh[1] + x[n] - own[SPEED])
    for i in range(1, n):
        fresh[1 + i] = 0.5 * (fresh[1 + i] + x[n + i])
    kicked(p, x, motor, load, h, fresh)
    for m in range(2):
        own[LEAST + m] = min(own[LEAST + m], own[FLANKS + m])
        if own[FLANKS + m] <= 0.0:
            own[OPENED] = 1.0
    x[2 * n] += gained * (total - x[2 * n])
    own[SHAFT] += gained * (difference - own[SHAFT])
    x[n], own[SPEED] = 0.5 * (fresh[0] + fresh[1]), 0.5 * (fresh[0] - fresh[1])
    x[0] += 0.5 * h * x[n]
    own[DIFFERENCE] += 0.5 * h * own[SPEED]
    for i in range(1, n):
        x[n + i] = fresh[1 + i]
        x[i] += 0.5 * h * x[n + i]


@njit_part
def move_pair(
    p: PairPlant,
    x: Array,
    total: float,
    difference: float,
    motor: float,
    load: float,
    time: float,
    fresh: Array,
) -> None:
    """Move the pair on under constant commands; nothing where no time is left."""
    steps = int(np.ceil(time / p.step - 1e-9)) if time > 0.0 else 0
    for _ in range(steps):
        pair_step(p, x, total, difference, motor, load, time / steps, fresh)


@njit_part
def pair_ends(p: PairPlant, gone: float, s: LoopState) -> int:
    """Look at the pair at a sample; why the run ends here, 0 where it goes on."""
    x, n = s.x, p.inertias.size + 1
    own = x[2 * n + 1 :]
    twist = abs(x[n - 2] - x[n - 1]) if n > 2 else 0.0
    s.summary[7] = max(s.summary[7], twist)
    s.summary[10] += own[OPENED]
    own[OPENED] = 0.0
    if not isfinite(x[n - 1]) or abs(x[n - 1]) > gone:
        return DIVERGED
    return WENT_SLACK if twist > p.twist_limit else 0


@njit_part
def sense_pair(pair: PairNumbers, observer: ObserverNumbers, rig: RigNumbers, k: int, s: LoopState) -> float:
    """Read both motors' encoders, the mean of which is that of the chain's motor; returns ϑ by them [rad]."""
    x = s.x
    sense(observer, rig, k, x, s)
    difference = x[2 * (pair.plant.inertias.size + 1) + 1 + DIFFERENCE]
    pressed, count = difference - pair.start, rig.counts[0]
    if not isfinite(s.readings[0]):
        return s.readings[0]
    if count > 0.0:
        first = count * np.rint((x[0] + pressed) / count + rig.phases[0])
        second = count * np.rint((x[0] - pressed) / count + pair.phase)
        s.readings[0], pressed = 0.5 * (first + second), 0.5 * (first - second)
    # Counted from where the preload was: what friction held there is not known.
    return pressed + pair.law.preload / pair.law.stiffness


@njit_in_place
def run_pair(
    pair: PairNumbers,
    observer: ObserverNumbers,
    law: LawNumbers,
    rig: RigNumbers,
    reference: Array,
    target: Array,
    first: int,
    last: int,
    s: LoopState,
    log: Array,
    record: Array,
) -> int:
    """Run samples ``first`` to ``last`` - 1; returns the sample at which the run ended.

    ``log``: as in `cabledrive.rig.closed_loop.loop_kernels.run_loop`; ``record``, shape (samples or 0, 6).
    """
    p, x, c = pair.plant, s.x, s.controller
    n = p.inertias.size + 1
    own = x[2 * n + 1 :]
    memory, fresh, flanks = own[MEMORY:], s.terms[0], s.terms[1]
    gone = farthest(target)
    for k in range(first, last):
        code = pair_ends(p, gone, s)
        if code != 0:
            s.discrete[1] = code
            return k
        pressed = sense_pair(pair, observer, rig, k, s)
        wanted, command, sigma, valid = controller_step(
            observer, law, rig.torque_limit, c, s.readings, reference, k
        )
        if not valid:
            s.summary[6] += 1.0
        twist = s.readings[0] - s.readings[1]
        if pair.joint[0] >= 0:
            twist = c.estimate[pair.joint[0]] - c.estimate[pair.joint[1]]
        if not isfinite(twist):
            twist = 0.0
        difference = preload_step(pair.law, memory, pressed, twist, command, s.work, flanks)
        slip = 0 if x[n] == 0.0 else 1
        finish_sample(rig, target, k, s, log, x[: 2 * n + 1], wanted, command, sigma, slip)
        if record.shape[0] > 0:
            for i in range(2):
                record[k, i], record[k, 4 + i] = own[FLANKS + i], flanks[i]
                record[k, 2 + i] = 0.5 * command + (1.0 - 2.0 * i) * difference
        span, late = rig.interval, rig.late_part
        if rig.jitter.size > 0:
            span += rig.jitter[k + 1] - rig.jitter[k]
        motor, load = rig.forces[k, 0], rig.forces[k, 1]
        move_pair(p, x, c.commands[0], memory[COMMANDS], motor, load, late, fresh)
        move_pair(p, x, c.commands[1], memory[COMMANDS + 1], motor, load, span - late, fresh)
    return last
