"""Items of the errata for a page that refers to them, read from the pages of the documentation."""

import re
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup, escape

PAGES = ("reproduction/errata.md", "reproduction/errata_control.md")
_ITEM = re.compile(r"^\(([\w-]+)\)=\n#+ (.+)\n+((?:(?!^\(|^#).*\n?)*)", re.M)
_FORMULA = re.compile(r"\$\$?(.+?)\$\$?", re.S)
_CODE = re.compile(r"`([^`]+)`")


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrataItem:
    """One item.

    Attributes
    ----------
    page, anchor : str
        Where it stands, such as "reproduction/errata.md" and "erratum-3-14-length".
    title : str
    lines : tuple of Markup
        What is printed, what is right, why, and the test.
    """

    page: str
    anchor: str
    title: str
    lines: tuple[Markup, ...]

    @property
    def name(self) -> str:
        """Anchor on the page that refers to it."""
        return f"errata-{self.anchor}"


def errata_items() -> dict[tuple[str, str], ErrataItem]:
    """Every item of both pages.

    Returns by page and anchor.
    """
    found = {}
    for page in PAGES:
        for anchor, title, body in _ITEM.findall(_text(page)):
            lines = tuple(_set(line) for line in re.split(r"^- ", body, flags=re.M) if line.strip())
            found[page, anchor] = ErrataItem(page=page, anchor=anchor, title=_plain(title), lines=lines)
    return found


def _text(page: str) -> str:
    """A page of the documentation."""
    return (Path(__file__).parents[1] / page).read_text(encoding="utf-8")


def _set(line: str) -> Markup:
    """A line of the page; its formulas stay as they are written, set as code."""
    text = str(escape(" ".join(line.split())))
    text = _FORMULA.sub(lambda m: f"<code>{m[1].strip()}</code>", text)
    return Markup(_CODE.sub(lambda m: f"<code>{m[1]}</code>", text))


def _plain(title: str) -> str:
    return title.replace("$", "").replace("\\", "")
