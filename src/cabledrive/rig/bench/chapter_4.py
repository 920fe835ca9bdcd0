"""The rigs and excitations of chapter 4: the motor alone, with either pulley, and the whole drive."""

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.excitation import (
    multisine_lines,
    random_multisine,
    sum_of_sines,
)
from cabledrive.mechanics.holding import released
from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain, lumped_model
from cabledrive.rig.bench.virtual_rig import Imperfections, VirtualRig
from cabledrive.rig.setting import sample_interval

Array = NDArray[np.float64]

TORQUE_PER_VOLT = 10 ** (4.2 / 20)
"""Amplifier gain [N m/V], Eq. (4.20): 4.2 dB."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BenchTest:
    """One row of Table 4.1 with the excitation that the text describes.

    Attributes
    ----------
    name : str
    inertia, viscous, coulomb, offset : float
        As printed [kg m^2, N m s/rad, N m, N m].
    frequencies, amplitudes : tuple of float
        Sines of the command [Hz], [V].
    duration : float
        [s].
    """

    name: str
    inertia: float
    viscous: float
    coulomb: float
    offset: float
    frequencies: tuple[float, ...]
    amplitudes: tuple[float, ...]
    duration: float


BENCH_TESTS = (
    BenchTest(
        name="motor",
        inertia=0.0011,
        viscous=0.00216,
        coulomb=0.024,
        offset=-0.0057,
        frequencies=(1.0, 3.0, 5.0),
        amplitudes=(0.05, 0.05, 0.1),
        duration=55.0,
    ),
    BenchTest(
        name="motor and drive pulley",
        inertia=0.001742,
        viscous=0.0031,
        coulomb=0.0376,
        offset=-0.0006,
        frequencies=(1.0, 3.0, 5.0),
        amplitudes=(0.1, 0.1, 0.1),
        duration=70.0,
    ),
    BenchTest(
        name="motor and load pulley",
        inertia=0.00345,
        viscous=0.005,
        coulomb=0.045,
        offset=-0.0008,
        frequencies=(1.0, 3.0, 5.0),
        amplitudes=(0.05, 0.05, 0.1),
        duration=55.0,
    ),
)


def bench_rig(test: BenchTest, imperfections: Imperfections | None = None) -> VirtualRig:
    """The rig of one bench test: a rigid axis, 2,600 counts, 1 kHz."""
    chain = LumpedChain(
        names=("motor",),
        inertias=(test.inertia,),
        viscous=(test.viscous,),
        coulomb=(test.coulomb,),
        offsets=(test.offset,),
    )
    return VirtualRig(
        chain=chain, torque_per_volt=TORQUE_PER_VOLT, imperfections=imperfections or Imperfections()
    )


def bench_command(test: BenchTest, rng: np.random.Generator, sample_rate: float = 1000.0) -> Array:
    """The command of one bench test, with random phases, which the text does not give.

    ``sample_rate`` [Hz].
    Returns shape (samples,) [V].
    """
    phases = rng.uniform(0.0, 2 * pi, len(test.frequencies))
    return sum_of_sines(test.duration, sample_rate, test.frequencies, test.amplitudes, phases)


def rig_of(drive: Drive, model: int | None = None, imperfections: Imperfections | None = None) -> VirtualRig:
    """The virtual rig of a drive: its reduced model with its sensors; 1 N m/V where it names no amplifier.

    ``model``, {1, 2, 3, 4}: default: the highest that the drive's data allow; ``imperfections``: default:
    with the drive's current loop and backlash.
    Raises `InputRefused` if the drive has no encoder of the model's shafts, or no sample rate.
    """
    motor, sensors = drive.motor, drive.sensors
    flaws = imperfections or Imperfections(
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
        raise InputRefused(
            f"{drive.name} has no encoder on {', '.join(chain.names)}, a log needs one: add such as "
            "sensors.motor_encoder = 2600"
        )
    return VirtualRig(
        chain=chain,
        torque_per_volt=(motor.torque_per_volt if motor and motor.torque_per_volt else 1.0),
        encoders=encoders,
        sample_rate=1.0 / sample_interval(drive),
        torque_limit=motor.torque_limit if motor else None,
        imperfections=flaws,
    )


def response_command(
    rng: np.random.Generator, *, sample_rate: float = 5000.0, duration: float = 8.0, amplitude: float = 1.0
) -> Array:
    """The command of section 4.3: 1,000 sines from 1 to 500 Hz, the lowest peak of ten draws.

    ``sample_rate`` [Hz]; ``duration`` [s]; ``amplitude``: largest value [V].
    Returns shape (samples,) [V].
    """
    samples = round(duration * sample_rate)
    lines = multisine_lines(samples, sample_rate, 1.0, 500.0, count=1000)
    return amplitude * random_multisine(samples, sample_rate, lines, 10, rng).values
