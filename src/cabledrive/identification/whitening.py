r"""Weight of a residual by its own spectrum: what is noisy at one frequency counts less there.

Noise of a torque comes out of a simulated axis as :math:`1/\omega`, rounding of an encoder goes into a speed
as :math:`\omega`. Unweighted, the slow drift of the first hides what the log knows, and neighbouring segments
depend on one another. The weight :math:`1/\sqrt{S(\omega)}` of the smoothed spectrum S makes the residual
white in its band; the estimating equations have the same solution on average under any such weight.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Array = NDArray[np.float64]

BANDS = 24
LONGEST_SEGMENT = 8.0
"""Of the records whose spectra are averaged [s]."""
REACH = 4.0
"""Half of the filter's length [s]; a short one cannot follow the corner, some tenths of a hertz, below which
noise of the torque no longer grows."""
SHARE = 1 / 16
"""Of the shortest log, that half of the filter's length at most."""
INSIDE = 0.8
"""Share of the bandwidth of the compared signals that is used: above, their filter leaves too little."""


def whitener(residuals: Sequence[Array], interval: float, bandwidth: float) -> Array:
    """Symmetric filter that makes residuals white below a bandwidth.

    ``residuals``, shape (rows,); ``interval`` [s]; ``bandwidth``: of the residuals [Hz].
    Returns shape (2 m + 1,): weights; the filtered residual has a power density of 1 [1/Hz].
    """
    shortest = min(r.size for r in residuals)
    length = min(round(LONGEST_SEGMENT / interval), shortest)
    spectra = [signal.welch(r, 1.0 / interval, nperseg=length, detrend=False) for r in residuals]
    frequency, power = spectra[0][0], np.mean([s[1] for s in spectra], axis=0)
    top = INSIDE * bandwidth
    edges = np.geomspace(frequency[1], top, BANDS + 1)
    bands = [(frequency >= a) & (frequency < b) for a, b in pairwise(edges)]
    filled = [band for band in bands if band.any()]
    middles = [float(np.mean(np.log(frequency[band]))) for band in filled]
    levels = [float(np.mean(np.log(power[band] + 1e-300))) for band in filled]
    smooth = np.interp(np.log(np.maximum(frequency, frequency[1])), middles, levels)
    gain = np.exp(-0.5 * smooth) * np.clip((bandwidth - frequency) / (bandwidth - top), 0.0, 1.0)
    impulse = np.fft.fftshift(np.fft.irfft(gain))
    reach = min(round(REACH / interval), round(SHARE * shortest), impulse.size // 2 - 1)
    middle = impulse.size // 2
    window = np.hanning(2 * reach + 3)[1:-1]
    return np.asarray(impulse[middle - reach : middle + reach + 1] * window)


def whitened(rows: Array, weights: Array) -> Array:
    """Columns through the filter of `whitener`.

    ``rows``, shape (rows, columns); ``weights``, shape (2 m + 1,).
    Returns shape (rows, columns): nothing is assumed beyond both ends.
    """
    return np.asarray(signal.oaconvolve(rows, weights[:, None], mode="same", axes=0))
