r"""The longest run of unknowns that are each tied to two others alone, as carriages along a rope are.

Every second one is eliminated at a time, all of them at once, until a few are left: of one with pivot d and
ties :math:`e_l, e_r` the neighbours lose :math:`e_l^2/d` and :math:`e_r^2/d`, and are tied to each other by
:math:`-e_l e_r/d`. Negative pivots, and negative eigenvalues of what is left, are together those of the whole
matrix (Sylvester).
"""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.intp]

LEAST, SHIFTS = 24, 3
"""Unknowns of a run from which on it is worth the calls; eliminations that are tried."""
MOST_LEFT = 48
"""Unknowns that may be left: they are a matrix of their own for each frequency."""


class Run(NamedTuple):
    """Unknowns in order, their ties by column and distance in the band, how often every second one goes.

    ``kept``: the unknowns that are left; ``path``: of these, by their numbers among them, both ends of the
    run and what is left between; ``ties``: other ties of what is left, its two numbers, column and distance.
    """

    inner: Integers
    column: Integers
    distance: Integers
    levels: int
    kept: Integers
    path: Integers
    ties: tuple[Integers, Integers, Integers, Integers]


Left = tuple[Array, Array, list[tuple[Array, Array, Array]]]
"""What is left, (lanes, k, k), right sides (k, lanes, m); shares of neighbours, right sides over pivots."""


def long_runs(upper: Integers, lower: Integers, size: int) -> tuple[Run, ...]:
    """The longest run of a matrix with ties between these pairs of unknowns; none where it is short.

    Three times, each begun an unknown later: a frequency at which one elimination grows is well with another.
    """
    both = np.concatenate((upper, lower))
    ties = np.bincount(both, minlength=size)
    near = np.concatenate((lower, upper))[np.argsort(both, kind="stable")].tolist()
    first, free = [0, *np.cumsum(ties).tolist()], (ties == 2).tolist()
    if all(free):  # a ring has an end somewhere
        free[:1] = [False]
    longest, seen = [0, 0], set[int]()
    for start in (c for c in range(size) if not free[c]):
        for c in near[first[start] : first[start + 1]]:
            run = [start, c]
            while free[run[-1]] and run[-1] not in seen:
                seen.add(run[-1])
                a, b = near[first[run[-1]] : first[run[-1]] + 2]
                run.append(b if a == run[-2] else a)
            longest = max(longest, run, key=len)
    if len(longest) < LEAST + SHIFTS + 2:
        return ()
    found = [_run(np.array(longest[k:]), upper, lower, size) for k in range(SHIFTS)]
    return tuple(found) if found[-1].kept.size <= MOST_LEFT else ()


def _run(path: Integers, upper: Integers, lower: Integers, size: int) -> Run:
    inner, levels = path[1:-1], (path.size - 2).bit_length() - 2
    beside = np.ones(size, dtype=bool)
    beside[inner] = False
    stay, direct = beside.copy(), beside[upper] & beside[lower]
    stay[inner[2**levels - 1 :: 2**levels]] = True
    place, i, j = np.cumsum(stay) - 1, upper[direct], lower[direct]
    left, kept, ties = place[path[stay[path]]], np.flatnonzero(stay), (place[i], place[j], j, i - j)
    return Run(inner, np.minimum(path[:-1], path[1:]), np.abs(np.diff(path)), levels, kept, left, ties)


def eliminated(run: Run, band: Array, x: Array | None = None) -> tuple[Left, Integers, Array]:
    """Eliminate the run of bands, shape (size, width + 1, lanes), and of right sides (size, lanes, m).

    Returns what is left, the negative pivots, and how terms outgrow the matrix.
    """
    lanes, k = band.shape[2], np.arange(run.kept.size)
    x = np.zeros((band.shape[0], lanes, 0)) if x is None else x
    matrix, (p, q, column, distance) = np.zeros((k.size, k.size, lanes), band.dtype), run.ties
    matrix[k, k] = band[run.kept, 0]
    matrix[p, q] = matrix[q, p] = band[column, distance]
    negative: Integers = np.zeros(lanes, np.intp)
    terms, load = np.zeros(lanes), x[run.kept]
    d, e, b, steps = band[run.inner, 0], band[run.column, run.distance], x[run.inner], []
    near, far = run.path[0], run.path[-1]
    for _ in range(run.levels):
        pivot, left, right, here = d[::2], e[:-1:2], e[1::2], b[::2]
        r, s = left / pivot, right / pivot
        before, behind = left * r, right * s
        negative += np.count_nonzero(pivot < 0.0, axis=0)
        for own in (before, behind):
            np.maximum(terms, np.abs(own).max(axis=0), out=terms)
        e = np.concatenate((-left * s, e[2 * pivot.shape[0] :]))  # the last tie of an even number stays
        d = _without(d, before, behind, matrix[near, near], matrix[far, far])
        r, s = r[..., None], s[..., None]
        steps.append((r, s, here / pivot[..., None]))
        b = _without(b, r * here, s * here, load[near], load[far])
    matrix[run.path[1:-1], run.path[1:-1]], load[run.path[1:-1]] = d, b
    for tie, (i, j) in zip(e, pairwise(run.path), strict=True):
        matrix[i, j] += tie
        matrix[j, i] += tie
    rest = np.ascontiguousarray(matrix.transpose(2, 0, 1)), load, steps
    return rest, negative, terms / np.abs(band[:, 0]).max(axis=0)


def _without(d: Array, before: Array, behind: Array, near: Array, far: Array) -> Array:
    """Values of a run without every second one, less what these take from both sides; the ends change."""
    half, odd = divmod(d.shape[0], 2)
    near -= before[0]
    if odd:
        far -= behind[-1]
    d = d[1::2] - behind[:half]
    d[: half + odd - 1] -= before[1:]
    return d


def solved_run(run: Run, left: Left, size: int) -> Array:
    """Solutions, shape (size, lanes, m), for the right sides that `eliminated` was given."""
    matrix, load, steps = left
    rest = solved_whole(matrix, load)
    out, path = np.empty((size, *rest.shape[1:])), rest[run.path]
    out[run.kept] = rest
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
