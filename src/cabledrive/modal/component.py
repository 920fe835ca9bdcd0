"""Coordinates of a network that are tied together, and what ties them: counted and searched."""

from collections.abc import Hashable, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cabledrive.modal.cuts import Cut
from cabledrive.modal.elements import Rope, Row, Tag, Wave
from cabledrive.modal.rows import SPRING, Array, Integers, bands, counted, lanes_at, weights, zero_pivots
from cabledrive.modal.search import Solved, modes_between
from cabledrive.parameters.errors import InputRefused

LONG = 2.0
"""Phase of a wave above which it is cut [rad]."""
REACH = 2.5
"""How far segments of ropes may be finer than is needed, rather than cut anew."""
SETTLED = 30  # rounds for the sizes of rows and columns
ROUND_OFF = 1e-12  # of a row, over its largest entry, which has no size of its own
ASKEW = 2e-4
"""Slope of a rope to a slide [rad] below which it does not hold what slides."""
_NONE = np.zeros(0, dtype=np.intp)


class Fixed(NamedTuple):
    """A mass or a spring by the row that moves or strains it; ``name``: of a spring."""

    kind: int
    factor: float
    row: Row
    name: str = ""

    @property
    def rows(self) -> tuple[Row, ...]:
        """Its one row."""
        return (self.row,)


class Component:
    """Coordinates tied together, with what ties them; ``columns``: their numbers in the network.

    ``least``: entries of waves and ropes below which they are left out; ``tags``: pieces and directions that
    take part; ``ways``: the directions.
    """

    def __init__(
        self,
        columns: Sequence[int],
        parts: Sequence[Wave | Rope | Fixed],
        least: Mapping[int, float] | None = None,
    ) -> None:
        self.columns = np.array(columns, np.intp)
        self.waves = waves = [part for part in parts if isinstance(part, Wave)]
        self.ropes = ropes = [part for part in parts if isinstance(part, Rope)]
        self.fixed = fixed = [part for part in parts if isinstance(part, Fixed)]
        place = {int(c): i for i, c in enumerate(self.columns)}
        self.size = len(place)
        self._least = least = least or {}

        def level(row: Row) -> list[tuple[int, float]]:
            return [(place[c], v) for c, v in row if abs(v) >= least.get(c, 0.0)]

        self.near = _columns([(i, *one) for i, own in enumerate(waves) for one in level(own.start)])
        self.far = _columns([(i, *one) for i, own in enumerate(waves) for one in level(own.end)])
        self.fixed_rows = _columns([(i, place[c], v) for i, own in enumerate(fixed) for c, v in own.row])
        self.fixed_kind = np.array([own.kind for own in fixed], dtype=np.intp)
        self.factor = np.array([own.factor for own in fixed], dtype=float)
        self.z = np.array([own.z * own.ropes for own in waves], dtype=float)
        self.time = np.array([own.time for own in waves], dtype=float)
        self.lag = np.array([own.lag for own in waves], dtype=float)
        self.ring = np.array([own.ring for own in waves], dtype=float)
        self.ends = [[level(row) for row in own.rows] for own in ropes]
        self._lengths: list[Wave | Rope] = [*waves, *ropes]
        every = [own.time for own in self._lengths]
        self.longest, self.whole = max(every, default=0.0), float(sum(every))
        self.tags: list[Tag] = [tag for part in self._lengths for tag in part.tags]
        self.ways = {way for _, way in self.tags}
        self._cuts: list[Cut] = []
        self._counts: dict[bytes, Array] = {}
        self._modes: dict[tuple[float, float], list[tuple[Cut, Solved]]] = {}
        self.twin = self  # or one with the same modes, of which they are taken

    @property
    def alike(self) -> Hashable:
        """Equal of components with the same rows, which have the same modes."""
        ropes = tuple(
            (own.hold, own.direction, own.length, own.density, own.pull, own.bend, own.speed, own.ropes)
            for own in self.ropes
        )
        arrays = (self.z, self.time, self.lag, self.ring, self.fixed_kind, self.factor)
        rows = (*self.near, *self.far, *self.fixed_rows)
        return self.size, ropes, repr(self.ends), *(own.tobytes() for own in (*arrays, *rows))

    def cut(self, top: float) -> "Cut":
        """The table for frequencies up to one [rad/s]."""
        long = self.time * top > LONG
        for cut in self._cuts:
            if (not self.ropes or top <= cut.top <= REACH * top) and np.array_equal(cut.long, long):
                return cut
        self._cuts.append(Cut(self, 1.02 * top, long))
        return self._cuts[-1]

    @cached_property
    def rigid(self) -> int:
        """Motions that strain nothing; refuses a rest position that is unstable."""
        if not self.size:
            return 0
        if self.twin is not self:
            return self.twin.rigid
        if any(own.taut for own in self.ropes):
            # its weight holds a sagging rope that runs round; that of the rope on the wheels, which is
            # left out, moves it as much: a taut one has neither
            parts = (part for own in self.ropes for part in own.taut or (own,))
            return Component(self.columns.tolist(), [*self.waves, *parts, *self.fixed]).rigid
        if not self._least:  # what is askew by a rounded figure drowns in round-off of stiff parts
            entries = [one for own in self._lengths for row in own.rows for one in row]
            least = dict[int, float]()
            for column, value in entries:
                least[column] = max(least.get(column, 0.0), ASKEW * abs(value))
            if any(0.0 < abs(value) < least[column] for column, value in entries):
                return Component(self.columns.tolist(), [*self._lengths, *self.fixed], least).rigid
        cut = self.cut(1e-2 / (self.whole or 1.0))
        t, waves = cut.table, 3 * cut.wave.size
        strains = np.zeros(t.first.size - 1)
        strains[:waves:3], strains[waves:] = 1.0, t.kind == SPRING
        turned = bool(np.any(t.a[t.kind == SPRING] < 0.0))
        if turned:  # by how stiff they are, far below what curvature does to a wave
            w, _, _, _ = weights(t._replace(ring=np.zeros_like(t.ring)), lanes_at(1e-6 / (self.whole or 1.0)))
            strains *= w[:, 0]
        else:  # whatever strains anything, however little, counts alike, in whatever unit a coordinate moves
            row = np.repeat(np.arange(strains.size), np.diff(t.first))
            sizes, largest = np.abs(t.value), np.zeros(strains.size)
            np.maximum.at(largest, row, sizes)
            held = np.flatnonzero((strains[row] > 0.0) & (sizes > ROUND_OFF * largest[row]))
            size = _sizes(row[held], t.column[held], sizes[held], strains.size)
            for segments, base, _ in cut.segments:
                own = size[base : base + segments.kind.size].reshape(segments.kind.shape)
                own[:] = own.max(axis=1, keepdims=True)
            strains /= size**2
        still = t._replace(lag=np.zeros_like(t.lag))
        band = bands(still, np.ones(1), strains[:, None], np.zeros((t.part.size, 1)))[..., 0]
        loose, unstable = zero_pivots(still, band, 1e-12 + 1e-13 * t.size if turned else 1e-9)
        if turned and unstable:
            said = "the machine is unstable where it stands: the forces at rest turn a body away"
            raise InputRefused(f"{said}; support it, or give it stiffness")
        return loose

    def counts(self, omega: Array) -> Array:
        """Modes below frequencies [rad/s], ascending, without motions that strain nothing."""
        if not omega.size or omega[-1] <= 0.0:
            return np.zeros(omega.size)
        if self.twin is not self:
            return self.twin.counts(omega)
        key = omega.tobytes()
        if key in self._counts:
            return self._counts[key]
        found = np.zeros(omega.size)
        if not self.size and not self.ropes:
            for own in self.waves:
                found += np.floor(omega * own.time / np.sqrt(1.0 + (own.ring / omega) ** 2) / np.pi)
        elif (
            table := self.cut(float(omega[-1])).table
        ).size:  # else a segment too short for a mode of its own
            found = np.maximum(counted(table, lanes_at(omega)) - self.rigid, 0.0)
        self._counts[key] = found
        return found

    def count(self, omega: float) -> int:
        """Modes below a frequency [rad/s], without motions that strain nothing."""
        return int(self.counts(np.array([omega]))[0])

    def modes(self, low: float, top: float) -> list[tuple["Cut", Solved]]:
        """Modes between two frequencies [rad/s], each with the table of its shapes."""
        if self.twin is not self:
            return [(cut.of(self), own) for cut, own in self.twin.modes(low, top)]
        if (low, top) not in self._modes:
            cut = self.cut(top)
            first = self.count(low) + self.rigid if low > 0.0 else self.rigid
            last = max(self.count(top) + self.rigid, first)
            found = modes_between(cut.table, low, top, first, last, self.longest)
            self._modes[low, top] = [(cut, own) for own in found]
        return self._modes[low, top]


def _sizes(row: Integers, column: Integers, value: Array, rows: int) -> Array:
    """Sizes of rows of a matrix of entries in whatever units of its columns, shape (rows,).

    With those of the columns they leave logarithms of least squares: A. R. Curtis and J. K. Reid, J. Inst.
    Maths Applics 10 (1972) 118.
    """
    logs, by_row, by_column = np.log(value), np.zeros(rows), np.zeros(1 + column.max(initial=0))
    numbers = np.bincount(row, minlength=rows), np.bincount(column)
    for _ in range(SETTLED):
        by_column = np.bincount(column, logs - by_row[row]) / np.maximum(numbers[1], 1)
        by_row = np.bincount(row, logs - by_column[column], rows) / np.maximum(numbers[0], 1)
    return np.exp(by_row)


def _columns(entries: list[tuple[int, int, float]]) -> tuple[Integers, Integers, Array]:
    if not entries:
        return _NONE, _NONE, np.zeros(0)
    row, column, value = zip(*entries, strict=True)
    return np.array(row, np.intp), np.array(column, np.intp), np.array(value, dtype=float)
