"""Compiled loops of a network's exact stiffness: assembled in a narrow band, factorised and counted.

Coordinates are scaled to energies and stand in an order that keeps the ends of a rope close together.
A cut of a long link (`cabledrive.modal.network.stiffness`) stands behind the first coordinate that its
link moves. Bands are stored by rows: column d of row i holds the entry (i, i - d).
"""

from math import floor, pi, tan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.compiled import njit_strict, njit_strict_in_place

LONG = 2.0
STIFFNESS, RATE = 0, 1
"""What is assembled: the stiffness, or minus its derivative by the frequency."""


class SparseRows(NamedTuple):
    """A component as the loops read it, in the band's order, scaled.

    Attributes
    ----------
    time, lag, impedance, cut_scale : ndarray, shape (m,)
        Of the links; the scale of a cut's coordinate.
    start_from, start_at, start_by : ndarray, shapes (m + 1,), (k,), (k,)
        Where the entries of each link's start begin, their coordinates and values.
    end_from, end_at, end_by : ndarray
        Of the ends.
    first : ndarray of int, shape (m,)
        First coordinate of each link.
    fixed_row, fixed_column, mass, spring : ndarray, shape (f,)
        Entries, row not before column, of masses and of springs with geometric stiffness.
    """

    time: NDArray[np.float64]
    lag: NDArray[np.float64]
    impedance: NDArray[np.float64]
    cut_scale: NDArray[np.float64]
    start_from: NDArray[np.int64]
    start_at: NDArray[np.int64]
    start_by: NDArray[np.float64]
    end_from: NDArray[np.int64]
    end_at: NDArray[np.int64]
    end_by: NDArray[np.float64]
    first: NDArray[np.int64]
    fixed_row: NDArray[np.int64]
    fixed_column: NDArray[np.int64]
    mass: NDArray[np.float64]
    spring: NDArray[np.float64]


@njit_strict
def placed(rows: SparseRows, omega: float, position: Any, cuts: Any) -> tuple[int, int, int]:
    """Places of coordinates and cuts in the band at a frequency.

    ``position``, shape (n,), and ``cuts``, shape (m,), are written; -1: not cut.
    Returns the size, the half bandwidth, and the modes that the parts of cut links hide.
    """
    n, inside = position.size, 0
    behind = np.zeros(n + 1, dtype=np.int64)
    for link in range(rows.time.size):
        cuts[link] = -1
        phase = omega * rows.time[link]
        if phase > LONG:
            cuts[link] = behind[rows.first[link]]
            behind[rows.first[link]] += 1
            inside += int(floor(phase / pi + 0.5) - 1.0)
    shift = 0
    for i in range(n):
        position[i] = i + shift
        shift += behind[i]
    width = 0
    for k in range(rows.fixed_row.size):
        width = max(width, position[rows.fixed_row[k]] - position[rows.fixed_column[k]])
    for link in range(rows.time.size):
        low, high = n + shift, 0
        if cuts[link] >= 0:
            cuts[link] += position[rows.first[link]] + 1
            low = high = cuts[link]
        for k in range(rows.start_from[link], rows.start_from[link + 1]):
            low, high = min(low, position[rows.start_at[k]]), max(high, position[rows.start_at[k]])
        for k in range(rows.end_from[link], rows.end_from[link + 1]):
            low, high = min(low, position[rows.end_at[k]]), max(high, position[rows.end_at[k]])
        width = max(width, high - low)
    return n + shift, width, inside


@njit_strict_in_place
def _first_share(phase: float) -> float:
    """Share of the first part of a cut link: neither part is then near a pole."""
    half_turns = floor(phase / pi + 0.5)
    return float(((floor((half_turns - 1) / 2) + 0.5) * pi + (phase - half_turns * pi) / 2) / phase)


@njit_strict_in_place
def _entries(rows: SparseRows, link: int, number: int, far: bool, cuts: Any) -> int:
    """How many entries one end of a part has; ``number``: of the part, 1 behind a cut."""
    if number != (far and cuts[link] >= 0):
        return 1  # the cut alone
    return int(
        rows.end_from[link + 1] - rows.end_from[link]
        if far
        else rows.start_from[link + 1] - rows.start_from[link]
    )


@njit_strict_in_place
def _entry(
    rows: SparseRows, link: int, number: int, far: bool, k: int, position: Any, cuts: Any
) -> tuple[int, float]:
    """Place in the band and value of entry k of one end of a part."""
    if number != (far and cuts[link] >= 0):
        return cuts[link], rows.cut_scale[link]
    if far:
        k += rows.end_from[link]
        return position[rows.end_at[k]], rows.end_by[k]
    k += rows.start_from[link]
    return position[rows.start_at[k]], rows.start_by[k]


@njit_strict_in_place
def _moved(
    rows: SparseRows, link: int, number: int, far: bool, position: Any, cuts: Any, x: Any, column: int
) -> Any:
    """Displacement of one end of a part, for a column of x in the order of the band."""
    moved = 0.0 * x[0, column]
    for k in range(_entries(rows, link, number, far, cuts)):
        place, value = _entry(rows, link, number, far, k, position, cuts)
        moved += value * x[place, column]
    return moved


@njit_strict_in_place
def assemble(
    rows: SparseRows,
    omega: float,
    cut_at: float,
    what: int,
    imaginary: Any,
    position: Any,
    cuts: Any,
    band: Any,
) -> None:
    """Write the stiffness of `stiffness.assembled`, or its rate, into a band, shape (size, width + 1).

    ``cut_at``: frequency at which the cuts were placed; ``imaginary``: 1j where a rope runs, else 0.0, so
    that all numbers stay real.
    """
    band[:] = 0.0
    for link in range(rows.time.size):
        cut = cuts[link] >= 0
        share = _first_share(cut_at * rows.time[link]) if cut else 1.0
        for number in range(2 if cut else 1):
            part = share if number == 0 else 1.0 - share
            near = _entries(rows, link, number, False, cuts)
            both = near + _entries(rows, link, number, True, cuts)
            z, own_time, delay = rows.impedance[link], part * rows.time[link], part * rows.lag[link]
            t = tan(0.5 * omega * own_time)
            stiff = z * (t + 1.0 / t) / 2
            by_link, by_edge = stiff, -z * t
            if what == RATE:
                by_link, by_edge = stiff * own_time * (1.0 / t - t) / 2, z * own_time * (1.0 + t**2) / 2
            turn = np.exp(imaginary * (omega * delay))
            # link |turn a - b|^2 + edge (|a|^2 + |b|^2), and of the rate what the turning of a adds
            mixed = imaginary * (stiff * delay * what) * turn - by_link * turn
            for i in range(both):
                i_far = i >= near
                row, i_by = _entry(rows, link, number, i_far, i - near * i_far, position, cuts)
                for j in range(both):
                    j_far = j >= near
                    column, j_by = _entry(rows, link, number, j_far, j - near * j_far, position, cuts)
                    d = row - column
                    if d >= 0:
                        product = i_by * j_by
                        if i_far == j_far:
                            band[row, d] += (by_link + by_edge) * product
                        elif i_far:
                            band[row, d] += mixed * product
                        else:
                            band[row, d] += np.conj(mixed) * product
    for k in range(rows.fixed_row.size):
        i, j = position[rows.fixed_row[k]], position[rows.fixed_column[k]]
        if what == STIFFNESS:
            band[i, i - j] += rows.spring[k] / omega - omega * rows.mass[k]
        else:
            band[i, i - j] += rows.spring[k] / omega**2 + rows.mass[k]


@njit_strict
def negative_pivots(band: Any) -> tuple[int, float]:
    """Number of negative pivots of LDL^H, and how its terms outgrow the matrix; the band is lost."""
    size, width = band.shape[0], band.shape[1] - 1
    top = 0.0
    for i in range(size):
        top = max(top, abs(band[i, 0]))
    terms = np.zeros(size)
    count, growth = 0, 0.0
    for k in range(size):
        pivot = band[k, 0].real
        if pivot == 0.0:
            return count, np.inf
        count += pivot < 0.0
        for i in range(k + 1, min(k + width, size - 1) + 1):
            factor = band[i, i - k] / pivot
            if factor != 0.0:
                terms[i] += abs(factor) ** 2 * abs(pivot)
                growth = max(growth, terms[i])
                for j in range(k + 1, i + 1):
                    band[i, i - j] -= factor * np.conj(band[j, j - k])
    return count, growth / top


@njit_strict_in_place
def for_lapack(band: Any, out: Any) -> None:
    """Spread a Hermitian band into LAPACK's storage for a general one, shape (3 width + 1, size)."""
    size, width = band.shape[0], band.shape[1] - 1
    out[:] = 0.0
    for i in range(size):
        for d in range(min(width, i) + 1):
            out[2 * width + d, i - d] = band[i, d]
            out[2 * width - d, i] = np.conj(band[i, d])


@njit_strict_in_place
def times(band: Any, x: Any, out: Any) -> None:
    """Product of a Hermitian band with columns, shape (size, k)."""
    size, width = band.shape[0], band.shape[1] - 1
    out[:] = 0.0
    for i in range(size):
        for d in range(min(width, i) + 1):
            for c in range(x.shape[1]):
                out[i, c] += band[i, d] * x[i - d, c]
                if d > 0:
                    out[i - d, c] += np.conj(band[i, d]) * x[i, c]


@njit_strict_in_place
def forms(
    rows: SparseRows,
    omega: float,
    cut_at: float,
    imaginary: Any,
    position: Any,
    cuts: Any,
    x: Any,
    energy: Any,
    rate: Any,
) -> None:
    """Quadratic forms of stiffness and rate for the columns of x, shape (k, k), without cancellation."""
    energy[:] = 0.0
    rate[:] = 0.0
    columns = x.shape[1]
    for link in range(rows.time.size):
        cut = cuts[link] >= 0
        share = _first_share(cut_at * rows.time[link]) if cut else 1.0
        for number in range(2 if cut else 1):
            part = share if number == 0 else 1.0 - share
            z, own_time, delay = rows.impedance[link], part * rows.time[link], part * rows.lag[link]
            t = tan(0.5 * omega * own_time)
            stiff = z * (t + 1.0 / t) / 2
            stiff_rate = stiff * own_time * (1.0 / t - t) / 2
            edge, edge_rate = -z * t, z * own_time * (1.0 + t**2) / 2
            turn = np.exp(imaginary * (omega * delay))
            for p in range(columns):
                a_p = _moved(rows, link, number, False, position, cuts, x, p)
                b_p = _moved(rows, link, number, True, position, cuts, x, p)
                for q in range(columns):
                    a_q = _moved(rows, link, number, False, position, cuts, x, q)
                    b_q = _moved(rows, link, number, True, position, cuts, x, q)
                    stretch = np.conj(turn * a_p - b_p) * (turn * a_q - b_q)
                    ends = np.conj(a_p) * a_q + np.conj(b_p) * b_q
                    mixed = np.conj(b_p) * (imaginary * turn * a_q)
                    mixed = mixed + np.conj(np.conj(b_q) * (imaginary * turn * a_p))
                    energy[p, q] += stiff * stretch + edge * ends
                    rate[p, q] += stiff_rate * stretch + edge_rate * ends + stiff * delay * mixed
    for k in range(rows.fixed_row.size):
        i, j = position[rows.fixed_row[k]], position[rows.fixed_column[k]]
        stiff, stiff_rate = (
            rows.spring[k] / omega - omega * rows.mass[k],
            rows.spring[k] / omega**2 + rows.mass[k],
        )
        for p in range(columns):
            for q in range(columns):
                both = np.conj(x[i, p]) * x[j, q]
                if i != j:
                    both = both + np.conj(x[j, p]) * x[i, q]
                energy[p, q] += stiff * both
                rate[p, q] += stiff_rate * both
