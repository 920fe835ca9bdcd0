"""Items as data: the sheet of a chapter is read, and each of its rows judged by what a function has found.

Beside the functions of a chapter stands its sheet, `sheets/chapter_5.txt` for `chapter_5.py`. A line
``## name function: Fig. 5.4, Fig. 5.6`` begins an entry: `function` computes it and returns what it found, by
names, and panels of curves. The rows that follow are its items, their columns divided by ``|``:

- a number: id, source, the printed digits, unit, accuracy. It agrees inside the print's rounding or the
  accuracy stated: ``within 10``, ``within 1 %``, or as found.
- a claim: id, source; indented below, ``printed:`` and ``computed:`` have the words.

What is found under the id of an item, its hyphens underscores, is the number, or whether the claim holds.
Words may name what was found, ``{peak:.2f}``, a constant of the chapter, or one at the head of the sheet. The
reason where an item agrees stands under ``agrees:``; where it does not, under ``erratum:`` or ``differs:``,
which is the verdict then; ``not computable:`` is all there is to say. ``#erratum-...`` is a place of the
errata. The last column is ``input`` for a value that is held as printed, ``arithmetic`` for what tests
nothing but the print, or one of `REASONS`.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from reproduction.panel import Panel

AGREES, ERRATUM, DIFFERS, NOT_COMPUTABLE = "agrees", "erratum", "differs", "not computable"
VERDICTS = (AGREES, ERRATUM, DIFFERS, NOT_COMPUTABLE)
UNEXPLAINED, NOT_COMPARABLE = "not explained", "not comparable"
INSIDE = "inside the print's rounding"
INPUT = "a measured or chosen input: what the packaged drive holds"
REASONS = {
    "datum": "a datum of the manufacturer: nothing in the print gives it again",
    "price": "a price of 2015: nothing in the print gives it again",
    "setting": "a dimension or setting of the rig: nothing in the print gives it again",
}
CHAPTERS = ("chapter_2", "chapter_3", "chapter_4", "chapter_5", "chapter_6", "rig", "chapter_7", "appendix")

Found = dict[str, Any]
Outcome = tuple[Found, Sequence[Panel]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One printed number or claim, as the sheet has it."""

    id: str
    source: str
    printed: str  # digits of a number; empty where nothing is printed
    unit: str
    how: str  # accuracy, or why nothing is tested
    words: Mapping[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """Numbered tables or figures, or the numbers in the prose of a section, that belong together."""

    name: str  # unique, fit for a file name
    covers: tuple[str, ...]  # such as "Table 3.2", "Fig. 3.1", "Section 4.1"
    compute: "Callable[..., Outcome] | partial[Outcome]"  # takes whether the quick version is wanted
    rows: tuple[Row, ...]
    names: Mapping[str, Any]  # constants of the chapter, which the words of its items may name

    @property
    def chapter(self) -> str:
        """Chapter of the print, "A" for the appendix."""
        return self.covers[0].split()[1].partition(".")[0]

    def judged(self, quick: bool) -> "tuple[tuple[Item, ...], tuple[Panel, ...]]":
        """Every item with its verdict, and the curves."""
        found, panels = self.compute(quick)
        return tuple(judge(row, found, self.names) for row in self.rows), tuple(panels)


@dataclass(frozen=True, slots=True, kw_only=True)
class Item:
    """One printed number or claim beside what is computed."""

    id: str
    source: str
    printed: float | str | None
    computed: float | str | None  # words for a claim
    unit: str
    deviation: float | None  # computed over printed, minus one
    verdict: str  # one of VERDICTS
    note: str  # the reason, with the place in the errata
    tested: bool  # whether the verdict tests a figure that this package computes; else it cannot fail


def judge(row: Row, found: Found, names: Mapping[str, Any] | None = None) -> Item:
    """An item, its verdict by what was found under its id: a number, (number, accuracy), True or False."""
    known = {**(names or {}), **found}
    value: Any = found.get(row.id.replace("-", "_"))
    value, accuracy = value if isinstance(value, tuple) else (value, 0.0)

    def say(key: str, otherwise: str = "") -> str:
        said = row.words.get(key, otherwise).format_map(known)
        return re.sub(r"#(?=[a-z]+-)", "reproduction/errata.md#", said)

    claim, failed = "computed" in row.words, ERRATUM if ERRATUM in row.words else DIFFERS
    printed, computed = say("printed") or _number(row.printed), say("computed") or None
    deviation = None
    if "not computable" in row.words or row.how in REASONS:
        verdict, note = NOT_COMPUTABLE, say("not computable") or REASONS[row.how]
    elif value is None and (not claim or AGREES in row.words or failed == DIFFERS):
        raise KeyError(row.id)  # nothing was found for what is more than a word in the errata
    elif claim:
        verdict, note = (AGREES, say("agrees", "the claim holds")) if value else (failed, "")
    else:
        half = 0.5 * last_place(row.printed)
        if stated := re.search(r"within (\S+)( %)?", row.how):
            accuracy = float(stated[1]) * (0.01 * abs(float(row.printed)) if stated[2] else 1.0)
        good = abs(value - float(row.printed)) <= max(half, accuracy) * (1 + 1e-9)
        close = f"inside {accuracy:.3g} {row.unit}".strip() if accuracy > half else INSIDE
        reasons = [close, *filter(None, (INPUT if row.how == "input" else "", say("agrees")))]
        verdict, note = (AGREES, "; ".join(reasons)) if good else (failed, "")
    size = None if value is None or claim else float(value)
    if size is not None and isinstance(printed, float) and printed:
        deviation = size / printed - 1.0
    return Item(
        id=row.id,
        source=row.source.format_map(known),
        printed=printed,
        computed=computed if size is None else size,
        unit=row.unit,
        deviation=deviation,
        verdict=verdict,
        note=note or say(failed, UNEXPLAINED),
        tested=value is not None and verdict != NOT_COMPUTABLE and not re.match("input|arithmetic", row.how),
    )


def last_place(printed: str) -> float:
    """Value of the last printed digit, of such as "0.0011", "7.316e-6" or "1000"."""
    mantissa, _, exponent = printed.lower().partition("e")
    return float(10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2])))


def _number(printed: str) -> float | str | None:
    try:
        return float(printed)
    except ValueError:
        return printed or None


def entries() -> tuple[Entry, ...]:
    """All entries, in the order of the print."""
    return tuple(entry for name in CHAPTERS for entry in entries_of(name))


def entries_of(chapter: str) -> tuple[Entry, ...]:
    """Entries of one chapter's sheet."""
    home = vars(import_module(f"{__package__}.{chapter}"))
    sheet = Path(__file__).with_name("sheets") / f"{chapter}.txt"
    constants, *blocks = re.split(r"^## ", sheet.read_text(encoding="utf-8"), flags=re.M)
    names = {key: value for key, value in home.items() if key.isupper()}
    names |= dict(re.findall(r"^([A-Z_]+) = (.+)$", constants, re.M))
    found = []
    for block in blocks:
        head, *rows = re.split(r"\n(?=\S)", block.strip())
        name, function, argument, covers = re.fullmatch(r"(\S+) (\w+)(?:\((.+)\))?: (.+)", head).groups()  # type: ignore[union-attr]
        compute = partial(home[function], argument) if argument else home[function]
        covered = tuple(covers.split(", "))
        found.append(Entry(name=name, covers=covered, compute=compute, rows=(*map(_row, rows),), names=names))
    return tuple(found)


def _row(text: str) -> Row:
    """A row: its columns, then its words, one key a line; lines indented deeper go on with the one above."""
    head, *lines = (" ".join(part.split()) for part in re.split(r"\n {2}(?=\S)", text))
    words = dict(line.split(": ", 1) for line in lines)
    name, source, *rest = (column.strip() for column in head.split("|"))
    printed, unit, how, *_ = [*rest, "", "", ""]
    if "printed" in words:  # a claim, which may have one more column
        printed, unit, how = "", "", printed
    return Row(id=name, source=source, printed=printed, unit=unit, how=how, words=words)
