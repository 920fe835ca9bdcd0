"""What is asked of the rig: the motion, the sensors, the disturbances, as frozen options."""

from dataclasses import dataclass, field
from math import isfinite, pi

from cabledrive.parameters import Drive, InputRefused
from cabledrive.trajectories import Trajectory, pulse

DEGREE = pi / 180.0
CABLE = "cable"
DISSERTATION_ORDER = 9


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """Pulses (6.1)-(6.8) of the load pulley.

    Attributes
    ----------
    angle : float
        [deg].
    rise, dwell : float
        [s].
    pulses : int
    order : int or None
        Odd order of the rise; None: in `track` what the law needs, elsewhere 9, as in (6.1).
    """

    angle: float = 45.0
    rise: float = 0.5
    dwell: float = 0.5
    pulses: int = 1
    order: int | None = None

    @property
    def rise_order(self) -> int:
        """Order of the rise, 9 where none was asked for."""
        return DISSERTATION_ORDER if self.order is None else self.order

    @property
    def trajectory(self) -> Trajectory:
        """The motion of the load pulley [rad]."""
        return pulse(self.angle * DEGREE, self.rise, self.dwell, pulses=self.pulses, order=self.rise_order)


@dataclass(frozen=True, slots=True, kw_only=True)
class Disturbance:
    """A torque that steps in.

    Attributes
    ----------
    torque : float
        [N m], at the first shaft.
    start, end : float
        [s].
    on : {"motor", "load"}
    """

    torque: float
    start: float
    end: float
    on: str = "load"

    def __post_init__(self) -> None:
        if self.on not in ("motor", "load"):
            raise InputRefused(f'disturbance on "{self.on}" is not known: take motor or load')
        if not isfinite(self.torque):
            raise InputRefused(f"disturbance = {self.torque:.4g} N m must be finite: give a torque")
        if not 0.0 <= self.start < self.end:
            raise InputRefused(
                f"disturbance from {self.start:.4g} s to {self.end:.4g} s is no time: swap them"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class RigOptions:
    """How the rig differs from an ideal one.

    Attributes
    ----------
    observer : {"kalman", "difference"}
    feedback : {"motor", "drive"}
        Encoder that stands for theta_1 in Models 1 and 3.
    encoder_phase : {"random", "centred"}
        Where in its count each encoder starts; where it is known, the filter has no states for offsets.
    ideal_sensors : bool
        The law sees true angles and speeds.
    smooth_friction : bool
        c tanh(50 w) in the plant instead of stick-slip.
    jitter : float
        Standard deviation of the sample times [s].
    disturbances : tuple of Disturbance
    substeps : int
        Internal steps of the plant per sample; the result does not depend on them.
    forbid_slack : bool
        Whether a span that goes slack ends the run; else it carries nothing while it is slack.
    blind : tuple of (str, float, float), or None
        Encoder ("motor", "drive", "load") that gives NaN from one time to another [s].
    as_printed : bool
        The distributed cable keeps its own EA and axial damping where ``[lumped]`` says otherwise.
    segments : int
        Of each span of the distributed cable.
    check_conditions : bool
        Whether the conditions on the robust term are checked along the run.
    """

    observer: str = "kalman"
    feedback: str = "motor"
    encoder_phase: str = "random"
    ideal_sensors: bool = False
    smooth_friction: bool = False
    jitter: float = 0.0
    disturbances: tuple[Disturbance, ...] = field(default=())
    substeps: int = 1
    forbid_slack: bool = True
    blind: tuple[str, float, float] | None = None
    as_printed: bool = False
    segments: int = 8
    check_conditions: bool = False

    def __post_init__(self) -> None:
        for name, words in (
            ("observer", ("kalman", "difference")),
            ("feedback", ("motor", "drive")),
            ("encoder_phase", ("random", "centred")),
        ):
            if getattr(self, name) not in words:
                raise InputRefused(
                    f"{name} = {getattr(self, name)!r} is not known: take {' or '.join(words)}"
                )
        if self.segments < 3:
            raise InputRefused(f"segments = {self.segments} per span are too few: give at least 3")
        if not isfinite(self.jitter) or self.jitter < 0.0:
            raise InputRefused(f"jitter = {self.jitter:.4g} s must not be negative: give a time in seconds")


def sample_interval(drive: Drive) -> float:
    """Sample time of a drive.

    Returns [s].
    Raises `InputRefused` if the drive names no sample rate.
    """
    if drive.sensors is None or drive.sensors.sample_rate is None:
        raise InputRefused('sensors.sample_rate is missing: add it, such as sample_rate = "5 kHz"')
    return 1.0 / drive.sensors.sample_rate
