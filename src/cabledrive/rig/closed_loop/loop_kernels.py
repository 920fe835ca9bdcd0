"""The closed loop of the rig on lumped plants, compiled: for runs, for own controllers, for firmware."""

from collections.abc import Callable
from functools import lru_cache
from math import isfinite, nan, pi
from typing import Any, NamedTuple

import numpy as np

from cabledrive.control.controller_kernels import (
    PathState,
    TargetState,
    controller_step,
    issue,
    observe,
    path_row,
    target_step,
)
from cabledrive.control.numbers import LawNumbers, ObserverNumbers
from cabledrive.control.observers import COMMANDS, FlankLaw, preload_step
from cabledrive.control.reference import ReferenceNumbers
from cabledrive.mechanics.compiled import njit_in_place, njit_part
from cabledrive.parameters.arrays import Array
from cabledrive.rig.closed_loop.chain_kernels import (
    FLANKS,
    MEMORY,
    TORQUE,
    VIEW,
    ChainPlant,
    Control,
    Integers,
    LoopState,
    RigNumbers,
    counted,
    farthest,
    finish_sample,
    move,
    move_chain,
    read_encoders,
    see_chain,
    sense,
)


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


@njit_part
def sense_pair(pair: PairNumbers, rig: RigNumbers, s: LoopState) -> float:
    """Read both motors' encoders, the mean of which is that of the chain's motor; returns ϑ by them [rad]."""
    x, count = s.x, rig.counts[0]
    pressed = 0.5 * (x[0] - x[1]) - pair.start
    if not isfinite(s.readings[0]):
        return s.readings[0]
    if count > 0.0:
        first = counted(s.work[0] + pressed, count, rig.phases[0])
        second = counted(s.work[0] - pressed, count, pair.phase)
        s.readings[0], pressed = 0.5 * (first + second), 0.5 * (first - second)
    # Counted from where the preload was: what friction held there is not known.
    return pressed + pair.law.preload / pair.law.stiffness


@njit_part
def part_command(
    pair: PairNumbers, p: ChainPlant, pressed: float, command: float, k: int, s: LoopState
) -> None:
    """What the first motor of a pair gets more, onto its way; what flanks bear, into the record."""
    kept, c, flanks = s.x[2 * p.inertia.size - 1 :], s.controller, s.terms[TORQUE]
    record = pair.record
    twist = s.readings[0] - s.readings[1]
    if pair.joint[0] >= 0:
        twist = c.estimate[pair.joint[0]] - c.estimate[pair.joint[1]]
    if not isfinite(twist):
        twist = 0.0
    apart = preload_step(pair.law, kept[MEMORY:], (pressed, twist, command), s.work, flanks)
    if record.shape[0] > 0:
        for i in range(2):
            record[k, i], record[k, 4 + i] = kept[FLANKS + i], flanks[i]
            record[k, 2 + i] = 0.5 * command + (1.0 - 2.0 * i) * apart


@njit_in_place
def run_loop(
    plant: ChainPlant, pair: PairNumbers, control: Control, span: tuple[int, int], s: LoopState, log: Array
) -> int:
    """Run the samples of a span, its end not among them; returns the sample at which the run ended.

    ``log`` has a row per sample, or none at all: true angles and speeds, shaft
    torque, readings, limited command, slip, sigma, estimates (12), regressor (12), states of the law.
    """
    gone, two, pressed, older, newer = farthest(control.target), plant.motors > 1, 0.0, 0.0, 0.0
    observer, rig = control.observer, control.rig
    size = plant.inertia.size - plant.motors + 1
    on_its_way = s.x[2 * plant.inertia.size - 1 + MEMORY + COMMANDS :] if two else s.x[:0]
    for k in range(span[0], span[1]):
        s.discrete[1] = see_chain(plant, gone, s)
        if s.discrete[1] != 0:
            return k
        sense(observer, rig, k, s.work, s)
        if two:
            pressed = sense_pair(pair, rig, s)
        wanted, command, sigma, valid = controller_step(
            observer, control.law, rig.torque_limit, s.controller, s.readings, control.reference, k
        )
        s.summary[6] += not valid
        if two:
            part_command(pair, plant, pressed, command, k, s)
            older, newer = on_its_way[0], on_its_way[1]
        if plant.field > 0.0:  # the command is an angle: the torque is scored, and lost steps
            lag = abs(plant.field_periods * (command - s.x[0]))
            command = s.x[2 * size]
            wanted = command + (1.0 if lag > 0.5 * pi else 0.0)
        seen = s.terms[VIEW, : 2 * size + 1]
        finish_sample(control, k, s, log, seen, (wanted, command, sigma))
        move_chain(plant, rig, k, s, older, newer)
    return span[1]


NOT_FINITE = 9
"""Why a run ended: the command or the state of the user's controller is not finite, or of another size."""


HELD = -1
"""No end: a reading is missing, and the last command is held."""


@njit_in_place
def before_step(plant: ChainPlant, c: Control, k: int, gone: float, s: LoopState) -> int:
    """A sample up to the user's step: why the run ends here, `HELD` where a reading is missing, else 0."""
    code = see_chain(plant, gone, s)
    if code != 0:
        return code
    sense(c.observer, c.rig, k, s.work, s)
    seen = observe(c.observer, s.controller, s.readings)
    for j in range(s.readings.size):
        seen = seen and isfinite(s.readings[j])
    return 0 if seen else HELD


@njit_in_place
def after_step(plant: ChainPlant, c: Control, k: int, torque: float, s: LoopState, log: Array) -> None:
    """A sample from the user's torque on, NaN where there is none: limit, filter, score, log, plant."""
    valid = isfinite(torque)
    s.summary[6] += not valid
    wanted, command = issue(c.observer, c.rig.torque_limit, s.controller, torque, valid)
    finish_sample(c, k, s, log, s.terms[VIEW, : s.x.size], (wanted, command, 0.0))
    move_chain(plant, c.rig, k, s, 0.0, 0.0)


@lru_cache(maxsize=16)
def own_loop(step: Any, filtered: bool) -> Callable[..., int]:
    """The loop for a compiled step; it is compiled when it is first run, in each process."""
    import numba

    def run_own_loop(  # arrays may be made here: numba counts their references
        plant: Any, control: Any, gains: Any, span: tuple[int, int], s: Any, log: Array
    ) -> int:
        gone, memory = farthest(control.target), s.controller.memory
        for k in range(span[0], span[1]):
            code, torque = before_step(plant, control, k, gone, s), nan
            if code > 0:
                s.discrete[1] = code
                return k
            if code == 0:
                measurement = s.controller.states.copy() if filtered else s.readings.copy()
                state, torque = step(gains, memory.copy(), measurement, control.reference[k].copy())
                good = isfinite(torque) and len(state) == memory.size
                for i in range(memory.size):
                    if good:
                        memory[i] = state[i]
                        good = isfinite(memory[i])
                if not good:
                    s.discrete[1] = NOT_FINITE
                    return k
            after_step(plant, control, k, torque, s, log)
        return span[1]

    compiled: Callable[..., int] = numba.njit(error_model="numpy", nogil=True)(run_own_loop)
    return compiled


class PlantState(NamedTuple):
    """A lumped chain in time: what it is, its slip, commands under way, and scratch, as in `LoopState`."""

    x: Array
    discrete: Integers
    commands: Array
    readings: Array
    terms: Array
    work: Array


class LoopTarget(NamedTuple):
    """A closed loop in time: plant, controller, reference; ``sample`` (1,): of the next step."""

    plant: PlantState
    target: TargetState
    path: PathState
    row: Array
    sample: Integers


def new_plant_state(plant: ChainPlant, rig: RigNumbers) -> PlantState:
    """A plant at rest at angle zero."""
    states = 2 * len(plant.inertia) + 1
    return PlantState(
        x=np.zeros(states),
        discrete=np.zeros(2, dtype=np.int64),
        commands=np.zeros(rig.late_samples + 2),
        readings=np.zeros(len(rig.encoders)),
        terms=np.zeros((5, states)),
        work=np.zeros(states),
    )


@njit_part
def plant_read(rig: RigNumbers, s: PlantState) -> None:
    """The encoders now, into the plant's readings."""
    read_encoders(rig, s.x, 0, s.readings)


@njit_part
def plant_step(
    plant: ChainPlant, rig: RigNumbers, s: PlantState, command: float, motor: float, load: float
) -> None:
    """One sample on, under a command, which acts after the delay, and torques on motor and load [N m]."""
    newest = s.commands.size - 1
    for i in range(newest):
        s.commands[i] = s.commands[i + 1]
    s.commands[newest] = command
    # `move` looks at the fields that both kinds of state have.
    move(plant, s, s.commands[0], 0.0, 0.0, motor, load, 0.0, rig.late_part)  # type: ignore[arg-type]
    move(plant, s, s.commands[1], 0.0, 0.0, motor, load, 0.0, rig.interval - rig.late_part)  # type: ignore[arg-type]
    s.discrete[0] = 0 if s.x[plant.inertia.size] == 0.0 else 1


@njit_part
def loop_step(
    plant: ChainPlant,
    rig: RigNumbers,
    observer: ObserverNumbers,
    law: LawNumbers,
    numbers: ReferenceNumbers,
    limit: float,
    s: LoopTarget,
    motor: float,
    load: float,
) -> tuple[float, bool]:
    """One sample of the closed loop: limited command [N m], and whether it was computed."""
    plant_read(rig, s.plant)
    path_row(numbers, s.path, s.sample[0] * rig.interval, s.row[0])
    command, valid = target_step(observer, law, limit, s.target, s.plant.readings, s.row)
    plant_step(plant, rig, s.plant, command, motor, load)
    s.sample[0] += 1
    return command, valid
