"""What the motion of a carriage asks of motor and cable, and the model that its law is made for."""

from dataclasses import dataclass, replace

import numpy as np

from cabledrive.modal import natural_frequencies
from cabledrive.parameters import Drive
from cabledrive.reduction.quality import with_measured_stiffness
from cabledrive.reduction.transporter import strand_stiffness
from cabledrive.studies.study.carriage_case import Array, CarriageCase, case_of
from cabledrive.studies.study.carriage_machine import cable_frequency
from cabledrive.studies.study.demand_stage import Demand, DemandResult
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.machine import has_flexible_joint

LONGEST, HALVINGS = 64.0, 12
"""How much longer a move is tried, and how finely the shortest is looked for."""
RIGHT = 0.05
"""Largest distance of the model's frequency from the distributed cable's."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CarriageModel:
    """The model of the carriage beside the distributed cable.

    Attributes
    ----------
    positions : tuple of float
        Start, middle and end of the way [m].
    lumped, exact : tuple of float
        Frequency of the carriage on the cable at each, without what hangs below it [Hz].
    left_out : float
        Windup of a joint that is taken as rigid, and its backlash, at the rim [m]; added to every error.
    reason : str
        Why it is wrong by more than is allowed; empty where it is right.
    """

    positions: tuple[float, ...]
    lumped: tuple[float, ...]
    exact: tuple[float, ...]
    left_out: float
    reason: str

    @property
    def deviation(self) -> float:
        """Largest distance of the frequencies, relative."""
        return max(abs(one / other - 1.0) for one, other in zip(self.lumped, self.exact, strict=True))


def carriage_model(drive: Drive, goals: Goals) -> CarriageModel:
    """Hold the model's frequency against the certified one along the way."""
    case, machine = case_of(drive, goals), with_measured_stiffness(drive)
    places = tuple(float(x) for x in np.linspace(*case.ends, 3))
    found = CarriageModel(
        positions=places,
        lumped=tuple(cable_frequency(case.design, x) for x in places),
        exact=tuple(_certified(machine, x) for x in places),
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


def _certified(drive: Drive, position: float) -> float:
    there = replace(drive, carriage=(replace(drive.carriage[0], position=position),))
    return float(natural_frequencies(there, count=1)[0])


def left_out_of(case: CarriageCase) -> float:
    """Largest windup of the joint along the motion, and the whole of its backlash, at the rim [m]."""
    motor, r = case.drive.motor, case.design.radius
    assert motor is not None
    windup = 0.0
    if has_flexible_joint(case.drive):
        assert motor.joint_stiffness is not None
        windup = float(np.abs(case.reference[:, 8]).max()) * r**2 / motor.joint_stiffness
    return windup + motor.backlash * r


def carriage_demand(drive: Drive, goals: Goals) -> DemandResult:
    """Torque, speed and tension along the feedforward's motion."""
    demands = _demands(drive, goals)
    exceeded = [demand.name for demand in demands if not demand.met]
    if not exceeded:
        return DemandResult(demands=demands, shortest=None, binding="no limit is met")
    assert goals.duration is not None
    long = LONGEST * goals.duration
    if not _possible(drive, goals, long):
        return DemandResult(
            demands=demands, shortest=None, binding="none of the tried durations is long enough"
        )
    short = goals.duration
    for _ in range(HALVINGS):
        middle = (short * long) ** 0.5
        short, long = (short, middle) if _possible(drive, goals, middle) else (middle, long)
    return DemandResult(demands=demands, shortest=long, binding=exceeded[0])


def _possible(drive: Drive, goals: Goals, duration: float) -> bool:
    return all(one.met for one in _demands(drive, replace(goals, duration=duration, pulses=1)))


def _demands(drive: Drive, goals: Goals) -> tuple[Demand, ...]:
    case = case_of(drive, goals)
    assert drive.motor is not None
    row, r = case.reference, case.design.radius
    limit, speed = case.limit * r, drive.motor.speed_limit
    bounded = drive.motor.torque_limit is not None or goals.torque is not None
    return (
        Demand(
            name="torque",
            asked=float(np.abs(row[:, 8]).max()) * r,
            limit=limit if bounded else None,
            unit="N m",
        ),
        Demand(name="speed", asked=float(np.abs(row[:, 4]).max()) / r, limit=speed, unit="rad/s"),
        Demand(
            name="lost tension",
            asked=_lost_tension(case, row),
            limit=case.design.pretension,
            unit="N",
        ),
    )


def _lost_tension(case: CarriageCase, row: Array) -> float:
    """Largest fall of a strand's tension along the motion, its stiffness that of the place [N]."""
    design = case.design
    lost = 0.0
    for k in range(0, len(row), max(1, len(row) // 1000)):
        q1, s, q2 = row[k, :3]
        strands = strand_stiffness(design, design.start + float(s))
        pulled = (s - q1, q2 - s, q1 - q2)
        lost = max(lost, *(-stiff * e for stiff, e in zip(strands, pulled, strict=True)))
    return float(lost)
