"""Rigs and excitations of chapter 4."""

from dataclasses import dataclass
from math import pi

import numpy as np

from cabledrive.identification.planning import multisine_lines, random_multisine, sum_of_sines
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.virtual_rig import Imperfections, VirtualRig

TORQUE_PER_VOLT = 10 ** (4.2 / 20)
"""Amplifier gain [N m/V], Eq. (4.20): 4.2 dB."""


@dataclass(frozen=True, slots=True)
class BenchTest:
    """One row of Table 4.1, and the sines of its command as the text has them."""

    name: str
    inertia: float  # [kg m^2], then viscous and Coulomb friction and offset torque, as printed
    viscous: float
    coulomb: float
    offset: float
    amplitudes: tuple[float, ...]  # [V]
    duration: float  # [s]
    frequencies: tuple[float, ...] = (1.0, 3.0, 5.0)  # [Hz]


BENCH_TESTS = (
    BenchTest("motor", 0.0011, 0.00216, 0.024, -0.0057, (0.05, 0.05, 0.1), 55.0),
    BenchTest("motor and drive pulley", 0.001742, 0.0031, 0.0376, -0.0006, (0.1, 0.1, 0.1), 70.0),
    BenchTest("motor and load pulley", 0.00345, 0.005, 0.045, -0.0008, (0.05, 0.05, 0.1), 55.0),
)


def bench_rig(test: BenchTest, imperfections: Imperfections | None = None) -> VirtualRig:
    """The rig of one bench test: a rigid axis, 2,600 counts, 1 kHz."""
    held = (test.inertia, test.viscous, test.coulomb, test.offset)
    inertia, viscous, coulomb, offset = ((value,) for value in held)
    chain = LumpedChain(names=("motor",), inertias=inertia, viscous=viscous, coulomb=coulomb, offsets=offset)
    flaws = imperfections or Imperfections()
    return VirtualRig(chain=chain, torque_per_volt=TORQUE_PER_VOLT, imperfections=flaws)


def bench_command(test: BenchTest, rng: np.random.Generator, sample_rate: float = 1000.0) -> Array:
    """The command of one bench test with random phases, shape (samples,) [V]; ``sample_rate`` [Hz]."""
    phases = rng.uniform(0.0, 2 * pi, len(test.frequencies))
    return sum_of_sines(test.duration, sample_rate, test.frequencies, test.amplitudes, phases)


def response_command(
    rng: np.random.Generator, *, sample_rate: float = 5000.0, duration: float = 8.0, amplitude: float = 1.0
) -> Array:
    """Section 4.3's 1,000 sines from 1 to 500 Hz, the lowest peak of ten draws, shape (samples,) [V]."""
    samples = round(duration * sample_rate)
    lines = multisine_lines(samples, sample_rate, 1.0, 500.0, count=1000)
    return amplitude * random_multisine(samples, lines, 10, rng)
