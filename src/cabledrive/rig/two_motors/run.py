"""Run the law of two motors on a machine, and what is left of a run."""

from dataclasses import dataclass
from math import ceil, exp, pi
from typing import Any

import numpy as np

from cabledrive.control.tension_position import first_state, place_answers, place_bound
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import described, meaning
from cabledrive.parameters.terminal import ResultCard
from cabledrive.reduction.two_motors import TwoMotorMachine
from cabledrive.reduction.two_motors_kernels import TwoMotors
from cabledrive.rig.disturbances import stepped_in
from cabledrive.rig.plant_samples import share_low
from cabledrive.rig.setting import Disturbance
from cabledrive.rig.two_motors.plan import Setup, lines_along
from cabledrive.rig.two_motors.plant_kernels import COLUMNS, RigNumbers, close_loop


@described
@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class TwoMotorTracking(ResultCard):
    """A run of a body between two motors."""

    summary: dict[str, Any] = meaning("what `cabledrive track --json` prints")
    time: Array = meaning("(samples,) [s]")
    reference: Array = meaning("(samples, m): wanted place of the body from where it rests [m]")
    place: Array = meaning("(samples, m): true place [m]")
    tensions: Array = meaning("(samples, 2): of the lines [N]")
    torques: Array = meaning("(samples, 2): of the motors, positive winding in [N m]")
    incomplete: str | None = meaning("what was not kept, and why")

    def _card(self) -> list[tuple[str, str]]:
        said = self.summary
        rows = [
            ("Tracking", f"{said['controller']} on {said['plant']}"),
            ("peak error", f"{said['peak_error_mm']:.4g} mm"),
            ("least tension", f"{said['least_tension']:.4g} N (allowed: {said['least_allowed']:.4g} N)"),
            ("peak torque", f"{said['peak_torque']:.4g} N m"),
        ]
        return [*rows, *([("not kept", self.incomplete)] if self.incomplete else [])]


INTERNAL_STEP = 1e-4
"""Largest internal step of the plant [s]; smaller where the lines are stiff."""
STEPS_PER_RADIAN = 20.0


@dataclass(frozen=True, kw_only=True, eq=False)
class PlantRun:
    """One plant under the law."""

    # (samples, m + 9): see `cabledrive.rig.two_motors.plant_kernels`; fewer samples where a number was not
    # finite
    record: Array
    least: Array  # (2,): least tension, between samples as well [N]
    substeps: int


def run_plant(setup: Setup, actual: TwoMotors, force: Array, rng: np.random.Generator) -> PlantRun:
    """Run one plant, at rest at first, with encoder phases and cell noise drawn."""
    gains, table, m = setup.design.gains, setup.table, actual.mass.size
    # Steps that resolve the fastest motion of drums and body against the lines.
    reach = np.sqrt(((actual.anchor - actual.centre) ** 2).sum(axis=1)) + actual.fixed
    stiffness = actual.rigidity / reach
    fastest = np.sqrt(np.max(stiffness * (actual.drum**2 / actual.inertia + 1.0 / actual.mass.min())))
    per_second = max(1.0 / INTERNAL_STEP, STEPS_PER_RADIAN * float(fastest))
    substeps = int(max(1, ceil(gains.interval * per_second)))
    record, least = np.zeros((len(table), m + COLUMNS)), np.full(2, np.inf)
    state = first_state(gains, setup.machine.tension)
    rig = rig_numbers(setup.machine, gains.interval, substeps, len(table), rng)
    ended = close_loop(actual, gains, state, rig, table, force, record, least)
    return PlantRun(record=record[:ended], least=least, substeps=substeps)


def rig_numbers(
    machine: TwoMotorMachine, interval: float, substeps: int, samples: int, rng: np.random.Generator
) -> RigNumbers:
    """Sensors of the file, their phases and noise drawn."""
    sensors = machine.drive.sensors
    assert sensors is not None  # the design has read it
    rates = [motor.current_bandwidth for motor in machine.drive.motor if motor.current_bandwidth is not None]
    step = interval / substeps
    return RigNumbers(
        interval=interval,
        substeps=substeps,
        late=round(sensors.delay / step),
        lag=exp(-2.0 * pi * min(rates) * step) if rates else 0.0,
        counts=np.full(2, 2.0 * pi / (sensors.motor_encoder or np.inf)),
        phases=rng.uniform(-0.5, 0.5, 2),
        noise=rng.normal(0.0, sensors.load_cell_noise or 0.0, (samples, 2)),
    )


def forces_of(setup: Setup, disturbances: tuple[Disturbance, ...]) -> Array:
    """Forces on the body from each sample to the next, shape (samples, m) [N]."""
    interval, samples = setup.design.gains.interval, len(setup.table)
    for push in disturbances:
        if push.start >= samples * interval:
            raise InputRefused(
                f"disturbance on {push.on[:60]}: starts at {push.start:.4g} s, the motion ends at "
                f"{samples * interval:.4g} s: start earlier"
            )
    return stepped_in(disturbances, setup.machine.names, interval, samples)


CHECKED_PLACES = 50
"""At most so many places of the way are looked at."""


def bound_of_place(setup: Setup) -> Array:
    """Bound of each coordinate along the way, for gusts as the tension is promised for, shape (m,) [m]."""
    machine, gains, design = setup.machine, setup.design.gains, setup.design
    numbers, sensors = machine.numbers, machine.drive.sensors
    assert sensors is not None  # the design has read it
    m = numbers.mass.size
    places = np.ascontiguousarray(setup.table[:: max(1, len(setup.table) // CHECKED_PLACES), :m])
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


MASS, RIGIDITY, FRICTION = 0.1, 0.1, 0.5
"""Each true value is drawn evenly within this part of what is believed."""
GUSTS = 3
MOST_DRAWS = 100_000


def run_samples(setup: Setup, draws: int, rng: np.random.Generator) -> dict[str, Any]:
    """Run drawn plants with gusts; how many kept every line tight, and the least share that this shows."""
    if not 0 < draws <= MOST_DRAWS:
        raise InputRefused(f"draws = {draws} must lie between 1 and {MOST_DRAWS}: ask for fewer")
    least, errors, used = [], [], []
    bound = bound_of_place(setup)
    for _ in range(draws):
        actual = drawn_plant(setup, rng)
        done = run_plant(setup, actual, drawn_gusts(setup, rng), rng)
        m = actual.mass.size
        complete = len(done.record) == len(setup.table)
        least.append(float(done.least.min()) if complete else 0.0)
        off = done.record[:, :m] - setup.table[: len(done.record), :m]
        errors.append(float(np.sqrt((off**2).sum(axis=1)).max()) if complete else np.inf)
        used.append(part_used(bound, off) if complete else np.inf)
    kept = sum(value >= setup.design.floor for value in least)
    return {
        "draws": draws,
        "kept": kept,
        "share": kept / draws,
        "share_low": share_low(kept, draws),
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
    samples, m = len(setup.table), setup.machine.numbers.mass.size
    force = np.zeros((samples, m))
    edges = np.sort(rng.integers(0, samples, 2 * GUSTS)).reshape(GUSTS, 2)
    for first, last in edges:
        direction = rng.normal(size=m)
        size = setup.design.gust * rng.uniform() / np.linalg.norm(direction)
        force[first:last] = size * direction
    return force
