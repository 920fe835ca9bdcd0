"""The dissertation beside what is computed, on one page: verdicts first, then chapter by chapter."""

import platform
import re
from datetime import UTC, datetime
from importlib.metadata import version
from itertools import groupby

from markupsafe import Markup

from cabledrive.parameters.version import __version__
from cabledrive.report.blocks import Block, Cell, Chapter, Column, Paragraph, RowGroup, Section, Table
from cabledrive.report.context import Provenance
from cabledrive.report.page import Page, render
from cabledrive.report.typesetting import number
from cabledrive.report.wording import texts
from reproduction import Entry, Item, Outcome, Reproduction
from reproduction.errata_text import ErrataItem, errata_items
from reproduction.panel_figures import panels_figure
from reproduction.run import call_of

Known = dict[str, ErrataItem]

PACKAGES = ("numpy", "scipy", "numba", "matplotlib", "Jinja2")
TITLES = {
    "2": "Chapter 2: dynamics",
    "3": "Chapter 3: modal analysis",
    "4": "Chapter 4: identification",
    "5": "Chapter 5: autoparametric resonance",
    "6": "Chapter 6: control",
    "7": "Chapter 7: conclusions",
    "A": "Appendix A: hardware",
}
_PLACE = re.compile(r"reproduction/errata\.md#([\w-]+)")
say = texts("page", "reproduction")


def reproduction_html(found: Reproduction, written_at: datetime | None = None) -> str:
    """The reproduction as text.

    ``written_at``: time that the page states; now where it is not given.
    Returns HTML that needs no other file.
    """
    known = errata_items()
    chapters = (_summary(found), *_chapters(found, known), *_errata(found, known))
    return render(
        Page(
            title="The dissertation, item by item",
            subtitle=say("subtitle", items=len(found.items), counts=found.counts),
            chapters=chapters,
            provenance=Provenance(
                written_at=(written_at or datetime.now(UTC)).astimezone(UTC),
                versions=(
                    ("cabledrive", __version__),
                    ("Python", platform.python_version()),
                    *((name, version(name)) for name in PACKAGES),
                ),
                hashes=(("sources of the package", found.source),),
                methods=(say("method", quick=found.quick),),
            ),
        )
    )


def _summary(found: Reproduction) -> Chapter:
    fixed = found.untested
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (verdict, str(count), str(fixed[verdict]), say("verdict", name=verdict))
        for verdict, count in found.counts.items()
    )
    differs = [item for item in found.items if item.verdict == "differs"]
    blocks: list[Block] = [
        Table(
            caption="Verdicts.",
            columns=(
                Column(title="Verdict"),
                Column(title="Items", numeric=True),
                Column(title="of these cannot fail", numeric=True),
                Column(title="Meaning"),
            ),
            groups=(RowGroup(rows=rows),),
            note=say("untested_note", inputs=found.inputs),
        )
    ]
    if differs:
        blocks.append(_table("What differs, and why.", differs, errata_items()))
    return Chapter(
        title="Verdict",
        anchor="verdict",
        headline=say("headline", items=len(found.items), counts=found.counts, untested=fixed),
        blocks=(Paragraph(text=say("intro")), *blocks),
    )


def _chapters(found: Reproduction, known: Known) -> list[Chapter]:
    made = []
    for name, group in groupby(found.outcomes, key=lambda pair: pair[0].chapter):
        pairs = list(group)
        items = [item for _, outcome in pairs for item in outcome.items]
        agree = sum(item.verdict == "agrees" for item in items)
        made.append(
            Chapter(
                title=TITLES[name],
                anchor=f"chapter-{name.lower()}",
                headline=say("chapter_headline", agree=agree, items=len(items)),
                blocks=(),
                sections=tuple(_section(entry, outcome, known, found.quick) for entry, outcome in pairs),
            )
        )
    return made


def _section(entry: Entry, outcome: Outcome, known: Known, quick: bool) -> Section:
    blocks: list[Block] = [_table("Printed beside computed.", outcome.items, known), _call(entry, quick)]
    for figure, group in groupby(outcome.panels, key=lambda panel: panel.figure):
        name = f"{entry.name}-{figure.lower().replace('. ', '-').replace('.', '-')}"
        blocks.append(panels_figure(name, tuple(group)))
    return Section(title=", ".join(entry.covers), anchor=entry.name, blocks=tuple(blocks))


def _call(entry: Entry, quick: bool) -> Paragraph:
    """How to make it again: on the command line, and in Python."""
    shell = f'python -m reproduction --only "{entry.covers[0]}"{" --quick" if quick else ""} -o DIR'
    words = Markup("Made by <code>{}</code>, in Python <code>{}</code>.")
    return Paragraph(text=words.format(shell, call_of(entry, quick)))


def _errata(found: Reproduction, known: Known) -> tuple[Chapter, ...]:
    """The items of the errata that the page refers to."""
    named = dict.fromkeys(m[1] for item in found.items for m in _PLACE.finditer(item.note))
    sections = tuple(
        Section(title=known[place].title, anchor=known[place].name, blocks=(_lines(known[place]),))
        for place in named
        if place in known
    )
    if not sections:
        return ()
    intro = Paragraph(text=say("errata"))
    return (Chapter(title="Errata", anchor="errata", blocks=(intro,), sections=sections),)


def _lines(item: ErrataItem) -> Paragraph:
    where = Markup("<code>reproduction/errata.md#{}</code>").format(item.anchor)
    return Paragraph(text=where, items=item.lines)


def _table(caption: str, items: tuple[Item, ...] | list[Item], known: Known) -> Table:
    return Table(
        caption=caption,
        columns=(
            Column(title="Item"),
            Column(title="Verdict"),
            Column(title="Printed"),
            Column(title="Computed"),
            Column(title="Deviation", unit="%", numeric=True),
            Column(title="Reason"),
        ),
        groups=(RowGroup(rows=tuple(_row(item, known) for item in items)),),
    )


def _row(item: Item, known: Known) -> tuple[Cell, ...]:
    deviation = "" if item.deviation is None else number(round(100 * item.deviation, 9), 2)
    note = Markup(_PLACE.sub(lambda m: _link(m, known), str(Markup.escape(item.note))))
    printed, computed = (_value(value, item.unit) for value in (item.printed, item.computed))
    verdict = item.verdict if item.tested else f"{item.verdict} (cannot fail)"
    return (item.source, verdict, printed, computed, deviation, note)


def _link(place: re.Match[str], known: Known) -> str:
    """A place of the errata, linked to its item on this page where the page has it."""
    words = f"<code>{place[0]}</code>"
    item = known.get(place[1])
    return words if item is None else f'<a href="#{item.name}">{words}</a>'


def _value(value: float | str | None, unit: str) -> str:
    if value is None:
        return "none"
    if isinstance(value, str):
        return value
    return f"{number(value)} {unit}".strip()
