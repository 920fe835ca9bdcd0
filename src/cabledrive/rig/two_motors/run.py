"""Run the law of two motors on a machine, and what is left of a run."""

from dataclasses import dataclass
from math import ceil, exp, pi
from typing import Any

import numpy as np

from cabledrive.control.tension_position import first_state
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.parameters.terminal import ResultCard
from cabledrive.reduction.two_motors import TwoMotorMachine, winched_machine
from cabledrive.reduction.two_motors_kernels import TwoMotors
from cabledrive.rig.disturbances import stepped_in
from cabledrive.rig.setting import BodyMotion, Disturbance
from cabledrive.rig.two_motors.plan import ORDER, Plan, TensionDesign, design_tensions, plan_motion, way_of
from cabledrive.rig.two_motors.plant_kernels import COLUMNS, RigNumbers, close_loop


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class TwoMotorTracking(ResultCard):
    """A run of a body between two motors.

    Attributes
    ----------
    summary : dict
        What `cabledrive track --json` prints.
    time : ndarray, shape (samples,)
        [s].
    reference, place : ndarray, shape (samples, m)
        Wanted and true place of the body from where it rests [m].
    tensions, torques : ndarray, shape (samples, 2)
        Of the lines [N]; of the motors, positive winding in [N m].
    incomplete : str or None
        What was not kept, and why.
    """

    summary: dict[str, Any]
    time: Array
    reference: Array
    place: Array
    tensions: Array
    torques: Array
    incomplete: str | None

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
DEFAULT_WAY = 0.05
"""Of the distance between the last pulleys."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Setup:
    """A machine as believed, its law and the motion: what all runs share."""

    machine: TwoMotorMachine
    design: TensionDesign
    plan: Plan


@dataclass(frozen=True, kw_only=True, eq=False)
class PlantRun:
    """One plant under the law."""

    # (samples, m + 9): see `cabledrive.rig.two_motors.plant_kernels`; fewer samples where a number was not
    # finite
    record: Array
    least: Array  # (2,): least tension, between samples as well [N]
    substeps: int


def track_two_motors(
    drive: RoutedDrive,
    *,
    motion: BodyMotion | None = None,
    least_tension: float | None = None,
    gust: float | None = None,
    bandwidth: float | None = None,
    disturbances: tuple[Disturbance, ...] = (),
    plant_drive: RoutedDrive | None = None,
    seed: int = 0,
    draws: int = 0,
) -> TwoMotorTracking:
    """Move a body that two motors hold between them, and keep both lines tight.

    Parameters
    ----------
    drive : RoutedDrive
        As the law believes it to be: two motors, each winding a line that ends at the same body.
    motion : BodyMotion, optional
        Default: a twentieth of the distance between the last pulleys and back.
    least_tension : float, optional
        Tension that no line may fall below [N]; default: a fifth of the smaller one at rest.
    gust : float, optional
        Force on the body for which that is promised [N]; default: a tenth of its weight.
    bandwidth : float, optional
        Of the position [Hz]; default: what sampling and lines allow.
    disturbances : tuple of Disturbance
        Forces on the body.
    plant_drive : RoutedDrive, optional
        The machine as it is, where that differs.
    seed : int, default 0
        Of encoder phases and load cells, and of what is drawn.
    draws : int, default 0
        Plants to draw besides, with gusts.

    Returns
    -------
    TwoMotorTracking

    Raises
    ------
    InputRefused
        If the machine is another, data are missing, or the tension at rest leaves no room.
    """
    from cabledrive.rig.two_motors.front import run_samples
    from cabledrive.rig.two_motors.summary import summarize

    if seed < 0:
        raise InputRefused(f"seed = {seed} must not be negative: give 0 or more")
    machine, motion = winched_machine(drive), motion or BodyMotion()
    design = design_tensions(machine, least_tension=least_tension, gust=gust, bandwidth=bandwidth)
    way = way_of(machine, motion.moves) if motion.moves else _default_way(machine)
    plan = plan_motion(
        machine,
        design,
        way,
        rise=motion.rise,
        dwell=motion.dwell,
        pulses=motion.pulses,
        order=ORDER if motion.order is None else motion.order,
    )
    setup = Setup(machine=machine, design=design, plan=plan)
    actual = machine.numbers if plant_drive is None else winched_machine(plant_drive).numbers
    force, rng = forces_of(setup, disturbances), np.random.default_rng(seed)
    done = run_plant(setup, actual, force, rng)
    drawn = run_samples(setup, draws, rng) if draws else None
    return summarize(setup, actual, done, force, seed=seed, drawn=drawn)


def run_plant(setup: Setup, actual: TwoMotors, force: Array, rng: np.random.Generator) -> PlantRun:
    """Run one plant, at rest at first, with encoder phases and cell noise drawn."""
    gains, table = setup.design.gains, setup.plan.table
    m, substeps = actual.mass.size, substeps_of(actual, gains.interval)
    record, least = np.zeros((len(table), m + COLUMNS)), np.full(2, np.inf)
    state = first_state(gains, setup.machine.tension)
    ended = close_loop(
        actual, gains, state, rig_numbers(setup.machine, gains.interval, substeps, len(table), rng),
        table, force, record, least,
    )  # fmt: skip
    return PlantRun(record=record[:ended], least=least, substeps=substeps)


def substeps_of(numbers: TwoMotors, interval: float) -> int:
    """Internal steps per sample that resolve the fastest motion of drums and body against the lines."""
    reach = np.sqrt(((numbers.anchor - numbers.centre) ** 2).sum(axis=1)) + numbers.fixed
    stiffness = numbers.rigidity / reach
    fastest = np.sqrt(np.max(stiffness * (numbers.drum**2 / numbers.inertia + 1.0 / numbers.mass.min())))
    return int(max(1, ceil(interval * max(1.0 / INTERNAL_STEP, STEPS_PER_RADIAN * float(fastest)))))


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
    interval, samples = setup.design.gains.interval, len(setup.plan.table)
    for push in disturbances:
        if push.start >= samples * interval:
            raise InputRefused(
                f"disturbance on {push.on[:60]}: starts at {push.start:.4g} s, the motion ends at "
                f"{samples * interval:.4g} s: start earlier"
            )
    return stepped_in(disturbances, setup.machine.names, interval, samples)


def _default_way(machine: TwoMotorMachine) -> Array:
    """A twentieth of the distance between the last pulleys, towards the nearer middle."""
    centre = machine.numbers.centre
    way = np.zeros(len(machine.names))
    number = 0
    axis = "xy".index(machine.names[number][-1])
    size = DEFAULT_WAY * float(np.abs(centre[1] - centre[0]).max())
    middle = float(centre[:, axis].mean())
    way[number] = size if machine.numbers.anchor[:, axis].mean() <= middle else -size
    return way
