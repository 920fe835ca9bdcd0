"""The rows of a component in a table: long waves cut, ropes in segments, ordered in a narrow band, scaled."""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.modal.elements import Segments, Values
from cabledrive.modal.rows import (
    MASS,
    ONE_WAY,
    Array,
    Integers,
    Lanes,
    Table,
    moved,
    part_times,
    weights,
)
from cabledrive.modal.runs import Run, long_runs

if TYPE_CHECKING:
    from cabledrive.modal.component import Component
    from cabledrive.modal.search import Solved

DENSE = 20_000
"""Entries up to which a matrix is kept whole."""
_NONE = np.zeros(0, dtype=np.intp)


class Cut:
    """The rows of a component, its long waves cut and its ropes in segments, ordered and scaled."""

    def __init__(self, own: "Component", top: float, long: NDArray[np.bool_]) -> None:
        self.own, self.top, self.long, n, m = own, top, long, own.size, long.size
        cuts = int(long.sum())
        first = np.arange(m) + np.concatenate(([0], np.cumsum(long)[:-1])).astype(np.intp)[:m]
        last = first + long
        self.wave = np.repeat(np.arange(m), 1 + long)
        part = np.zeros(m + cuts, dtype=np.intp)
        part[first[long]], part[last[long]] = 1, 2
        joint, ones = n + np.arange(cuts), np.ones(cuts)
        n += cuts
        near = [
            np.concatenate(both)
            for both in zip((first[own.near[0]], *own.near[1:]), (last[long], joint, ones), strict=True)
        ]
        far = [
            np.concatenate(both)
            for both in zip((last[own.far[0]], *own.far[1:]), (first[long], joint, ones), strict=True)
        ]
        no = np.zeros(near[0].size, bool), np.zeros(far[0].size, bool)
        late = own.lag[self.wave][near[0]] != 0.0 if m else no[0]
        rows = [
            (3 * near[0], near[1], near[2], late),
            (3 * far[0], far[1], -far[2], no[1]),
            (3 * near[0] + 1, near[1], near[2], no[0]),
            (3 * far[0] + 2, far[1], far[2], no[1]),
        ]
        waves = base = 3 * (m + cuts)
        kind, a, b = [own.fixed_kind], [own.factor], [np.zeros(own.factor.size)]
        which, column, value = own.fixed_rows
        rows.append((base + which, column, value, np.zeros(which.size, bool)))
        base += own.factor.size
        self.segments: list[tuple[Segments, int, Integers]] = []
        for rope, ends in zip(own.ropes, own.ends, strict=True):
            parts = rope.segments(top)
            p, r, width = parts.value.shape
            inner = n + np.arange((p - 1) * (width // 2)).reshape(p - 1, width // 2)
            self.segments.append((parts, base, inner))
            rows += _rope_rows(parts, ends, inner, base)
            kind.append(parts.kind.ravel())
            a.append(np.full(p * r, float(rope.ropes)))
            b.append(parts.b.ravel())
            n, base = n + inner.size, base + p * r
        row, column, value, delayed = (np.concatenate(both) for both in zip(*rows, strict=True))
        kinds, factor = np.concatenate(kind), np.concatenate(a)
        mass = np.zeros(base)
        if m:
            share = np.repeat(own.z * own.time / (1 + long) / 3.0, 1 + long)
            mass[1:waves:3] = mass[2:waves:3] = share
        mass[waves:][kinds == MASS] = factor[kinds == MASS]
        diagonal = np.bincount(column, mass[row] * np.abs(value) ** 2, n)
        self.scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        sort = np.argsort(row, kind="stable")
        row, column, value, delayed = row[sort], column[sort], value[sort], delayed[sort]
        pairs = _pairs(first := np.searchsorted(row, np.arange(base + 1)))
        e, f = (column[own] for own in pairs)
        key = np.unique((e * n + f)[e > f])  # what is tied, each pair once
        upper, lower = key // max(1, n), key % max(1, n)
        self.order = _narrow_order(upper, lower, n)
        self.position = np.empty(n, dtype=np.intp)
        self.position[self.order] = np.arange(n)
        upper, lower = self.position[upper], self.position[lower]
        running = bool(own.lag[self.wave].any()) or np.iscomplexobj(value)
        self.table = _table(
            own,
            self.wave,
            part,
            (kinds, factor, np.concatenate(b)),
            (row, self.position[column], value * self.scale[column], delayed),
            (first, *pairs),
            None if running else long_runs(np.maximum(upper, lower), np.minimum(upper, lower), n),
            n,
        )

    def of(self, own: "Component") -> "Cut":
        """The same rows as those of a twin."""
        other = copy(self)
        other.own = own
        other.segments = [
            (replace(parts, rope=rope), base, inner)
            for (parts, base, inner), rope in zip(self.segments, own.ropes, strict=True)
        ]
        return other

    def natural(self, x: Values) -> Values:
        """Shapes in the component's coordinates, cuts and joints behind."""
        return self.scale[:, None] * x[self.position]

    def waves(self, omega: float, placed: float, x: Values) -> tuple[Values, Array, Array]:
        """Motion of the ends of the parts of waves without phase; their travel times [s] and phases."""
        t = self.table._replace(lag=np.zeros_like(self.table.lag))
        lane = Lanes(np.array([omega]), np.array([placed]), np.zeros(1, np.intp))
        y, _ = moved(t, lane.omega, np.zeros((t.part.size, 1)), x[:, None])
        times = part_times(t, lane)[0][:, 0]
        return y[: 3 * t.part.size, 0], times, omega * times / np.sqrt(1.0 + (t.ring / omega) ** 2)

    def rope_ends(self, number: int, x: Values) -> Values:
        """Motion of the ends of the segments of one rope, shape (p, ends, k); ``x`` natural shapes."""
        inner, ends = self.segments[number][2], self.own.ends[number]
        k = len(ends) // 2
        rows = [sum((v * x[c] for c, v in row), np.zeros(x.shape[1], x.dtype)) for row in ends]
        joints = x[inner.ravel()].reshape(-1, k, x.shape[1])
        nodes = np.concatenate((np.array(rows[:k])[None], joints, np.array(rows[k:])[None]))
        return np.concatenate((nodes[:-1], nodes[1:]), axis=1)

    def energies(self, modes: Sequence["Solved"]) -> list[tuple[Array, Array]]:
        """Of every row and mode, four times its strain and its kinetic energy; means over shapes.

        With the terms k of the stiffness over omega and r of its rate, the strain energy is (omega k +
        omega^2 r)/4 and the kinetic energy (omega^2 r - omega k)/4. The modes have one multiplicity.
        """
        omega, placed = np.array([(own.omega, own.placed) for own in modes]).T
        t, lanes = self.table, Lanes(omega, placed, np.zeros(omega.size, np.intp))
        w, rate, late, _ = weights(t, lanes)
        y, turned = moved(t, omega, late, np.stack([own.shapes for own in modes], axis=1))
        square = np.mean(np.abs(y) ** 2, axis=2)
        stiff, fall = w * square, rate * square
        if t.running:
            fall = fall - 2.0 * w * np.mean((y.conj() * turned).real, axis=2)
        stiff, fall = omega * stiff, omega**2 * fall
        return list(zip((stiff + fall).T, (fall - stiff).T, strict=True))

    def across(self, modes: Sequence["Solved"]) -> Array:
        """Share across in the strain energy of ropes that move along as well, shape (modes, ropes)."""
        found, x = np.zeros((len(modes), len(self.segments))), [self.natural(own.shapes) for own in modes]
        omega, shapes = np.repeat([own.omega for own in modes], x[0].shape[1]), np.concatenate(x, axis=1)
        for number, (segments, _, _) in enumerate(self.segments):
            if len(segments.rope.tags) > 1:
                found[:, number] = segments.share_across(omega, self.rope_ends(number, shapes), len(modes))
        return found


def _rope_rows(
    parts: Segments, ends: list[list[tuple[int, float]]], inner: Integers, base: int
) -> list[tuple[Integers, Integers, Values, NDArray[np.bool_]]]:
    """Entries of a rope's rows: of the joints between its segments, and of its ends."""
    p, r, width = parts.value.shape
    k, found = width // 2, []
    rows = base + np.arange(p * r).reshape(p, r)
    for c in range(width):
        s = slice(0, p - 1) if c >= k else slice(1, p)
        joint = np.repeat(inner[:, c % k], r)
        found.append((rows[s].ravel(), joint, parts.value[s, :, c].ravel()))
        end = p - 1 if c >= k else 0
        for column, factor in ends[c]:
            found.append((rows[end], np.full(r, column), factor * parts.value[end, :, c]))
    return [(*one, np.zeros(one[0].size, bool)) for one in found]


def _table(
    own: "Component",
    wave: Integers,
    part: Integers,
    fixed: tuple[Integers, Array, Array],
    entries: tuple[Integers, Integers, Values, NDArray[np.bool_]],
    pairs: tuple[Integers, Integers, Integers],
    runs: tuple[Run, ...] | None,
    size: int,
) -> Table:
    """Entries, in order of their rows, and the pairs of them that make the lower half of the band.

    ``runs``: None where a rope runs.
    """
    row, column, value, delayed = entries
    lag, rows = own.lag[wave], 3 * wave.size + fixed[0].size
    first, e, f = pairs
    lower = column[e] >= column[f]
    e, f = e[lower], f[lower]
    width = int((column[e] - column[f]).max(initial=0))
    slot = column[f] * (width + 1) + column[e] - column[f]
    delay, product = delayed[f].astype(float) - delayed[e], value[e].conj() * value[f]
    which = [~delayed, delayed] if runs is None else [~delayed]
    where = [delay == 0.0, delay > 0.0, delay < 0.0] if runs is None else [delay == 0.0]
    return Table(
        z=own.z[wave],
        time=own.time[wave],
        lag=lag,
        ring=own.ring[wave],
        part=part,
        kind=fixed[0],
        a=fixed[1],
        b=fixed[2],
        first=first,
        column=column,
        value=value,
        kinds=tuple(
            (kind, np.flatnonzero(fixed[0] == kind)) for kind in range(ONE_WAY + 1) if kind in fixed[0]
        ),
        rows=tuple(_matrix(value[one], row[one], column[one], (rows, size)) for one in which),
        products=tuple(
            _matrix(product[one], slot[one], row[e][one], (size * (width + 1), rows)) for one in where
        ),
        runs=runs or (),
        size=size,
        width=width,
    )


def _matrix(value: Values, row: Integers, column: Integers, shape: tuple[int, int]) -> Any:
    """A matrix of entries that add up, sparse where it is large."""
    if shape[0] * shape[1] <= DENSE:
        full = np.zeros(shape, value.dtype)
        np.add.at(full, (row, column), value)
        return full
    from scipy.sparse import coo_array  # small machines do not wait for it

    return coo_array((value, (row, column)), shape=shape).tocsr()


def _pairs(first: Integers) -> tuple[Integers, Integers]:
    """All ordered pairs of entries of one row."""
    size = np.diff(first)
    left, right = [_NONE], [_NONE]
    for k in np.unique(size[size > 0]):
        entry = first[:-1][size == k][:, None] + np.arange(k)
        left.append(np.repeat(entry, k, axis=1).ravel())
        right.append(np.tile(entry, (1, k)).ravel())
    return np.concatenate(left), np.concatenate(right)


def _narrow_order(upper: Integers, lower: Integers, n: int) -> Integers:
    """An order of the unknowns with those that are tied near each other (Cuthill and McKee, reversed)."""
    if n < 4:
        return np.arange(n)
    both, other = np.concatenate((upper, lower)), np.concatenate((lower, upper))
    ties = np.bincount(both, minlength=n)
    near, first = other[np.lexsort((other, ties[other], both))].tolist(), [0, *np.cumsum(ties).tolist()]
    seen, order = set[int](), list[int]()
    for start in np.argsort(ties, kind="stable").tolist():
        if start in seen:
            continue
        for _ in range(2):  # from the far end of what hangs together
            here, visited = [start], {start}
            for c in here:  # which grows
                for neighbour in near[first[c] : first[c + 1]]:
                    if neighbour not in visited:
                        visited.add(neighbour)
                        here.append(neighbour)
            start = here[-1]
        order += here
        seen |= visited
    return np.array(order[::-1], dtype=np.intp)
