r"""What a test will identify, before it is run: predicted standard errors, limits, the best of a family.

The motion is that of guessed parameters under the planned torque. The regression of inverse dynamics then
has known regressors, and its residual is the noise of the torque measurement and of the encoder,

.. math::

    S_e(f) = S_\tau + \big|J (2\pi f)^2 + 2\pi i f\,b\big|^2 S_\theta, \qquad
    C = (\Phi^T\Phi)^{-1} \Big(\sum_k \hat\phi_k^* \hat\phi_k^T |H_f|^2 S_e(f_k)\Big) (\Phi^T\Phi)^{-1},

white both, an encoder's rounding with a twelfth of its step squared.

The axis is moved under the planned torque with guessed parameters; `predicted_errors` gives the rest.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite, pi

import numpy as np

from cabledrive.identification.axis.equation import AxisEquation
from cabledrive.identification.filters import butterworth, difference
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.friction_integration import integrate_rigid_axis

NAMES = ("inertia", "viscous_friction", "coulomb_friction", "offset_torque")


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisGuess:
    """What is thought of an axis before it is tested."""

    # inertia, viscous, coulomb, offset: [kg m^2, N m s/rad, N m, N m], or of a slide [kg, N s/m, N, N]
    inertia: float
    viscous: float
    coulomb: float
    offset: float = 0.0

    def __post_init__(self) -> None:
        if not (self.inertia > 0.0 and self.viscous >= 0.0 and self.coulomb >= 0.0):
            raise InputRefused(
                f"guess of inertia {self.inertia:g}, viscous {self.viscous:g} and Coulomb friction "
                f"{self.coulomb:g}: the first must be positive, the others not negative"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Instruments:
    """Noise of the test's instruments."""

    torque_noise: float = 0.006  # standard deviation of one sample of the torque [N m]
    quantum: float = 2 * pi / 2600  # step of the encoder [rad]; 0: none
    bandwidth: float = 20.0  # of the filter on both sides of the regression [Hz]


def predicted_errors(
    speed: Array, interval: float, guess: AxisGuess, instruments: Instruments
) -> dict[str, float]:
    """Standard error of each parameter of an axis that moves with a known speed (samples,) [rad/s]."""
    equation = AxisEquation(linear=False, bandwidth=min(instruments.bandwidth, 0.2 / interval))
    columns = [difference(speed, interval), speed, np.sign(speed)]
    smooth = [equation.filtered(column, interval) for column in columns]
    edge = int(np.ceil(2.0 / (equation.bandwidth * interval)))
    regressors = np.column_stack([*smooth, -np.ones(speed.size)])[edge:-edge]
    sizes = np.linalg.norm(regressors, axis=0)
    q, r = np.linalg.qr(regressors / sizes)
    frequency = np.asarray(np.fft.rfftfreq(len(q), interval), dtype=float)
    noise = _residual_spectrum(frequency, interval, guess, instruments) * _gain(frequency, interval, equation)
    spectrum = np.fft.rfft(q, axis=0)
    both = np.where((frequency == 0.0) | (2 * np.arange(frequency.size) == len(q)), 1.0, 2.0)
    weights = both * noise / len(q)
    middle = np.real(np.einsum("ki,k,kj->ij", spectrum.conj(), weights, spectrum))
    inverse = np.linalg.inv(r)
    covariance = inverse @ middle @ inverse.T
    errors = np.sqrt(np.diag(covariance)) / sizes
    return {name: float(error) for name, error in zip(NAMES, errors, strict=True)}


def _residual_spectrum(
    frequency: Array, interval: float, guess: AxisGuess, instruments: Instruments
) -> Array:
    """Variance of the residual's noise per sample, over frequency [(N m)^2]."""
    omega = 2 * pi * frequency
    from_angle = np.abs(-guess.inertia * omega**2 + 1j * omega * guess.viscous) ** 2
    return instruments.torque_noise**2 + from_angle * instruments.quantum**2 / 12.0


def _gain(frequency: Array, interval: float, equation: AxisEquation) -> Array:
    """Power gain of the filter without phase."""
    from scipy import signal

    _, response = signal.sosfreqz(butterworth(interval, equation.bandwidth), 2 * pi * frequency * interval)
    return np.asarray(np.abs(response) ** 4)


WEAK = "will not be identifiable"
"""Of a parameter whose standard error is more than half of it; in the finding."""


LIMITS = ("torque", "speed", "stroke")
BISECTIONS = 24


@dataclass(frozen=True, slots=True, kw_only=True)
class TestPlan:
    """What a test will identify."""

    __test__ = False  # no test of pytest's

    standard_errors: dict[str, float]  # of each parameter, in its unit
    relative_errors: dict[str, float]  # over the size of the guess; infinite where that is zero
    # largest "torque", "speed" and "stroke" (from end to end) that the test will reach
    peaks: dict[str, float]
    moving: float  # share of the time that the axis does not stick
    findings: tuple[str, ...] = ()  # limits that are passed, parameters that will not be identified


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlannedMotion:
    """The axis under the planned torque."""

    # angle, speed: (samples,): [rad, rad/s]
    angle: Array
    speed: Array = field(repr=False)


def planned_motion(torque: Array, interval: float, guess: AxisGuess) -> PlannedMotion:
    """Move the guessed axis under the planned torque (samples,) [N m]."""
    values = np.array([guess.inertia, guess.viscous, guess.coulomb, guess.offset])
    speed, _ = integrate_rigid_axis(values, np.asarray(torque, dtype=float), interval)
    steps = 0.5 * (speed[1:] + speed[:-1]) * interval
    return PlannedMotion(angle=np.concatenate([[0.0], np.cumsum(steps)]), speed=speed)


def plan_test(
    torque: Array,
    interval: float,
    guess: AxisGuess,
    instruments: Instruments | None = None,
    limits: Mapping[str, float] | None = None,
) -> TestPlan:
    """Predict the standard error of each parameter, and what the test asks of the machine.

    ``torque`` (samples,) [N m]; ``limits``: largest "torque", "speed", "stroke" that the machine bears.
    Refused if a limit is unknown, or the torque does not move the axis.
    """
    instruments = instruments or Instruments()
    motion = planned_motion(torque, interval, guess)
    moving = float(np.mean(motion.speed != 0.0))
    if moving < 0.02:
        raise InputRefused(
            f"largest torque {np.abs(torque).max():.4g} N m does not move the axis against its Coulomb "
            f"friction of {guess.coulomb:.4g} N m: raise the amplitude"
        )
    peaks = peaks_of(torque, motion)
    errors = predicted_errors(motion.speed, interval, guess, instruments)
    sizes = (guess.inertia, guess.viscous, guess.coulomb, guess.offset)
    relative = {
        name: errors[name] / abs(size) if size else float("inf")
        for name, size in zip(NAMES, sizes, strict=True)
    }
    findings = [
        f"{name} reaches {peaks[name]:.4g}, above its limit of {limit:.4g}"
        for name, limit in checked_limits(limits).items()
        if peaks[name] > limit
    ]
    findings += [
        f"{name} {WEAK}: its standard error is {100 * share:.3g} % of it"
        for name, share in relative.items()
        if share > 0.5 and isfinite(share)
    ]
    return TestPlan(
        standard_errors=errors,
        relative_errors=relative,
        peaks=peaks,
        moving=moving,
        findings=tuple(findings),
    )


def peaks_of(torque: Array, motion: PlannedMotion) -> dict[str, float]:
    """What a test asks of the machine."""
    return {
        "torque": float(np.abs(torque).max()),
        "speed": float(np.abs(motion.speed).max()),
        "stroke": float(np.ptp(motion.angle)),
    }


def checked_limits(limits: Mapping[str, float] | None) -> dict[str, float]:
    """Limits that are known and positive."""
    for name, limit in (limits or {}).items():
        if name not in LIMITS or not limit > 0.0:
            raise InputRefused(f"limit {name} = {limit:g}: give {', '.join(LIMITS)}, each positive")
    return dict(limits or {})


def largest_amplitude(torque: Array, interval: float, guess: AxisGuess, limits: Mapping[str, float]) -> float:
    """Factor, found to 1e-4 of itself, by which a torque can be multiplied without passing a limit."""
    limits = checked_limits(limits)

    def within(scale: float) -> bool:
        peaks = peaks_of(scale * torque, planned_motion(scale * torque, interval, guess))
        return all(peaks[name] <= limit for name, limit in limits.items())

    low, high = 0.0, 1.0
    while within(high) and high < 1e6:
        low, high = high, 2.0 * high
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if within(middle) else (low, middle)
        if high - low < 1e-4 * high:
            break
    return low
