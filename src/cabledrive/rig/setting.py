"""What is asked of the rig, motion and options, both as words; the memory and time that a run may take."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite, pi, sqrt
from typing import Any, ClassVar, Self

import numpy as np

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import check_fields, choice, described, meaning, nearest, quantity
from cabledrive.parameters.units import to_si
from cabledrive.trajectories import Trajectory, pulse

DEGREE = pi / 180.0
CABLE, SHAFTS = "cable", ("motor", "drive", "load")
DISSERTATION_ORDER = 9
PAYLOAD_RANGE = (0.5, 3.0)


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Payload:
    """A load that is announced to the law, from a time on."""

    factor: float = meaning("inertia of the load over that of the drive [-]")
    start: float = meaning("from when on [s]", 0.0)

    def __post_init__(self) -> None:
        if not 0.0 < self.factor < inf:
            raise InputRefused(f"payload = {self.factor:.4g} must be finite and above 0: give a factor")
        if not 0.0 <= self.start < inf:
            raise InputRefused(f"payload from {self.start:.4g} s on is no time: give 0 s or more")


class Task(ABC):
    """What is asked of a load: its way over the time, with the derivatives that a law follows."""

    __slots__ = ()
    unit: ClassVar[str]  # of the way, {"rad", "m"}
    of: ClassVar[str]  # what moves, in words

    @property
    @abstractmethod
    def trajectory(self) -> Trajectory:
        """The way over the time."""

    def samples(self, interval: float) -> int:
        """Of a run, its ends included, every ``interval`` [s]; refused beyond `MOST_MEMORY`."""
        duration = self.trajectory.duration
        size = BYTES_PER_SAMPLE * duration / interval
        if size > MOST_MEMORY:
            raise InputRefused(
                f"a motion of {duration:.4g} s takes {duration / interval:.3g} samples and {size / 1e9:.3g} "
                f"GB; at most {MOST_MEMORY / 1e9:.0f} GB are used, {duration * MOST_MEMORY / size:.4g} s: "
                "shorten rise, dwell or pulses"
            )
        return round(duration / interval) + 1

    def sampled(self, interval: float, derivatives: int) -> Array:
        """Way and derivatives at each sample, shape (derivatives + 1, samples), in `unit` per s and so on."""
        time = np.asarray(interval * np.arange(self.samples(interval)), dtype=np.float64)
        return self.trajectory(time, derivatives)

    @classmethod
    def asked(cls, given: "Task | None") -> Self:
        """The task that is given, by default the usual one; of another kind it is refused."""
        if given is None or isinstance(given, cls):
            return given or cls()
        said = f"motion = {type(given).__name__}(...) is for {given.of}"
        raise InputRefused(f"{said}: give {cls.__name__}(...), for {cls.of}")


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Pulses(Task):
    """There and back, any number of times."""

    rise: float | None = meaning("duration of a move [s]", 0.5)
    dwell: float = meaning("rest after each move [s]", 0.5)
    pulses: int = meaning("times there and back", 1)
    order: int | None = meaning(
        "odd order of the rise; None: in `track` of a load what the law needs, elsewhere 9, as in (6.1)", None
    )

    @property
    def way(self) -> float:
        """Of one pulse, in `unit`."""
        return 1.0

    @property
    def rise_order(self) -> int:
        """Order of the rise, 9 where none was asked for."""
        return DISSERTATION_ORDER if self.order is None else self.order

    @property
    def trajectory(self) -> Trajectory:
        """Pulses (6.1)-(6.8)."""
        assert self.rise is not None
        return pulse(self.way, self.rise, self.dwell, pulses=self.pulses, order=self.rise_order)

    @property
    def words(self) -> dict[str, Any]:
        """How the pulses go, as an answer has it."""
        return {"rise": self.rise, "dwell": self.dwell, "pulses": self.pulses, "order": self.rise_order}


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Motion(Pulses):
    """Pulses (6.1)-(6.8) of the load pulley."""

    unit = "rad"
    of = "pulses of a load pulley"

    angle: float = meaning("of a pulse [deg]", 45.0)
    rise: float = meaning("duration of a move [s]", 0.5)
    payload: tuple[Payload, ...] = meaning(
        "loads announced along the motion, in any order; until the first the drive's own. The plant "
        "keeps its load whatever is announced: that changes by ``RigOptions.load_change`` or a "
        "comparison's disturbances",
        (),
    )
    payload_range: tuple[float, float] = meaning(
        "least and largest load that a law scheduled by it is designed for, as factors of the drive's [-]",
        PAYLOAD_RANGE,
    )

    def __post_init__(self) -> None:
        low, high = self.payload_range
        if not (0.0 < low <= 1.0 <= high < inf and low < high):
            said = f"payload_range = {low:.4g} to {high:.4g} must hold 1, the drive's own load"
            raise InputRefused(f"{said}: give the least and the largest factor, such as 0.5 to 3")
        for one in self.payload:
            if not low <= one.factor <= high:
                raise InputRefused(
                    f"payload = {one.factor:.4g} times the load of the drive at {one.start:.4g} s is outside "
                    f"the range of the design, {low:.4g} to {high:.4g}: widen --payload-range (payload_range)"
                )

    @property
    def way(self) -> float:
        """Of the load pulley [rad]."""
        return self.angle * DEGREE


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class BodyMotion(Pulses):
    """How far a body between two winches goes and comes back; its way is the part of the moves."""

    unit = "m"
    of = "a body between two winches"

    moves: Mapping[str, float] = meaning(
        'of each coordinate, such as ``{"camera.x": 2.0}`` [m]; empty: a twentieth of the distance '
        "between the last pulleys, in the first coordinate",
        factory=dict,
    )
    rise: float | None = meaning(
        "duration of a move [s]; None: the shortest that uses at most 80 % of tension, torque and speed", None
    )


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Disturbance:
    """A torque that steps in, or a force on a body."""

    torque: float = meaning("at the first shaft [N m]; on a coordinate of a body its force [N]")
    start: float = meaning("[s]")
    end: float = meaning("[s]")
    on: str = meaning(
        '"motor", "load", or a coordinate of a body between two winches, such as "camera.x"', "load"
    )

    def __post_init__(self) -> None:
        if self.on not in ("motor", "load") and "." not in self.on:
            raise InputRefused(f'disturbance on "{self.on[:60]}" is not known: take motor or load')
        if not isfinite(self.torque):
            raise InputRefused(
                f"disturbance = {self.torque:.4g} on {self.on[:60]} must be finite: give a torque or a force"
            )
        if not 0.0 <= self.start < self.end:
            raise InputRefused(
                f"disturbance from {self.start:.4g} s to {self.end:.4g} s is no time: swap them"
            )


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class RigOptions:
    """How the rig differs from an ideal one."""

    observer: str = choice(("kalman", "difference"), "what makes states of the readings", "kalman")
    feedback: str = choice(("motor", "drive"), "encoder that stands for theta_1 in Models 1 and 3", "motor")
    encoder_phase: str = choice(
        ("random", "centred"),
        "where in its count each encoder starts; where it is known, the filter has no states for offsets",
        "random",
    )
    ideal_sensors: bool = meaning("the law sees true angles and speeds", False)
    smooth_friction: bool = meaning("c tanh(50 w) in the plant instead of stick-slip", False)
    jitter: float = quantity("s", "nonnegative", "standard deviation of the sample times", 0.0)
    disturbances: tuple[Disturbance, ...] = meaning("torques and forces that step in", ())
    substeps: int = meaning("internal steps of the plant per sample; the result does not depend on them", 1)
    forbid_slack: bool = meaning(
        "whether a span that goes slack ends the run; else it carries nothing while it is slack", True
    )
    blind: tuple[str, float, float] | None = meaning(
        'encoder ("motor", "drive", "load") that gives NaN from one time to another [s]', None
    )
    as_printed: bool = meaning(
        "the distributed cable keeps its own EA and axial damping where ``[lumped]`` says otherwise", False
    )
    segments: int = meaning("of each span of the distributed cable", 8)
    check_conditions: bool = meaning(
        "whether the conditions on the robust term are checked along the run", False
    )
    pair: bool = meaning(
        "a second motor and gear like the first on the drive pulley, preloaded against it", False
    )
    preload: float | None = meaning(
        "torque with which the motors of a pair press against each other [N m]; None: a quarter of "
        "the limit of one",
        None,
    )
    load_change: tuple[float, float] | None = meaning(
        "time [s] from which the load has another inertia, and its factor; a law learns of it by "
        "what is announced, ``Motion.payload``, alone",
        None,
    )

    def __post_init__(self) -> None:
        check_fields(self)
        if self.load_change is not None:
            Payload(factor=self.load_change[1], start=self.load_change[0])  # refuses no time and no inertia
        if self.preload is not None and not self.pair:
            raise InputRefused("preload is that of a pair of motors: add --pair (pair=True), or leave it out")
        if self.segments < 3:
            raise InputRefused(f"segments = {self.segments} per span are too few: give at least 3")


def none(key: str, why: str) -> dict[str, Any]:
    """A figure of an answer that there is not, and why."""
    return {key: None, f"{key}_reason": why}


def sample_interval(drive: Drive) -> float:
    """Sample time of a drive [s]."""
    if drive.sensors is None or drive.sensors.sample_rate is None:
        raise InputRefused('sensors.sample_rate is missing: add it, such as sample_rate = "5 kHz"')
    return 1.0 / drive.sensors.sample_rate


def current_rate(drive: Drive) -> float:
    """Bandwidth of the torque loop [rad/s]; 0 where it is ideal."""
    hertz = drive.motor.current_bandwidth if drive.motor else None
    return 0.0 if hertz is None else 2.0 * pi * hertz


def control_delay(drive: Drive) -> float:
    """Time from sampling to torque [s]; 0 where the drive names no sensors."""
    return drive.sensors.delay if drive.sensors else 0.0


def torque_limit(drive: Drive) -> float:
    """Largest torque [N m]; infinite where the drive names none."""
    limit = drive.motor.torque_limit if drive.motor else None
    return float("inf") if limit is None else limit


def stepped_in(
    disturbances: Sequence[Disturbance], names: Sequence[str], interval: float, samples: int
) -> Array:
    """Disturbances from each sample to the next, shape (samples, names) [N m] or [N]."""
    found = np.zeros((samples, len(names)))
    for step in disturbances:
        if step.on not in names:
            raise InputRefused(
                f'disturbance on "{step.on[:60]}" is none of {", ".join(names)}'
                f"{nearest(step.on[:60], list(names))}: take one of these"
            )
        last = samples if step.end >= samples * interval else round(step.end / interval)
        found[round(step.start / interval) : last, names.index(step.on)] += step.torque
    return found


def parse_disturbance(words: str) -> Disturbance:
    """A torque or a force that steps in: shaft or coordinate, size, start and end."""
    parts = words.split(":")
    if len(parts) not in (3, 4):
        raise InputRefused(
            f'disturbance "{words[:60]}" is not SHAFT:TORQUE:START:END: write load:0.05:0.3:0.6, or for a '
            "body between two winches COORDINATE:FORCE:START:END, such as camera.x:30:1:1.5"
        )
    end = to_si(parts[3], "s") if len(parts) == 4 else float("inf")
    unit = "N" if "." in parts[0] else "N m"
    return Disturbance(torque=to_si(parts[1], unit), start=to_si(parts[2], "s"), end=end, on=parts[0])


def parse_encoder_dropout(words: str | None) -> tuple[str, float, float] | None:
    """An encoder that gives no number for a while: shaft, start and end [s]."""
    if words is None:
        return None
    parts = words.split(":")
    if len(parts) != 3 or parts[0] not in SHAFTS:
        raise InputRefused(f'encoder dropout "{words[:60]}" is not SHAFT:START:END: write load:0.1:0.11')
    start, end = to_si(parts[1], "s"), to_si(parts[2], "s")
    if not (isfinite(start) and isfinite(end) and 0.0 <= start <= end):
        raise InputRefused(
            f'encoder dropout "{words[:60]}": from {start:.4g} s to {end:.4g} s is no time: swap them'
        )
    return parts[0], start, end


def random_from(seed: int) -> np.random.Generator:
    """A generator for phases, noise and draws; refused if the seed is negative."""
    if seed < 0:
        raise InputRefused(f"seed = {seed} must not be negative: give 0 or more")
    return np.random.default_rng(seed)


MOST_MEMORY = 4e9
"""Of the record of one run [bytes]."""
BYTES_PER_SAMPLE = 600.0
"""States, readings, estimates, reference and bound of one sample, measured at the process."""
MOST_DRAWS = 100_000
MOST_DRAWN_SAMPLES = 1e11
"""Of all draws together: about a day of one core."""
MOST_SEGMENT_STEPS = 1e13
"""Steps times segments of the cable as plant: about a day of one core."""
MOST_JITTER = 0.4
"""Standard deviation of the sample times, in samples: later samples would change places."""


def check_run(
    drive: Drive, motion: Motion, options: RigOptions, *, draws: int = 0, cable: bool = False
) -> None:
    """Refuse a run, with ``draws`` more, that would not end or not fit into memory, or a late disturbance."""
    if not isfinite(motion.angle):
        raise InputRefused(f"angle = {motion.angle:.4g} deg must be finite: give one in deg")
    interval, duration = sample_interval(drive), motion.trajectory.duration
    check_runs(motion, interval, options, draws)
    if options.jitter > MOST_JITTER * interval:
        said = f"jitter = {options.jitter:.4g} s is above {MOST_JITTER:g} of the sample time {interval:.4g} s"
        raise InputRefused(f"{said}: give at most {MOST_JITTER * interval:.4g} s")
    if control_delay(drive) >= duration:
        said = f"sensors.delay = {control_delay(drive):.4g} s is not below the {duration:.4g} s of the motion"
        raise InputRefused(f"{said}, in which no torque would act: shorten the delay")
    if not cable and options.segments != RigOptions().segments:
        raise InputRefused(f"segments = {options.segments} divide the cable as plant: leave them out")
    if cable:  # by the steps that a wave along it asks for
        machine = drive.axis.machine
        speed = max(sqrt(rope.axial_rigidity / rope.density) for rope in machine.ropes)
        per_second = speed / max(span.length for span in machine.free_spans)
        most = int(sqrt(MOST_SEGMENT_STEPS / (2.0 * duration * per_second)))
        if options.segments > most:
            raise InputRefused(
                f"segments = {options.segments} are more than the {most} per span that a motion of "
                f"{duration:.4g} s allows: take fewer, or shorten the motion"
            )


def check_runs(task: Task, interval: float, options: RigOptions, draws: int = 0) -> None:
    """The same of any task, by its sample time [s]."""
    duration = task.trajectory.duration
    most = min(MOST_DRAWS, int(MOST_DRAWN_SAMPLES / task.samples(interval)))
    if draws < 0:
        raise InputRefused(f"draws = {draws} must not be negative: ask for 0 or more")
    if draws > most:
        raise InputRefused(f"draws = {draws} are more than the {most} that this motion allows: ask for fewer")
    starts = [(f"disturbance on {step.on}", step.start) for step in options.disturbances]
    if options.blind is not None:
        starts.append((f"dropout of the {options.blind[0]} encoder", options.blind[1]))
    for what, start in starts:
        if start >= duration:
            raise InputRefused(
                f"{what}: starts at {start:.4g} s, the motion ends at {duration:.4g} s: start earlier"
            )
