"""The Kalman filter's covariance recursion, compiled."""

import numpy as np

from cabledrive.mechanics.compiled import njit
from cabledrive.parameters.arrays import Array


@njit
def _product(one: Array, other: Array, into: Array) -> None:
    for i in range(one.shape[0]):
        for j in range(other.shape[1]):
            total = 0.0
            for k in range(other.shape[0]):
                total += one[i, k] * other[k, j]
            into[i, j] = total


@njit
def _product_of_transposed(one: Array, other: Array, into: Array) -> None:
    """One times the transposed other."""
    for i in range(one.shape[0]):
        for j in range(other.shape[0]):
            total = 0.0
            for k in range(other.shape[1]):
                total += one[i, k] * other[j, k]
            into[i, j] = total


@njit
def _solve_positive(matrix: Array, sides: Array) -> None:
    """Solve by elimination; a covariance needs no pivot. ``sides``, shape (m, n), becomes the answer."""
    m, n = sides.shape
    for i in range(m):
        for row in range(i + 1, m):
            factor = matrix[row, i] / matrix[i, i]
            for j in range(i, m):
                matrix[row, j] -= factor * matrix[i, j]
            for j in range(n):
                sides[row, j] -= factor * sides[i, j]
    for i in range(m - 1, -1, -1):
        for j in range(n):
            for row in range(i + 1, m):
                sides[i, j] -= matrix[i, row] * sides[row, j]
            sides[i, j] /= matrix[i, i]


@njit
def gain_schedule(
    transition: Array,
    noise: Array,
    output: Array,
    reading: Array,
    start: Array,
    gains: Array,
    settled: float,
) -> int:
    """Covariance recursion in Joseph's form; writes each sample's gain, returns the number of the last.

    Products by `_product`: those of numba's own call a library and take five times as long to compile.
    """
    n, m = output.shape[1], output.shape[0]
    covariance, seen, spread, gain = start.copy(), np.zeros((m, n)), np.zeros((m, m)), np.zeros((m, n))
    kept, part, other = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    for k in range(gains.shape[0]):
        _product(output, covariance, seen)
        for i in range(m):
            for j in range(m):
                spread[i, j] = reading[i, j]
                for a in range(n):
                    spread[i, j] += seen[i, a] * output[j, a]
            for a in range(n):
                gain[i, a] = seen[i, a]
        _solve_positive(spread, gain)
        largest, change = 0.0, 0.0
        for a in range(n):
            for i in range(m):
                gains[k, a, i] = gain[i, a]
                largest = max(largest, abs(gain[i, a]))
                if k > 100:
                    change = max(change, abs(gain[i, a] - gains[k - 100, a, i]))
            for b in range(n):
                kept[a, b] = 1.0 if a == b else 0.0
                for i in range(m):
                    kept[a, b] -= gain[i, a] * output[i, b]
        _product(kept, covariance, part)
        _product_of_transposed(part, kept, other)
        for a in range(n):
            for b in range(n):
                for i in range(m):
                    for j in range(m):
                        other[a, b] += gain[i, a] * reading[i, j] * gain[j, b]
        _product(transition, other, part)
        _product_of_transposed(part, transition, covariance)
        for a in range(n):
            for b in range(n):
                covariance[a, b] += noise[a, b]
        if k > 100 and change <= settled * largest:
            return k
    return gains.shape[0] - 1
