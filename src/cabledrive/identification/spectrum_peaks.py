r"""Frequencies and damping ratios of the modes behind the peaks of a printer's spectrum, with intervals.

A test excites with an acceleration in proportion to the frequency, so that the density that is measured is
:math:`\omega^2|H|^2` seen through the window. The squared magnitude of any sum of modes, and any sum of those
over directions, is in partial fractions

.. math::

    |H|^2 = c + \sum_k \frac{\alpha_k + \beta_k\omega^2}
    {(\omega_k^2 - \omega^2)^2 + (2\zeta_k\omega_k\omega)^2},

which is fitted to the density with the sensor's noise, the window's own width included, by least squares of the
relative error.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, signal, stats

from cabledrive.identification.printer_spectrum import KAISER, LOWEST, PrinterSpectrum

Array = NDArray[np.float64]

HEIGHT = 0.05
"""Smallest peak, of the largest density: what a shaper is judged by."""
PROMINENCE = 0.3
"""By how much of its height a peak rises above the valleys beside it; less may be chance."""
MOST_PEAKS = 6
CONFIDENCE = 0.95
SMALLEST, LARGEST = 2e-3, 0.5
"""Damping ratios that are sought."""
STARTS = (0.03, 0.1)
"""Damping ratios from which the fit starts; the better result counts."""
FLOOR = 0.02
"""Of the largest density, added to the local one in the scale of errors."""
FINE = 16
"""Points within an interval of the spectrum, on which the window is applied."""
REACH = 5
"""Width of the window's main lobe and more, to each side [intervals]."""
CORRELATED = 4
"""Neighbouring errors that the window makes alike."""
LEAST_WIDTH = (0.01, 0.01)
"""Half an interval at least, as the test sweeps instead of resting at a frequency: of a frequency in steps of
the spectrum, of a damping ratio relative to it."""
WIDEST = 0.5
"""Interval of the damping ratio, to each side of it and relative, up to which the ratio is given."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SpectrumPeak:
    """A peak of a spectrum as a mode.

    Attributes
    ----------
    source : str
        Name of the file.
    frequency : float
        Undamped natural frequency; that of the largest density where ``reason`` is given [Hz].
    frequency_low, frequency_high : float or None
        Ends of its interval of 95 % [Hz].
    damping, damping_low, damping_high : float or None
        Damping ratio, and its interval.
    height : float
        Density over the largest.
    reason : str or None
        Why there is no damping ratio.
    """

    source: str
    frequency: float
    frequency_low: float | None
    frequency_high: float | None
    damping: float | None
    damping_low: float | None
    damping_high: float | None
    height: float
    reason: str | None


def spectrum_peaks(spectrum: PrinterSpectrum) -> tuple[SpectrumPeak, ...]:
    """Find the peaks of a spectrum and fit a mode to each, from the lowest frequency up."""
    frequency, density = spectrum.frequency, spectrum.density
    found, _ = signal.find_peaks(density, height=HEIGHT * density.max())
    depth = signal.peak_prominences(density, found)[0]
    found = found[(depth > PROMINENCE * density[found]) & (frequency[found] > 2.0 * LOWEST)]
    places = np.sort(found[np.argsort(-density[found])][:MOST_PEAKS])
    if places.size == 0:
        return ()
    used = np.flatnonzero(
        (frequency > max(2 * LOWEST, 0.4 * frequency[places[0]])) & (frequency < 1.6 * frequency[places[-1]])
    )
    if not spectrum.even or used.size < 4 * places.size + 6:
        why = "the frequencies are not even" if not spectrum.even else "too few frequencies about it"
        return tuple(_unfitted(spectrum, int(place), why) for place in places)
    fit = _Fit(spectrum, used)
    return _fitted(spectrum, places, fit)


def _unfitted(spectrum: PrinterSpectrum, place: int, reason: str) -> SpectrumPeak:
    return SpectrumPeak(
        source=spectrum.source,
        frequency=float(spectrum.frequency[place]),
        frequency_low=None,
        frequency_high=None,
        damping=None,
        damping_low=None,
        damping_high=None,
        height=float(spectrum.density[place]),
        reason=reason,
    )


@cache
def _window_power() -> Array:
    """Power of the window at steps of 1/16 interval about its centre; the sum is 1."""
    length = 256
    spectrum = np.abs(np.fft.fft(np.kaiser(length, KAISER), FINE * length)) ** 2
    reach = FINE * REACH
    power = np.concatenate([spectrum[-reach:], spectrum[: reach + 1]])
    return np.asarray(power / power.sum())


class _Fit:
    """Partial fractions through the window, on the lines of a spectrum that are used."""

    def __init__(self, spectrum: PrinterSpectrum, used: NDArray[np.int64]) -> None:
        measured = spectrum.measured
        self.target = measured[used] / measured[used].max()
        self.scale = 1.0 / (self.target + FLOOR)
        step = spectrum.interval / FINE
        self.step = spectrum.interval
        start = spectrum.frequency[used[0]] - REACH * self.step
        # Below 0 Hz the window sees the mirrored density.
        self.fine = np.abs(start + step * np.arange(FINE * (used.size - 1 + 2 * REACH) + 1))

    def basis(self, parameters: Array) -> Array:
        """Columns of the linear amplitudes, each over the scale of the errors, shape (lines, 2 k + 2)."""
        count = parameters.size // 2
        square = self.fine**2
        shapes = [square, np.ones_like(square)]  # rigid motion, noise
        for place, ratio in zip(parameters[:count], np.exp(parameters[count:]), strict=True):
            share = square / place**2
            peak = 1.0 / ((1.0 - share) ** 2 + 4.0 * ratio**2 * share)
            shapes += [square * peak, square * (1.0 - share) * peak]
        seen = [np.convolve(shape, _window_power(), "valid")[::FINE] for shape in shapes]
        columns = np.column_stack(seen)
        return np.asarray(columns / np.abs(columns).max(axis=0) * self.scale[:, None])

    def amplitudes(self, basis: Array) -> Array:
        return np.asarray(np.linalg.lstsq(basis, self.target * self.scale, rcond=1e-12)[0])

    def errors(self, parameters: Array) -> Array:
        """Relative errors with the amplitudes that fit best, shape (lines,)."""
        basis = self.basis(parameters)
        return np.asarray(basis @ self.amplitudes(basis) - self.target * self.scale)

    def variance(self, parameters: Array) -> tuple[Array, int]:
        """Of each parameter, errors of neighbours being alike; degrees of freedom."""
        errors, slopes = self.errors(parameters), []
        for k in range(parameters.size):
            delta = np.zeros_like(parameters)
            delta[k] = 1e-5 * max(1.0, abs(parameters[k]))
            slopes.append(
                (self.errors(parameters + delta) - self.errors(parameters - delta)) / (2.0 * delta[k])
            )
        slope = np.column_stack(slopes)
        free = errors.size - 2 * parameters.size - 2
        moments = slope * errors[:, None]
        middle = moments.T @ moments
        for lag in range(1, CORRELATED + 1):
            crossed = moments[lag:].T @ moments[:-lag]
            middle += (1.0 - lag / (CORRELATED + 1)) * (crossed + crossed.T)
        inverse = np.linalg.pinv(slope.T @ slope, rcond=1e-12)
        # No smaller than for errors that are independent: few lines estimate correlations badly.
        plain = (errors @ errors) / free * inverse
        robust = inverse @ middle @ inverse * errors.size / free
        return np.maximum(np.diag(robust), np.diag(plain)), free


def _fitted(spectrum: PrinterSpectrum, places: NDArray[np.int64], fit: _Fit) -> tuple[SpectrumPeak, ...]:
    count = places.size
    seen = spectrum.frequency[places]
    low = np.concatenate([seen - 2.5 * fit.step, np.full(count, np.log(SMALLEST))])
    high = np.concatenate([seen + 2.5 * fit.step, np.full(count, np.log(LARGEST))])
    found = min(
        (
            optimize.least_squares(
                fit.errors,
                np.concatenate([seen, np.full(count, np.log(ratio))]),
                bounds=(low, high),
                x_scale=np.repeat([1.0, 0.3], count),
            )
            for ratio in STARTS
        ),
        key=lambda fitted: fitted.cost,
    )
    variance, free = fit.variance(found.x)
    least = np.repeat([LEAST_WIDTH[0] * fit.step, LEAST_WIDTH[1]], count)
    width = np.hypot(least, stats.t.ppf(0.5 + 0.5 * CONFIDENCE, free) * np.sqrt(variance))
    peaks = []
    for k, place in enumerate(places):
        at, ratio = float(found.x[k]), float(np.exp(found.x[count + k]))
        reach, factor = float(width[k]), float(np.exp(min(width[count + k], 50.0)))
        held = (found.x - low < 1e-6) | (high - found.x < 1e-6)
        if held[k] or held[count + k]:
            why = "the fit of a mode ends at a bound: the peak is no single mode, or narrower than the window"
        elif factor > 1.0 + WIDEST or reach > 2.5 * fit.step:
            why = f"its 95 % interval would be wider than {100 * WIDEST:.0f} % to each side"
        else:
            peaks.append(
                SpectrumPeak(
                    source=spectrum.source,
                    frequency=at,
                    frequency_low=at - reach,
                    frequency_high=at + reach,
                    damping=ratio,
                    damping_low=ratio / factor,
                    damping_high=ratio * factor,
                    height=float(spectrum.density[place]),
                    reason=None,
                )
            )
            continue
        peaks.append(_unfitted(spectrum, int(place), why))
    return tuple(peaks)
