"""A carriage with a hanging mass from one end of its span to the other, under one law after another."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.control.transporter import frozen_poles
from cabledrive.parameters import Carriage, Drive, InputRefused, Motor, Sensors
from cabledrive.reduction.transporter import Transporter, frozen_frequencies, transporter_of
from cabledrive.rig.carriage.transporter import (
    LAWS,
    MARGIN,
    CarriageMove,
    CarriageRun,
    force_limit,
    made_law,
    move_carriage,
    one_count,
)
from cabledrive.rig.setting import sample_interval

Array = NDArray[np.float64]
LENGTH, PRETENSION, DAMPING_TIME = 1.5, 10.0, 5e-4
CARRIAGE, START, RATE = 0.5, 0.25, 5000.0


def scaled_transporter(drive: Drive) -> Drive:
    """A transporter of laboratory size made large enough to carry half a kilogram over a metre.

    The span becomes 1.5 m, the pretension 10 N, the carriage 0.5 kg at 0.25 m, the cable's damping over its
    stiffness 0.5 ms (an estimate; none is printed); the motor is that of configuration 3 with a rigid joint.
    """
    if len(drive.carriage) != 1 or drive.sensors is None:
        raise InputRefused(f"drive {drive.name!r} has {len(drive.carriage)} carriages: give one with 1")
    rigidity = drive.cable.axial_rigidity
    motor = Motor(inertia=0.0011, viscous_friction=0.0031, coulomb_friction=0.0376, torque_limit=2.1)
    carriage: Carriage = replace(drive.carriage[0], mass=CARRIAGE, position=START)
    sensors: Sensors = replace(drive.sensors, sample_rate=RATE)
    return replace(
        drive,
        cable=replace(drive.cable, pretension=PRETENSION, axial_damping=DAMPING_TIME * rigidity),
        layout=replace(drive.layout, span_length=LENGTH),
        carriage=(carriage,),
        motor=motor,
        sensors=sensors,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ResidualMotion:
    """What is left of a payload's motion under one law, over many runs."""

    law: str
    # at_once, later: (runs,): largest distance from the place of rest after the arrival, and from two seconds
    # later on [m]; infinite for a run that ended early
    at_once: Array
    later: Array


def residual_motion(
    drive: Drive, law: str, *, runs: int = 8, seed: int = 0, drawn: bool = False, gust: float = 0.0
) -> ResidualMotion:
    """Move the carriage again and again at random encoder phases; ``gust``: on the payload [N]."""
    move = CarriageMove(gust=(gust, 1.0, 1.5))
    nominal = transporter_of(drive, payload_mass=move.payload_mass, line_length=move.line_length)
    found: list[CarriageRun] = []
    for i, generator in enumerate(np.random.default_rng(seed).spawn(runs)):
        plant = sampled_transporter(nominal, generator) if drawn else nominal
        found.append(move_carriage(drive, law, move=move, plant=plant, seed=seed + i))
    return ResidualMotion(
        law=law,
        at_once=np.array([run.residual() for run in found]),
        later=np.array([run.residual(later=2.0) for run in found]),
    )


def sampled_transporter(transporter: Transporter, generator: np.random.Generator) -> Transporter:
    """A random plant: payload 10 %, line, cable 5 %, friction 6 %, rail 20 %, carriage 2 %, offset 0.3 N."""
    spreads = {
        "payload_mass": 0.10,
        "line_length": 0.05,
        "axial_rigidity": 0.05,
        "coulomb": 0.06,
        "viscous": 0.06,
        "rail_friction": 0.2,
        "carriage_mass": 0.02,
    }
    drawn: dict[str, Any] = {
        name: getattr(transporter, name) * (1.0 + spread * generator.uniform(-1.0, 1.0))
        for name, spread in spreads.items()
    }
    return replace(transporter, **drawn, offset=float(generator.uniform(-0.3, 0.3)))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AlongTheWay:
    """Frequencies and stability over the carriage's place."""

    position: Array  # (positions,): [m]
    frequency: Array  # (positions, 3): Swing, carriage on the cable, load pulley [Hz]
    # of each law, the largest real part of a closed-loop pole at each position [1/s]; below 0: stable
    growth: dict[str, Array]


def along_the_way(
    drive: Drive,
    *,
    positions: int = 41,
    rigidity: float = 1.0,
    laws: tuple[str, ...] = ("scheduled", "frozen", "pd"),
) -> AlongTheWay:
    """Closed-loop poles of law, observer and frozen plant on a grid of positions."""
    move, interval = CarriageMove(), sample_interval(drive)
    design = transporter_of(drive, payload_mass=move.payload_mass, line_length=move.line_length)
    plant = replace(design, axial_rigidity=rigidity * design.axial_rigidity)
    place = np.linspace(design.start - MARGIN, design.start + move.distance + MARGIN, positions)
    growth = {}
    for law in laws:
        if law not in LAWS:
            raise InputRefused(f"law = {law!r} is not known: take one of {', '.join(LAWS)}")
        made = made_law(design, law, move, interval, one_count(drive), force_limit(drive))
        largest = [np.abs(frozen_poles(made, plant, float(x), interval)).max() for x in place]
        growth[law] = np.log(largest) / interval
    return AlongTheWay(
        position=place,
        frequency=np.array([frozen_frequencies(plant, float(x)) for x in place]) / (2.0 * np.pi),
        growth=growth,
    )
