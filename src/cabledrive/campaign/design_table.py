"""The table ``[design]`` of a SPEC."""

from collections.abc import Mapping
from math import isqrt, prod
from typing import Any

from cabledrive.campaign.axes import Axis
from cabledrive.campaign.design import (
    KINDS,
    LARGEST_SOBOL,
    Design,
    Diagonal,
    Grid,
    LatinHypercube,
    Morris,
    Random,
    Saltelli,
    Sequence,
)
from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import nearest, written
from cabledrive.parameters.toml_values import text_of, whole_of

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
