"""Count the modes of a large table of rows, compiled: what `cabledrive.modal.rows` does for lanes."""

from collections.abc import Callable
from math import floor, pi, tan
from typing import Any

import numpy as np

from cabledrive.mechanics.compiled import njit_strict
from cabledrive.modal.rows import GROWTH, MASS, SPRING, Array, Lanes, Table, bands, counted, dense, weights


@njit_strict
def _weights(t, omega, w, late):  # type: ignore[no-untyped-def]
    """Weights of all rows, phases of running ropes [s]; returns hidden modes."""
    inside = 0.0
    for i in range(t.z.size):
        slow = np.sqrt(1.0 + (t.ring[i] / omega) ** 2)
        time, hidden = t.time[i] / slow, 0.0
        if t.part[i] > 0:
            phase = omega * time
            half = max(1.0, floor(phase / pi + 0.5))
            share = ((floor((half - 1.0) / 2.0) + 0.5) * pi + 0.5 * (phase - half * pi)) / phase
            if t.part[i] == 1:
                time, hidden = time * share, half - 1.0
            else:
                time = time * (1.0 - share)
        inside += hidden
        x = tan(0.5 * omega * time)
        w[3 * i] = 0.5 * t.z[i] * slow * (x + 1.0 / x)
        w[3 * i + 1] = w[3 * i + 2] = -t.z[i] * slow * x
        late[3 * i] = t.lag[i] * time / t.time[i]
    base = 3 * t.z.size
    for k in range(t.kind.size):
        if t.kind[k] == MASS:
            w[base + k] = -omega * t.a[k]
        elif t.kind[k] == SPRING:
            w[base + k] = t.a[k] / omega
        else:
            w[base + k] = -t.a[k] * omega**3 / (t.b[k] ** 2 - omega**2)
    return inside


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
        hidden = _weights(t, omega[lane], w, late)
        flat[:] = 0.0
        for p in range(t.pair_slot.size):
            r = t.pair_row[p]
            term = t.pair_value[p] * w[r] * one[0]
            if t.pair_delay[p] != 0.0:
                term = term * np.exp(one[1] * (omega[lane] * late[r] * t.pair_delay[p]))
            flat[t.pair_slot[p]] += term
        if backward:
            order[:, :] = 0.0
            for j in range(t.size):
                for d in range(min(t.width, t.size - 1 - j) + 1):
                    order[t.size - 1 - j - d, d] = np.conj(band[j, d])
            count, growth[lane] = _negative_pivots(order, terms)
        else:
            count, growth[lane] = _negative_pivots(band, terms)
        found[lane] = count + hidden


def compiled_counts(t: Table) -> Callable[[Lanes], Array]:
    """The counter of one table; where round-off clouds a count, from the other end, then by eigenvalues."""
    one: Any = np.array([1.0, 1j]) if t.running else np.array([1.0, 0.0])

    bare: Any = t._replace(kinds=(), rows=(), products=())

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
    return float(np.sum(np.linalg.eigvalsh(dense(band)[0]) < 0.0) + hidden[0])
