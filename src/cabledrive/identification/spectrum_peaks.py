r"""Modes behind the peaks of a spectrum: sums of partial fractions fitted through the noise.

A resonance test excites with an acceleration in proportion to the frequency, so that the density that is
measured is :math:`\omega^2|H|^2` seen through the window. The squared magnitude of any sum of modes, and any
sum of those over directions, is

.. math::

    |H|^2 = c + \sum_k \frac{\alpha_k + \beta_k\omega^2}
    {(\omega_k^2 - \omega^2)^2 + (2\zeta_k\omega_k\omega)^2},

which is fitted with the sensor's noise by least squares of the relative error.
"""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, signal, stats

from cabledrive.identification.printer_spectrum import KAISER, LOWEST, PrinterSpectrum
from cabledrive.parameters.arrays import Array, Integers

SMALLEST, LARGEST = 2e-3, 0.5
"""Damping ratios that are searched."""
STARTS = (0.03, 0.1)
"""Damping ratios from which the fit starts; the better result counts."""
FLOOR = 0.01
"""Of the largest density, added to the local one in the scale of errors."""
FINE = (4, 16)
"""Fewest and most points within an interval of the spectrum, on which the window is applied; 10 in 1 Hz."""
MOST_TRIES = 40
"""Of one fit."""
REACH = 5
"""Width of the window's main lobe and more, to each side [intervals]."""
MOVED = 2.5
"""How far a frequency may lie from that of its peak [intervals]."""
CORRELATED = 4
"""Neighbouring errors that the window makes alike."""
MOST_LEVERAGE = 0.9
"""Of a line on its own fit, in the estimate of its error."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModeFit:
    """Modes fitted to a spectrum."""

    # values, errors: (2, k): undamped natural frequencies [Hz], damping ratios; errors, of their logarithm
    values: Array
    errors: Array
    at_bound: NDArray[np.bool_]  # (k,)
    free: int  # degrees of freedom
    misfit: float  # root mean square of the relative errors


@cache
def _window_power(fine: int) -> Array:
    """Power of the window about its centre, ``fine`` values an interval; the sum is 1."""
    length = 256
    spectrum = np.abs(np.fft.fft(np.kaiser(length, KAISER), fine * length)) ** 2
    reach = fine * REACH
    power = np.concatenate([spectrum[-reach:], spectrum[: reach + 1]])
    return np.asarray(power / power.sum())


_WINDOW = np.kaiser(256, KAISER)
ALIKE = float(_WINDOW.size * np.sum(_WINDOW**4) / np.sum(_WINDOW**2) ** 2)
"""Number of neighbouring lines whose errors are alike for noise through the window."""


class SpectrumFit:
    """Partial fractions through the window, on the lines of a spectrum that are used."""

    def __init__(self, spectrum: PrinterSpectrum, used: Integers, *, windowed: bool = True) -> None:
        measured = spectrum.measured
        self.target = measured[used] / measured[used].max()
        self.scale = 1.0 / (self.target + FLOOR)
        self.per_line = int(np.clip(np.ceil(10.0 * spectrum.interval), *FINE))
        step = spectrum.interval / self.per_line
        self.power = _window_power(self.per_line)
        if not windowed:  # a density that was computed without a window
            self.power = np.zeros_like(self.power)
            self.power[self.power.size // 2] = 1.0
        self.step = spectrum.interval
        start = spectrum.frequency[used[0]] - REACH * self.step
        # Below 0 Hz the window sees the mirrored density.
        self.fine = np.abs(start + step * np.arange(self.per_line * (used.size - 1 + 2 * REACH) + 1))

    def basis(self, parameters: Array) -> Array:
        """Columns of the linear amplitudes, each over the scale of the errors, shape (lines, 2 k + 2)."""
        count = parameters.size // 2
        square = self.fine**2
        shapes = [square, np.ones_like(square)]  # rigid motion, noise
        for place, ratio in zip(parameters[:count], np.exp(parameters[count:]), strict=True):
            share = square / place**2
            peak = 1.0 / ((1.0 - share) ** 2 + 4.0 * ratio**2 * share)
            shapes += [square * peak, square * (1.0 - share) * peak]
        seen = [np.convolve(shape, self.power, "valid")[:: self.per_line] for shape in shapes]
        columns = np.column_stack(seen)
        return np.asarray(columns / np.abs(columns).max(axis=0) * self.scale[:, None])

    def errors(self, parameters: Array) -> Array:
        """Relative errors with the linear amplitudes that fit best, shape (lines,)."""
        basis, wanted = self.basis(parameters), self.target * self.scale
        return np.asarray(basis @ np.linalg.lstsq(basis, wanted, rcond=1e-12)[0] - wanted)

    def variance(self, parameters: Array) -> tuple[Array, int]:
        """Of each parameter, errors of neighbours being alike; degrees of freedom."""
        errors, slopes = self.errors(parameters), []
        for k, step in enumerate(1e-5 * np.maximum(1.0, np.abs(parameters))):
            delta = step * np.eye(parameters.size)[k]
            slopes.append((self.errors(parameters + delta) - self.errors(parameters - delta)) / (2.0 * step))
        slope = np.column_stack(slopes)
        free = errors.size - 2 * parameters.size - 2
        inverse = np.linalg.pinv(slope.T @ slope, rcond=1e-12)
        # A line with leverage draws the fit to itself: its error is larger than it looks.
        span = np.linalg.qr(np.hstack([self.basis(parameters), slope]))[0]
        leverage = np.minimum(np.sum(span**2, axis=1), MOST_LEVERAGE)
        moments = slope * (errors / (1.0 - leverage))[:, None]
        middle = moments.T @ moments
        for lag in range(1, CORRELATED + 1):
            crossed = moments[lag:].T @ moments[:-lag]
            middle += (1.0 - lag / (CORRELATED + 1)) * (crossed + crossed.T)
        # Few lines estimate correlations badly: no smaller than the window alone would make it.
        plain = ALIKE * (errors @ errors) / free * inverse
        robust = inverse @ middle @ inverse
        return np.maximum(np.diag(robust), np.diag(plain)), free

    def modes(self, seen: Array, reach: Array) -> ModeFit:
        """Fit a mode near each of some frequencies [Hz], which may move so far [Hz]."""
        count = seen.size
        low = np.concatenate([seen - reach, np.full(count, np.log(SMALLEST))])
        high = np.concatenate([seen + reach, np.full(count, np.log(LARGEST))])
        scale = np.repeat([1.0, 0.3], count)
        starts = (np.concatenate([seen, np.full(count, np.log(ratio))]) for ratio in STARTS)
        tried = (
            optimize.least_squares(self.errors, start, bounds=(low, high), x_scale=scale, max_nfev=MOST_TRIES)
            for start in starts
        )
        found = min(tried, key=lambda fitted: fitted.cost)
        variance, free = self.variance(found.x)
        held = (found.x - low < 1e-6) | (high - found.x < 1e-6)
        return ModeFit(
            values=np.array([found.x[:count], np.exp(found.x[count:])]),
            errors=np.sqrt(variance).reshape(2, -1),
            at_bound=held[:count] | held[count:],
            free=free,
            misfit=float(np.sqrt(2.0 * found.cost / free)),
        )


HEIGHT = 0.05
"""Smallest peak, of the largest density: what a shaper is judged by."""
PROMINENCE = 0.3
"""By how much of its height a peak rises above the valleys beside it; less may be chance."""
MOST_PEAKS = 6
LEAST_WIDTH = (0.01, 0.01)
"""Half an interval at least, as the test sweeps instead of resting at a frequency: of a frequency in steps of
the spectrum, of a damping ratio relative to it."""
WIDEST = 0.5
"""Interval of the damping ratio, to each side of it and relative, up to which the ratio is given."""
BELOW, ABOVE, SWEPT = 0.5, 1.4, 130.0
"""Lines that are fitted: from 0.5 of the lowest peak to 1.4 of the highest; above 130 Hz, where a test
usually ends, no more than 1.1 of it."""
FIRST = 12.0
"""Below which a hump of the density is that of its normalisation [Hz]."""
RESOLUTION = 3.0
"""Width over which a density is smoothed before peaks are searched [Hz]."""
MOST_HIDDEN = 3
"""Peaks beside which a hidden mode is searched."""
EXPLAINED, HIDDEN = 0.01, 0.7
"""A mode without a peak of its own is added where the misfit is above 1 %, and falls to 0.7 of it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SpectrumPeak:
    """A peak of a spectrum as a mode."""

    source: str  # name of the file
    frequency: float  # undamped natural frequency; that of the largest density where ``reason`` is given [Hz]
    height: float  # density over the largest
    # frequency_low, frequency_high: ends of its interval of 95 % [Hz]
    frequency_low: float | None = None
    frequency_high: float | None = None
    # damping, damping_low, damping_high: damping ratio, and its interval
    damping: float | None = None
    damping_low: float | None = None
    damping_high: float | None = None
    reason: str | None = None  # why there is no damping ratio


def spectrum_peaks(spectrum: PrinterSpectrum) -> tuple[SpectrumPeak, ...]:
    """Find the peaks of a spectrum and fit a mode to each, from the lowest frequency up."""
    frequency, density = spectrum.frequency, spectrum.density
    smooth, width = density, min(int(RESOLUTION / spectrum.interval), density.size // 4)
    if width >= 3:  # the resolution of the firmware, so that chance makes no peaks of a fine one
        weights = np.hanning(width + 2)
        smooth = np.asarray(np.convolve(density, weights / weights.sum(), "same"))
    found, _ = signal.find_peaks(smooth, height=HEIGHT * smooth.max())
    depth = signal.peak_prominences(smooth, found)[0]
    found = found[(depth > PROMINENCE * smooth[found]) & (frequency[found] > FIRST)]
    places = np.sort(found[np.argsort(-density[found])][:MOST_PEAKS])
    if places.size == 0:
        return ()
    first, last = frequency[places[0]], frequency[places[-1]]
    top = min(ABOVE * last, max(SWEPT, 1.1 * last))
    used = np.flatnonzero((frequency > max(2 * LOWEST, BELOW * first)) & (frequency < top))
    peaks = [
        SpectrumPeak(source=spectrum.source, frequency=float(frequency[k]), height=float(density[k]))
        for k in places
    ]
    if not spectrum.even or used.size < 4 * places.size + 6:
        why = "the frequencies are not even" if not spectrum.even else "too few frequencies about it"
        return tuple(replace(peak, reason=why) for peak in peaks)
    fit = _best_fit(spectrum, used, frequency[places])
    return tuple(_fitted(peak, spectrum.interval, fit, k) for k, peak in enumerate(peaks))


def _best_fit(spectrum: PrinterSpectrum, used: Integers, seen: Array) -> ModeFit:
    """A mode for each peak; where that explains too little, without the window, or with one mode more."""
    reach = np.full(seen.size, MOVED * max(spectrum.interval, 0.5))
    fit = SpectrumFit(spectrum, used)
    found = fit.modes(seen, reach)
    if found.misfit < EXPLAINED:
        return found
    plain = SpectrumFit(spectrum, used, windowed=False).modes(seen, reach)
    if plain.misfit < HIDDEN * found.misfit:
        return plain
    if seen.size > MOST_HIDDEN or fit.target.size < 4 * seen.size + 12:
        return found
    middles = 0.5 * (seen[1:] + seen[:-1])
    tried = [
        fit.modes(np.append(seen, place), np.append(reach, 0.2 * place))
        for place in (0.75 * seen[0], *middles, 1.25 * seen[-1])
    ]
    best = min(tried, key=lambda one: one.misfit, default=found)
    return best if best.misfit < HIDDEN * found.misfit else found


def _fitted(seen: SpectrumPeak, interval: float, fit: ModeFit, k: int) -> SpectrumPeak:
    """One peak, as the mode number k of the fit; ``interval``: of the spectrum [Hz]."""
    (at, ratio), errors = fit.values[:, k].tolist(), float(stats.t.ppf(0.975, fit.free)) * fit.errors[:, k]
    reach = float(np.hypot(LEAST_WIDTH[0] * interval, errors[0]))
    spread = float(np.hypot(LEAST_WIDTH[1], errors[1]))
    if fit.at_bound[k]:
        return replace(seen, reason="no single mode fits it, or it is narrower than the window")
    if not (spread < np.log(1.0 + WIDEST) and reach < MOVED * interval):
        return replace(seen, reason=f"its interval is wider than {100 * WIDEST:.0f} %")
    return replace(
        seen,
        frequency=at,
        frequency_low=at - reach,
        frequency_high=at + reach,
        damping=ratio,
        damping_low=float(ratio * np.exp(-spread)),
        damping_high=float(ratio * np.exp(spread)),
    )
