"""Least squares as its authors published it for the EMPS benchmark, with MATLAB's edges."""

from dataclasses import dataclass

import numpy as np
from scipy import signal

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecipeResult:
    """What the recipe returns."""

    # values, deviations: (p,): parameters and their standard deviations as the authors compute them
    # (residuals taken as white)
    values: Array
    deviations: Array
    condition: float
    # residual_norm, residual_relative, residual_deviation: Norm, its ratio to that of the force, and MATLAB's
    # ``std``
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
    w, y = recipe_rows(
        position, force, interval, asymmetric=asymmetric, cutoff=cutoff, dropped=dropped, factor=factor
    )
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


def recipe_regressor(
    position: Array, interval: float, *, asymmetric: bool = False, cutoff: float = 100.0
) -> Array:
    """Columns of the regression at every sample, of any axis.

    ``position``, shape (samples,) [m or rad]; ``interval`` [s]; ``asymmetric``: columns [a, v+, 1+, v-, -1-]
    instead of [a, v, sign v, 1]; ``cutoff`` [Hz].
    Returns shape (samples, 4 or 5).
    Raises `InputRefused` if the cutoff is not below half of the sample rate.
    """
    if not 0.0 < 2.0 * cutoff * interval < 1.0:
        raise InputRefused(
            f"cutoff = {cutoff:.4g} Hz must lie between 0 and half of the sample rate, "
            f"{0.5 / interval:.4g} Hz: lower it"
        )
    smooth = signal.filtfilt(*signal.butter(4, 2 * cutoff * interval), position, padlen=12)
    v = np.gradient(smooth, interval)
    a = np.gradient(v, interval)
    if not asymmetric:
        return np.column_stack([a, v, np.sign(v), np.ones_like(v)])
    forth, back = (v > 0).astype(float), (v < 0).astype(float)
    return np.column_stack([a, v * forth, forth, v * back, -back])


def recipe_rows(
    position: Array,
    force: Array,
    interval: float,
    *,
    asymmetric: bool = False,
    cutoff: float = 100.0,
    dropped: int = 49,
    factor: int = 10,
) -> tuple[Array, Array]:
    """Decimated regressor (rows, p) and force (rows,), as `published_recipe` takes them."""
    columns = recipe_regressor(position, interval, asymmetric=asymmetric, cutoff=cutoff)
    return _decimated(columns[dropped:], factor), _decimated(force[dropped:], factor)


def _decimated(rows: Array, factor: int) -> Array:
    filter_ = signal.cheby1(8, 0.05, 0.8 / factor)
    return np.asarray(signal.filtfilt(*filter_, rows, axis=0, padlen=24)[1::factor])
