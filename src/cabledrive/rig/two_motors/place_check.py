"""The bound of the body's place for a machine and its way, and what of its assumptions a run did not have."""

from typing import Any

import numpy as np

from cabledrive.control.position_bound import place_answers, place_bound
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.two_motors_kernels import TwoMotors
from cabledrive.rig.two_motors.plan import lines_along
from cabledrive.rig.two_motors.run import Setup

PLACES = 50
"""At most so many places of the way are looked at."""
NAMES = {
    "mass": "mass of the body",
    "rigidity": "stiffness of the lines",
    "loss": "damping of the lines",
    "force": "weight of the body",
    "turning_coulomb": "friction of the drums",
    "turning_viscous": "viscous friction of the drums",
    "inertia": "inertia of the drums",
    "coulomb": "friction of the body",
}
ALWAYS = (
    "the loop is sampled, and a drum's friction sticks and slides",
    "the lines turn and change their stiffness on the way: the bound is that of the linear loop",
)


def bound_of_place(setup: Setup) -> Array:
    """Bound of each coordinate along the way, for gusts as the tension is promised for, shape (m,) [m]."""
    machine, gains, design = setup.machine, setup.design.gains, setup.design
    numbers, sensors = machine.numbers, machine.drive.sensors
    assert sensors is not None  # the design has read it
    m = numbers.mass.size
    places = np.ascontiguousarray(setup.plan.table[:: max(1, len(setup.plan.table) // PLACES), :m])
    along, _, free = lines_along(numbers, places)
    turns, pulls = np.abs(np.linalg.pinv(along)), np.abs(along)
    stretch = (sensors.load_cell_noise or 0.0) * free / numbers.rigidity
    rounded = np.pi / (sensors.motor_encoder or np.inf) * numbers.drum
    return place_bound(
        place_answers(gains.position, gains.filter, gains.observer),
        gains.interval,
        unexpected=(design.gust + numbers.coulomb) / numbers.mass,
        tension=np.einsum("kim,i->km", pulls, design.margin).max(axis=0) / numbers.mass,
        counts=np.einsum("kmi,i->km", turns, rounded).max(axis=0),
        place_noise=np.sqrt(np.einsum("kmi,ki->km", turns**2, stretch**2)).max(axis=0),
        acceleration_noise=(sensors.load_cell_noise or 0.0)
        * np.sqrt((pulls**2).sum(axis=1)).max(axis=0)
        / numbers.mass,
    )


def part_used(bound: Array, error: Array) -> float:
    """Largest part of the bound, shape (m,), that an error used, shape (samples, m); above 1: left."""
    return float((np.abs(error).max(axis=0, initial=0.0) / bound).max())


def place_departures(setup: Setup, actual: TwoMotors, reshaped: float) -> list[str]:
    """In what a run differs from what the bound of the place supposes; ``reshaped``: part of its samples."""
    believed = setup.machine.numbers
    found = [
        f"{words} {100.0 * off:.0f} % off"
        for key, words in NAMES.items()
        if (off := _off(getattr(actual, key), getattr(believed, key))) > 1e-9
    ]
    if reshaped > 0.0:
        found.append(f"wanted tensions were reshaped at {reshaped:.1%} of the samples")
    return [*found, *ALWAYS]


def _off(actual: Array, believed: Array) -> float:
    """Largest relative difference."""
    scale = np.maximum(np.abs(believed), 1e-12)
    return float(np.max(np.abs(actual - believed) / scale, initial=0.0))


def place_words(
    setup: Setup, actual: TwoMotors, error: Array, broken: list[str], reshaped: float
) -> dict[str, Any]:
    """The bound beside the measured error, shape (samples, m) [m]; ``broken``: named by that of tension.

    Where nothing is named the error is inside.
    """
    bound = bound_of_place(setup)
    used = part_used(bound, error)
    named = list(broken)
    if not used <= 1.0:
        named += place_departures(setup, actual, reshaped)
    return {
        "position_bound_mm": {
            name: 1e3 * float(value) for name, value in zip(setup.machine.names, bound, strict=True)
        },
        "position_bound_used": used,
        "position_within_bound": None if named else True,
        "position_broken_assumptions": named,
    }
