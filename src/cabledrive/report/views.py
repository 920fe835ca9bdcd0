"""Pages inside a report: a card in the overview, and what opens behind it."""

from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from cabledrive.report.blocks import Block, Text

MACHINES, TOPICS = "machines", "topics"


@dataclass(frozen=True, slots=True, kw_only=True)
class Badge:
    """A verdict in a few words."""

    text: str
    tone: str  # "good", "warning" or "remark"


@dataclass(frozen=True, slots=True, kw_only=True)
class Card:
    """What the overview shows of a page."""

    text: Text  # one sentence
    picture: Markup | None = None  # inline SVG
    badges: tuple[Badge, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()  # what, and its value


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """A page inside the report."""

    anchor: str  # unique in the file
    title: str
    group: str  # "machines" or "topics"
    card: Card
    template: str  # sets the page
    content: Any  # what the template is given as ``it``
    blocks: tuple[Block, ...]  # its figures and tables in order, those beside one another included
    methods: tuple[str, ...] = ()  # how its numbers were computed
