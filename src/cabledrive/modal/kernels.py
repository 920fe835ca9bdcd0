"""Count and refine the modes of a large table of rows, compiled: what `rows` and `search` do for lanes."""

from collections.abc import Callable
from math import floor, pi, tan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.compiled import njit_strict
from cabledrive.modal.rows import (
    CONVERGED,
    GROWTH,
    MASS,
    SPRING,
    STAY,
    STEPS,
    Array,
    Lanes,
    Table,
    bands,
    counted,
    dense,
    negative_values,
    weights,
)


@njit_strict
def _weights(t, omega, placed, w, rate, late):  # type: ignore[no-untyped-def]
    """Weights of all rows, if asked minus their derivatives, phases of running ropes [s]; hidden modes."""
    inside = 0.0
    for i in range(t.z.size):
        own = t.time[i]
        if t.part[i] > 0:
            phase = placed * own / np.sqrt(1.0 + (t.ring[i] / placed) ** 2)
            half = max(1.0, floor(phase / pi + 0.5))
            share = ((floor((half - 1.0) / 2.0) + 0.5) * pi + 0.5 * (phase - half * pi)) / phase
            if t.part[i] == 1:
                own, inside = own * share, inside + half - 1.0
            else:
                own = own * (1.0 - share)
        late[3 * i] = t.lag[i] * own / t.time[i]
        curved = (t.ring[i] / omega) ** 2
        slow = np.sqrt(1.0 + curved)
        z, own, turned = t.z[i] * slow, own / slow, curved / (1.0 + curved)
        time, x = own * (1.0 + turned), tan(0.5 * omega * own)
        stretch, end = 0.5 * z * (x + 1.0 / x), -z * x
        w[3 * i] = stretch
        w[3 * i + 1] = w[3 * i + 2] = end
        if rate is not None:
            rate[3 * i] = 0.5 * stretch * time * (1.0 / x - x) + stretch * turned / omega
            rate[3 * i + 1] = rate[3 * i + 2] = 0.5 * z * time * (1.0 + x * x) + end * turned / omega
    base, square = 3 * t.z.size, omega**2
    for k in range(t.kind.size):
        a, r = t.a[k], base + k
        if t.kind[k] == MASS:
            w[r], fall = -omega * a, a
        elif t.kind[k] == SPRING:
            w[r], fall = a / omega, a / square
        else:
            b = t.b[k] ** 2
            ratio = a * square / (b - square)
            w[r], fall = -omega * ratio, ratio * (3.0 * b - square) / (b - square)
        if rate is not None:
            rate[r] = fall
    return inside


@njit_strict
def _assembled(t, omega, w, late, one, flat):  # type: ignore[no-untyped-def]
    """The band of the weighted squares, lower half by columns."""
    flat[:] = 0.0
    for p in range(t.pair_slot.size):
        r = t.pair_row[p]
        term = t.pair_value[p] * w[r] * one[0]
        if t.pair_delay[p] != 0.0:
            term = term * np.exp(one[1] * (omega * late[r] * t.pair_delay[p]))
        flat[t.pair_slot[p]] += term


@njit_strict
def _negative_pivots(band, terms):  # type: ignore[no-untyped-def]
    """Negative pivots of LDL^H, and how its terms outgrow the matrix; the band is lost."""
    size, width = band.shape[0], band.shape[1] - 1
    top = 0.0
    for i in range(size):
        top = max(top, abs(band[i, 0]))
        terms[i] = 0.0
    count, growth = 0, 0.0
    for k in range(size):
        pivot = band[k, 0].real
        if pivot == 0.0:
            return count, np.inf
        count += pivot < 0.0
        m = min(width, size - 1 - k)
        for j in range(m):
            lower = band[k, j + 1]
            if lower == 0.0:
                continue
            terms[k + 1 + j] += abs(lower) ** 2 / abs(pivot)
            growth = max(growth, terms[k + 1 + j])
            across = np.conj(lower) / pivot
            for i in range(j, m):
                band[k + 1 + j, i - j] -= band[k, i + 1] * across
    return count, growth / top


@njit_strict
def counts(t, omega, backward, one, found, growth):  # type: ignore[no-untyped-def]
    """Modes below each frequency, and the growth of the elimination, from either end."""
    rows = t.first.size - 1
    w, late, terms = np.empty(rows), np.zeros(rows), np.empty(t.size)
    band = np.empty((t.size, t.width + 1), one.dtype)
    order = np.empty((t.size, t.width + 1), one.dtype)
    flat = band.reshape(-1)
    for lane in range(omega.size):
        hidden = _weights(t, omega[lane], omega[lane], w, None, late)
        _assembled(t, omega[lane], w, late, one, flat)
        if backward:
            order[:, :] = 0.0
            for j in range(t.size):
                for d in range(min(t.width, t.size - 1 - j) + 1):
                    order[t.size - 1 - j - d, d] = np.conj(band[j, d])
            count, growth[lane] = _negative_pivots(order, terms)
        else:
            count, growth[lane] = _negative_pivots(band, terms)
        found[lane] = count + hidden


@njit_strict
def _factored(band, a, swap):  # type: ignore[no-untyped-def]
    """LU of a symmetric band by partial pivoting, entry (i, j) in ``a[i, j - i + width]``; none is zero."""
    n, width = band.shape[0], band.shape[1] - 1
    a[:, :] = 0.0
    largest = 0.0
    for j in range(n):
        largest = max(largest, abs(band[j, 0]))
        a[j, width] = band[j, 0]
        for d in range(1, min(width, n - 1 - j) + 1):
            a[j + d, width - d] = a[j, width + d] = band[j, d]
    for k in range(n):
        last, best = min(n - 1, k + width), k
        for i in range(k + 1, last + 1):
            if abs(a[i, k - i + width]) > abs(a[best, k - best + width]):
                best = i
        swap[k], right = best, min(n - 1, k + 2 * width)
        if best != k:
            for j in range(k, right + 1):
                a[k, j - k + width], a[best, j - best + width] = (
                    a[best, j - best + width],
                    a[k, j - k + width],
                )
        if a[k, width] == 0.0:
            a[k, width] = 1e-16 * largest
        for i in range(k + 1, last + 1):
            factor = a[i, k - i + width] / a[k, width]
            a[i, k - i + width] = factor
            if factor != 0.0:
                for j in range(k + 1, right + 1):
                    a[i, j - i + width] -= factor * a[k, j - k + width]


@njit_strict
def _solved(a, swap, x):  # type: ignore[no-untyped-def]
    """Solve in place by a factored band; scaled to a largest entry of 1."""
    n, width = a.shape[0], a.shape[1] // 3
    for k in range(n):
        best = swap[k]
        x[k], x[best] = x[best], x[k]
        for i in range(k + 1, min(n - 1, k + width) + 1):
            x[i] -= a[i, k - i + width] * x[k]
    largest = 0.0
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, min(n - 1, k + 2 * width) + 1):
            x[k] -= a[k, j - k + width] * x[j]
        x[k] /= a[k, width]
        largest = max(largest, abs(x[k]))
    for k in range(n):
        x[k] /= largest


@njit_strict
def _moved(t, x, y):  # type: ignore[no-untyped-def]
    """Motion of every row in a shape."""
    for r in range(y.size):
        y[r] = 0.0
        for e in range(t.first[r], t.first[r + 1]):
            y[r] += t.value[e] * x[t.column[e]]


@njit_strict
def _loaded(t, rate, y, out):  # type: ignore[no-untyped-def]
    """Minus the derivative of the stiffness times a shape, by the motion of the rows."""
    out[:] = 0.0
    for r in range(y.size):
        load = rate[r] * y[r]
        for e in range(t.first[r], t.first[r + 1]):
            out[t.column[e]] += t.value[e] * load


@njit_strict
def refine_singles(t, low, high, one, good, found, shapes):  # type: ignore[no-untyped-def]
    """Inverse iteration on the one mode of every bracket; ``shapes``, shape (brackets, size)."""
    rows, n = t.first.size - 1, t.size
    w, rate, late, y = np.empty(rows), np.empty(rows), np.zeros(rows), np.empty(rows)
    band, a = np.empty((n, t.width + 1)), np.empty((n, 3 * t.width + 1))
    flat, swap = band.reshape(-1), np.empty(n, np.intp)
    for lane in range(low.size):
        start = omega = 0.5 * (low[lane] + high[lane])
        x, before = shapes[lane], np.inf
        for i in range(n):
            x[i] = np.cos((i + 1.0) * (1.0 + np.sqrt(2.0)))
        _weights(t, omega, start, w, rate, late)
        _assembled(t, omega, w, late, one, flat)
        _factored(band, a, swap)
        _solved(a, swap, x)
        _moved(t, x, y)
        for _ in range(STEPS):
            _loaded(t, rate, y, x)
            _solved(a, swap, x)
            _moved(t, x, y)
            energy, fall = 0.0, 0.0
            for r in range(rows):
                energy += w[r] * y[r] ** 2
                fall += rate[r] * y[r] ** 2
            if not (fall > 0.0 and np.isfinite(energy)):
                break
            x *= np.sqrt(2.0 / fall)
            y *= np.sqrt(2.0 / fall)
            shift, slack = energy / fall, STAY * high[lane]
            if not low[lane] - slack <= omega + shift <= high[lane] + slack:
                break
            still = abs(shift) <= 1e-11 * omega and abs(shift) >= 0.5 * before
            if still or abs(shift) <= CONVERGED * omega:
                good[lane], found[lane] = True, omega + shift
                break
            omega, before = omega + shift, abs(shift)
            _weights(t, omega, start, w, rate, late)
            _assembled(t, omega, w, late, one, flat)
            _factored(band, a, swap)


def compiled_singles(t: Table, low: Array, high: Array) -> tuple[NDArray[np.bool_], Array, Array]:
    """As `search.refined` for brackets of one mode each, of a table without running ropes."""
    good, found = np.zeros(low.size, dtype=bool), np.zeros(low.size)
    shapes = np.zeros((low.size, t.size))
    refine_singles(_bare(t), low, high, np.array([1.0, 0.0]), good, found, shapes)
    return good, found[:, None], shapes.T[:, :, None]


def _bare(t: Table) -> Any:
    """The table without what only lanes of numpy use."""
    return t._replace(kinds=(), rows=(), products=())


def compiled_counts(t: Table) -> Callable[[Lanes], Array]:
    """The counter of one table; where round-off clouds a count, from the other end, then by eigenvalues."""
    one: Any = np.array([1.0, 1j]) if t.running else np.array([1.0, 0.0])

    bare = _bare(t)

    def count(lanes: Lanes) -> Array:
        found, growth = np.empty(lanes.omega.size), np.empty(lanes.omega.size)
        counts(bare, lanes.omega, False, one, found, growth)
        bad = np.flatnonzero(~(growth <= GROWTH))
        if bad.size:
            again, grown = np.empty(bad.size), np.empty(bad.size)
            counts(bare, lanes.omega[bad], True, one, again, grown)
            found[bad] = again
            for lane in bad[~(grown <= GROWTH)]:
                found[lane] = _by_eigenvalues(t, lanes.take(slice(lane, lane + 1)))
        return found

    return count


def _by_eigenvalues(t: Table, lane: Lanes) -> float:
    """The count of one lane without an elimination."""
    if t.size > 1500:
        return float(counted(t, lane)[0])
    w, _, late, hidden = weights(t, lane)
    band = bands(t, lane.omega, w, late)
    return float(negative_values(dense(band)[0]) + hidden[0])
