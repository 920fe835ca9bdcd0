"""What a drive and the options make of the rig: limits, phases, jitter, disturbances, a encoder dropout."""

from collections.abc import Sequence
from math import pi

import numpy as np

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.loop_numbers import Array, Integers
from cabledrive.rig.laws.controllers import fitted_encoders
from cabledrive.rig.setting import Disturbance, RigOptions


def slack_twist(drive: Drive, chain: LumpedChain) -> float:
    """Twist between the pulleys at which one span carries no tension [rad]."""
    if drive.kind != "loop" or "load" not in chain.names or chain.size < 2:
        return float("inf")
    return 2.0 * drive.drive_pulley.radius * drive.cable.pretension / chain.stiffness[-1]


def joint_backlash(drive: Drive, chain: LumpedChain) -> float:
    """Backlash of the gearhead, which lies in the motor's joint [rad]; 0 where that is rigid in the plant."""
    flexible = "motor" in chain.names and "drive" in chain.names
    return drive.motor.backlash if drive.motor is not None and flexible else 0.0


def encoder_phases(
    drive: Drive, options: RigOptions, generator: np.random.Generator, names: Sequence[str]
) -> Array:
    """Where in its count each encoder that is read starts, from -1/2 to 1/2; zero where centred."""
    every = list(fitted_encoders(drive))
    drawn = generator.uniform(-0.5, 0.5, len(every))[[every.index(name) for name in names]]
    return drawn if options.encoder_phase == "random" and not options.ideal_sensors else np.zeros(len(drawn))


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


def late_samples(options: RigOptions, interval: float, samples: int, generator: np.random.Generator) -> Array:
    """How late each sample is taken, at most 0.4 of a sample, shape (samples + 1,) [s]."""
    if options.jitter == 0.0:
        return np.zeros(0)
    drawn = generator.normal(0.0, options.jitter, samples + 1)
    return np.clip(drawn, -0.4 * interval, 0.4 * interval)


def disturbing_torques(options: RigOptions, interval: float, samples: int) -> Array:
    """Torque on motor and load from each sample to the next, shape (samples, 2) [N m]."""
    return stepped_in(options.disturbances, ("motor", "load"), interval, samples)


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


def encoder_dropout(options: RigOptions, interval: float, names: Sequence[str]) -> Integers:
    """Encoder that gives NaN (-1: none), first and last sample at which it does, shape (3,)."""
    if options.blind is None:
        return np.array([-1, 0, 0], dtype=np.int64)
    shaft, start, end = options.blind
    if shaft not in names:
        raise InputRefused(f"encoder dropout {shaft!r} is not fitted: take one of {', '.join(names)}")
    return np.array([names.index(shaft), round(start / interval), round(end / interval)], dtype=np.int64)
