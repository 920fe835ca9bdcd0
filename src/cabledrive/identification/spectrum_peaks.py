"""Frequencies and damping ratios of the modes behind the peaks of a printer's spectrum, with intervals."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal, stats

from cabledrive.identification.printer_spectrum import LOWEST, PrinterSpectrum
from cabledrive.identification.spectrum_fit import MOVED, ModeFit, SpectrumFit

Array = NDArray[np.float64]

HEIGHT = 0.05
"""Smallest peak, of the largest density: what a shaper is judged by."""
PROMINENCE = 0.3
"""By how much of its height a peak rises above the valleys beside it; less may be chance."""
MOST_PEAKS = 6
CONFIDENCE = 0.95
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
    smooth = _smoothed(spectrum)
    found, _ = signal.find_peaks(smooth, height=HEIGHT * smooth.max())
    depth = signal.peak_prominences(smooth, found)[0]
    found = found[(depth > PROMINENCE * smooth[found]) & (frequency[found] > FIRST)]
    places = np.sort(found[np.argsort(-density[found])][:MOST_PEAKS])
    if places.size == 0:
        return ()
    first, last = frequency[places[0]], frequency[places[-1]]
    top = min(ABOVE * last, max(SWEPT, 1.1 * last))
    used = np.flatnonzero((frequency > max(2 * LOWEST, BELOW * first)) & (frequency < top))
    if not spectrum.even or used.size < 4 * places.size + 6:
        why = "the frequencies are not even" if not spectrum.even else "too few frequencies about it"
        return tuple(_unfitted(spectrum, int(place), why) for place in places)
    fit = _best_fit(spectrum, used, frequency[places])
    return tuple(_fitted(spectrum, int(place), fit, k) for k, place in enumerate(places))


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


def _smoothed(spectrum: PrinterSpectrum) -> Array:
    """The density at the resolution of the firmware, so that chance makes no peaks of a fine one."""
    width = min(int(RESOLUTION / spectrum.interval), spectrum.density.size // 4)
    if width < 3:
        return spectrum.density
    weights = np.hanning(width + 2)
    return np.asarray(np.convolve(spectrum.density, weights / weights.sum(), "same"))


def _best_fit(spectrum: PrinterSpectrum, used: NDArray[np.int64], seen: Array) -> ModeFit:
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


def _fitted(spectrum: PrinterSpectrum, place: int, fit: ModeFit, k: int) -> SpectrumPeak:
    """One peak, as the mode number k of the fit."""
    at, ratio = float(fit.frequency[k]), float(fit.damping[k])
    times = float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, fit.free))
    reach = float(np.hypot(LEAST_WIDTH[0] * spectrum.interval, times * fit.frequency_error[k]))
    spread = float(np.hypot(LEAST_WIDTH[1], times * fit.damping_error[k]))
    if fit.at_bound[k]:
        return _unfitted(spectrum, place, "no single mode fits it, or it is narrower than the window")
    if not (spread < np.log(1.0 + WIDEST) and reach < MOVED * spectrum.interval):
        return _unfitted(spectrum, place, f"its interval is wider than {100 * WIDEST:.0f} %")
    return SpectrumPeak(
        source=spectrum.source,
        frequency=at,
        frequency_low=at - reach,
        frequency_high=at + reach,
        damping=ratio,
        damping_low=float(ratio * np.exp(-spread)),
        damping_high=float(ratio * np.exp(spread)),
        height=float(spectrum.density[place]),
        reason=None,
    )
