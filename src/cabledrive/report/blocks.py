"""What a chapter is made of: paragraphs, figures, tables, equations, notes, live curves."""

import base64
import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from importlib import resources
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from cabledrive.answers.figures import Row
from cabledrive.parameters.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """A curve of a plot."""

    name: str
    values: NDArray[np.float64]  # (p,): at the points of the plot; a gap where not finite
    colour: str = "blue"  # name of a colour of the page
    dashed: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """Curves over one axis."""

    title: str
    unit: str  # of all curves
    series: tuple[Series, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plot:
    """Curves that answer to the pointer: values, zoom, the data as a file."""

    kind: ClassVar[str] = "plot"
    name: str  # anchor, unique on the page
    alt: str  # what is seen, for whoever does not see it
    caption: str | Markup
    points: NDArray[np.float64]  # (p,): ascending, common to all panels
    along: str  # what the points are
    unit: str  # of the points
    panels: tuple[Panel, ...]  # one above the other

    def __post_init__(self) -> None:
        for panel in self.panels:
            for series in panel.series:
                if series.values.shape != self.points.shape:
                    raise ValueError(
                        f"{self.name}: {series.name} has shape {series.values.shape}, "
                        f"the points {self.points.shape}"
                    )


Text = str | Markup  # plain text is escaped by the page; markup is taken as it is
Cell = Text | float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Paragraph:
    """Running text."""

    kind: ClassVar[str] = "paragraph"
    text: Text
    items: tuple[Text, ...] = ()  # points of a list below it


@dataclass(frozen=True, slots=True, kw_only=True)
class Note:
    """A remark set apart from the text."""

    kind: ClassVar[str] = "note"
    text: Text
    tone: str = "remark"  # "remark", "warning" or "good"; its first words say the same without colour


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """A picture with its words."""

    kind: ClassVar[str] = "figure"
    name: str  # anchor, unique on the page
    alt: str  # what is seen, for whoever does not see it
    caption: Text  # what it says
    drawing: Markup  # inline SVG, which scales, and scrolls inside its box where the page is narrow
    switch: Markup | None = None  # before the drawings: starts and stops one that moves, its styles included

    def __post_init__(self) -> None:
        if not self.alt.strip():
            raise ValueError(f"figure {self.name} has no alt text: describe the picture")


def pictured(say: Callable[..., str], name: str, drawing: Markup, **seen: object) -> Figure:
    """A drawing whose words are texts: its name for the caption, with ``_seen`` and values what is seen."""
    return Figure(name=name, alt=say(f"{name}_seen", **seen), caption=say(name), drawing=drawing)


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """Head of a column."""

    title: Text
    unit: str = ""  # unit of the numbers below
    numeric: bool = False  # whether it is set flush right, in figures of equal width
    bar: bool = False  # cells are shares between 0 and 1, shown in per cent with a bar behind


@dataclass(frozen=True, slots=True, kw_only=True)
class RowGroup:
    """Rows under a heading of their own."""

    title: str = ""  # heading; none where empty
    rows: tuple[tuple[Cell, ...], ...]  # as many cells as columns: text, markup, or a share


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table whose first column names the row."""

    kind: ClassVar[str] = "table"
    caption: Text
    columns: tuple[Column, ...]
    groups: tuple[RowGroup, ...]
    note: Text = ""  # what stands below it


def table(
    caption: Text,
    heads: str,
    rows: Iterable[tuple[Cell, ...] | RowGroup],
    *,
    bars: Iterable[str] = (),
    note: Text = "",
) -> Table:
    """A table of rows or of groups, with heads such as "Span | Length [m] | Runs []": brackets mean numbers.

    ``bars``: heads of further columns, of shares that are shown in per cent with a bar behind.
    """
    named = (head.partition(" [") for head in heads.split(" | "))
    columns = [Column(title=t, unit=u.removesuffix("]"), numeric=bool(n)) for t, n, u in named]
    columns += [Column(title=head, unit="%", bar=True) for head in bars]
    given = tuple(rows)
    groups = tuple(one for one in given if isinstance(one, RowGroup))
    single = tuple(one for one in given if not isinstance(one, RowGroup))
    groups = groups or (RowGroup(rows=single),)
    return Table(caption=caption, columns=tuple(columns), groups=groups, note=note)


def listed(caption: Text, rows: Sequence[Row], things: Iterable[Any], note: Text = "") -> Table:
    """A table with a line for each thing, of the figures that results declare."""
    heads = [
        Column(
            title=row.words,
            unit="" if row.form == "" else row.unit,  # a quantity has its own
            numeric=row.kind.startswith(("number", "count")),
        )
        for row in rows
    ]
    cells = tuple(tuple(row.text(row.of(thing)) for row in rows) for thing in things)
    return Table(caption=caption, columns=tuple(heads), groups=(RowGroup(rows=cells),), note=note)


def table_text(made: Table) -> str:
    """A table for a terminal: words to the left, numbers to the right, shares in per cent."""
    heads = [f"{head.title} [{head.unit}]" if head.unit else str(head.title) for head in made.columns]
    rows = [row for group in made.groups for row in group.rows]
    cells = [
        [f"{100 * cell:.1f}" if isinstance(cell, float) else Markup(cell or "").striptags() for cell in row]
        for row in rows
    ]
    widths = [max(map(len, column)) for column in zip(heads, *cells, strict=True)]

    def line(row: Sequence[str]) -> str:
        sides = (head.numeric or head.bar for head in made.columns)
        parts = zip(row, widths, sides, strict=True)
        return "  ".join(cell.rjust(w) if right else cell.ljust(w) for cell, w, right in parts).rstrip()

    lines, done = [line(heads)], 0
    for group in made.groups:
        lines += ["", group.title] if group.title else []
        lines += map(line, cells[done : done + len(group.rows)])
        done += len(group.rows)
    return "\n".join([*lines, *([str(made.note)] if made.note else [])])


Block = Paragraph | Note | Figure | Plot | Table


@dataclass(frozen=True, slots=True)
class Section:
    """A part of a chapter with its own entry in the table of contents."""

    title: str
    anchor: str  # unique on the page
    blocks: tuple[Block, ...]
    text: str = ""  # before the blocks
    folded: bool = False  # opened by whoever wants it


@dataclass(frozen=True, slots=True)
class Chapter:
    """One chapter of the report."""

    title: str
    anchor: str  # unique on the page
    blocks: tuple[Block, ...]  # what stands before the sections
    sections: tuple[Section, ...] = ()
    methods: tuple[str, ...] = ()  # how its numbers were computed, for the provenance at the end
    headline: str = ""  # what it found, in one sentence, for the top of the page
    summary: str = ""  # what it is about, in one sentence, for its card

    @property
    def all_blocks(self) -> tuple[Block, ...]:
        """Every block in order, those of the sections included."""
        return (*self.blocks, *(block for section in self.sections for block in section.blocks))


UPLOT = resources.files("cabledrive.report") / "vendor" / "uplot"


def plot_json(plot: Plot) -> Markup:
    """Names, units, colours and curves of a plot, fit for a script element."""
    data = {
        "name": plot.name,
        "x": {"name": plot.along, "unit": plot.unit, "values": _packed(plot.points)},
        "panels": [
            {
                "title": panel.title,
                "unit": panel.unit,
                "series": [
                    {"name": s.name, "colour": s.colour, "dashed": s.dashed, "values": _packed(s.values)}
                    for s in panel.series
                ],
            }
            for panel in plot.panels
        ],
    }
    # "<" ends no element from inside a string, whatever a drive file calls its parts
    return Markup(json.dumps(data, ensure_ascii=False).replace("<", "\\u003c"))


def _packed(values: NDArray[np.float64]) -> str:
    return base64.urlsafe_b64encode(np.asarray(values, dtype="<f4").tobytes()).decode("ascii")


def library() -> tuple[str, str]:
    """The script and the style of uPlot, its licence in front of the script."""
    names = ("LICENSE", "uPlot.iife.min.js", "uPlot.min.css")
    licence, script, style = ((UPLOT / name).read_text(encoding="utf-8") for name in names)
    return f"/*! uPlot 1.6.32\n{licence.strip()}\n*/\n{script}", style


BINS = 250
COLOURS = ("blue", "orange", "green", "purple", "ochre", "red", "ink")


def in_turn(curves: Iterable[tuple[str, Array]]) -> tuple[Series, ...]:
    """Curves by their names, each in the next colour, dashed when all were used."""
    return tuple(Series(*one, COLOURS[i % len(COLOURS)], i >= len(COLOURS)) for i, one in enumerate(curves))


def time_plot(name: str, time: Array, panels: Sequence[Panel], *, alt: str, caption: Text) -> Plot:
    """A plot over time of as few instants as keep every peak of every curve. ``time``, shape (p,) [s]."""
    curves = [series.values for panel in panels for series in panel.series]
    kept = instants(curves, time.size)
    thin = tuple(
        replace(panel, series=tuple(replace(s, values=s.values[kept]) for s in panel.series))
        for panel in panels
    )
    return Plot(name=name, alt=alt, caption=caption, points=time[kept], along="time", unit="s", panels=thin)


def instants(curves: Sequence[Array], count: int, bins: int = BINS) -> NDArray[np.intp]:
    """Which of ``count`` instants to show: both ends, and in each bin the extremes of each curve."""
    if count <= 2 * bins:
        return np.arange(count)
    kept = {0, count - 1}
    for first, last in pairwise(np.linspace(0, count, bins + 1).astype(int)):
        for curve in curves:
            part = curve[first:last]
            kept |= {first + int(np.argmin(part)), first + int(np.argmax(part))}
    return np.array(sorted(kept))
