"""The closed loop of the rig on lumped plants, compiled: one motor or a preloaded pair."""

from math import isfinite, pi
from typing import NamedTuple

import numpy as np

from cabledrive.control.controller_kernels import controller_step
from cabledrive.control.flank_torque import COMMANDS, FlankLaw, preload_step
from cabledrive.control.numbers import LawNumbers, ObserverNumbers
from cabledrive.mechanics.compiled import njit_in_place, njit_part
from cabledrive.rig.closed_loop.chain_kernels import (
    FLANKS,
    MEMORY,
    TORQUE,
    VIEW,
    ChainPlant,
    move_chain,
    see_chain,
)
from cabledrive.rig.closed_loop.loop_numbers import Array, Integers, LoopState, RigNumbers
from cabledrive.rig.closed_loop.sample_kernels import farthest, finish_sample, sense


class PairNumbers(NamedTuple):
    """Law and sensors of a pair.

    ``phase``: of the second motor's encoder; ``start``: half the angle between the motors at which both are
    switched on [rad]; ``joint``: states of the filter whose difference is the twist of the joint; -1: that of
    the encoders of motor and shaft.
    """

    law: FlankLaw
    phase: float
    start: float
    joint: Integers


@njit_part
def sense_pair(pair: PairNumbers, rig: RigNumbers, s: LoopState) -> float:
    """Read both motors' encoders, the mean of which is that of the chain's motor; returns ϑ by them [rad]."""
    x, count = s.x, rig.counts[0]
    pressed = 0.5 * (x[0] - x[1]) - pair.start
    if not isfinite(s.readings[0]):
        return s.readings[0]
    if count > 0.0:
        first = count * np.rint((s.work[0] + pressed) / count + rig.phases[0])
        second = count * np.rint((s.work[0] - pressed) / count + pair.phase)
        s.readings[0], pressed = 0.5 * (first + second), 0.5 * (first - second)
    # Counted from where the preload was: what friction held there is not known.
    return pressed + pair.law.preload / pair.law.stiffness


@njit_part
def part_command(
    pair: PairNumbers, p: ChainPlant, pressed: float, command: float, k: int, s: LoopState, record: Array
) -> None:
    """What the first motor of a pair gets more, onto its way; what flanks bear, into the record."""
    kept, c, flanks = s.x[2 * p.inertia.size - 1 :], s.controller, s.terms[TORQUE]
    twist = s.readings[0] - s.readings[1]
    if pair.joint[0] >= 0:
        twist = c.estimate[pair.joint[0]] - c.estimate[pair.joint[1]]
    if not isfinite(twist):
        twist = 0.0
    apart = preload_step(pair.law, kept[MEMORY:], pressed, twist, command, s.work, flanks)
    if record.shape[0] > 0:
        for i in range(2):
            record[k, i], record[k, 4 + i] = kept[FLANKS + i], flanks[i]
            record[k, 2 + i] = 0.5 * command + (1.0 - 2.0 * i) * apart


@njit_in_place
def run_loop(
    plant: ChainPlant, pair: PairNumbers, observer: ObserverNumbers, law: LawNumbers, rig: RigNumbers,
    reference: Array, target: Array, first: int, last: int, s: LoopState, log: Array, record: Array,
) -> int:  # fmt: skip
    """Run samples ``first`` to ``last`` - 1; returns the sample at which the run ended.

    ``target``: wanted load angle. ``log`` has a row per sample, or none at all: true angles and speeds, shaft
    torque, readings, limited command, slip, sigma, estimates (12), regressor (12), states of the law.
    ``record``, shape (samples or 0, 6), of a pair: torques of both flanks, of both motors, of both flanks as
    observed.
    """
    gone, two, pressed, older, newer = farthest(target), plant.motors > 1, 0.0, 0.0, 0.0
    size = plant.inertia.size - plant.motors + 1
    on_its_way = s.x[2 * plant.inertia.size - 1 + MEMORY + COMMANDS :] if two else s.x[:0]
    for k in range(first, last):
        s.discrete[1] = see_chain(plant, gone, s)
        if s.discrete[1] != 0:
            return k
        sense(observer, rig, k, s.work, s)
        if two:
            pressed = sense_pair(pair, rig, s)
        wanted, command, sigma, valid = controller_step(
            observer, law, rig.torque_limit, s.controller, s.readings, reference, k
        )
        s.summary[6] += not valid
        if two:
            part_command(pair, plant, pressed, command, k, s, record)
            older, newer = on_its_way[0], on_its_way[1]
        if plant.field > 0.0:  # the command is an angle: the torque is scored, and lost steps
            lag = abs(plant.field_periods * (command - s.x[0]))
            command = s.x[2 * size]
            wanted = command + (1.0 if lag > 0.5 * pi else 0.0)
        seen = s.terms[VIEW, : 2 * size + 1]
        finish_sample(rig, target, k, s, log, seen, wanted, command, sigma, s.discrete[0])
        move_chain(plant, rig, k, s, older, newer)
    return last
