"""What a chapter is made of: paragraphs, figures, tables, equations and notes, without a word of HTML."""

from dataclasses import dataclass
from typing import ClassVar

from markupsafe import Markup

from cabledrive.report.plot import Plot

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
    wide: Markup  # inline SVG for a page of ordinary width
    narrow: Markup | None = None  # inline SVG for a narrow page; None: the wide one scrolls inside its box
    switch: Markup | None = None  # before the drawings: starts and stops one that moves, its styles included

    def __post_init__(self) -> None:
        if not self.alt.strip():
            raise ValueError(f"figure {self.name} has no alt text: describe the picture")


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

    def __post_init__(self) -> None:
        for group in self.groups:
            for row in group.rows:
                if len(row) != len(self.columns):
                    raise ValueError(f"row {row} has {len(row)} cells, the table {len(self.columns)} columns")


@dataclass(frozen=True, slots=True, kw_only=True)
class Equation:
    """A displayed formula."""

    kind: ClassVar[str] = "equation"
    formula: Markup  # content of a MathML ``math`` element, see `cabledrive.report.formula`
    words: str  # the formula as it is read aloud
    number: str = ""  # number in the documentation, such as "3.13"


@dataclass(frozen=True, slots=True, kw_only=True)
class Details:
    """Longer text that opens on demand; printed in full."""

    kind: ClassVar[str] = "details"
    summary: str  # what it is about
    paragraphs: tuple[Text, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Beside:
    """Tables beside one another where the page is wide enough."""

    kind: ClassVar[str] = "beside"
    blocks: tuple[Table, ...]


Block = Paragraph | Note | Figure | Plot | Table | Equation | Details | Beside


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """A part of a chapter with its own entry in the table of contents."""

    title: str
    anchor: str  # unique on the page
    blocks: tuple[Block, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
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
        """Every block in order, those of the sections included, and those that stand beside one another."""
        blocks = (*self.blocks, *(block for section in self.sections for block in section.blocks))
        return tuple(
            part for block in blocks for part in (block.blocks if isinstance(block, Beside) else (block,))
        )
