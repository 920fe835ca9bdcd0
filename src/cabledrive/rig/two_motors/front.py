"""What `track` asks of a body between two motors, once or on many plants."""

from collections.abc import Mapping
from dataclasses import fields
from math import sqrt
from typing import Any

import numpy as np

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.reduction.two_motors_kernels import TwoMotors
from cabledrive.rig.setting import BodyMotion, Motion, RigOptions
from cabledrive.rig.two_motors.run import Setup, TwoMotorTracking, run_plant, track_two_motors
from cabledrive.rig.two_motors.summary import CONTROLLER, bound_of_place, part_used

OWN = (None, CONTROLLER, "best")
"""Names of the one law that moves a body between two winches."""


def track_winches(
    drive: RoutedDrive,
    *,
    controller: Any,
    motion: Motion | BodyMotion | None,
    options: RigOptions | None,
    plant_drive: Drive | RoutedDrive | None,
    others: Mapping[str, tuple[Any, Any]],
    **spec: Any,
) -> TwoMotorTracking:
    """Run the law of two winches; ``others``: arguments without effect here, each as given and by default."""
    if controller not in OWN:
        raise InputRefused(
            f'controller = "{str(controller)[:60]}" moves a load by one motor: a body between two winches '
            f"has {CONTROLLER}: leave it out"
        )
    if isinstance(motion, Motion):
        raise InputRefused(
            "motion = Motion(...) is a pulse of a load pulley: two winches move a body, give "
            'BodyMotion(moves={"camera.x": 2.0})'
        )
    given = {name: values for name, values in others.items() if values[0] != values[1]}
    given |= _given_options(options or RigOptions())
    for name in given:
        raise InputRefused(f"{name} is for pulses of a load pulley: two winches move a body: leave it out")
    if isinstance(plant_drive, Drive):
        raise InputRefused("plant_drive has no winches: give the same machine with other figures")
    disturbances = () if options is None else options.disturbances
    return track_two_motors(drive, motion=motion, disturbances=disturbances, plant_drive=plant_drive, **spec)


def _given_options(options: RigOptions) -> dict[str, Any]:
    """Options of the rig that differ from their defaults and that two winches do not have."""
    plain = RigOptions()
    return {
        field.name: getattr(options, field.name)
        for field in fields(options)
        if field.name != "disturbances" and getattr(options, field.name) != getattr(plain, field.name)
    }


MASS, RIGIDITY, FRICTION = 0.1, 0.1, 0.5
"""Each true value is drawn evenly within this part of what is believed."""
GUSTS = 3
MOST_DRAWS = 100_000


def run_samples(setup: Setup, draws: int, rng: np.random.Generator) -> dict[str, Any]:
    """Run drawn plants with gusts; how many kept every line tight, with the 95 % interval of Wilson."""
    if not 0 < draws <= MOST_DRAWS:
        raise InputRefused(f"draws = {draws} must lie between 1 and {MOST_DRAWS}: ask for fewer")
    least, errors, used = [], [], []
    bound = bound_of_place(setup)
    for _ in range(draws):
        actual = drawn_plant(setup, rng)
        done = run_plant(setup, actual, drawn_gusts(setup, rng), rng)
        m = actual.mass.size
        complete = len(done.record) == len(setup.plan.table)
        least.append(float(done.least.min()) if complete else 0.0)
        off = done.record[:, :m] - setup.plan.table[: len(done.record), :m]
        errors.append(float(np.sqrt((off**2).sum(axis=1)).max()) if complete else np.inf)
        used.append(part_used(bound, off) if complete else np.inf)
    kept = sum(value >= setup.design.floor for value in least)
    low, high = wilson(kept, draws)
    return {
        "draws": draws,
        "kept": kept,
        "share": kept / draws,
        "share_low": low,
        "share_high": high,
        "least_tension": min(least),
        "median_peak_error_mm": 1e3 * float(np.median(errors)),
        "worst_peak_error_mm": 1e3 * max(errors),
        "position_bound_left": sum(part > 1.0 for part in used),
        "drawn": f"mass and stiffness within {MASS:.0%}, friction within {FRICTION:.0%}, {GUSTS} gusts of up "
        f"to {setup.design.gust:.4g} N in any direction",
    }


def drawn_plant(setup: Setup, rng: np.random.Generator) -> TwoMotors:
    """A plant around the believed one that rests where it is believed to rest."""
    numbers = setup.machine.numbers
    heavier, stiffer = 1.0 + rng.uniform(-MASS, MASS), 1.0 + rng.uniform(-RIGIDITY, RIGIDITY)
    rougher = 1.0 + rng.uniform(-FRICTION, FRICTION, 2)
    along = numbers.bearing @ numbers.frame
    extra = np.linalg.lstsq(along.T, (heavier - 1.0) * numbers.force, rcond=None)[0]
    rest = setup.machine.tension + extra
    ratio = rest / setup.machine.tension / stiffer
    return numbers._replace(
        mass=numbers.mass * heavier,
        force=numbers.force * heavier,
        rigidity=numbers.rigidity * stiffer,
        unwound=numbers.unwound * ratio,
        turning_coulomb=numbers.turning_coulomb * rougher,
    )


def drawn_gusts(setup: Setup, rng: np.random.Generator) -> Array:
    """Gusts that step in and out at random, together never above the stated force, shape (samples, m) [N]."""
    samples, m = len(setup.plan.table), setup.machine.numbers.mass.size
    force = np.zeros((samples, m))
    edges = np.sort(rng.integers(0, samples, 2 * GUSTS)).reshape(GUSTS, 2)
    for first, last in edges:
        direction = rng.normal(size=m)
        size = setup.design.gust * rng.uniform() / np.linalg.norm(direction)
        force[first:last] = size * direction
    return force


def wilson(successes: int, runs: int) -> tuple[float, float]:
    """Two-sided 95 % interval of a share, E. B. Wilson, J. Am. Stat. Assoc. 22, 209-212, 1927."""
    z = 1.959963984540054
    share, scale = successes / runs, 1.0 + z * z / runs
    middle = share + 0.5 * z * z / runs
    half = z * sqrt(share * (1.0 - share) / runs + 0.25 * (z / runs) ** 2)
    return max((middle - half) / scale, 0.0), min((middle + half) / scale, 1.0)
