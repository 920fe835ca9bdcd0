"""The dissertation beside what is computed, on one page: verdicts first, then chapter by chapter."""

import re
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from markupsafe import Markup, escape

from cabledrive.answers.figures import number
from cabledrive.report.blocks import Block, Cell, Chapter, Paragraph, Section, Table, table
from cabledrive.report.page import page_of
from cabledrive.report.words import texts
from reproduction.items import DIFFERS, Entry, Item
from reproduction.panel import Panel, panels_figure
from reproduction.run import Reproduction, call_of

TITLES = {
    "2": "Chapter 2: dynamics",
    "3": "Chapter 3: modal analysis",
    "4": "Chapter 4: identification",
    "5": "Chapter 5: autoparametric resonance",
    "6": "Chapter 6: control",
    "7": "Chapter 7: conclusions",
    "A": "Appendix A: hardware",
}
ERRATA = Path(__file__).with_name("errata.md")
_PLACE = re.compile(r"reproduction/errata\.md#([\w-]+)")
_ERRATUM = re.compile(r"^\(([\w-]+)\)=\n#+ (.+)\n+((?:(?!^\(|^#).*\n?)*)", re.M)
say = texts("page", "reproduction")


def reproduction_html(found: Reproduction) -> str:
    """The reproduction as HTML that needs no other file."""
    counts = found.counts()
    return page_of(
        "The dissertation, item by item",
        say("subtitle", items=len(found.items)),
        (_summary(found, counts), *_chapters(found), *_errata(found)),
        (("sources of the package", found.source),),
    )


def _summary(found: Reproduction, counts: dict[str, int]) -> Chapter:
    fixed = found.counts(untested=True)
    words = tuple(say("verdict", name=one, count=n, fixed=fixed[one]) for one, n in counts.items())
    blocks: list[Block] = [Paragraph(text=say("intro"))]
    blocks.append(Paragraph(text=say("untested_note", inputs=found.inputs), items=words))
    if differs := [item for item in found.items if item.verdict == DIFFERS]:
        blocks.append(_items("What differs, and why.", differs))
    return Chapter(
        title="Verdict",
        anchor="verdict",
        headline=say("headline", items=len(found.items), counts=counts, untested=fixed),
        blocks=tuple(blocks),
        methods=(say("method", quick=found.quick),),
    )


def _chapters(found: Reproduction) -> list[Chapter]:
    made = []
    for name, group in groupby(found.outcomes, key=lambda one: one[0].chapter):
        entries = list(group)
        verdicts = [item.verdict for _, items, _ in entries for item in items]
        made.append(
            Chapter(
                title=TITLES[name],
                anchor=f"chapter-{name.lower()}",
                headline=say("chapter_headline", agree=verdicts.count("agrees"), items=len(verdicts)),
                blocks=(),
                sections=tuple(_section(*entry, found.quick) for entry in entries),
            )
        )
    return made


def _section(entry: Entry, items: tuple[Item, ...], panels: tuple[Panel, ...], quick: bool) -> Section:
    """Items, how to make them again on the command line and in Python, and the figures."""
    shell = f'python -m reproduction --only "{entry.covers[0]}"{" --quick" if quick else ""} -o DIR'
    words = Markup("Made by <code>{}</code>, in Python <code>{}</code>.")
    call = Paragraph(text=words.format(shell, call_of(entry, quick)))
    blocks: list[Block] = [_items("Printed beside computed.", items), call]
    for figure, group in groupby(panels, key=lambda panel: panel.figure):
        name = f"{entry.name}-{figure.lower().replace('. ', '-').replace('.', '-')}"
        blocks.append(panels_figure(name, tuple(group)))
    return Section(title=", ".join(entry.covers), anchor=entry.name, blocks=tuple(blocks))


def _items(caption: str, items: Sequence[Item]) -> Table:
    return table(caption, "Item | Verdict | Printed | Computed | Deviation [%] | Reason", map(_row, items))


def _row(item: Item) -> tuple[Cell, ...]:
    deviation = "" if item.deviation is None else number(round(100 * item.deviation, 9), 2)
    place = r'<a href="#errata-\1"><code>reproduction/errata.md#\1</code></a>'
    note = Markup(_PLACE.sub(place, str(escape(item.note))))
    printed, computed = (_value(value, item.unit) for value in (item.printed, item.computed))
    verdict = item.verdict if item.tested else f"{item.verdict} (cannot fail)"
    return (item.source, verdict, printed, computed, deviation, note)


def _value(value: float | str | None, unit: str) -> str:
    if isinstance(value, str):
        return value
    return "none" if value is None else f"{number(value)} {unit}".strip()


def errata_items() -> dict[str, tuple[str, tuple[Markup, ...]]]:
    """Title and lines of every item of the errata: what is printed, what is right, why, the test."""
    found = {}
    for anchor, title, body in _ERRATUM.findall(ERRATA.read_text(encoding="utf-8")):
        lines = tuple(_set(line) for line in re.split(r"^- ", body, flags=re.M) if line.strip())
        found[anchor] = (title.replace("$", "").replace("\\", ""), lines)
    return found


def _set(line: str) -> Markup:
    """A line of the errata; its formulas stay as they are written, set as code."""
    text = re.sub(r"\$\$?(.+?)\$\$?", lambda m: f"`{m[1].strip()}`", str(escape(" ".join(line.split()))))
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", text))


def _errata(found: Reproduction) -> tuple[Chapter, ...]:
    """The items of the errata that the page refers to."""
    known = errata_items()
    sections = []
    for anchor in dict.fromkeys(place[1] for item in found.items for place in _PLACE.finditer(item.note)):
        title, lines = known[anchor]
        where = Markup("<code>reproduction/errata.md#{}</code>").format(anchor)
        blocks = (Paragraph(text=where, items=lines),)
        sections.append(Section(title=title, anchor=f"errata-{anchor}", blocks=blocks))
    intro = (Paragraph(text=say("errata")),)
    made = Chapter(title="Errata", anchor="errata", blocks=intro, sections=tuple(sections))
    return (made,) if sections else ()
