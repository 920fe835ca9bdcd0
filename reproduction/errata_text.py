"""Items of the errata for a page that refers to them."""

import re
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup, escape

PAGE = Path(__file__).with_name("errata.md")
_ITEM = re.compile(r"^\(([\w-]+)\)=\n#+ (.+)\n+((?:(?!^\(|^#).*\n?)*)", re.M)
_FORMULA = re.compile(r"\$\$?(.+?)\$\$?", re.S)
_CODE = re.compile(r"`([^`]+)`")


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrataItem:
    """One item.

    Attributes
    ----------
    anchor : str
        Such as "erratum-3-14-length".
    title : str
    lines : tuple of Markup
        What is printed, what is right, why, and the test.
    """

    anchor: str
    title: str
    lines: tuple[Markup, ...]

    @property
    def name(self) -> str:
        """Anchor on the page that refers to it."""
        return f"errata-{self.anchor}"


def errata_items() -> dict[str, ErrataItem]:
    """Every item, by anchor."""
    found = {}
    for anchor, title, body in _ITEM.findall(PAGE.read_text(encoding="utf-8")):
        lines = tuple(_set(line) for line in re.split(r"^- ", body, flags=re.M) if line.strip())
        found[anchor] = ErrataItem(anchor=anchor, title=_plain(title), lines=lines)
    return found


def _set(line: str) -> Markup:
    """A line of the page; its formulas stay as they are written, set as code."""
    text = str(escape(" ".join(line.split())))
    text = _FORMULA.sub(lambda m: f"<code>{m[1].strip()}</code>", text)
    return Markup(_CODE.sub(lambda m: f"<code>{m[1]}</code>", text))


def _plain(title: str) -> str:
    return title.replace("$", "").replace("\\", "")
