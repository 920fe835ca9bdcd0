r"""Signals that make a log informative, and what a test will identify, before it is run.

The motion is that of guessed parameters under the planned torque. The regression of inverse dynamics then
has known regressors, and its residual is the noise of the torque measurement and of the encoder,

.. math::

    S_e(f) = S_\tau + \big|J (2\pi f)^2 + 2\pi i f\,b\big|^2 S_\theta, \qquad
    C = (\Phi^T\Phi)^{-1} \Big(\sum_k \hat\phi_k^* \hat\phi_k^T |H_f|^2 S_e(f_k)\Big) (\Phi^T\Phi)^{-1},

white both, an encoder's rounding with a twelfth of its step squared.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, pi

import numpy as np
from scipy import optimize, signal

from cabledrive.identification.axis.equation import AxisEquation
from cabledrive.identification.response_models import PARAMETERS, chain_for
from cabledrive.identification.signals import butterworth, difference
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array, Integers
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.friction_integration import integrate_rigid_axis
from cabledrive.reduction.lumped_chain import speed_response
from cabledrive.reduction.threshold import threshold_torque


def crest_factor(values: Array) -> float:
    """Largest absolute value over root mean square."""
    return float(np.abs(values).max() / np.sqrt(np.mean(values**2)))


def multisine_lines(
    samples: int, sample_rate: float, low: float, high: float, count: int | None = None, odd: bool = False
) -> Integers:
    """Lines of a multisine of so many samples in a band [Hz], all or odd: ``count`` spread evenly, or all."""
    if not 0.0 < low < high < 0.5 * sample_rate:
        raise InputRefused(f"band {low:.4g} to {high:.4g} Hz must lie in 0 to {0.5 * sample_rate:.4g} Hz")
    spacing = sample_rate / samples
    lines = np.arange(int(np.ceil(low / spacing - 1e-9)), int(np.floor(high / spacing + 1e-9)) + 1)
    lines = lines[lines % 2 == 1] if odd else lines
    if lines.size < max(1, count or 1):
        said = f"{lines.size} lines of {spacing:.4g} Hz from {low:.4g} to {high:.4g} Hz, {count or 1} wanted"
        raise InputRefused(f"{said}: take a longer period")
    if count is not None:
        lines = lines[np.unique(np.rint(np.linspace(0, lines.size - 1, count)).astype(int))]
    return lines


def random_multisine(samples: int, lines: Integers, trials: int, rng: np.random.Generator) -> Array:
    """The lowest crest of some draws of random phases, `idinput` 'sine', Eqs. (4.13), (4.14), (samples,)."""
    drawn = [_summed(samples, lines, rng.uniform(0.0, 2 * pi, lines.size)) for _ in range(trials)]
    best = min(drawn, key=crest_factor)
    return best / np.abs(best).max()


def low_crest_multisine(samples: int, lines: Integers, passes: int = 200) -> Array:
    r"""Schroeder phases, then clipping in turn with restoring of the amplitudes, (samples,), largest value 1.

    :math:`\varphi_k = -\pi k(k-1)/N`: M. R. Schroeder, IEEE Trans. Inf. Theory 16(1), 85-89, 1970; clipping:
    E. Van der Ouderaa, J. Schoukens, J. Renneboog, IEEE Trans. Instrum. Meas. 37(1), 145-147, 1988.
    """
    k = np.arange(1, lines.size + 1)
    values = best = _summed(samples, lines, -pi * k * (k - 1) / lines.size)
    for number in range(passes):
        level = (0.75 + 0.2 * number / passes) * np.abs(values).max()
        phases = np.angle(np.fft.rfft(np.clip(values, -level, level))[lines]) + 0.5 * pi
        values = _summed(samples, lines, phases)
        if crest_factor(values) < crest_factor(best):
            best = values
    return best / np.abs(best).max()


def sum_of_sines(
    duration: float,
    sample_rate: float,
    frequencies: Sequence[float] | Array,
    amplitudes: Sequence[float] | Array,
    phases: Sequence[float] | Array | None = None,
) -> Array:
    """Few sines [Hz] with phases [rad] together for a duration [s], as in section 4.2, shape (samples,)."""
    t = np.arange(round(duration * sample_rate)) / sample_rate
    angles = np.zeros(len(frequencies)) if phases is None else phases
    waves = [a * np.sin(2 * pi * f * t + p) for f, a, p in zip(frequencies, amplitudes, angles, strict=True)]
    return np.sum(waves, axis=0)


def chirp(duration: float, sample_rate: float, low: float, high: float) -> Array:
    """A sine of amplitude 1 whose frequency [Hz] rises by every octave in the same time, (samples,)."""
    t = np.arange(round(duration * sample_rate)) / sample_rate
    rate = np.log(high / low) / duration
    return np.sin(2 * pi * low * np.expm1(rate * t) / rate)


def steps(duration: float, sample_rate: float, period: float) -> Array:
    """A square wave of 1 and -1 with a period [s], shape (samples,)."""
    t = np.arange(round(duration * sample_rate)) / sample_rate
    return np.where(np.mod(t, period) < 0.5 * period, 1.0, -1.0)


def _summed(samples: int, lines: Integers, phases: Array) -> Array:
    spectrum = np.zeros(samples // 2 + 1, dtype=complex)
    spectrum[lines] = np.exp(1j * (phases - 0.5 * pi))
    return np.fft.irfft(spectrum, samples) * samples / 2


LOUD = 0.01
"""Lines below this share of the largest are not looked at."""
NEAR = 0.25
"""Lines within this share of the pulley mode's frequency are compared with the threshold."""


def resonance_warnings(drive: Drive, torque: Array, sample_rate: float) -> tuple[str, ...]:
    """Lines of a torque (samples,) [N m] that would make the spans grow through the 1:2 resonance."""
    try:
        model = autoparametric_model(drive)
    except InputRefused as refusal:
        return (f"the 1:2 resonance was not checked: {refusal}",)
    frequency = np.asarray(np.fft.rfftfreq(torque.size, 1.0 / sample_rate)[1:], dtype=float)
    size = 2.0 * np.abs(np.fft.rfft(torque))[1:] / torque.size
    pulley = float(model.natural) / (2 * pi)
    loud = size > LOUD * size.max()
    near = loud & (np.abs(frequency / pulley - 1.0) < NEAR)
    if not near.any():
        return ()
    # Neighbours within the pulley mode's half-width sum up in it.
    width, lines = max(0.25 * model.modal_damping / pi, 0.5 * float(frequency[0])), frequency[near]
    sizes = np.array([np.sqrt(np.sum(size[np.abs(frequency - f) <= width] ** 2)) for f in lines])
    thresholds = np.asarray(threshold_torque(model, 2 * pi * lines))
    over = sizes > thresholds
    if not over.any():
        return ()
    worst = int(np.argmax(np.where(over, sizes / np.maximum(thresholds, 1e-300), 0.0)))
    return (
        f"would drive the 1:2 resonance: {sizes[worst]:.3g} N m at {lines[worst]:.5g} Hz, a span is "
        f"unstable above {thresholds[worst]:.3g} N m (pulley mode {pulley:.5g} Hz): leave that line out, "
        "lower it, or change the pretension",
    )


STEP = 1e-5
"""Of the logarithm of a parameter, by which the sensitivity of a response is taken."""
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
    omega = 2 * pi * frequency
    from_angle = np.abs(-guess.inertia * omega**2 + 1j * omega * guess.viscous) ** 2
    _, passed = signal.sosfreqz(butterworth(interval, equation.bandwidth), omega * interval)
    noise = instruments.torque_noise**2 + from_angle * instruments.quantum**2 / 12.0
    noise = noise * np.asarray(np.abs(passed) ** 4)  # the filter has no phase, forwards and backwards
    spectrum = np.fft.rfft(q, axis=0)
    both = np.where((frequency == 0.0) | (2 * np.arange(frequency.size) == len(q)), 1.0, 2.0)
    weights = both * noise / len(q)
    middle = np.real(np.einsum("ki,k,kj->ij", spectrum.conj(), weights, spectrum))
    inverse = np.linalg.inv(r)
    covariance = inverse @ middle @ inverse.T
    errors = np.sqrt(np.diag(covariance)) / sizes
    return {name: float(error) for name, error in zip(NAMES, errors, strict=True)}


def predicted_response_errors(
    values: Mapping[str, float],
    radius: float,
    lines: tuple[Array, Array],
    samples: float,
    instruments: Instruments,
) -> dict[str, float]:
    r"""Relative standard error of each parameter of Model 4 from a fit of the response to a multisine.

    N samples give the torque's variance :math:`4\sigma^2/N`, the speed's :math:`\omega^2 q^2/(3N)`.
    """
    names, (frequency, amplitude) = PARAMETERS[4], lines
    if 2 * frequency.size <= len(names):
        raise InputRefused(f"{frequency.size} lines are too few for {len(names)} parameters: add lines")
    omega = 2 * pi * np.asarray(frequency, dtype=float)
    base = speed_response(chain_for(4, values, radius), omega)
    of_speed = omega**2 * instruments.quantum**2 / 3.0
    variance = (of_speed + 4.0 * instruments.torque_noise**2 * np.abs(base) ** 2) / samples / amplitude**2
    columns = []
    for name in names:
        moved = {k: v * (np.exp(STEP) if k == name else 1.0) for k, v in values.items()}
        slope = (speed_response(chain_for(4, moved, radius), omega) - base) / STEP
        columns.append(slope / np.sqrt(variance))
    rows = np.column_stack(columns)
    r = np.linalg.qr(np.vstack([rows.real, rows.imag]), mode="r")
    s = np.linalg.svd(r / np.maximum(np.linalg.norm(r, axis=0), 1e-300), compute_uv=False)
    if s[-1] < 1e-9 * s[0]:
        return dict.fromkeys(names, float("inf"))
    errors = np.linalg.norm(np.linalg.inv(r), axis=1) / np.sqrt(2.0)  # each part carries half the variance
    return {name: float(error) for name, error in zip(names, errors, strict=True)}


WEAK = "will not be identifiable"
"""Of a parameter whose standard error is more than half of it; in the finding."""


LIMITS = ("torque", "speed", "stroke")


@dataclass(frozen=True, slots=True, kw_only=True)
class TestPlan:
    """What a test will identify."""

    __test__ = False  # no test of pytest's

    relative_errors: dict[str, float]  # standard ones over the size of the guess; infinite where that is zero
    # largest "torque", "speed" and "stroke" (from end to end) that the test will reach
    peaks: dict[str, float]
    moving: float  # share of the time that the axis does not stick
    findings: tuple[str, ...] = ()  # limits that are passed, parameters that will not be identified


def _moved(torque: Array, interval: float, guess: AxisGuess) -> tuple[Array, dict[str, float]]:
    """Speed (samples,) of the guessed axis under the planned torque, and what that asks of a machine."""
    values = np.array([guess.inertia, guess.viscous, guess.coulomb, guess.offset])
    speed, _ = integrate_rigid_axis(values, np.asarray(torque, dtype=float), interval)
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * interval)])
    largest = (np.abs(torque).max(), np.abs(speed).max(), np.ptp(angle))
    return speed, dict(zip(LIMITS, map(float, largest), strict=True))


def plan_test(
    torque: Array,
    interval: float,
    guess: AxisGuess,
    instruments: Instruments | None = None,
    limits: Mapping[str, float] | None = None,
) -> TestPlan:
    """Predict the standard error of each parameter under a torque (samples,) [N m], and what it asks for."""
    instruments = instruments or Instruments()
    speed, peaks = _moved(torque, interval, guess)
    moving = float(np.mean(speed != 0.0))
    if moving < 0.02:
        raise InputRefused(
            f"largest torque {np.abs(torque).max():.4g} N m does not move the axis against its Coulomb "
            f"friction of {guess.coulomb:.4g} N m: raise the amplitude"
        )
    errors = predicted_errors(speed, interval, guess, instruments)
    sizes = (guess.inertia, guess.viscous, guess.coulomb, guess.offset)
    pairs = zip(errors.items(), sizes, strict=True)
    relative = {name: error / abs(size) if size else float("inf") for (name, error), size in pairs}
    findings = [
        f"{name} reaches {peaks[name]:.4g}, above its limit of {limit:.4g}"
        for name, limit in _checked(limits or {}).items()
        if peaks[name] > limit
    ]
    findings += [
        f"{name} {WEAK}: its standard error is {100 * share:.3g} % of it"
        for name, share in relative.items()
        if share > 0.5 and isfinite(share)
    ]
    return TestPlan(
        relative_errors=relative,
        peaks=peaks,
        moving=moving,
        findings=tuple(findings),
    )


def _checked(limits: Mapping[str, float]) -> Mapping[str, float]:
    for name, limit in limits.items():
        if name not in LIMITS or not limit > 0.0:
            raise InputRefused(f"limit {name} = {limit:g}: give {', '.join(LIMITS)}, each positive")
    return limits


def largest_amplitude(torque: Array, interval: float, guess: AxisGuess, limits: Mapping[str, float]) -> float:
    """Factor, found to 1e-4 of itself, by which a torque can be multiplied without passing a limit."""
    limits, highest = _checked(limits), 1.0

    def beyond(scale: float) -> float:
        peaks = _moved(scale * torque, interval, guess)[1]
        return max(peaks[name] / limit for name, limit in limits.items()) - 1.0

    while beyond(highest) < 0.0 and highest < 1e6:
        highest *= 2.0
    return float(optimize.brentq(beyond, 0.0, highest, rtol=1e-4)) if beyond(highest) > 0.0 else highest
