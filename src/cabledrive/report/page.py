"""From chapters to one page of HTML that needs no other file and no network."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from importlib import resources
from itertools import count
from typing import Any

import jinja2
from markupsafe import Markup

from cabledrive.answers.figures import unit_name
from cabledrive.report.blocks import Block, Chapter, Figure, Plot, Table, Text, library, plot_json
from cabledrive.report.context import Provenance, provenance
from cabledrive.report.picture import theme_css
from cabledrive.report.typesetting import capital, typeset

MACHINES, TOPICS = "machines", "topics"


@dataclass(frozen=True, slots=True)
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


_TEMPLATES = resources.files("cabledrive.report") / "templates"


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """All that stands in the file: chapters in a row, or an overview of cards with a page behind each."""

    title: str
    subtitle: str
    chapters: tuple[Chapter, ...] = ()
    provenance: Provenance
    views: tuple[View, ...] = ()  # pages inside the file
    overview: Figure | None = None  # below the cards of the machines
    links: tuple[tuple[str, str], ...] = ()  # title and file of pages beside this one, shown as cards

    @property
    def headlines(self) -> tuple[tuple[str, str, str], ...]:
        """Anchor, title and finding of every chapter that states one."""
        return tuple((c.anchor, c.title, c.headline) for c in self.chapters if c.headline)

    @property
    def own_blocks(self) -> list[Block]:
        """Blocks outside the views."""
        first: list[Block] = [self.overview] if self.overview is not None else []
        return first + [block for chapter in self.chapters for block in chapter.all_blocks]


def page_of(
    title: str,
    subtitle: str,
    chapters: Iterable[Chapter],
    hashes: Iterable[tuple[str, str]] = (),
    written_at: datetime | None = None,
) -> str:
    """Chapters in a row as HTML that needs no other file; ``hashes``: name and hash of what it rests on."""
    made = tuple(chapters)
    methods = [method for chapter in made for method in chapter.methods]
    origin = provenance(hashes, methods, written_at)
    return render(Page(title=title, subtitle=subtitle, chapters=made, provenance=origin))


def render(page: Page) -> str:
    """Set a page as HTML, the same for the same page; `ValueError` if two places have the same name."""
    _check_anchors(page)
    environment = page_environment(_template)
    environment.filters |= {"capital": capital, "identity": id, "plot_json": plot_json}
    machines = [view for view in page.views if view.group == "machines"]
    alone = len(machines) == 1 and not page.links  # the page opens on the machine, not on a card
    every = [block for view in page.views for block in view.blocks]
    bodies = {
        view.anchor: Markup(
            environment.get_template(view.template).render(
                it=view.content, numbers=_numbered(every if alone else view.blocks)
            )
        )
        for view in page.views
    }
    css, script = theme_css() + _template("report.css"), _template("looking.js")
    if any(isinstance(block, Plot) for block in (*page.own_blocks, *every)):
        drawing, style = library()
        css, script = style + css, f"{drawing}\n{script}\n{_template('plots.js')}"
    if page.views:
        script += _template("views.js")
    html = environment.get_template("page.html").render(
        page=page,
        alone=alone,
        bodies=bodies,
        css=Markup(css),
        script=Markup(script),
        page_numbers=_numbered(page.own_blocks),
    )
    return typeset(html)


def page_environment(load: Callable[[str], str]) -> jinja2.Environment:
    """What sets templates of pages, which are loaded by name."""
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(load),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals["unit_name"] = unit_name
    return environment


def _template(name: str) -> str:
    return (_TEMPLATES / name).read_text(encoding="utf-8")


def _numbered(blocks: Sequence[Block]) -> dict[int, int]:
    """Running numbers of figures and tables, each kind for itself, by the identity of the block."""
    figures, tables = count(1), count(1)
    numbers = {}
    for block in blocks:
        if isinstance(block, Figure | Plot):
            numbers[id(block)] = next(figures)
        elif isinstance(block, Table):
            numbers[id(block)] = next(tables)
    return numbers


def _check_anchors(page: Page) -> None:
    blocks = [*page.own_blocks, *(block for view in page.views for block in view.blocks)]
    topics = [view.content for view in page.views if isinstance(view.content, Chapter)]
    names = [view.anchor for view in page.views] + [chapter.anchor for chapter in page.chapters]
    names += [section.anchor for chapter in (*page.chapters, *topics) for section in chapter.sections]
    names += [block.name for block in blocks if isinstance(block, Figure | Plot)]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise ValueError(f"places of the page with the same name: {', '.join(sorted(twice))}")
