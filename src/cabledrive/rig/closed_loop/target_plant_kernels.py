"""Plant and closed loop a sample at a time, for other programs; `cabledrive export` writes them in C."""

from typing import NamedTuple

import numpy as np

from cabledrive.control.controller_kernels import PathState, TargetState, path_row, target_step
from cabledrive.control.numbers import LawNumbers, ObserverNumbers
from cabledrive.control.reference import ReferenceNumbers
from cabledrive.mechanics.compiled import njit_part
from cabledrive.rig.closed_loop.chain_kernels import ChainPlant, move
from cabledrive.rig.closed_loop.loop_numbers import Array, Integers, RigNumbers
from cabledrive.rig.closed_loop.sample_kernels import read_encoders


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
    read_encoders(rig.encoders, rig.counts, rig.phases, rig.dropout, s.x, 0, s.readings)


@njit_part
def plant_step(
    plant: ChainPlant,
    rig: RigNumbers,
    s: PlantState,
    command: float,
    motor: float,
    load: float,
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
