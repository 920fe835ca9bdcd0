"""Designs: which points of the unit cube a campaign visits."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import prod
from typing import Any, Protocol

import numpy as np

from cabledrive.campaign.vary import Axis
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import require_known, written
from cabledrive.parameters.toml_values import text_of, whole_of

LARGEST_SOBOL = 2**30
MORRIS_LEVELS, MORRIS_STEP = 4, 0.5


class Design(Protocol):
    """What a campaign asks of a design; any object with these three will do."""

    @property
    def rows(self) -> int:
        """Number of rows."""

    @property
    def identity(self) -> str:
        """Distinguishes it from other designs: the same text, the same points. A store keeps it."""

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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NamedDesign:
    """A design that a SPEC can name; its points follow from these numbers alone."""

    kind: str  # of `POINTS`
    rows: int
    axes: int
    seed: int = 0
    shares: tuple[Array, ...] = ()  # places of a grid along each axis

    @property
    def identity(self) -> str:
        """Kind."""
        return self.kind

    @property
    def modules(self) -> tuple[str, ...]:
        """What its points are computed with."""
        return ("scipy.stats.qmc",) if self.kind in ("sobol", "halton", "lhs", "saltelli") else ()

    def points(self, first: int, last: int) -> Array:
        """Points of rows, (last - first, axes); of some kinds in groups, whole ones are made."""
        size = self.axes + GROUPED[self.kind] if self.kind in GROUPED else 1
        begin, end = first // size, -(-last // size)
        points = np.reshape(POINTS[self.kind](self, begin, end), (-1, self.axes))
        return np.asarray(points[first - begin * size : last - begin * size])


def _grid(design: NamedDesign, first: int, last: int) -> Array:
    """Every combination, by the digits of the row's number; the last axis changes fastest."""
    shape = [share.size for share in design.shares]
    places = np.unravel_index(np.arange(first, last), shape)
    return np.column_stack([share[place] for share, place in zip(design.shares, places, strict=True)])


def _list(design: NamedDesign, first: int, last: int) -> Array:
    """Row by row: the middle of each value's part of the interval, of all keys together."""
    share = (np.arange(first, last) + 0.5) / design.rows
    return np.repeat(share[:, None], design.axes, axis=1)


def _random(design: NamedDesign, first: int, last: int) -> Array:
    """Independent points; a row's numbers are at a place of their own in the generator's sequence."""
    generator = np.random.PCG64(design.seed)
    generator.advance(first * design.axes)
    return np.random.Generator(generator).random((last - first, design.axes))


def _sequence(design: NamedDesign, first: int, last: int) -> Array:
    """A scrambled Sobol or Halton sequence from a place on."""
    from scipy.stats import qmc

    make = qmc.Halton if design.kind == "halton" else qmc.Sobol
    sequence = make(design.axes, scramble=True, rng=np.random.default_rng(design.seed))
    if first:
        sequence.fast_forward(first)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # balanced at powers of two only, as the docs say
        return np.asarray(sequence.random(last - first))


@cache
def _hypercube(rows: int, axes: int, seed: int) -> Array:
    """One point in each of as many slices of every axis as there are rows; each process makes it once."""
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(axes, rng=np.random.default_rng(seed)).random(rows))


def _saltelli(design: NamedDesign, begin: int, end: int) -> Array:
    """Groups of k + 2 rows: a point of sample A, one of B, then A with each column in turn from B."""
    k, size = design.axes, design.axes + 2
    pairs = NamedDesign(kind="sobol", rows=design.rows // size, axes=2 * k, seed=design.seed)
    both = pairs.points(begin, end)
    groups = np.repeat(both[:, None, :k], size, axis=1)
    groups[:, 1] = both[:, k:]
    for axis in range(k):
        groups[:, 2 + axis, axis] = both[:, k + axis]
    return groups


def _morris(design: NamedDesign, begin: int, end: int) -> Array:
    """Paths of k + 1 rows through a grid of four levels: each step moves one axis, in random order.

    The levels are the middles of quarters, so that distributions without ends have them too; a step is two
    levels, half of the interval. A path has random numbers of its own.
    """
    k, size = design.axes, design.axes + 1
    paths = np.empty((end - begin, size, k))
    for path, number in zip(paths, range(begin, end), strict=True):
        generator = np.random.default_rng(np.random.SeedSequence(design.seed, spawn_key=(number,)))
        low, up = generator.integers(2, size=k), generator.integers(2, size=k)
        moved = np.argsort(generator.permutation(k))[None, :] < np.arange(size)[:, None]
        path[:] = (low + 2 * (up ^ moved) + 0.5) / MORRIS_LEVELS
    return paths


POINTS = {
    "grid": _grid,
    "sobol": _sequence,
    "halton": _sequence,
    "lhs": lambda made, first, last: _hypercube(made.rows, made.axes, made.seed)[first:last],
    "random": _random,
    "list": _list,
    "saltelli": _saltelli,
    "morris": _morris,
}
GROUPED = {"saltelli": 2, "morris": 1}
"""Designs of groups of rows, each of k rows and so many more."""
DESIGN_WORDS = ("kind", "rows", "seed", "base")


def design_of(table: Mapping[str, Any], axes: tuple[Axis, ...], seed: int) -> NamedDesign:
    """The design of ``[design]``; refused: an unknown key, rows that do not fit what is varied."""
    for key in table:
        require_known(key, DESIGN_WORDS, f'unknown key "design.{key}"', "design.")
    counted = all(axis.counted for axis in axes)
    kind = text_of("design.kind", table.get("kind", "list" if counted else "sobol"))
    require_known(kind, POINTS, f'design.kind = "{kind}" is not known')
    if "base" in table and kind not in GROUPED:
        raise InputRefused(f"design.base is for kind = saltelli or morris: give rows to {kind}")
    rows = whole_of("design.rows", table["rows"]) if "rows" in table else None
    if kind == "grid":
        shares = _shares(axes, rows)
        return NamedDesign(
            kind=kind, rows=prod(share.size for share in shares), axes=len(axes), shares=shares
        )
    if kind == "list":
        rows = _listed(axes, rows)
    elif kind in GROUPED:
        rows = _grouped_rows(kind, table, len(axes), rows)
    elif rows is None:
        raise InputRefused("design.rows is missing: give the number of rows")
    elif kind in ("sobol", "halton") and rows > LARGEST_SOBOL:
        raise InputRefused(f"design.rows = {rows} is above {LARGEST_SOBOL}: take kind = random")
    return NamedDesign(kind=kind, rows=rows, axes=len(axes), seed=seed)


def _shares(axes: tuple[Axis, ...], rows: int | None) -> tuple[Array, ...]:
    """Places of a grid; ranges that state no number have an equal share of the rows asked for."""
    open_axes, each = [axis for axis in axes if axis.levels is None], 1
    if open_axes:
        key = next(iter(open_axes[0].spreads))
        if rows is None:
            raise InputRefused(
                f"vary.{key}: a grid needs n, the number of points: add n = 5, or give design.rows"
            )
        fixed = prod(axis.levels for axis in axes if axis.levels is not None)
        each = round((rows // fixed) ** (1.0 / len(open_axes)))
        if fixed * each ** len(open_axes) != rows:
            raise InputRefused(f"design.rows = {rows} is no grid of equal axes: give n to vary.{key}")
    shares = tuple(axis.shares(axis.levels or each) for axis in axes)
    made = prod(share.size for share in shares)
    if rows is not None and made != rows:
        raise InputRefused(f"design.rows = {rows}, but this grid has {made}: leave rows out, or change n")
    return shares


def _listed(axes: tuple[Axis, ...], rows: int | None) -> int:
    """Rows of a list, of which every key has as many values."""
    lengths = {next(iter(axis.spreads)): axis.levels for axis in axes}
    for key, axis in zip(lengths, axes, strict=True):
        if not axis.counted:
            raise InputRefused(f"vary.{key}: a list needs values or a table, no range")
    if len(set(lengths.values())) > 1:
        shown = ", ".join(f"{key} {length}" for key, length in lengths.items())
        raise InputRefused(f"design.kind = list needs as many values of each key: {shown}")
    length = next(iter(lengths.values()))
    assert length is not None
    if rows is not None and rows != length:
        raise InputRefused(f"design.rows = {rows}, but the list has {length} values: leave rows out")
    return length


def _grouped_rows(kind: str, table: Mapping[str, Any], axes: int, rows: int | None) -> int:
    """Rows of as many groups as ``base`` says, or the rows make."""
    size = axes + GROUPED[kind]
    if "base" not in table:
        if rows is not None and rows % size == 0:
            return rows
        no = "" if rows is None else f", and rows = {written(rows)} is no multiple of {size}"
        raise InputRefused(
            f"design.base is missing{no}: give N, of which N (k + {GROUPED[kind]}) = {size} N rows are made"
        )
    base = whole_of("design.base", table["base"])
    if rows is not None and rows != base * size:
        raise InputRefused(f"design.rows = {rows}, but base = {base} makes {base * size}: give one of them")
    return base * size
