"""Motions that repeat: what an encoder's rounding does in one period it does in all of them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from cabledrive.identification.innovations import ORDER, Prediction, Track, autoregression

Array = NDArray[np.float64]

SHORTEST = 0.3
"""Period that is looked for at least [s]."""
ALIKE = 0.9
"""Correlation of a torque with itself, one period later, from which it counts as periodic."""


def period_of(values: Array, interval: float) -> int:
    """Period of a signal.

    ``values``, shape (samples,); ``interval`` [s].
    Returns [samples]; 0 where it does not repeat at least once.
    """
    centred = values - values.mean()
    size = values.size
    power = np.abs(fft.rfft(centred, fft.next_fast_len(2 * size))) ** 2
    products = fft.irfft(power)[:size]
    energy = np.cumsum(centred**2)
    first, last = round(SHORTEST / interval), size // 2
    lags = np.arange(first, last)
    if lags.size == 0 or energy[-1] == 0.0:
        return 0
    heads, tails = energy[size - 1 - lags], energy[-1] - energy[lags - 1]
    alike = products[lags] / np.sqrt(np.maximum(heads * tails, 1e-300))
    best = int(np.argmax(alike))
    if alike[best] < ALIKE:
        return 0
    # The shortest of the multiples that are as good.
    near = np.flatnonzero(alike > alike[best] - 0.02)
    return int(lags[near[0] + int(np.argmax(alike[near[0] : near[0] + 20]))])


def design_effect(tracks: Sequence[Track], runs: Sequence[Prediction]) -> float:
    r"""Factor of the variances of a log that repeats: :math:`1 + (n - 1)\rho`.

    ``runs``: of the observer.
    Returns with n periods, and the correlation of the whitened innovations with those one period later; 1
    where nothing repeats.
    """
    found = [1.0]
    for track, run in zip(tracks, runs, strict=True):
        period = period_of(track.torque, track.interval)
        if period == 0:
            continue
        white = np.convolve(run.innovation, autoregression(run.innovation), "valid")[ORDER:]
        count = white.size / period
        alike = float(white[period:] @ white[:-period]) / float(white @ white) / (1.0 - 1.0 / count)
        found.append(1.0 + (count - 1.0) * max(alike, 0.0))
    return max(found)
