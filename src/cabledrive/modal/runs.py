r"""Long runs of unknowns, each tied to two others alone, as carriages along a rope are.

Every second unknown of a run is eliminated at a time, all of them at once, until a few are left: of one with
pivot d and ties :math:`e_l, e_r` its neighbours lose :math:`e_l^2/d` and :math:`e_r^2/d`, and are tied to
each other by :math:`-e_l e_r/d`. Negative pivots, and negative eigenvalues of what is left, are together
those of the whole matrix (Sylvester).
"""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.intp]

LEAST = 24
"""Unknowns of a run from which on it is worth the calls."""
MOST_LEFT = 48
"""Unknowns that may be left: they are a matrix of their own for each frequency."""


class Run(NamedTuple):
    """Unknowns in order, their ties by column and distance in the band, how often every second one goes.

    ``left``: numbers of both ends and, between them, of those that stay, among all that are left.
    """

    inner: Integers
    column: Integers
    distance: Integers
    levels: int
    left: Integers


class Runs(NamedTuple):
    """All runs of a band, what is left, and other ties of this: its two numbers, column, distance."""

    runs: tuple[Run, ...]
    kept: Integers
    ties: tuple[Integers, Integers, Integers, Integers]


class Left(NamedTuple):
    """What is left, shape (lanes, k, k), negative pivots, and how terms outgrow the matrix.

    ``load``: right sides that are left; ``steps``: of each run and level, shares of both neighbours and right
    sides over pivots.
    """

    matrix: Array
    negative: Integers
    growth: Array
    load: Array | None
    steps: list[list[tuple[Array, Array, Array]]]


def runs_of(upper: Integers, lower: Integers, size: int) -> Runs | None:
    """The long runs of a matrix with ties between these pairs of unknowns; None where it has none."""
    both = np.concatenate((upper, lower))
    ties = np.bincount(both, minlength=size)
    if np.count_nonzero(ties == 2) < LEAST:
        return None
    near = np.concatenate((lower, upper))[np.argsort(both, kind="stable")].tolist()
    first, free = [0, *np.cumsum(ties).tolist()], (ties == 2).tolist()
    free[0] = False  # a ring has an end somewhere
    found, seen, stay = list[tuple[Integers, int]](), set[int](), np.ones(size, dtype=bool)
    for start in (c for c in range(size) if not free[c]):
        for c in near[first[start] : first[start + 1]]:
            run = [start, c]
            while free[run[-1]] and run[-1] not in seen:
                a, b = near[first[run[-1]] : first[run[-1]] + 2]
                run.append(b if a == run[-2] else a)
            if (inner := len(run) - 2) >= LEAST:
                seen.update(run[1:-1])
                found.append((np.array(run), inner.bit_length() - 2))
                stay[run[1:-1]] = False
    inside = ~stay
    for path, levels in found:
        stay[path[1:-1][2**levels - 1 :: 2**levels]] = True
    kept, place = np.flatnonzero(stay), np.cumsum(stay) - 1
    if not found or kept.size > MOST_LEFT:
        return None
    runs = []
    for path, levels in found:
        column = np.minimum(path[:-1], path[1:])
        left = place[path[np.concatenate(([True], stay[path[1:-1]], [True]))]]
        runs.append(Run(path[1:-1], column, np.abs(np.diff(path)), levels, left))
    direct = ~(inside[upper] | inside[lower])
    i, j = upper[direct], lower[direct]
    return Runs(tuple(runs), kept, (place[i], place[j], j, i - j))


def eliminated(own: Runs, band: Array, x: Array | None = None) -> Left:
    """The runs of bands, shape (size, width + 1, lanes), and of right sides (size, lanes, k), eliminated."""
    lanes, k = band.shape[2], np.arange(own.kept.size)
    matrix = np.zeros((k.size, k.size, lanes), band.dtype)
    matrix[k, k] = band[own.kept, 0]
    p, q, column, distance = own.ties
    matrix[p, q] = matrix[q, p] = band[column, distance]
    negative, terms, load = np.zeros(lanes, np.intp), np.zeros(lanes, band.dtype), None
    if x is not None:
        load = x[own.kept]
    steps: list[list[tuple[Array, Array, Array]]] = [[] for _ in own.runs]
    for run, gone in zip(own.runs, steps, strict=True):
        d, e, near, far = band[run.inner, 0], band[run.column, run.distance], run.left[0], run.left[-1]
        b = d if x is None else x[run.inner]
        for _ in range(run.levels):
            pivot, left, right = d[::2], e[:-1:2], e[1::2]
            r, s = left / pivot, right / pivot
            before, behind = left * r, right * s
            negative += np.count_nonzero(pivot < 0.0, axis=0)
            for own_terms in (before, behind):
                np.maximum(terms, np.abs(own_terms).max(axis=0), out=terms)
            # of an even number the last tie stays
            e = np.concatenate((-left * s, e[2 * pivot.shape[0] :]))
            d = _without(d, before, behind, matrix[near, near], matrix[far, far])
            if load is not None:
                here, r, s = b[::2], r[..., None], s[..., None]
                gone.append((r, s, here / pivot[..., None]))
                b = _without(b, r * here, s * here, load[near], load[far])
        matrix[run.left[1:-1], run.left[1:-1]] = d
        if load is not None:
            load[run.left[1:-1]] = b
        for tie, (i, j) in zip(e, pairwise(run.left), strict=True):
            matrix[i, j] += tie
            matrix[j, i] += tie
    growth = terms / np.abs(band[:, 0]).max(axis=0)
    return Left(np.ascontiguousarray(matrix.transpose(2, 0, 1)), negative, growth, load, steps)


def _without(d: Array, before: Array, behind: Array, near: Array, far: Array) -> Array:
    """Values of a run without every second one, less what these take from both sides; the ends change."""
    half, odd = divmod(d.shape[0], 2)
    near -= before[0]
    if odd:
        far -= behind[-1]
    d = d[1::2] - behind[:half]
    d[: half + odd - 1] -= before[1:]
    return d


def solved_runs(own: Runs, left: Left, size: int) -> Array:
    """Solutions, shape (size, lanes, k), for the right sides that `eliminated` was given."""
    assert left.load is not None
    rest = solved_whole(left.matrix, left.load)
    out = np.empty((size, *rest.shape[1:]))
    out[own.kept] = rest
    for run, steps in zip(own.runs, left.steps, strict=True):
        path = rest[run.left]
        for r, s, half in steps[::-1]:
            m = half.shape[0]
            whole = np.empty((m + path.shape[0], *half.shape[1:]))
            whole[: 2 * m + 1 : 2], whole[-1] = path[: m + 1], path[-1]
            whole[1 : 2 * m : 2] = half - r * path[:m] - s * path[1 : m + 1]
            path = whole
        out[run.inner] = path[1:-1]
    return out


def solved_whole(full: NDArray[Any], x: NDArray[Any]) -> NDArray[Any]:
    """Solutions of whole matrices, shape (lanes, n, n), for columns, shape (n, lanes, k)."""
    diagonal, n = np.abs(np.einsum("lii->li", full)).max(axis=1), np.arange(full.shape[1])
    for share in (1e-15, 1e-14, 1e-13):  # a root itself is left by as little as will do
        try:
            return np.linalg.solve(full, x.transpose(1, 0, 2)).transpose(1, 0, 2)
        except np.linalg.LinAlgError:
            full[:, n, n] += np.where(diagonal > 0.0, share * diagonal, 1.0)[:, None]
    return np.linalg.solve(full, x.transpose(1, 0, 2)).transpose(1, 0, 2)
