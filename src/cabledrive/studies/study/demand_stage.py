"""What the motion asks of motor and cable, before any controller: torque, speed, slack."""

from dataclasses import dataclass, replace

import numpy as np

from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.rig.setting import DEGREE, Motion
from cabledrive.studies.study.machine import values_of
from cabledrive.studies.study.resonance_stage import motion_torque
from cabledrive.trajectories import move_limits, shortest_rise

UNITS = {"torque": "N m", "speed": "rad/s", "slack_torque": "N m"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Demand:
    """One thing that is asked, and what there is.

    Attributes
    ----------
    name : {"torque", "speed", "slack_torque"}
    asked : float
        Largest along the motion.
    limit : float or None
        None: no limit is known.
    unit : str
    """

    name: str
    asked: float
    limit: float | None
    unit: str

    @property
    def met(self) -> bool:
        """Whether the limit is kept."""
        return self.limit is None or self.asked <= self.limit


@dataclass(frozen=True, slots=True, kw_only=True)
class DemandResult:
    """Everything that the motion asks for.

    Attributes
    ----------
    demands : tuple of Demand
    shortest : float or None
        Shortest duration of this move within the limits, by an upper bound of the demand [s].
    binding : str
        The limit that decides it, or why there is none.
    """

    demands: tuple[Demand, ...]
    shortest: float | None
    binding: str

    @property
    def exceeded(self) -> tuple[Demand, ...]:
        """What is asked beyond its limit."""
        return tuple(demand for demand in self.demands if not demand.met)


def demand_of(drive: Drive, motion: Motion, torque: float | None) -> DemandResult:
    """What a motion asks of a drive.

    ``drive``: with the best values; ``torque``: largest torque of the goals [N m].
    """
    limits = move_limits(drive)
    limits = limits if torque is None else replace(limits, torque=min(limits.torque, torque))
    _, along = motion_torque(drive, motion)
    gear = drive.load_pulley.radius / drive.drive_pulley.radius
    time = np.linspace(0.0, motion.trajectory.duration, 4001)
    _, speed, acceleration = motion.trajectory(time, 2)
    through = values_of(drive)["load_inertia"] / gear * np.abs(acceleration).max()
    found = [
        Demand(name="torque", asked=float(np.abs(along).max()), limit=_finite(limits.torque), unit="N m"),
        Demand(name="speed", asked=float(np.abs(speed).max()), limit=_finite(limits.speed), unit="rad/s"),
    ]
    if drive.kind == "loop":
        slack = _finite(limits.slack_torque)
        found.append(Demand(name="slack_torque", asked=float(through), limit=slack, unit="N m"))
    try:
        shortest, binding = shortest_rise(limits, motion.angle * DEGREE, motion.rise_order)
    except (InputRefused, NotComputed) as failure:
        return DemandResult(demands=tuple(found), shortest=None, binding=str(failure))
    return DemandResult(demands=tuple(found), shortest=shortest, binding=binding)


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
