"""Designs: which points of the unit cube a campaign visits."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from math import isqrt, prod
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np

from cabledrive.campaign.vary import Axis
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import nearest, written
from cabledrive.parameters.toml_values import text_of, whole_of

KINDS = ("grid", "sobol", "halton", "lhs", "random", "list", "saltelli", "morris")
SAMPLING = ("scipy.stats.qmc",)
"""Modules that its points are computed with."""
LARGEST_SOBOL = 2**30
MORRIS_LEVELS, MORRIS_STEP = 4, 0.5


@runtime_checkable
class Design(Protocol):
    """What a campaign asks of a design; any object with these three will do.

    Attributes
    ----------
    rows : int
        Number of rows.
    identity : str
        Distinguishes it from other designs: the same text, the same points. A store keeps it.
    """

    @property
    def rows(self) -> int:
        """Number of rows."""
        ...

    @property
    def identity(self) -> str:
        """The same text, the same points."""
        ...

    def points(self, first: int, last: int) -> Array:
        """Points of some rows, the same however the rows are divided among workers.

        Parameters
        ----------
        first, last : int
            Rows from `first` to before `last`.

        Returns
        -------
        ndarray, shape (last - first, axes)
            Between 0 and 1, one column for each axis in the order of the SPEC.
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Grid:
    """Every combination; the last axis changes fastest."""

    shares: tuple[Array, ...]
    rows: int = field(init=False)
    identity: str = "grid"

    def __post_init__(self) -> None:
        object.__setattr__(self, "rows", prod(share.size for share in self.shares))

    def points(self, first: int, last: int) -> Array:
        """Points by the digits of the row's number."""
        numbers, columns = np.arange(first, last), []
        for share in reversed(self.shares):
            columns.append(share[numbers % share.size])
            numbers = numbers // share.size
        return np.column_stack(columns[::-1])


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagonal:
    """Row by row: the first values of all keys, then the second ones."""

    rows: int
    axes: int
    identity: str = "list"

    def points(self, first: int, last: int) -> Array:
        """The middle of each value's part of the interval."""
        share = (np.arange(first, last) + 0.5) / self.rows
        return np.repeat(share[:, None], self.axes, axis=1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Random:
    """Independent points; a row's numbers are at a place of their own in the generator's sequence."""

    rows: int
    axes: int
    seed: int

    @property
    def identity(self) -> str:
        """Kind."""
        return "random"

    def points(self, first: int, last: int) -> Array:
        """Uniform numbers."""
        generator = np.random.PCG64(self.seed)
        generator.advance(first * self.axes)
        return np.random.Generator(generator).random((last - first, self.axes))


@dataclass(frozen=True, slots=True, kw_only=True)
class Sequence:
    """A scrambled Sobol or Halton sequence."""

    modules: ClassVar[tuple[str, ...]] = SAMPLING
    rows: int
    axes: int
    seed: int
    kind: str

    @property
    def identity(self) -> str:
        """Kind."""
        return self.kind

    def points(self, first: int, last: int) -> Array:
        """Points from the place `first` of the sequence on."""
        from scipy.stats import qmc

        make = qmc.Sobol if self.kind == "sobol" else qmc.Halton
        sequence = make(self.axes, scramble=True, rng=np.random.default_rng(self.seed))
        if first:
            sequence.fast_forward(first)
        return _drawn(sequence, last - first)


def _drawn(sequence: Any, count: int) -> Array:
    """Points; scipy warns that a Sobol sequence is balanced at powers of two only, which the page says."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return np.asarray(sequence.random(count), dtype=np.float64)


@dataclass(frozen=True, slots=True, kw_only=True)
class LatinHypercube:
    """One point in each of as many slices of every axis as there are rows."""

    modules: ClassVar[tuple[str, ...]] = SAMPLING
    rows: int
    axes: int
    seed: int
    identity: str = "lhs"

    def points(self, first: int, last: int) -> Array:
        """Rows of the whole table, which each process makes once."""
        return _hypercube(self.rows, self.axes, self.seed)[first:last]


@cache
def _hypercube(rows: int, axes: int, seed: int) -> Array:
    from scipy.stats import qmc

    sampler = qmc.LatinHypercube(axes, rng=np.random.default_rng(seed))
    return np.asarray(sampler.random(rows), dtype=np.float64)


@dataclass(frozen=True, slots=True, kw_only=True)
class Saltelli:
    """Groups of k + 2 rows: a point of sample A, one of B, then A with each column in turn from B."""

    modules: ClassVar[tuple[str, ...]] = SAMPLING
    base: int
    axes: int
    seed: int
    identity: str = "saltelli"

    @property
    def rows(self) -> int:
        """N (k + 2)."""
        return self.base * (self.axes + 2)

    def points(self, first: int, last: int) -> Array:
        """Points of the groups that these rows touch."""
        k, size = self.axes, self.axes + 2
        begin, end = first // size, -(-last // size)
        both = Sequence(rows=self.base, axes=2 * k, seed=self.seed, kind="sobol").points(begin, end)
        groups = np.repeat(both[:, None, :k], size, axis=1)
        groups[:, 1] = both[:, k:]
        for axis in range(k):
            groups[:, 2 + axis, axis] = both[:, k + axis]
        return groups.reshape(-1, k)[first - begin * size : last - begin * size]


@dataclass(frozen=True, slots=True, kw_only=True)
class Morris:
    """Paths of k + 1 rows through a grid of four levels: each step moves one axis, in random order.

    The levels are the middles of quarters, so that distributions without ends have them too; a step is two
    levels, half of the interval.
    """

    base: int
    axes: int
    seed: int
    identity: str = "morris"

    @property
    def rows(self) -> int:
        """N (k + 1)."""
        return self.base * (self.axes + 1)

    def points(self, first: int, last: int) -> Array:
        """Points of the paths that these rows touch."""
        size = self.axes + 1
        begin, end = first // size, -(-last // size)
        paths = np.concatenate(
            [self._path(number) for number in range(begin, end)] or [np.empty((0, self.axes))]
        )
        return paths[first - begin * size : last - begin * size]

    def _path(self, number: int) -> Array:
        """One path, shape (k + 1, k), by its own random numbers."""
        generator = np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(number,)))
        low, up = generator.integers(2, size=self.axes), generator.integers(2, size=self.axes)
        order = generator.permutation(self.axes)
        moved = np.argsort(order)[None, :] < np.arange(self.axes + 1)[:, None]
        return np.asarray((low + 2 * (up ^ moved) + 0.5) / MORRIS_LEVELS)


DESIGN_WORDS = ("kind", "rows", "seed", "base")
GROUPED: dict[str, tuple[type[Saltelli] | type[Morris], int]] = {
    "saltelli": (Saltelli, 2),
    "morris": (Morris, 1),
}
"""Designs of groups of rows, each of k rows and so many more."""


def design_of(table: Mapping[str, Any], axes: tuple[Axis, ...], seed: int) -> Design:
    """The design of ``[design]``; refused: an unknown key, rows that do not fit what is varied."""
    for key in table:
        if key not in DESIGN_WORDS:
            raise InputRefused(f'unknown key "design.{key}"{nearest(key, DESIGN_WORDS, "design.")}')
    counted = all(axis.counted for axis in axes)
    kind = text_of("design.kind", table.get("kind", "list" if counted else "sobol"))
    if kind not in KINDS:
        raise InputRefused(f'design.kind = "{kind}" is not known{nearest(kind, KINDS)}')
    if "base" in table and kind not in GROUPED:
        raise InputRefused(f"design.base is for kind = saltelli or morris: give rows to {kind}")
    rows = whole_of("design.rows", table["rows"]) if "rows" in table else None
    if kind == "grid":
        return _grid(axes, rows)
    if kind == "list":
        return _list(axes, rows)
    if kind in GROUPED:
        return _grouped(kind, table, len(axes), rows, seed)
    if rows is None:
        raise InputRefused("design.rows is missing: give the number of rows")
    if kind == "random":
        return Random(rows=rows, axes=len(axes), seed=seed)
    if kind == "lhs":
        return LatinHypercube(rows=rows, axes=len(axes), seed=seed)
    if rows > LARGEST_SOBOL:
        raise InputRefused(f"design.rows = {rows} is above {LARGEST_SOBOL}: take kind = random")
    return Sequence(rows=rows, axes=len(axes), seed=seed, kind=kind)


def _grid(axes: tuple[Axis, ...], rows: int | None) -> Grid:
    open_axes = [axis for axis in axes if axis.levels is None]
    each = _equal_share(axes, open_axes, rows)
    counts = [each if axis.levels is None else axis.levels for axis in axes]
    grid = Grid(shares=tuple(axis.shares(count) for axis, count in zip(axes, counts, strict=True)))
    if rows is not None and grid.rows != rows:
        raise InputRefused(
            f"design.rows = {rows}, but this grid has {grid.rows}: leave rows out, or change n"
        )
    return grid


def _equal_share(axes: tuple[Axis, ...], open_axes: list[Axis], rows: int | None) -> int:
    """Points of each range that states none: an equal share of the rows that are asked for."""
    if not open_axes:
        return 1
    key = next(iter(open_axes[0].spreads))
    if rows is None:
        raise InputRefused(
            f"vary.{key}: a grid needs n, the number of points: add n = 5, or give design.rows"
        )
    fixed = prod(axis.levels for axis in axes if axis.levels is not None)
    share = rows // fixed
    each = round(share ** (1.0 / len(open_axes))) if len(open_axes) != 2 else isqrt(share)
    if fixed * each ** len(open_axes) != rows:
        raise InputRefused(f"design.rows = {rows} is no grid of equal axes: give n to vary.{key}")
    return each


def _list(axes: tuple[Axis, ...], rows: int | None) -> Diagonal:
    for axis in axes:
        if not axis.counted:
            raise InputRefused(f"vary.{next(iter(axis.spreads))}: a list needs values or a table, no range")
    lengths = {axis.levels for axis in axes}
    if len(lengths) > 1:
        shown = ", ".join(f"{next(iter(axis.spreads))} {axis.levels}" for axis in axes)
        raise InputRefused(f"design.kind = list needs as many values of each key: {shown}")
    length = lengths.pop()
    assert length is not None
    if rows is not None and rows != length:
        raise InputRefused(f"design.rows = {rows}, but the list has {length} values: leave rows out")
    return Diagonal(rows=length, axes=len(axes))


def _grouped(kind: str, table: Mapping[str, Any], axes: int, rows: int | None, seed: int) -> Design:
    """A design of as many groups as ``base`` says, or the rows make."""
    make, more = GROUPED[kind]
    size = axes + more
    if "base" not in table and rows is not None and rows % size == 0:
        return make(base=rows // size, axes=axes, seed=seed)
    if "base" not in table:
        shown = (
            "is missing"
            if rows is None
            else f"is missing, and rows = {written(rows)} is no multiple of {size}"
        )
        raise InputRefused(f"design.base {shown}: give N, of which N (k + {more}) = {size} N rows are made")
    design = make(base=whole_of("design.base", table["base"]), axes=axes, seed=seed)
    if rows is not None and rows != design.rows:
        raise InputRefused(
            f"design.rows = {rows}, but base = {design.base} makes {design.rows}: give one of them"
        )
    return design
