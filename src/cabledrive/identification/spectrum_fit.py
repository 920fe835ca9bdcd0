r"""Sums of modes in partial fractions, fitted to a power spectral density through the window of its making.

A resonance test excites with an acceleration in proportion to the frequency, so that the density that is
measured is :math:`\omega^2|H|^2` seen through the window. The squared magnitude of any sum of modes, and any
sum of those over directions, is

.. math::

    |H|^2 = c + \sum_k \frac{\alpha_k + \beta_k\omega^2}
    {(\omega_k^2 - \omega^2)^2 + (2\zeta_k\omega_k\omega)^2},

which is fitted with the sensor's noise by least squares of the relative error.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from cabledrive.identification.printer_spectrum import KAISER, PrinterSpectrum

Array = NDArray[np.float64]

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
    """Modes fitted to a spectrum.

    Attributes
    ----------
    frequency, damping : ndarray, shape (k,)
        Undamped natural frequencies [Hz], damping ratios.
    frequency_error, damping_error : ndarray, shape (k,)
        Standard errors [Hz], of the logarithm of the ratio [-].
    at_bound : ndarray of bool, shape (k,)
    free : int
        Degrees of freedom.
    misfit : float
        Root mean square of the relative errors.
    """

    frequency: Array
    damping: Array
    frequency_error: Array
    damping_error: Array
    at_bound: NDArray[np.bool_]
    free: int
    misfit: float


@cache
def _window_power(fine: int) -> Array:
    """Power of the window about its centre, ``fine`` values an interval; the sum is 1."""
    length = 256
    spectrum = np.abs(np.fft.fft(np.kaiser(length, KAISER), fine * length)) ** 2
    reach = fine * REACH
    power = np.concatenate([spectrum[-reach:], spectrum[: reach + 1]])
    return np.asarray(power / power.sum())


@cache
def _alike() -> float:
    """Number of neighbouring lines whose errors are alike for noise through the window."""
    window = np.kaiser(256, KAISER)
    return float(window.size * np.sum(window**4) / np.sum(window**2) ** 2)


class SpectrumFit:
    """Partial fractions through the window, on the lines of a spectrum that are used."""

    def __init__(self, spectrum: PrinterSpectrum, used: NDArray[np.int64], *, windowed: bool = True) -> None:
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

    def amplitudes(self, basis: Array) -> Array:
        """Linear amplitudes that fit best, shape (2 k + 2,)."""
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
        plain = _alike() * (errors @ errors) / free * inverse
        robust = inverse @ middle @ inverse
        return np.maximum(np.diag(robust), np.diag(plain)), free

    def modes(self, seen: Array, reach: Array) -> ModeFit:
        """Fit a mode near each of some frequencies.

        ``seen`` [Hz]; ``reach``: how far each may move [Hz].
        """
        count = seen.size
        low = np.concatenate([seen - reach, np.full(count, np.log(SMALLEST))])
        high = np.concatenate([seen + reach, np.full(count, np.log(LARGEST))])
        found = min(
            (
                optimize.least_squares(
                    self.errors,
                    np.concatenate([seen, np.full(count, np.log(ratio))]),
                    bounds=(low, high),
                    x_scale=np.repeat([1.0, 0.3], count),
                    max_nfev=MOST_TRIES,
                )
                for ratio in STARTS
            ),
            key=lambda fitted: fitted.cost,
        )
        variance, free = self.variance(found.x)
        error = np.sqrt(variance)
        held = (found.x - low < 1e-6) | (high - found.x < 1e-6)
        return ModeFit(
            frequency=found.x[:count],
            damping=np.exp(found.x[count:]),
            frequency_error=error[:count],
            damping_error=error[count:],
            at_bound=held[:count] | held[count:],
            free=free,
            misfit=float(np.sqrt(2.0 * found.cost / free)),
        )
