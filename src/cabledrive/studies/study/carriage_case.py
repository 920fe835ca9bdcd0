"""A carriage under its scheduled law, and what its motion asks of motor and cable."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import ceil, pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.control.transporter import WIND_TIME, flat_motion, frozen_poles, scheduled_law, tuning_for
from cabledrive.modal import natural_frequencies
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.quality import with_measured_stiffness
from cabledrive.reduction.transporter import Transporter, frozen_frequencies, strand_stiffness
from cabledrive.rig.carriage import CARRIAGE, FORCE, PAYLOAD, CarriageLoop, force_limit, run_carriage
from cabledrive.rig.setting import sample_interval
from cabledrive.studies.study.carriage_machine import (
    MARGIN,
    cable_frequency,
    carriage_values,
    encoders_read,
    transporter_with,
)
from cabledrive.studies.study.check_stage import Demand, DemandResult
from cabledrive.studies.study.goals import Goals
from cabledrive.trajectories import pulse

POSITIONS, LOOKED_AT = 12, 9
FINE, LEAST_SUBSTEPS = 0.3, 5
"""Largest angle of the fastest mode in an internal step [rad], and the fewest steps in a sample."""
STILL = 1e-9
"""Speed below which the carriage is to stand, over the largest."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CarriageCase:
    """What every run of a carriage shares."""

    drive: Drive
    design: Transporter  # with the best values
    goals: Goals
    hanging: bool  # whether a mass hangs below the carriage
    # (samples,): motion profile of the hanging mass, or of the carriage where nothing hangs [m]
    wanted: Array
    standing: NDArray[np.bool_]  # (samples,): when a move is over and the next has not begun
    reference: Array  # (samples, 10)
    # interval, count, limit: sample time [s], count at the rim [m], largest force at the rim [N]
    interval: float
    count: float
    limit: float
    reads: tuple[int, ...]  # pulleys with an encoder
    substeps: int

    @property
    def ends(self) -> tuple[float, float]:
        """Where the way begins and ends, from the drive pulley [m]."""
        assert self.goals.travel is not None
        return self.design.start, self.design.start + self.goals.travel

    @property
    def places(self) -> Array:
        """Where poles are looked at, shape (9,) [m]."""
        return np.asarray(np.linspace(*self.ends, LOOKED_AT), dtype=np.float64)

    @property
    def cable_frequencies(self) -> Array:
        """Of the carriage on the cable at those places, shape (9,) [Hz]."""
        return np.array([cable_frequency(self.design, float(x)) for x in self.places])


def case_of(drive: Drive, goals: Goals) -> CarriageCase:
    """The motion and its feedforward, made once."""
    assert goals.travel is not None
    assert goals.duration is not None
    design, interval = transporter_with(drive, carriage_values(drive, goals)), sample_interval(drive)
    way = pulse(goals.travel, goals.duration, goals.dwell, pulses=goals.pulses, order=goals.order)
    time = np.asarray(interval * np.arange(round(way.duration / interval)), dtype=np.float64)
    y, (count, reads) = way(time, 6), encoders_read(drive)
    limit = force_limit(drive)
    if goals.torque is not None:
        limit = min(limit, goals.torque / design.radius)
    ends = (design.start, design.start + goals.travel)
    fastest = 1.2 * max(float(frozen_frequencies(design, x).max()) for x in ends)
    return CarriageCase(
        drive=drive,
        design=design,
        goals=goals,
        hanging=goals.hanging_mass is not None,
        wanted=y[0],
        standing=(np.abs(y[1]) <= STILL * np.abs(y[1]).max()) & (time >= goals.duration),
        reference=flat_motion(design, y, interval),
        interval=interval,
        count=count,
        limit=limit,
        reads=reads,
        substeps=max(LEAST_SUBSTEPS, ceil(fastest * interval / FINE)),
    )


def loop_at(case: CarriageCase, hertz: float, *, ideal: bool = False) -> CarriageLoop:
    """The scheduled law of a bandwidth, ready to run; ``hertz`` [Hz]."""
    tuning = tuning_for(
        case.design, 2.0 * pi * hertz, interval=case.interval, count=case.count, hanging=case.hanging
    )
    beyond = MARGIN * case.design.span_length
    law = scheduled_law(
        case.design,
        interval=case.interval,
        count=case.count,
        limit=case.limit,
        positions=np.linspace(case.ends[0] - beyond, case.ends[1] + beyond, POSITIONS),
        tuning=tuning,
        reads=case.reads,
    )
    still, count = np.zeros(len(case.reference)), 0.0 if ideal else case.count
    return CarriageLoop(law, case.reference, still, case.interval, case.substeps, count)


def growth(case: CarriageCase, loop: CarriageLoop, plant: Transporter) -> tuple[float, float]:
    """Largest real part of a pole of law, observer and frozen plant along the way [1/s], and where [m]."""
    radius = [
        float(np.abs(frozen_poles(loop.law, plant, float(x), case.interval, WIND_TIME)).max())
        for x in case.places
    ]
    worst = int(np.argmax(radius))
    return float(np.log(radius[worst])) / case.interval, float(case.places[worst])


def errors(case: CarriageCase, log: Array) -> Array:
    """Error of the carriage, and of a mass below it, along a log: shape (1 or 2, samples) [m]."""
    n = len(log)
    if not case.hanging:
        return np.asarray(log[:, CARRIAGE] - case.wanted[:n], dtype=np.float64)[None]
    return np.array([log[:, CARRIAGE] - case.reference[:n, CARRIAGE], log[:, PAYLOAD] - case.wanted[:n]])


def whole_run(case: CarriageCase, loop: CarriageLoop, values: Mapping[str, float], phases: Array) -> Array:
    """One run on a plant with other values, rows as `run_carriage` has; ``phases``, shape (2,) [counts]."""
    given = carriage_values(case.drive, case.goals) | dict(values)
    return run_carriage(loop, transporter_with(case.drive, given), phases)


def torque_of(case: CarriageCase, log: Array) -> tuple[float, float]:
    """Largest torque of a run [N m], and the share of the samples at the limit."""
    force = np.abs(log[:, FORCE])
    return float(force.max()) * case.design.radius, float(np.mean(force >= (1.0 - 1e-9) * case.limit))


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

    @property
    def deviation(self) -> float:
        """Largest distance of the frequencies, relative."""
        return max(abs(one / other - 1.0) for one, other in zip(self.lumped, self.exact, strict=True))


def carriage_model(drive: Drive, goals: Goals) -> CarriageModel:
    """Hold the model's frequency against the certified one along the way."""
    case, machine = case_of(drive, goals), with_measured_stiffness(drive)
    places = tuple(float(x) for x in np.linspace(*case.ends, 3))

    def certified(position: float) -> float:
        there = replace(machine, carriage=(replace(machine.carriage[0], position=position),))
        return float(natural_frequencies(there, count=1)[0])

    found = CarriageModel(
        positions=places,
        lumped=tuple(cable_frequency(case.design, x) for x in places),
        exact=tuple(certified(x) for x in places),
        left_out=left_out_of(case),
        reason="",
    )
    if found.deviation <= RIGHT:
        return found
    return replace(
        found,
        reason=f"the carriage model has a massless cable, and its frequency is "
        f"{100 * found.deviation:.2g} % from the distributed cable's; {100 * RIGHT:g} % are allowed: a "
        "model with the cable's mass is needed",
    )


def left_out_of(case: CarriageCase) -> float:
    """Largest windup of the joint along the motion, and the whole of its backlash, at the rim [m]."""
    motor, r, windup = case.drive.motor, case.design.radius, 0.0
    assert motor is not None
    if motor.joint_stiffness is not None:
        windup = float(np.abs(case.reference[:, 8]).max()) * r**2 / motor.joint_stiffness
    return windup + motor.backlash * r


def carriage_demand(drive: Drive, goals: Goals) -> DemandResult:
    """Torque, speed and tension along the feedforward's motion."""
    demands = _demands(drive, goals)
    exceeded = [demand.name for demand in demands if not demand.met]
    if not exceeded:
        return DemandResult(demands=demands, shortest=None, binding="no limit is met")

    def possible(duration: float) -> bool:
        return all(one.met for one in _demands(drive, replace(goals, duration=duration, pulses=1)))

    assert goals.duration is not None
    short, long = goals.duration, LONGEST * goals.duration
    if not possible(long):
        why = "none of the tried durations is long enough"
        return DemandResult(demands=demands, shortest=None, binding=why)
    for _ in range(HALVINGS):
        middle = (short * long) ** 0.5
        short, long = (short, middle) if possible(middle) else (middle, long)
    return DemandResult(demands=demands, shortest=long, binding=exceeded[0])


def _demands(drive: Drive, goals: Goals) -> tuple[Demand, ...]:
    case = case_of(drive, goals)
    assert drive.motor is not None
    row, r = case.reference, case.design.radius
    limit, speed = case.limit * r, drive.motor.speed_limit
    bounded = drive.motor.torque_limit is not None or goals.torque is not None
    lost, design = 0.0, case.design  # largest fall of a strand's tension, its stiffness that of the place [N]
    for k in range(0, len(row), max(1, len(row) // 1000)):
        q1, s, q2 = row[k, :3]
        strands = strand_stiffness(design, design.start + float(s))
        pulled = (s - q1, q2 - s, q1 - q2)
        lost = max(lost, *(float(-stiff * e) for stiff, e in zip(strands, pulled, strict=True)))
    torque, turn = float(np.abs(row[:, 8]).max()) * r, float(np.abs(row[:, 4]).max()) / r
    return (
        Demand(name="torque", asked=torque, limit=limit if bounded else None, unit="N m"),
        Demand(name="speed", asked=turn, limit=speed, unit="rad/s"),
        Demand(name="lost tension", asked=lost, limit=design.pretension, unit="N"),
    )
