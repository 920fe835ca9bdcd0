"""Control laws by name, made ready for a drive, a motion and the rig's sensors."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from math import pi
from typing import Any

import numpy as np

from cabledrive.control.darc import Bounds, darc_gains, darc_numbers, printed_bounds
from cabledrive.control.load_schedule import LoadSchedule, scheduled_filter, with_load
from cabledrive.control.numbers import DIFFERENCE, IDEAL, LawNumbers, ObserverNumbers
from cabledrive.control.observers import QUIET, KalmanTuning, Sampling, kalman_filter, plain_observer
from cabledrive.control.own_controller import OwnController
from cabledrive.control.reference import (
    FlatOutput,
    MotionNumbers,
    ReferenceNumbers,
    flat_generator,
    flat_output,
)
from cabledrive.control.reference_kernels import reference_table
from cabledrive.mechanics.holding import released
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import (
    FLEXIBLE_JOINT,
    LumpedChain,
    highest_model,
    lumped_model,
    reflected,
)
from cabledrive.rig.setting import DEGREE, Motion, RigOptions, control_delay, current_rate, sample_interval
from cabledrive.trajectories.limits import rise_coefficients

SHAFTS = ("motor", "drive", "load")


def plant_chain(drive: Drive, model: int | None) -> LumpedChain:
    """The lumped chain under control, at the first shaft; default: the highest model that the data allow."""
    return reflected(lumped_model(released(drive), model))[0]


def slack_twist(drive: Drive, chain: LumpedChain) -> float:
    """Twist between the pulleys at which one span carries no tension [rad]."""
    if not drive.closed or "load" not in chain.names or chain.size < 2:
        return float("inf")
    return 2.0 * drive.drive_pulley.radius * drive.cable.pretension / chain.stiffness[-1]


def joint_backlash(drive: Drive, chain: LumpedChain) -> float:
    """Backlash of the gearhead, which lies in the motor's joint [rad]; 0 where that is rigid in the plant."""
    flexible = "motor" in chain.names and "drive" in chain.names
    return drive.motor.backlash if drive.motor is not None and flexible else 0.0


def place(chain: LumpedChain, shaft: str) -> int:
    """Inertia of a chain that a shaft belongs to."""
    if shaft == "load":
        return chain.size - 1
    return chain.names.index(shaft) if shaft in chain.names else 0


def load_gear(drive: Drive) -> float:
    """Angle of the first shaft per angle of the load pulley, r2 / r1 [-]."""
    return drive.load_pulley.radius / drive.drive_pulley.radius


def fitted_encoders(drive: Drive, only: Sequence[str] | None = None) -> dict[str, float]:
    """Count of each encoder at the first shaft [rad], the load's last; ``only``: of these shafts alone."""
    sensors = drive.sensors
    counts = {shaft: getattr(sensors, f"{shaft}_encoder") if sensors else None for shaft in SHAFTS}
    if not any(counts.values()):
        raise InputRefused("sensors has no encoder, nothing is measured: add motor_encoder, such as 10000")
    gears = {"motor": 1.0, "drive": 1.0, "load": load_gear(drive)}
    return {
        shaft: 2.0 * pi / number * gears[shaft]
        for shaft, number in counts.items()
        if number is not None and (only is None or shaft in only)
    }


def load_count(drive: Drive) -> float:
    """One count of the load's encoder, else of the one nearest to it, at the first shaft [rad]."""
    return list(fitted_encoders(drive).values())[-1]


def law_shafts(model: int, feedback: str) -> tuple[str, ...]:
    """Shafts whose angles a law of a model takes, from the motor to the load."""
    return {1: (feedback,), 2: SHAFTS[:2], 3: (feedback, "load"), 4: SHAFTS}[model]


def fit_observer(
    made: "Controller",
    chains: tuple[LumpedChain, LumpedChain],
    fitted: dict[str, float],
    options: RigOptions,
    sampling: Sampling,
    *,
    settled: bool = False,
) -> ObserverNumbers:
    """Observer of a law; ``chains``: of its design, and the plant; ``fitted``: counts of what it reads."""
    (design, plant), shafts, schedule = chains, made.shafts, made.schedule
    if options.ideal_sensors:
        chosen = [place(plant, one) for one in shafts]
        return plain_observer(IDEAL, plant.size, sampling.interval, chosen)
    if options.observer == "difference":
        names = list(fitted)
        missing = [shaft for shaft in shafts if shaft not in fitted]
        if missing:
            said = f"sensors.{missing[0]}_encoder is missing, the difference needs it"
            raise InputRefused(f"{said}: add it, or take the Kalman filter")
        chosen = [names.index(shaft) for shaft in shafts]
        return plain_observer(DIFFERENCE, len(names), sampling.interval, chosen)
    tuning = replace(made.tuning, offsets=()) if options.encoder_phase == "centred" else made.tuning
    designs = [design] if schedule is None else [with_load(design, load) for load in schedule.loads]
    places, chosen = ([place(design, one) for one in names] for names in (fitted, shafts))
    settled = settled or schedule is not None
    read = list(zip(places, fitted.values(), strict=True))
    filters = [
        kalman_filter(one, read, sampling, chosen=chosen, tuning=tuning, settled=settled) for one in designs
    ]
    return filters[0] if schedule is None else scheduled_filter(filters, schedule)


DAMPED_SHARE = 0.1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Controller:
    """A law with its reference, ready to run."""

    name: str
    law: LawNumbers
    reference: Array  # (samples, columns): what the law takes at each sample
    shafts: tuple[str, ...]  # shafts whose angles it takes, from the motor to the load
    start: Array = field(default_factory=lambda: np.zeros(0))  # parameter estimates to begin with
    tuning: KalmanTuning = QUIET
    gains: dict[str, Any]  # what it was tuned to, in the units of their names
    model: int  # Model that it was made for
    damped: bool = True  # whether it counts the damping of joint and cable
    bandwidth: float | None = None  # lambda of a law of the chain [rad/s]
    flat: FlatOutput | None = None
    # Model of the Kalman filter; None: the highest that the drive's data allow, with every encoder. A filter
    # of the law's own model reads only the encoders that the law takes
    filter_model: int | None = None
    # lumped chain of the Kalman filter, where it is no model of the drive; it reads every encoder
    filter_chain: LumpedChain | None = None
    own: OwnController | None = None  # the user's own, which runs instead of ``law``
    # what makes the rows of ``reference`` from the time alone, on a target
    generator: ReferenceNumbers | None = None
    # of a law that learns the load's torque, (p, samples, 2n): angles and speeds that go with a unit of each
    # parameter of the load, see `cabledrive.control.bound`
    load_motion: Array | None = None
    schedule: LoadSchedule | None = None  # of a law whose gains go by an announced load
    # of laws that go by the load the chain that they are made for, with the drive's own load
    believed: LumpedChain | None = None
    # of a stepper, whose command is the angle of its field [rad]: largest torque [N m], periods per radian
    field: tuple[float, float] | None = None
    # by how much the motion comes late as a whole, and errors are counted against it so late [s]
    late: float = 0.0

    @property
    def load(self) -> float | None:
        """Inertia of the drive's own load where the law goes by it, at the first shaft [kg m^2]."""
        return None if self.believed is None else self.believed.inertias[-1]


@dataclass(frozen=True, slots=True, kw_only=True)
class Spreads:
    """Relative half widths of what the bounds of p2 to p5 do not say."""

    cable_stiffness: float = 0.05
    load_inertia: float = 0.05
    cable_damping: float = 0.2
    joint_damping: float = 0.2
    joint_stiffness: float = 0.1
    drive_inertia: float = 0.05


@dataclass(frozen=True, slots=True)
class DesignSpec:
    """What a law is to be designed for."""

    drive: Drive  # as the design believes it to be
    motion: Motion
    _: KW_ONLY
    bandwidth: float | None = None  # [Hz]; None: as printed
    adapt: bool = True  # whether estimates move
    best: bool = False  # the gains that trial runs accept, instead of those of the dissertation
    # {"damped", "undamped", "rigid"}: torque and motion that the baselines follow: the exact inverse of the
    # chain with its dampers, without them, or of one rigid inertia; friction by the reference's speed in each
    feedforward: str = "damped"
    # of the run; for trial runs and the filter
    options: RigOptions = field(default_factory=RigOptions)
    plant: Drive | None = None  # as it is, where that differs; trial runs are on this one

    @property
    def actual(self) -> Drive:
        """The drive as it is."""
        return self.plant or self.drive

    @property
    def feedback(self) -> str:
        """Encoder that stands for theta_1 in Models 1 and 3."""
        return self.options.feedback

    @property
    def interval(self) -> float:
        """Sample time [s]."""
        return sample_interval(self.drive)

    @property
    def sampling(self) -> Sampling:
        """Sampling and lags for which filters are designed: those of the drive as it is."""
        interval, delay = sample_interval(self.actual), control_delay(self.actual)
        return Sampling(interval=interval, delay=delay, current_rate=current_rate(self.drive))

    @property
    def samples(self) -> int:
        """Of the motion, its ends included."""
        return self.motion.samples(self.interval)

    @property
    def number(self) -> int:
        """The highest model that the drive's data allow."""
        return highest_model(self.drive)

    @property
    def chain(self) -> LumpedChain:
        """That model, in angles of the first shaft."""
        return self.model(self.number)

    @property
    def shafts(self) -> tuple[str, ...]:
        """Shafts of its angles, from the motor to the load."""
        return SHAFTS if self.number == 4 else (SHAFTS[0], SHAFTS[-1])

    def model(self, number: int) -> LumpedChain:
        """A model, {1, 2, 3, 4}, of the drive under torque control, in angles of its first shaft."""
        return plant_chain(self.drive, number)

    def rows(self, generator: ReferenceNumbers) -> Array:
        """What a law takes at each sample of the motion, shape (samples, columns)."""
        motion = motion_numbers(self.drive, self.motion)
        return reference_table(generator, motion, self.interval, self.samples)

    def wanted(self, derivatives: int) -> Array:
        """Wanted load angle at the first shaft with derivatives, shape (derivatives + 1, samples)."""
        return load_gear(self.drive) * self.motion.sampled(self.interval, derivatives)


def motion_numbers(drive: Drive, motion: Motion) -> MotionNumbers:
    """A motion as a reference generator takes it, at the first shaft."""
    angle = load_gear(drive) * motion.angle * DEGREE
    return MotionNumbers(
        coefficients=np.array(rise_coefficients(motion.rise_order)),
        scalars=np.array([angle, motion.rise, motion.dwell, motion.pulses], dtype=float),
    )


def chain_law(
    spec: DesignSpec,
    number: int,
    *,
    damped: bool,
    tuning: KalmanTuning = QUIET,
    chain: LumpedChain | None = None,
    bounds: Bounds | None = None,
) -> Controller:
    """A law of a model, {1, 2, 3, 4}, of the chain; default: the drive's chain, the printed bounds."""
    chain = spec.model(number) if chain is None else chain
    flat = flat_output(chain, damped=damped)
    generator = flat_generator(flat, spec.interval)
    reference = spec.rows(generator)
    bounds = printed_bounds(chain, flexible_joint=FLEXIBLE_JOINT[number]) if bounds is None else bounds
    share = (DAMPED_SHARE if damped else 1.0) if spec.adapt else 0.0
    gains = darc_gains(number, spec.bandwidth, adaptation_share=share)
    law = darc_numbers(flat, gains, bounds, reference, spec.interval, by_reference=damped)
    stated = {
        "bandwidth_hz": gains.bandwidth / (2.0 * pi),
        "sliding_rate_hz": gains.sliding_rate / (2.0 * pi),
        "k_sigma": law.k_sigma,
        "adaptation_share": share,
        "adaptation": law.learning[3].tolist(),
        "lower_bounds": bounds.low.tolist(),
        "upper_bounds": bounds.high.tolist(),
    }
    return Controller(
        name=f"darc-{number}" + ("-damped" if damped else ""),
        law=law,
        reference=reference,
        shafts=law_shafts(number, spec.feedback),
        start=bounds.nominal,
        tuning=tuning,
        gains=stated,
        model=number,
        damped=damped,
        bandwidth=gains.bandwidth,
        flat=flat,
        filter_model=own_filter(number, spec.feedback),
        generator=generator,
    )


def law_for_chain(spec: DesignSpec, chain: LumpedChain, *, tuning: KalmanTuning = QUIET) -> Controller:
    """The damped law of any chain from ``motor`` to ``load``, its gains in Model 4's ratio, its filter."""
    made = chain_law(spec, 4, damped=True, tuning=tuning, chain=chain)
    return replace(
        made, name="damped law of a chain", shafts=chain.names, filter_model=None, filter_chain=chain
    )


def own_filter(number: int, feedback: str) -> int | None:
    """Model of the filter of a law where it has its own: Model 3 on the motor's encoder; None: the highest.

    On the drive pulley's encoder a filter without joint would hide what the law then does to it.
    """
    return 3 if number == 3 and feedback == "motor" else None


def damped_law(spec: DesignSpec, number: int) -> Controller:
    """The damping-aware law of a model, {1, 2, 3, 4}; its filter by what is not known."""
    own = own_filter(number, spec.feedback)
    only = None if own is None else law_shafts(number, spec.feedback)
    tuning = tuning_by_uncertainty(spec, spec.model(own or spec.number), only)
    return chain_law(spec, number, damped=True, tuning=tuning)


def tuning_by_uncertainty(
    spec: DesignSpec, chain: LumpedChain, only: Sequence[str] | None = None
) -> KalmanTuning:
    """Noise of the filter from what is not known of the drive; ``only``: as `fitted_encoders` has it.

    The load's equation is off by the spreads times the largest acceleration, for a sixteenth of the rise;
    friction by the Coulomb torque, a walk in a second, noise in a millisecond; zeros by half a count.
    """
    spreads = Spreads()
    wanted = spec.wanted(2)
    moving = np.abs(wanted[1]) > 0.0
    sets_out = int(np.count_nonzero(np.diff(moving.astype(int)) > 0)) + int(moving[0])
    rise = float(np.count_nonzero(moving)) * spec.interval / max(1, sets_out)
    off = (spreads.cable_stiffness + spreads.load_inertia) * float(np.abs(wanted[2]).max())
    coulomb, counts = chain.coulomb[0], list(fitted_encoders(spec.drive, only).values())
    return KalmanTuning(
        torque=1e-3 * coulomb**2,
        disturbance=coulomb**2,
        load_acceleration=off**2 * rise / 16.0,
        offsets=tuple(count**2 / 6.0 for count in counts[:-1]),
    )
