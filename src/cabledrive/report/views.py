"""Pages inside a report: a card in the overview, and what opens behind it."""

from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from cabledrive.report.blocks import Block, Text

MACHINES, TOPICS = "machines", "topics"


@dataclass(frozen=True, slots=True, kw_only=True)
class Badge:
    """A verdict in a few words.

    Attributes
    ----------
    text : str
    tone : {"good", "warning", "remark"}
    """

    text: str
    tone: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Card:
    """What the overview shows of a page.

    Attributes
    ----------
    text : str or Markup
        One sentence.
    picture : Markup or None
        Inline SVG.
    badges : tuple of Badge
    facts : tuple of (str, str)
        What, and its value.
    """

    text: Text
    picture: Markup | None = None
    badges: tuple[Badge, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """A page inside the report.

    Attributes
    ----------
    anchor : str
        Unique in the file.
    title : str
    group : {"machines", "topics"}
    card : Card
    template : str
        Sets the page.
    content : Any
        What the template is given as ``it``.
    blocks : tuple of Block
        Its figures and tables in order, those beside one another included.
    methods : tuple of str
        How its numbers were computed.
    """

    anchor: str
    title: str
    group: str
    card: Card
    template: str
    content: Any
    blocks: tuple[Block, ...]
    methods: tuple[str, ...] = ()
