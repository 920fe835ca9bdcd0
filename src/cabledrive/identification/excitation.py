"""Signals that make a log informative: multisines of low crest, chirps, steps, sums of sines."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import InputRefused

Array = NDArray[np.float64]


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
    lines: NDArray[np.int64]
    frequencies: Array
    crest: float
    sample_rate: float


def crest_factor(values: Array) -> float:
    """Largest absolute value over root mean square."""
    return float(np.abs(values).max() / np.sqrt(np.mean(values**2)))


def multisine_lines(
    samples: int, sample_rate: float, low: float, high: float, count: int | None = None, odd: bool = False
) -> NDArray[np.int64]:
    """Lines of a multisine in a band.

    ``samples``: of one period; ``sample_rate`` [Hz]; ``low``, ``high``: band [Hz]; ``count``: how many lines,
    spread evenly; default: all in the band; ``odd``: only odd lines: what appears at even ones is then an
    even nonlinearity.
    Raises `InputRefused` if the band holds no line, or fewer than asked for, or reaches half the sample rate.
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
    r"""Phases of a flat multisine of low crest.

    .. math:: \varphi_k = -\pi k(k-1)/N

    Returns shape (count,) [rad].

    References
    ----------
    .. [1] M. R. Schroeder, "Synthesis of low-peak-factor signals and binary sequences with low
       autocorrelation", IEEE Trans. Inf. Theory 16(1), 85-89, 1970.
    """
    k = np.arange(1, count + 1)
    return -pi * k * (k - 1) / count


def random_multisine(
    samples: int, sample_rate: float, lines: NDArray[np.int64], trials: int, rng: np.random.Generator
) -> Multisine:
    """The lowest crest of several draws of random phases: `idinput` 'sine', Eqs. (4.13), (4.14).

    ``sample_rate`` [Hz]; ``trials``: how many draws.
    Returns of largest value 1.
    """
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
    lines: NDArray[np.int64],
    passes: int = 200,
    amplitudes: Array | None = None,
) -> Multisine:
    """Schroeder phases, then clipping in turn with restoring of the amplitudes.

    ``sample_rate`` [Hz]; ``amplitudes``: of the lines; default: all alike.
    Returns of largest value 1.

    References
    ----------
    .. [1] E. Van der Ouderaa, J. Schoukens, J. Renneboog, "Peak factor minimization using a time-frequency
       domain swapping algorithm", IEEE Trans. Instrum. Meas. 37(1), 145-147, 1988.
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
    """Few sines together, as in section 4.2.

    ``duration`` [s]; ``sample_rate`` [Hz]; ``frequencies`` [Hz]; ``phases`` [rad]; default: 0.
    Returns shape (samples,).
    """
    t = np.arange(round(duration * sample_rate)) / sample_rate
    angles = np.zeros(len(frequencies)) if phases is None else phases
    waves = [a * np.sin(2 * pi * f * t + p) for f, a, p in zip(frequencies, amplitudes, angles, strict=True)]
    return np.sum(waves, axis=0)


def chirp(duration: float, sample_rate: float, low: float, high: float) -> Array:
    """A sine whose frequency rises so that every octave takes the same time.

    ``duration`` [s]; ``sample_rate`` [Hz]; ``low``, ``high``: frequency at both ends [Hz].
    Returns shape (samples,): of amplitude 1.
    """
    t = np.arange(round(duration * sample_rate)) / sample_rate
    rate = np.log(high / low) / duration
    return np.sin(2 * pi * low * np.expm1(rate * t) / rate)


def steps(duration: float, sample_rate: float, period: float) -> Array:
    """A square wave.

    ``duration`` [s]; ``sample_rate`` [Hz]; ``period`` [s].
    Returns shape (samples,): 1 and -1.
    """
    t = np.arange(round(duration * sample_rate)) / sample_rate
    return np.where(np.mod(t, period) < 0.5 * period, 1.0, -1.0)


def _summed(samples: int, lines: NDArray[np.int64], phases: Array, sizes: Array | None = None) -> Array:
    spectrum = np.zeros(samples // 2 + 1, dtype=complex)
    spectrum[lines] = (1.0 if sizes is None else sizes) * np.exp(1j * (phases - 0.5 * pi))
    return np.fft.irfft(spectrum, samples) * samples / 2


def _finished(values: Array, lines: NDArray[np.int64], sample_rate: float) -> Multisine:
    values = values / np.abs(values).max()
    return Multisine(
        values=values,
        lines=lines,
        frequencies=lines * sample_rate / values.size,
        crest=crest_factor(values),
        sample_rate=sample_rate,
    )
