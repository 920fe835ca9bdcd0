"""Plants, gusts and sensors drawn at random under the law of two motors."""

from math import sqrt
from typing import Any

import numpy as np

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.two_motors_kernels import TwoMotors
from cabledrive.rig.two_motors.place_check import bound_of_place, part_used
from cabledrive.rig.two_motors.run import Setup, run_plant

MASS, RIGIDITY, FRICTION = 0.1, 0.1, 0.5
"""Each true value is drawn evenly within this part of what is believed."""
GUSTS = 3
MOST_DRAWS = 100_000


def run_samples(setup: Setup, draws: int, rng: np.random.Generator) -> dict[str, Any]:
    """Run drawn plants with gusts; how many kept every line tight, with the 95 % interval of Wilson.

    Raises `InputRefused` for a number of plants that is none.
    """
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
