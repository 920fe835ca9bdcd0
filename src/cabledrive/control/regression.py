"""Least squares on filtered encoder readings, and how far the rounding to counts may throw them off."""

from math import pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.control.reference import lagged
from cabledrive.parameters.arrays import Array

REPLICATES, SMOOTHING_HZ = 20, 20.0
SUMS = 4000
"""Sums of a normal and a bounded error of which the 95 % interval is taken."""
IN_THE_LOOP = 1.1
"""Rounding that a loop reacts to spreads wider than rounding drawn anew: over 1,000 draws of a pulse at 23
and 35 Hz, set apart for this, estimates spread 1.05 to 1.15 times as far as the replicates say."""


def filtered(signal: Array, interval: float, hertz: float) -> Array:
    r"""A signal and two derivatives through :math:`1/(1 + s/\omega)^3`, from rest, (3, ..., samples).

    With :math:`a, b, c` the signal after one, two and three lags of time constant T, the derivatives are
    :math:`(b - c)/T` and :math:`(a - 2b + c)/T^2`: nothing is differenced in time. ``hertz``: omega/(2 pi).
    """
    time = 1.0 / (2.0 * pi * hertz)
    one = lagged(signal, time, interval)
    two = lagged(one, time, interval)
    three = lagged(two, time, interval)
    return np.array([three, (two - three) / time, (one - 2.0 * two + three) / time**2])


def least_squares(regressors: Array, target: Array, used: NDArray[np.bool_]) -> Array:
    """Coefficients of the regressors, (p,), from samples used; all NaN where they do not span p."""
    x, y = regressors[used], target[used]
    scale = np.abs(x).max(axis=0) if len(x) else np.zeros(regressors.shape[1])
    if np.any(scale == 0.0):
        return np.full(regressors.shape[1], np.nan)
    solution, _, rank, _ = np.linalg.lstsq(x / scale, y, rcond=1e-9)
    return np.asarray(solution / scale) if rank == len(scale) else np.full(len(scale), np.nan)


def smoothed(readings: Array, interval: float) -> Array:
    """Readings through a second-order Butterworth filter forwards and backwards: no lag."""
    from scipy.signal import butter, filtfilt

    b, a = butter(2, SMOOTHING_HZ, fs=1.0 / interval)
    padding = min(len(readings) - 1, round(0.1 / interval))
    return np.asarray(filtfilt(b, a, readings, axis=0, padlen=padding))


def rounding_replicates(
    readings: Array, counts: Array, interval: float, generator: np.random.Generator
) -> list[Array]:
    """The smoothed motion rounded to counts again, each time with other phases.

    Least squares' own formula does not serve here: rounding errors are correlated in a way of their own, for
    as long as a count lasts, and the residual at hand shows one instance of them only.
    """
    motion = smoothed(readings, interval)
    phases = [generator.uniform(-0.5, 0.5, len(counts)) for _ in range(REPLICATES)]
    return [counts * (np.rint(motion / counts + one) - np.rint(one)) for one in phases]


def rounding_spread(found: Array) -> Array:
    """Standard errors, (p,), of an estimate from those of the replicates, (replicates, p)."""
    return np.asarray(IN_THE_LOOP * np.std(found, axis=0, ddof=1))


def with_bounded_errors(errors: Array, effects: Array, generator: np.random.Generator) -> Array:
    """Standard errors of an estimate that rounding and quantities believed within bounds throw off.

    What lies evenly within bounds has no tails: taken for normal it makes intervals too wide. The 95 %
    interval is that of the sum, and the error returned the one of which `interval_factor` gives it.

    ``errors``, (p,): by rounding, of `REPLICATES`; ``effects``, (n, p): of each quantity at its bound.
    """
    noise = generator.standard_t(REPLICATES - 1, (SUMS, 1)) * errors
    evenly = generator.uniform(-1.0, 1.0, (SUMS, len(effects))) @ effects
    return np.asarray(np.quantile(np.abs(noise + evenly), 0.95, axis=0) / interval_factor())


def interval_factor() -> float:
    """Half width of an interval of 95 % in standard errors, as few replicates ask for: 2.09."""
    from scipy.stats import t

    return float(t.ppf(0.975, REPLICATES - 1))
