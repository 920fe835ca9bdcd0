"""From chapters to one page of HTML that needs no other file and no network."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from itertools import count

import jinja2
from markupsafe import Markup

from cabledrive.report import formula
from cabledrive.report.blocks import Block, Chapter, Figure, Table
from cabledrive.report.numbers import unit_name
from cabledrive.report.provenance import Provenance
from cabledrive.report.style import theme_css
from cabledrive.report.typesetting import typeset

_TEMPLATES = resources.files("cabledrive.report") / "templates"


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """All that stands on the page.

    Attributes
    ----------
    title, subtitle : str
    chapters : tuple of Chapter
    provenance : Provenance
    """

    title: str
    subtitle: str
    chapters: tuple[Chapter, ...]
    provenance: Provenance

    @property
    def headlines(self) -> tuple[tuple[str, str, str], ...]:
        """Anchor, title and finding of every chapter that states one."""
        return tuple((c.anchor, c.title, c.headline) for c in self.chapters if c.headline)


def render(page: Page) -> str:
    """Set a page.

    Returns HTML, the same for the same page.
    Raises `ValueError` if two places of the page have the same name.
    """
    _check_anchors(page.chapters)
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(_template),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals |= {"math": formula.block, "unit_name": unit_name}
    environment.filters["identity"] = id
    numbers = _numbered([block for chapter in page.chapters for block in chapter.all_blocks])
    css = Markup(theme_css() + _template("report.css"))
    script = Markup(_template("looking.js"))
    html = environment.get_template("page.html").render(page=page, css=css, script=script, numbers=numbers)
    return typeset(html)


def _template(name: str) -> str:
    return (_TEMPLATES / name).read_text(encoding="utf-8")


def _numbered(blocks: Sequence[Block]) -> dict[int, int]:
    """Running numbers of figures and tables, each kind for itself, by the identity of the block."""
    figures, tables = count(1), count(1)
    numbers = {}
    for block in blocks:
        if isinstance(block, Figure):
            numbers[id(block)] = next(figures)
        elif isinstance(block, Table):
            numbers[id(block)] = next(tables)
    return numbers


def _check_anchors(chapters: Sequence[Chapter]) -> None:
    names = [chapter.anchor for chapter in chapters]
    names += [section.anchor for chapter in chapters for section in chapter.sections]
    names += [block.name for chapter in chapters for block in chapter.all_blocks if isinstance(block, Figure)]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise ValueError(f"places of the page with the same name: {', '.join(sorted(twice))}")
