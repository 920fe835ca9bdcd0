"""A rig in numbers as a laboratory has it."""

from dataclasses import dataclass, field, replace
from math import exp, pi

import numpy as np

from cabledrive.identification.logs.log import DataReport, Log
from cabledrive.mechanics.holding import released
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.friction_integration import FrictionLaw, integrate_chain, integrate_rigid_axis
from cabledrive.reduction.lumped_chain import LumpedChain, lumped_model
from cabledrive.rig.setting import sample_interval


@dataclass(frozen=True, slots=True, kw_only=True)
class Imperfections:
    """What a real rig adds to its equations of motion."""

    # standard deviation of the torque that the amplifier adds, and that the axis feels [N m]
    amplifier_noise: float = 0.005
    torque_noise: float = 0.006  # standard deviation of the torque measurement [N m]
    current_bandwidth: float | None = 1000.0  # of the torque loop [Hz]; None: ideal
    # stribeck_excess, stribeck_speed: friction of the motor at rest above its Coulomb friction [N m]; the
    # speed at which that fades [rad/s]
    stribeck_excess: float = 0.0
    stribeck_speed: float = 0.3
    smooth_slope: float = 0.0  # K of c tanh(K w) in (4.8) [s/rad]; 0: set-valued friction
    backlash: float = 0.0  # backlash of the first link [rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualRig:
    """A lumped chain with its motor, encoders and sampling."""

    chain: LumpedChain
    torque_per_volt: float = 1.0  # [N m/V]
    # counts per revolution by channel: "angle" (the motor's), "drive_angle", "load_angle"
    encoders: dict[str, int] = field(default_factory=lambda: {"angle": 2600})
    sample_rate: float = 1000.0  # [Hz]
    torque_limit: float | None = None  # [N m]
    imperfections: Imperfections = field(default_factory=Imperfections)


def run_rig(
    rig: VirtualRig,
    command: Array,
    rng: np.random.Generator,
    *,
    oversampling: int = 4,
    source: str = "virtual rig",
) -> Log:
    """Drive a rig by a voltage and log what its instruments say.

    ``command``, shape (samples,) [V]. The command stands from sample to sample; the torque that acts follows
    it through the current loop, with the amplifier's noise, and is logged as its mean over the interval
    centred on each time stamp, plus the noise of its measurement. Each encoder stands at a random phase
    within a count. Returns channels "torque", "command_voltage" and one per encoder.
    """
    if command.size < 3 or not np.all(np.isfinite(command)):
        raise InputRefused(
            f"a command of {command.size} samples cannot be run: give at least 3 finite voltages"
        )
    fine = 1.0 / (rig.sample_rate * oversampling)
    torque = acting_torque(rig, command, rng, oversampling)
    flaws, n = rig.imperfections, rig.chain.size
    if n == 1 and flaws.stribeck_excess == 0.0:
        values = [x[0] for x in (rig.chain.inertias, rig.chain.viscous, rig.chain.coulomb, rig.chain.offsets)]
        speeds, _ = integrate_rigid_axis(np.array(values), torque, fine, slope=flaws.smooth_slope)
        middle = 0.5 * (speeds[1:] + speeds[:-1]) * fine
        angles = np.concatenate([[0.0], np.cumsum(middle)])[:, None]
    else:
        law = FrictionLaw(
            excess=(flaws.stribeck_excess, *(0.0,) * (n - 1)),
            fading=(flaws.stribeck_speed,) * n,
            slope=(flaws.smooth_slope, *(0.0,) * (n - 1)),
        )
        gaps = (flaws.backlash, *(0.0,) * (n - 2)) if n > 1 else ()
        angles = integrate_chain(rig.chain, torque, fine, law=law, gaps=gaps).angles
    log = log_from(rig, torque, angles[::oversampling], rng, source)
    channels, units = {"command_voltage": command, **log.channels}, {"command_voltage": "V", **log.units}
    return replace(log, channels=channels, units=units)


def log_from(
    rig: VirtualRig,
    torque: Array,
    angles: Array,
    rng: np.random.Generator,
    source: str,
    phases: dict[str, float] | None = None,
) -> Log:
    """What the instruments of a rig say of a ``torque`` that acted, finely sampled, and of the angles.

    ``angles``, shape (samples, n) [rad]; ``phases``: place of each encoder within a count, default: random.
    """
    samples = angles.shape[0]
    per_sample = torque.size // samples
    # The mean over the interval centred on each stamp: the torque runs on straight lines between fine steps.
    half, weights = per_sample // 2, np.ones(per_sample + 1)
    weights[[0, -1]] = 0.5
    padded = np.concatenate([np.full(half, torque[0]), torque, np.full(half, torque[-1])])
    mean = np.convolve(padded, weights / per_sample, "valid")[::per_sample]
    channels = {"torque": mean + rig.imperfections.torque_noise * rng.normal(size=mean.size)}
    units, quanta = {"torque": "N m"}, {}
    for name, counts in rig.encoders.items():
        quantum = 2 * pi / counts
        shaft = {"drive_angle": "drive", "load_angle": "load"}.get(name, rig.chain.names[0])
        number = rig.chain.names.index(shaft)
        phase = rng.uniform() if phases is None else phases[name]
        channels[name] = quantum * np.floor(angles[:, number] / quantum + phase)
        units[name], quanta[name] = "rad", quantum
    interval = 1.0 / rig.sample_rate
    report = DataReport(rows=samples, duration=(samples - 1) * interval, interval=interval, quantum=quanta)
    time = interval * np.arange(samples, dtype=float)
    return Log(source=source, time=time, channels=channels, units=units, report=report)


def acting_torque(rig: VirtualRig, command: Array, rng: np.random.Generator, oversampling: int) -> Array:
    """Limited torque at the motor behind the current loop, shape (samples * oversampling,) [N m]."""
    wanted = rig.torque_per_volt * command
    if rig.torque_limit is not None:
        wanted = np.clip(wanted, -rig.torque_limit, rig.torque_limit)
    noise = rig.imperfections.amplifier_noise
    steady = np.repeat(wanted + noise * rng.normal(size=command.size), oversampling)
    if rig.imperfections.current_bandwidth is None:
        return steady
    from scipy import signal

    pole = exp(-2 * pi * rig.imperfections.current_bandwidth / (rig.sample_rate * oversampling))
    filtered, _ = signal.lfilter([1 - pole], [1, -pole], steady, zi=[pole * steady[0]])
    return np.asarray(filtered)


def load_cell_force(drive: Drive, pull: Array, speed: Array, rng: np.random.Generator) -> Array:
    """What the load cell of a loop's load pulley reads, shape (samples,) [N].

    That is ``pull``, the sum of both spans' tensions, less 2 rho v^2 of the rim's ``speed``, and noise.
    """
    assert drive.sensors is not None
    read = pull - 2.0 * drive.cable.stretched_mass_per_length * speed**2
    return np.asarray(read + (drive.sensors.load_cell_noise or 0.0) * rng.normal(size=len(speed)))


def rig_of(drive: Drive, model: int | None = None) -> VirtualRig:
    """The virtual rig of a drive: its reduced model with its sensors; 1 N m/V where it names no amplifier."""
    motor, sensors = drive.motor, drive.sensors
    flaws = Imperfections(
        current_bandwidth=motor.current_bandwidth if motor else None,
        backlash=motor.backlash if motor and motor.joint_stiffness is not None else 0.0,
    )
    chain = lumped_model(released(drive), model)
    counts = {
        "angle": sensors.motor_encoder if sensors else None,
        "drive_angle": sensors.drive_encoder if sensors and "drive" in chain.names else None,
        "load_angle": sensors.load_encoder if sensors and "load" in chain.names else None,
    }
    encoders = {name: count for name, count in counts.items() if count is not None}
    if not encoders:
        said = f"{drive.name} has no encoder on {', '.join(chain.names)}, a log needs one"
        raise InputRefused(f"{said}: add such as sensors.motor_encoder = 2600")
    return VirtualRig(
        chain=chain,
        torque_per_volt=(motor.torque_per_volt if motor and motor.torque_per_volt else 1.0),
        encoders=encoders,
        sample_rate=1.0 / sample_interval(drive),
        torque_limit=motor.torque_limit if motor else None,
        imperfections=flaws,
    )
