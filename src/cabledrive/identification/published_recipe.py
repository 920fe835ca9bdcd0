"""Least squares as its authors published it for the EMPS benchmark, with MATLAB's edges."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecipeResult:
    """What the recipe returns.

    Attributes
    ----------
    values, deviations : ndarray, shape (p,)
        Parameters and their standard deviations as the authors compute them (residuals taken as white).
    condition : float
    residual_norm, residual_relative, residual_deviation : float
        Norm, its ratio to that of the force, and MATLAB's ``std``.
    rows : int
    """

    values: Array
    deviations: Array
    condition: float
    residual_norm: float
    residual_relative: float
    residual_deviation: float
    rows: int


def published_recipe(
    position: Array,
    force: Array,
    interval: float,
    *,
    asymmetric: bool = False,
    cutoff: float = 100.0,
    dropped: int = 49,
    factor: int = 10,
) -> RecipeResult:
    """Identify mass, friction and offset by the recipe of the EMPS benchmark.

    Butterworth of order 4 forwards and backwards on the position, two differences, every column decimated by
    a Chebyshev filter of order 8 (0.05 dB, 0.8/factor) forwards and backwards, ordinary least squares.

    Parameters
    ----------
    position : ndarray, shape (samples,)
        [m].
    force : ndarray, shape (samples,)
        [N].
    interval : float
        [s].
    asymmetric : bool, default False
        Columns [a, v+, 1+, v-, -1-] instead of [a, v, sign v, 1].
    cutoff : float, default 100.0
        [Hz].
    dropped : int, default 49
        First samples left out.
    factor : int, default 10
        Of the decimation, which starts at the second row.

    Returns
    -------
    RecipeResult
        The offset with the authors' sign: force = M a + Fv v + Fc sign(v) + offset.

    References
    ----------
    .. [1] A. Janot, M. Gautier, M. Brunot, "Data Set and Reference Models of EMPS", Nonlinear System
       Identification Benchmarks, 2019.
    """
    smooth = signal.filtfilt(*signal.butter(4, 2 * cutoff * interval), position, padlen=12)
    v = np.gradient(smooth, interval)
    a = np.gradient(v, interval)
    if asymmetric:
        forth, back = (v > 0).astype(float), (v < 0).astype(float)
        columns = np.column_stack([a, v * forth, forth, v * back, -back])
    else:
        columns = np.column_stack([a, v, np.sign(v), np.ones_like(v)])
    w = _decimated(columns[dropped:], factor)
    y = _decimated(force[dropped:], factor)
    q, r = np.linalg.qr(w)
    values = np.linalg.solve(r, q.T @ y)
    rest = y - w @ values
    deviation = float(np.std(rest, ddof=1))
    inverse = np.linalg.inv(r)
    return RecipeResult(
        values=values,
        deviations=deviation * np.sqrt((inverse**2).sum(axis=1)),
        condition=float(np.linalg.cond(w)),
        residual_norm=float(np.linalg.norm(rest)),
        residual_relative=float(np.linalg.norm(rest) / np.linalg.norm(y)),
        residual_deviation=deviation,
        rows=y.size,
    )


def _decimated(rows: Array, factor: int) -> Array:
    filter_ = signal.cheby1(8, 0.05, 0.8 / factor)
    return np.asarray(signal.filtfilt(*filter_, rows, axis=0, padlen=24)[1::factor])
