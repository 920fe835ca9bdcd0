"""The closed loop of the rig on lumped plants, compiled: for runs, for own controllers, for firmware."""

from collections.abc import Callable
from functools import lru_cache
from math import isfinite, nan, pi, sin
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
from cabledrive.control.observers import COMMANDS, preload_step
from cabledrive.control.reference import ReferenceNumbers
from cabledrive.mechanics.compiled import njit_in_place, njit_part
from cabledrive.parameters.arrays import Array
from cabledrive.rig.closed_loop.chain_kernels import (
    DIVERGED,
    FLANKS,
    MEMORY,
    OPENED,
    TORQUE,
    WENT_SLACK,
    ChainPlant,
    Control,
    Integers,
    LoopState,
    PairNumbers,
    RigNumbers,
    counted,
    finish_sample,
    move,
    read_encoders,
    sense,
)


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


@njit_part
def see_chain(p: ChainPlant, gone: float, s: LoopState) -> int:
    """Look at the chain, two motors as one at their mean angle; why the run ends here, 0 where it goes on."""
    x, seen, n, more = s.x, s.shafts, p.inertia.size, p.motors - 1
    size = n - more
    for i in range(size):
        seen[i], seen[size + i] = x[i + more], x[n + i + more]
    seen[2 * size] = x[2 * n]
    if more > 0:
        seen[0], seen[size] = 0.5 * (x[0] + x[1]), 0.5 * (x[n] + x[n + 1])
        seen[2 * size] = x[2 * n] + x[2 * n + 1]
        s.summary[10] += x[2 * n - 1 + OPENED]
        x[2 * n - 1 + OPENED] = 0.0
    for i in range(2 * size + 1):
        s.work[i] = seen[i]
    if p.eccentricity > 0.0:
        s.work[size - 1] += p.eccentricity * sin(p.turning * seen[size - 1] + p.phases[2])
    s.discrete[0] = 0 if seen[size] == 0.0 else 1
    twist = 0.0
    if p.stiffness.size > more:
        last = p.stiffness.size - 1
        twist = abs(seen[size - 2] - seen[size - 1])
        s.summary[7] = max(s.summary[7], twist)
        if twist > p.slack[last]:
            s.summary[9] += 1.0
        if more == 0 and p.play[0] > 0.0 and abs(x[0] - x[1]) < p.play[0]:
            s.summary[10] += 1.0
    if not isfinite(seen[size - 1]) or abs(seen[size - 1]) > gone:
        return DIVERGED
    return WENT_SLACK if twist > p.twist_limit else 0


@njit_part
def move_chain(p: ChainPlant, rig: RigNumbers, k: int, s: LoopState) -> int:
    """Move the chain to the next sample, the older command first as long as the delay lasts."""
    span, commands, late, older, newer = rig.interval, s.controller.commands, rig.late_part, 0.0, 0.0
    if p.motors > 1:  # what the first motor gets more is on its way, too
        on_its_way = s.x[2 * p.inertia.size - 1 + MEMORY + COMMANDS :]
        older, newer = on_its_way[0], on_its_way[1]
    if rig.jitter.size > 0:
        span += rig.jitter[k + 1] - rig.jitter[k]
    motor, load, begin = rig.forces[k, 0], rig.forces[k, 1], k * rig.interval
    # The field of a stepper turns on between samples; a torque is held.
    turning = (commands[1] - commands[0]) / rig.interval if p.field > 0.0 else 0.0
    first = commands[0] + turning * (rig.interval - late)
    move(p, s, first, turning, older, motor, load, begin, late)
    move(p, s, commands[1], turning, newer, motor, load, begin + late, span - late)
    return 0


@njit_part
def decide_chain(plant: ChainPlant, c: Control, k: int, s: LoopState) -> tuple[float, float, float]:
    """As `decide`, for two motors, and for a stepper, whose command is the angle of its field."""
    pressed = 0.0
    sense(c.observer, c.rig, k, s)
    if plant.motors > 1:
        pressed = sense_pair(c.pair, c.rig, s)
    wanted, command, sigma, valid = controller_step(
        c.observer, c.law, c.rig.torque_limit, s.controller, s.readings, c.reference, k
    )
    s.summary[6] += not valid
    if plant.motors > 1:
        part_command(c.pair, plant, pressed, command, k, s)
    if plant.field > 0.0:  # the torque is scored, and lost steps
        lag = abs(plant.field_periods * (command - s.x[0]))
        command = s.shafts[s.shafts.size - 1]
        wanted = command + (1.0 if lag > 0.5 * pi else 0.0)
    return wanted, command, sigma


def loop_over(see: Any, decide: Any, move: Any) -> Any:
    """The one loop over samples, with the steps of a machine.

    ``see`` and ``move`` return why the run ends, 0 where it goes on; ``decide`` the command wanted, the
    limited command and sigma. The loop returns the sample at which the run ended; its ``log`` has a row per
    sample, or none at all: true angles and speeds, shaft torque, readings, limited command, slip, sigma,
    estimates (12), regressor (12), states of the law. Compiled, it is kept with the sources of ``see``.
    """

    def run_samples(machine: Any, control: Control, span: tuple[int, int], s: LoopState, log: Array) -> int:
        for k in range(span[0], span[1]):
            s.discrete[1] = see(machine, control.gone, s)
            if s.discrete[1] != 0:
                return k
            issued = decide(machine, control, k, s)
            finish_sample(control.rig, control.target[k], k, s, log, issued)
            s.discrete[1] = move(machine, control.rig, k, s)
            if s.discrete[1] != 0:
                return k + 1
        return span[1]

    run_samples.__dict__["sources"] = getattr(see, "py_func", see).__code__.co_filename
    return run_samples


run_loop = njit_in_place(loop_over(see_chain, decide_chain, move_chain))


class NotFinite(Exception):
    """The command or the state of the user's controller is not finite, or of another size."""


@lru_cache(maxsize=16)
def own_loop(step: Any, filtered: bool) -> tuple[Callable[..., float], Callable[..., int]]:
    """A compiled step as the loop asks it, and the loop, with its gains in the place of the law.

    The first, where numba counts references to the arrays that are made, is to be run before the second,
    where it does not. Both are compiled when they are first run, in each process.
    """
    import numba

    def ask(gains: Any, memory: Array, measurement: Array, row: Array) -> float:
        state, torque = step(gains, memory.copy(), measurement.copy(), row.copy())
        good = isfinite(torque) and len(state) == memory.size
        for i in range(memory.size):
            if good:
                memory[i] = state[i]
                good = isfinite(memory[i])
        return torque if good else nan

    def decide_own(machine: Any, c: Any, k: int, s: LoopState) -> tuple[float, float, float]:
        sense(c.observer, c.rig, k, s)
        kept, valid, torque = s.controller, observe(c.observer, s.controller, s.readings), nan
        for j in range(s.readings.size):
            valid = valid and isfinite(s.readings[j])
        if valid:
            torque = asked(c.law, kept.memory, kept.states if filtered else s.readings, c.reference[k])
            if not isfinite(torque):
                s.discrete[0] = k
                raise NotFinite
        s.summary[6] += not valid
        wanted, command = issue(c.observer, c.rig.torque_limit, kept, torque, valid)
        return wanted, command, 0.0

    options: dict[str, Any] = {"error_model": "numpy", "nogil": True}
    asked = numba.njit(**options)(ask)
    options["_nrt"] = False
    deciding = numba.njit(forceinline=True, **options)(decide_own)
    return asked, numba.njit(**options)(loop_over(see_chain, deciding, move_chain))


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
        terms=np.zeros((4, states)),
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
