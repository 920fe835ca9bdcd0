"""What a chapter is made of: paragraphs, figures, tables, equations and notes, without a word of HTML."""

from dataclasses import dataclass
from typing import ClassVar

from markupsafe import Markup

from cabledrive.report.plot import Plot

Text = str | Markup  # plain text is escaped by the page; markup is taken as it is
Cell = Text | float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Paragraph:
    """Running text.

    Attributes
    ----------
    text : str or Markup
    items : tuple of str or Markup, default ()
        Points of a list below it.
    """

    kind: ClassVar[str] = "paragraph"
    text: Text
    items: tuple[Text, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Note:
    """A remark set apart from the text.

    Attributes
    ----------
    text : str or Markup
    tone : {"remark", "warning", "good"}, default "remark"
        How it is set; its first words say the same without colour.
    """

    kind: ClassVar[str] = "note"
    text: Text
    tone: str = "remark"


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """A picture with its words.

    Attributes
    ----------
    name : str
        Anchor, unique on the page.
    alt : str
        What is seen, for whoever does not see it.
    caption : str or Markup
        What it says.
    wide : Markup
        Inline SVG for a page of ordinary width.
    narrow : Markup or None
        Inline SVG for a narrow page; None: the wide one scrolls inside its box.
    switch : Markup or None, default None
        Before the drawings, what starts and stops a drawing that moves, its styles included.
    """

    kind: ClassVar[str] = "figure"
    name: str
    alt: str
    caption: Text
    wide: Markup
    narrow: Markup | None = None
    switch: Markup | None = None

    def __post_init__(self) -> None:
        if not self.alt.strip():
            raise ValueError(f"figure {self.name} has no alt text: describe the picture")


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """Head of a column.

    Attributes
    ----------
    title : str or Markup
    unit : str, default ""
        Unit of the numbers below.
    numeric : bool, default False
        Whether it is set flush right, in figures of equal width.
    bar : bool, default False
        Whether its cells are shares between 0 and 1, shown in per cent with a bar behind them.
    """

    title: Text
    unit: str = ""
    numeric: bool = False
    bar: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class RowGroup:
    """Rows under a heading of their own.

    Attributes
    ----------
    title : str
        Heading; none where empty.
    rows : tuple of tuple
        One tuple of cells per row, as long as the columns: text, markup, or a share.
    """

    title: str = ""
    rows: tuple[tuple[Cell, ...], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table whose first column names the row.

    Attributes
    ----------
    caption : str or Markup
    columns : tuple of Column
    groups : tuple of RowGroup
    note : str or Markup
        What stands below it.
    """

    kind: ClassVar[str] = "table"
    caption: Text
    columns: tuple[Column, ...]
    groups: tuple[RowGroup, ...]
    note: Text = ""

    def __post_init__(self) -> None:
        for group in self.groups:
            for row in group.rows:
                if len(row) != len(self.columns):
                    raise ValueError(f"row {row} has {len(row)} cells, the table {len(self.columns)} columns")


@dataclass(frozen=True, slots=True, kw_only=True)
class Equation:
    """A displayed formula.

    Attributes
    ----------
    formula : Markup
        Content of a MathML ``math`` element, see `cabledrive.report.formula`.
    words : str
        The formula as it is read aloud.
    number : str, default ""
        Number in the documentation, such as "3.13".
    """

    kind: ClassVar[str] = "equation"
    formula: Markup
    words: str
    number: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Details:
    """Longer text that opens on demand; printed in full.

    Attributes
    ----------
    summary : str
        What it is about.
    paragraphs : tuple of str or Markup
    """

    kind: ClassVar[str] = "details"
    summary: str
    paragraphs: tuple[Text, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Beside:
    """Tables beside one another where the page is wide enough.

    Attributes
    ----------
    blocks : tuple of Table
    """

    kind: ClassVar[str] = "beside"
    blocks: tuple[Table, ...]


Block = Paragraph | Note | Figure | Plot | Table | Equation | Details | Beside


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """A part of a chapter with its own entry in the table of contents.

    Attributes
    ----------
    title : str
    anchor : str
        Unique on the page.
    blocks : tuple of Block
    """

    title: str
    anchor: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Chapter:
    """One chapter of the report.

    Attributes
    ----------
    title : str
    anchor : str
        Unique on the page.
    blocks : tuple of Block
        What stands before the sections.
    sections : tuple of Section, default ()
    methods : tuple of str, default ()
        How its numbers were computed, one sentence each, for the provenance at the end.
    headline : str, default ""
        What it found, in one sentence, for the top of the page.
    summary : str, default ""
        What it is about, in one sentence, for its card.
    """

    title: str
    anchor: str
    blocks: tuple[Block, ...]
    sections: tuple[Section, ...] = ()
    methods: tuple[str, ...] = ()
    headline: str = ""
    summary: str = ""

    @property
    def all_blocks(self) -> tuple[Block, ...]:
        """Every block in order, those of the sections included, and those that stand beside one another."""
        blocks = (*self.blocks, *(block for section in self.sections for block in section.blocks))
        return tuple(
            part for block in blocks for part in (block.blocks if isinstance(block, Beside) else (block,))
        )
