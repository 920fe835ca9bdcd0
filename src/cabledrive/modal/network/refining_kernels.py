"""A single mode of a network's component refined in one compiled call, by inverse iteration."""

from math import cos, sqrt
from typing import Any

import numpy as np

from cabledrive.mechanics.compiled import njit_strict, njit_strict_in_place
from cabledrive.modal.network.band_kernels import (
    RATE,
    STIFFNESS,
    SparseRows,
    assemble,
    for_lapack,
    forms,
    negative_pivots,
    placed,
    times,
)

STEPS = 14
CONVERGED = 1e-13
SETTLED = 1e-15
STAY = 1e-12
_ASIDE = 1e-13


@njit_strict
def counted(rows: SparseRows, omega: float, imaginary: Any, coordinates: int, kind: Any) -> tuple[int, float]:
    """Modes below a frequency and the growth of `negative_pivots`, in one call.

    ``coordinates``: n; ``kind``: an empty array of the band's numbers.
    """
    position, cuts = np.empty(coordinates, np.int64), np.empty(rows.time.size, np.int64)
    size, width, inside = placed(rows, omega, position, cuts)
    band = np.empty((size, width + 1), kind.dtype)
    assemble(rows, omega, omega, STIFFNESS, imaginary, position, cuts, band)
    negative, growth = negative_pivots(band)
    return negative + inside, growth


@njit_strict
def general_stiffness(
    rows: SparseRows, omega: float, cut_at: float, imaginary: Any, position: Any, cuts: Any, out: Any
) -> None:
    """The stiffness in LAPACK's storage of `for_lapack`, in one call."""
    band = np.empty((out.shape[1], (out.shape[0] - 1) // 3 + 1), out.dtype)
    assemble(rows, omega, cut_at, STIFFNESS, imaginary, position, cuts, band)
    for_lapack(band, out)


@njit_strict
def rate_times(
    rows: SparseRows,
    omega: float,
    cut_at: float,
    imaginary: Any,
    position: Any,
    cuts: Any,
    width: int,
    x: Any,
    out: Any,
) -> None:
    """Rate times columns, shape (size, k), in one call."""
    band = np.empty((out.shape[0], width + 1), out.dtype)
    assemble(rows, omega, cut_at, RATE, imaginary, position, cuts, band)
    times(band, x, out)


@njit_strict_in_place
def solved(matrix: Any, width: int, x: Any) -> None:
    """Solve a band in LAPACK's storage for one column, with partial pivoting; largest entry 1.

    A pivot that round-off has made zero is set aside by round-off of the whole.
    """
    n, last = matrix.shape[1], 0
    middle = 2 * width
    largest = 0.0
    for j in range(n):
        largest = max(largest, abs(matrix[middle, j]))
    for j in range(n):
        below = min(width, n - 1 - j)
        pivot = 0
        for i in range(1, below + 1):
            if abs(matrix[middle + i, j]) > abs(matrix[middle + pivot, j]):
                pivot = i
        last = max(last, min(j + width + pivot, n - 1))
        if pivot > 0:
            for c in range(j, last + 1):
                kept = matrix[middle + j - c, c]
                matrix[middle + j - c, c] = matrix[middle + j + pivot - c, c]
                matrix[middle + j + pivot - c, c] = kept
            kept = x[j, 0]
            x[j, 0] = x[j + pivot, 0]
            x[j + pivot, 0] = kept
        if matrix[middle, j] == 0.0:
            matrix[middle, j] = _ASIDE * largest
        for i in range(1, below + 1):
            factor = matrix[middle + i, j] / matrix[middle, j]
            if factor != 0.0:
                for c in range(j + 1, last + 1):
                    matrix[middle + j + i - c, c] -= factor * matrix[middle + j - c, c]
                x[j + i, 0] -= factor * x[j, 0]
    top = 0.0
    for j in range(n - 1, -1, -1):
        for c in range(j + 1, min(j + middle, n - 1) + 1):
            x[j, 0] -= matrix[middle + j - c, c] * x[c, 0]
        x[j, 0] /= matrix[middle, j]
        top = max(top, abs(x[j, 0]))
    for j in range(n):
        x[j, 0] /= top


@njit_strict
def refined_one(
    rows: SparseRows,
    start: float,
    low: float,
    high: float,
    imaginary: Any,
    position: Any,
    cuts: Any,
    kind: Any,
) -> Any:
    """One mode between two frequencies by the steps of `ComponentStructure.refined`.

    ``position``, ``cuts``: written, as by `placed` at the start; ``kind``: an empty array of the band's type.
    Returns whether it was found, its frequency [rad/s], its shape of unit modal mass, shape (size, 1), and
    the size, half bandwidth and hidden modes of the band.
    """
    size, width, inside = placed(rows, start, position, cuts)
    x, load = np.empty((size, 1), kind.dtype), np.empty((size, 1), kind.dtype)
    energy, rate = np.empty((1, 1), kind.dtype), np.empty((1, 1), kind.dtype)
    matrix = np.empty((3 * width + 1, size), kind.dtype)
    for i in range(size):
        x[i, 0] = cos((i + 1) * (1.0 + sqrt(2.0)))
    general_stiffness(rows, start, start, imaginary, position, cuts, matrix)
    solved(matrix, width, x)
    omega, fresh = start, True
    for _ in range(STEPS):
        if fresh:
            rate_times(rows, omega, start, imaginary, position, cuts, width, x, load)
            x[:] = load
            general_stiffness(rows, omega, start, imaginary, position, cuts, matrix)
            solved(matrix, width, x)
        forms(rows, omega, start, imaginary, position, cuts, x, energy, rate)
        shift = (energy[0, 0] / rate[0, 0]).real
        x *= sqrt(2.0 / rate[0, 0].real)
        if not low - STAY * high <= omega + shift <= high + STAY * high:
            return False, omega, x, size, width, inside
        if abs(shift) <= CONVERGED * omega:
            return True, omega + shift, x, size, width, inside
        omega += shift
        fresh = shift**2 > SETTLED * omega * min(omega - low, high - omega)  # other modes lie beyond
    return False, omega, x, size, width, inside
