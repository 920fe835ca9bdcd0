"""Which carriages the scheduled law covers, one under it, and what its motion asks of motor and cable."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import ceil, pi
from typing import Any

import numpy as np

from cabledrive.control import transporter as control
from cabledrive.modal import natural_frequencies
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.reduction import transporter as reduced
from cabledrive.reduction.network_axis import as_axis
from cabledrive.reduction.quality import distributed
from cabledrive.rig.carriage import CARRIAGE, FORCE, PAYLOAD, POSITIONS, SUBSTEPS, CarriageLoop
from cabledrive.rig.setting import DEGREE, current_rate, sample_interval, torque_limit
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.knowledge_stage import Knowledge, with_load
from cabledrive.studies.study.machine import (
    DATASHEET,
    GOAL,
    GUESS,
    KINDS,
    Demand,
    DemandResult,
    Quantity,
    by_datasheet,
    known,
    values_of,
)
from cabledrive.trajectories import pulse

SHARED = (
    *("near_inertia", "load_inertia", "viscous_friction", "coulomb_friction", "offset_torque"),
    *("cable_stiffness", "cable_damping"),
)
UNUSED = "the regression models have no carriage: the logs were not used, all values are from the data sheet"
RAIL = 0.5
"""Default friction of a carriage on its guide [N s/m]: an estimate, sampled from 0 to twice as much."""
STIFF_JOINT = 10.0
"""Stiffness of a motor joint that is taken as rigid, over the cable's between motor and carriage."""
LATE = 0.05
"""Largest delay with the torque loop's lag, over the shortest period of the carriage on its cable."""
MARGIN = 0.02
"""Nearest to a pulley that the carriage may come, over the span's length."""
GRAIN, GRAIN_RATIO, GRAVITY = 1e-6, 0.5, 9.81
"""Where nothing hangs: a grain, over the carriage's mass, its damping ratio, and the gravity it needs."""


def missing_for_carriage(drive: Drive) -> tuple[str, ...]:
    """What the scheduled law of one carriage lacks on a drive, each with what would be needed."""
    found, first, sensors = list[str](), drive.carriage[0], drive.sensors
    if not drive.closed or any(pulley.fixed for pulley in drive.pulley):
        machine = "an open line" if not drive.closed else "a loop with a fixed pulley"
        found.append(
            f"carriage control needs a closed loop with two rotating pulleys; this drive is {machine}"
        )
    if len(drive.carriage) > 1:
        found.append(f"carriage control supports one carriage; this drive has {len(drive.carriage)}")
    elif first.span != "upper" or not first.guided:
        found.append(
            'carriage control needs a guided carriage on the upper span: set guided = true and span = "upper"'
        )
    if drive.layout.gravity <= 0.0:
        found.append("layout.gravity = 0, but a hanging mass needs it: give its value")
    if drive.layout.inclination != 0.0:
        said = f"layout.inclination = {drive.layout.inclination / DEGREE:.4g} deg"
        found.append(f"{said}, but carriage control needs a level span")
    if drive.motor is None:
        found.append("motor is missing, but the carriage has to be moved: add motor.inertia")
    if sensors is None or sensors.sample_rate is None:
        found.append('sensors.sample_rate is missing: give it, such as "5 kHz"')
    if sensors is None or (sensors.motor_encoder is None and sensors.drive_encoder is None):
        found.append("neither sensors.motor_encoder nor sensors.drive_encoder is given: fit one")
    return tuple(found) or _too_soft_or_late(drive)


def _too_soft_or_late(drive: Drive) -> tuple[str, ...]:
    found = []
    assert drive.motor is not None
    assert drive.sensors is not None
    machine = transporter_with(drive, carriage_values(drive, Goals()))
    if drive.motor.joint_stiffness is not None:
        joint = drive.motor.joint_stiffness / machine.radius**2
        cable = 1.0 / float(reduced.compliance(machine, machine.start)[0])  # type: ignore[arg-type]
        if joint < STIFF_JOINT * cable:
            found.append(
                f"motor.joint_stiffness is {joint / cable:.3g} times the cable's between motor and "
                f"carriage; carriage control takes the joint as rigid and needs at least {STIFF_JOINT:g} "
                "times"
            )
    rate = current_rate(drive)
    lag = drive.sensors.delay + (1.0 / rate if rate else 0.0)
    frequency = cable_frequency(machine, machine.start)
    if lag * frequency > LATE:
        found.append(
            f"delay and torque loop add a lag of {1e3 * lag:.3g} ms, more than a twentieth of a period of "
            f"the carriage on its cable ({frequency:.3g} Hz), and the runs contain no delay: lower "
            "sensors.delay"
        )
    return tuple(found)


def cable_frequency(transporter: reduced.Transporter, position: float) -> float:
    """Frequency of the carriage on the cable, without what hangs below it [Hz]; ``position`` [m]."""
    bare = transporter._replace(payload_mass=GRAIN * transporter.carriage_mass, line_length=1e6)
    return float(reduced.frozen_frequencies(bare, position)[1]) / (2.0 * pi)


def carriage_values(drive: Drive, goals: Goals) -> dict[str, float]:
    """The numbers of a machine with a carriage, as file and goals give them."""
    known = values_of(drive)
    values = {name: known[name] for name in SHARED} | {"carriage_mass": drive.carriage[0].mass}
    values["rail_friction"] = RAIL if goals.rail_friction is None else goals.rail_friction
    if goals.hanging_mass is not None and goals.line_length is not None:
        values |= {"hanging_mass": goals.hanging_mass, "line_length": goals.line_length}
    return values


def know_carriage(drive: Drive, goals: Goals, spreads: Mapping[str, float], *, logged: bool) -> Knowledge:
    """What is known of a carriage: data sheet, goals, estimates, which may be nothing or twice as much."""
    sheet, found = by_datasheet(drive, spreads), dict[str, Quantity]()
    for name, value in carriage_values(drive, goals).items():
        if name in sheet:
            found[name] = sheet[name]
            continue
        guessed = name == "rail_friction" and goals.rail_friction is None
        half = value if guessed else spreads[KINDS[name]] * value
        source = GUESS if guessed else DATASHEET if name == "carriage_mass" else GOAL
        found[name] = known(name, value, value - half, value + half, source)
    sure = Knowledge(quantities=found, undetermined=(UNUSED,) if logged else ())
    return sure if goals.load_inertia is None else with_load(sure, goals.load_inertia)


def transporter_with(drive: Drive, values: Mapping[str, float]) -> reduced.Transporter:
    """The transporter of a drive with these numbers; where nothing hangs, a grain stands in for it."""
    assert drive.sensors is not None
    assert drive.sensors.sample_rate is not None
    hanging = "hanging_mass" in values
    r, gravity = drive.drive_pulley.radius, drive.layout.gravity if hanging else GRAVITY
    base = reduced.transporter_of(
        drive,
        payload_mass=values["hanging_mass"] if hanging else GRAIN * drive.carriage[0].mass,
        line_length=values["line_length"] if hanging else gravity / drive.sensors.sample_rate**2,
        rail_friction=values["rail_friction"],
    )
    damping = 2.0 * (reduced.SWING_RATIO if hanging else GRAIN_RATIO) * (base.line_length / gravity) ** 0.5
    return base._replace(
        axial_rigidity=values["cable_stiffness"] * drive.span_length,
        damping_time=values["cable_damping"] / r / values["cable_stiffness"],
        drive_mass=values["near_inertia"] / r**2,
        load_mass=values["load_inertia"] / drive.load_pulley.radius**2,
        carriage_mass=values["carriage_mass"],
        gravity=gravity,
        swing_damping=damping,
        viscous=values["viscous_friction"] / r**2,
        coulomb=values["coulomb_friction"] / r,
        offset=values["offset_torque"] / r,
    )


LOOKED_AT = 9
FINE = 0.3
"""Largest angle of the fastest mode in an internal step [rad]; a sample has `SUBSTEPS` and more."""
STILL = 1e-9
"""Speed below which the carriage is to stand, over the largest."""


class CarriageCase:
    """A carriage along its motion, the feedforward made once: what all its runs share."""

    def __init__(self, drive: Drive, goals: Goals) -> None:
        assert goals.travel is not None
        assert goals.duration is not None
        self.drive, self.values = drive, carriage_values(drive, goals)
        self.design, self.interval = transporter_with(drive, self.values), sample_interval(drive)
        self.hanging = goals.hanging_mass is not None
        way = pulse(goals.travel, goals.duration, goals.dwell, pulses=goals.pulses, order=goals.order)
        time = np.asarray(self.interval * np.arange(round(way.duration / self.interval)), dtype=np.float64)
        y, sensors, (first, second) = way(time, 6), drive.sensors, drive.pulley
        assert sensors is not None
        # (samples,): motion profile of the hanging mass, or of the carriage where nothing hangs [m]
        self.wanted: Array = y[0]
        # (samples,): when a move is over and the next has not begun
        self.standing = (np.abs(y[1]) <= STILL * np.abs(y[1]).max()) & (time >= goals.duration)
        self.reference = control.flat_motion(self.design, y, self.interval)  # (samples, 10)
        # at the rim: a count [m], the largest force [N]
        self.count = 2.0 * pi * first.radius / (sensors.drive_encoder or sensors.motor_encoder or np.inf)
        other = 2.0 * pi * second.radius / (sensors.load_encoder or np.inf)
        both = abs(other / self.count - 1.0) < 1e-9  # of one count
        self.reads = control.ENCODERS if both else control.ENCODERS[:1]
        limit = torque_limit(drive) if goals.torque is None else min(goals.torque, torque_limit(drive))
        self.limit = limit / self.design.radius
        self.ends = (self.design.start, self.design.start + goals.travel)  # of the way [m]
        fastest = 1.2 * max(float(reduced.frozen_frequencies(self.design, x).max()) for x in self.ends)
        self.substeps = max(SUBSTEPS, ceil(fastest * self.interval / FINE))
        self.places: Array = np.linspace(*self.ends, LOOKED_AT)  # where poles are looked at [m]

    @property
    def cable_frequencies(self) -> Array:
        """Of the carriage on the cable at those places, shape (9,) [Hz]."""
        return np.array([cable_frequency(self.design, float(x)) for x in self.places])

    @property
    def left_out(self) -> float:
        """Largest windup of the joint along the motion, and the whole of its backlash, at the rim [m]."""
        motor, r, windup = self.drive.motor, self.design.radius, 0.0
        assert motor is not None
        if motor.joint_stiffness is not None:
            windup = float(np.abs(self.reference[:, 8]).max()) * r**2 / motor.joint_stiffness
        return windup + motor.backlash * r

    def loop(self, hertz: float, *, ideal: bool = False) -> CarriageLoop:
        """The scheduled law of a bandwidth, ready to run; ``hertz`` [Hz]."""
        same: dict[str, Any] = {"interval": self.interval, "count": self.count}
        beyond = MARGIN * self.design.span_length
        law = control.scheduled_law(
            self.design,
            **same,
            limit=self.limit,
            positions=np.linspace(self.ends[0] - beyond, self.ends[1] + beyond, POSITIONS),
            tuning=control.tuning_for(self.design, 2.0 * pi * hertz, **same, hanging=self.hanging),
            reads=self.reads,
        )
        still, count = np.zeros(len(self.reference)), 0.0 if ideal else self.count
        return CarriageLoop(law, self.reference, still, self.interval, self.substeps, count)

    def plant(self, values: Mapping[str, float]) -> reduced.Transporter:
        """The machine with other values."""
        return transporter_with(self.drive, self.values | dict(values))

    def growth(self, loop: CarriageLoop, plant: reduced.Transporter) -> tuple[float, float]:
        """Largest real part of a pole of law, observer and frozen plant on the way [1/s], and where [m]."""
        given = self.interval, control.WIND_TIME
        poles = [control.frozen_poles(loop.law, plant, x, *given) for x in self.places.tolist()]
        radius = [float(np.abs(own).max()) for own in poles]
        worst = int(np.argmax(radius))
        return float(np.log(radius[worst])) / self.interval, float(self.places[worst])

    def errors(self, log: Array) -> Array:
        """Error of the carriage, and of a mass below it, along a log: shape (1 or 2, samples) [m]."""
        n = len(log)
        if not self.hanging:
            return np.asarray(log[:, CARRIAGE] - self.wanted[:n], dtype=np.float64)[None]
        return np.array([log[:, CARRIAGE] - self.reference[:n, CARRIAGE], log[:, PAYLOAD] - self.wanted[:n]])

    def torque(self, log: Array) -> tuple[float, float]:
        """Largest torque of a run [N m], and the share of the samples at the limit."""
        force = np.abs(log[:, FORCE])
        return float(force.max()) * self.design.radius, float(np.mean(force >= (1.0 - 1e-9) * self.limit))


LONGEST, HALVINGS = 64.0, 12
"""How much longer a move is tried, and how finely the shortest is looked for."""
RIGHT = 0.05
"""Largest distance of the model's frequency from the distributed cable's."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CarriageModel:
    """The model of the carriage beside the distributed cable."""

    positions: tuple[float, ...]  # Start, middle and end of the way [m]
    # lumped, exact: frequency of the carriage on the cable at each, without what hangs below it [Hz]
    lumped: tuple[float, ...]
    exact: tuple[float, ...]
    # windup of a joint that is taken as rigid, and its backlash, at the rim [m]; added to every error
    left_out: float
    reason: str  # why it is wrong by more than is allowed; empty where it is right


def carriage_model(drive: Drive, goals: Goals) -> CarriageModel:
    """Hold the model's frequency against the certified one along the way."""
    case, listed = CarriageCase(drive, goals), as_axis(distributed(drive))
    places = tuple(np.linspace(*case.ends, 3).tolist())

    def certified(position: float) -> float:
        there = replace(listed, carriage=(replace(listed.carriage[0], position=position),))
        return float(natural_frequencies(there.machine, count=1)[0])

    lumped = tuple(cable_frequency(case.design, x) for x in places)
    exact = tuple(certified(x) for x in places)
    off, reason = max(abs(one / other - 1.0) for one, other in zip(lumped, exact, strict=True)), ""
    if off > RIGHT:
        reason = (
            f"the carriage model has a massless cable, and its frequency is {100 * off:.2g} % from the "
            f"distributed cable's; {100 * RIGHT:g} % are allowed: a model with the cable's mass is needed"
        )
    return CarriageModel(positions=places, lumped=lumped, exact=exact, left_out=case.left_out, reason=reason)


def carriage_demand(drive: Drive, goals: Goals) -> DemandResult:
    """Torque, speed and tension along the feedforward's motion."""
    demands = _demands(drive, goals)
    exceeded = [demand.name for demand in demands if not demand.met]

    def possible(duration: float) -> bool:
        return all(one.met for one in _demands(drive, replace(goals, duration=duration, pulses=1)))

    assert goals.duration is not None
    short, long = goals.duration, LONGEST * goals.duration
    if not exceeded or not possible(long):
        why = "none of the tried durations is long enough" if exceeded else "no limit is met"
        return DemandResult(demands=demands, shortest=None, binding=why)
    for _ in range(HALVINGS):
        middle = (short * long) ** 0.5
        short, long = (short, middle) if possible(middle) else (middle, long)
    return DemandResult(demands=demands, shortest=long, binding=exceeded[0])


def _demands(drive: Drive, goals: Goals) -> tuple[Demand, ...]:
    case = CarriageCase(drive, goals)
    assert drive.motor is not None
    row, r = case.reference, case.design.radius
    limit, speed = case.limit * r, drive.motor.speed_limit
    bounded = drive.motor.torque_limit is not None or goals.torque is not None
    # Largest fall of a strand's tension, its stiffness that of the place [N].
    q1, s, q2 = row[:: max(1, len(row) // 1000), :3].T
    design, place, ea = case.design, case.design.start + s, case.design.axial_rigidity
    span = design.span_length
    pulled = (ea / place * (s - q1), ea / (span - place) * (q2 - s), ea / span * (q1 - q2))
    lost = max(0.0, -float(np.min(pulled)))
    torque, turn = float(np.abs(row[:, 8]).max()) * r, float(np.abs(row[:, 4]).max()) / r
    return (
        Demand(name="torque", asked=torque, limit=limit if bounded else None, unit="N m"),
        Demand(name="speed", asked=turn, limit=speed, unit="rad/s"),
        Demand(name="lost tension", asked=lost, limit=design.pretension, unit="N"),
    )
