"""Signals that make a log informative, and what a multisine will identify of Models 1 to 4."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.response_models import PARAMETERS, chain_for
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array, Integers
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.lumped_chain import speed_response
from cabledrive.reduction.threshold import threshold_torque


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Multisine:
    """A sum of sines that repeats after one period.

    Attributes
    ----------
    values : ndarray, shape (samples,)
        One period.
    lines : ndarray of int
        Numbers of the excited lines; line k has k periods in one period of the signal.
    frequencies : ndarray
        [Hz].
    crest : float
        Largest value over root mean square.
    sample_rate : float
        [Hz].
    """

    values: Array
    lines: Integers
    frequencies: Array
    crest: float
    sample_rate: float


def crest_factor(values: Array) -> float:
    """Largest absolute value over root mean square."""
    return float(np.abs(values).max() / np.sqrt(np.mean(values**2)))


def multisine_lines(
    samples: int, sample_rate: float, low: float, high: float, count: int | None = None, odd: bool = False
) -> Integers:
    """Lines of a multisine of so many samples in a band [Hz]: ``count`` of them, spread evenly, or all.

    ``odd``: only odd lines: what appears at even ones is then an even nonlinearity. Refused if the band holds
    fewer, or reaches half the sample rate [Hz].
    """
    if not 0.0 < low < high < 0.5 * sample_rate:
        raise InputRefused(
            f"band {low:.4g} to {high:.4g} Hz must lie between 0 and {0.5 * sample_rate:.4g} Hz"
        )
    spacing = sample_rate / samples
    lines = np.arange(int(np.ceil(low / spacing - 1e-9)), int(np.floor(high / spacing + 1e-9)) + 1)
    lines = lines[lines % 2 == 1] if odd else lines
    if lines.size < max(1, count or 1):
        raise InputRefused(
            f"{lines.size} lines of {spacing:.4g} Hz from {low:.4g} to {high:.4g} Hz, {count or 1} wanted:"
            " take a longer period"
        )
    if count is not None:
        lines = lines[np.unique(np.rint(np.linspace(0, lines.size - 1, count)).astype(int))]
    return lines


def schroeder_phases(count: int) -> Array:
    r"""Phases (count,) [rad] of a flat multisine of low crest, :math:`\varphi_k = -\pi k(k-1)/N`.

    M. R. Schroeder, "Synthesis of low-peak-factor signals and binary sequences with low autocorrelation",
    IEEE Trans. Inf. Theory 16(1), 85-89, 1970.
    """
    k = np.arange(1, count + 1)
    return -pi * k * (k - 1) / count


def random_multisine(
    samples: int, sample_rate: float, lines: Integers, trials: int, rng: np.random.Generator
) -> Multisine:
    """The lowest crest of some draws of random phases, `idinput` 'sine', Eqs. (4.13), (4.14) (largest: 1)."""
    best: Array | None = None
    for _ in range(trials):
        values = _summed(samples, lines, rng.uniform(0.0, 2 * pi, lines.size))
        if best is None or crest_factor(values) < crest_factor(best):
            best = values
    assert best is not None
    return _finished(best, lines, sample_rate)


def low_crest_multisine(
    samples: int,
    sample_rate: float,
    lines: Integers,
    passes: int = 200,
    amplitudes: Array | None = None,
) -> Multisine:
    """Schroeder phases, then clipping in turn with restoring of the amplitudes; of largest value 1.

    E. Van der Ouderaa, J. Schoukens, J. Renneboog, "Peak factor minimization using a time-frequency domain
    swapping algorithm", IEEE Trans. Instrum. Meas. 37(1), 145-147, 1988.
    """
    sizes = np.ones(lines.size) if amplitudes is None else np.asarray(amplitudes, dtype=float)
    values = _summed(samples, lines, schroeder_phases(lines.size), sizes)
    best = values
    for k in range(passes):
        level = (0.75 + 0.2 * k / passes) * np.abs(values).max()
        phases = np.angle(np.fft.rfft(np.clip(values, -level, level))[lines]) + 0.5 * pi
        values = _summed(samples, lines, phases, sizes)
        if crest_factor(values) < crest_factor(best):
            best = values
    return _finished(best, lines, sample_rate)


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


def _summed(samples: int, lines: Integers, phases: Array, sizes: Array | None = None) -> Array:
    spectrum = np.zeros(samples // 2 + 1, dtype=complex)
    spectrum[lines] = (1.0 if sizes is None else sizes) * np.exp(1j * (phases - 0.5 * pi))
    return np.fft.irfft(spectrum, samples) * samples / 2


def _finished(values: Array, lines: Integers, sample_rate: float) -> Multisine:
    values = values / np.abs(values).max()
    return Multisine(
        values=values,
        lines=lines,
        frequencies=lines * sample_rate / values.size,
        crest=crest_factor(values),
        sample_rate=sample_rate,
    )


STEP = 1e-5
LOUD = 0.01
"""Lines below this share of the largest are not looked at."""
NEAR = 0.25
"""Lines within this share of the pulley mode's frequency are compared with the threshold."""


def predicted_response_errors(
    model: int,
    values: Mapping[str, float],
    frequency: Array,
    amplitude: Array,
    *,
    radius: float,
    quantum: float,
    sample_rate: float,
    duration: float,
    torque_noise: float = 0.0,
) -> dict[str, float]:
    r"""Relative standard error of each parameter from a fit of the response at the lines of a multisine.

    A line that lasts for N samples is known to the variance :math:`4\sigma^2/N` in the torque and, through
    the rounded angle, to :math:`\omega^2 q^2/(3N)` in the speed.

    ``model``, {1, 2, 3, 4}; ``values``: guess of the parameters of
    `cabledrive.identification.response_models.PARAMETERS`; ``frequency``, ``amplitude``, shape (m,): lines of
    the torque [Hz], [N m]; ``radius`` [m]; ``quantum``: step of the motor's encoder [rad]; ``sample_rate``,
    ``duration`` [Hz], [s]; ``torque_noise``: standard deviation of one sample of the torque [N m].
    Returns infinite where the lines do not identify a parameter.
    Raises `InputRefused` if there are fewer lines than parameters need.
    """
    names = PARAMETERS[model]
    if 2 * frequency.size <= len(names):
        raise InputRefused(f"{frequency.size} lines are too few for {len(names)} parameters: add lines")
    omega = 2 * pi * np.asarray(frequency, dtype=float)
    samples = sample_rate * duration
    base = speed_response(chain_for(model, values, radius), omega)
    of_speed = omega**2 * quantum**2 / 3.0
    variance = (of_speed + 4.0 * torque_noise**2 * np.abs(base) ** 2) / samples / amplitude**2
    columns = []
    for name in names:
        moved = {k: v * (np.exp(STEP) if k == name else 1.0) for k, v in values.items()}
        slope = (speed_response(chain_for(model, moved, radius), omega) - base) / STEP
        columns.append(slope / np.sqrt(variance))
    rows = np.column_stack(columns)
    r = np.linalg.qr(np.vstack([rows.real, rows.imag]), mode="r")
    s = np.linalg.svd(r / np.maximum(np.linalg.norm(r, axis=0), 1e-300), compute_uv=False)
    if s[-1] < 1e-9 * s[0]:
        return dict.fromkeys(names, float("inf"))
    errors = np.linalg.norm(np.linalg.inv(r), axis=1) / np.sqrt(2.0)  # each part carries half the variance
    return {name: float(error) for name, error in zip(names, errors, strict=True)}


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
    lines, sizes = frequency[near], _joined(frequency, size, near, model.modal_damping)
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


def _joined(frequency: Array, size: Array, near: NDArray[np.bool_], damping: float) -> Array:
    """Amplitude at each line with its neighbours within the pulley mode's half-width, which sum up in it."""
    width = max(0.5 * damping / (2 * pi), 0.5 * float(frequency[0]))
    lines = frequency[near]
    return np.array([np.sqrt(np.sum(size[np.abs(frequency - f) <= width] ** 2)) for f in lines])
