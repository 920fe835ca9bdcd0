"""The whole dissertation, entry by entry; what is finished is kept and not done again."""

import hashlib
import json
import re
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.files import intact_object, with_own_hash, write_whole
from cabledrive.parameters.version import __version__
from reproduction.items import AGREES, INPUT, VERDICTS, Entry, Item, entries
from reproduction.panel import Panel

BEYOND = ("report", "app")  # rooms that no number depends on


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Reproduction:
    """The dissertation beside what is computed."""

    outcomes: tuple[tuple[Entry, tuple[Item, ...], tuple[Panel, ...]], ...]  # in the order of the print
    quick: bool
    source: str  # hash of the package that computed it
    only: str | None = None  # the part that was asked for

    @property
    def items(self) -> tuple[Item, ...]:
        """Every item."""
        return tuple(item for _, items, _ in self.outcomes for item in items)

    def counts(self, *, untested: bool = False) -> dict[str, int]:
        """Items by verdict; ``untested``: those that test nothing computed, and so cannot fail."""
        found = Counter(item.verdict for item in self.items if not (untested and item.tested))
        return {verdict: found[verdict] for verdict in VERDICTS}

    @property
    def inputs(self) -> int:
        """How many of the items that agree are inputs: held as printed, not computed."""
        return sum(item.verdict == AGREES and INPUT in item.note for item in self.items)

    def plain(self) -> dict[str, Any]:
        """What results.json holds."""
        calls = ((call_of(entry, self.quick), made) for entry, _, made in self.outcomes)
        return {
            "items": [asdict(item) for item in self.items],
            "counts": self.counts(),
            "inputs": self.inputs,
            "cannot_fail": self.counts(untested=True),
            "figures": [asdict(one) | {"call": call} for call, made in calls for one in made],
            "quick": self.quick,
            "only": self.only,
            "provenance": {"cabledrive": __version__, "source_hash": self.source},
        }


def call_of(entry: Entry, quick: bool = False) -> str:
    """The call in Python that computes an entry, such as ``reproduction.chapter_5.contours(quick=False)``."""
    function = getattr(entry.compute, "func", entry.compute)
    given = ", ".join([*map(repr, getattr(entry.compute, "args", ())), f"quick={quick}"])
    return f"{function.__module__}.{function.__qualname__}({given})"


def chosen_entries(only: str | None = None) -> tuple[Entry, ...]:
    """Entries that have a text in what they cover, "Fig. 5.3", or in their name; all unless given.

    Raises `InputRefused` if no entry has it.
    """
    found, asked = entries(), (only or "")[:60]
    known = [name for entry in found for name in entry.covers]
    if only is not None:
        found = tuple(one for one in found if any(mentions(name, only) for name in (*one.covers, one.name)))
    if not found:
        raise InputRefused(
            f'--only "{asked}" is no part of the dissertation that is computed{nearest(asked, known)}'
        )
    return found


def mentions(text: str, only: str) -> bool:
    """Whether a text holds another as a whole: "Fig. 5.3" is in "Fig. 5.3, Fig. 5.4", not in "Fig. 5.30"."""
    wanted = re.escape(" ".join(only.split()))
    return bool(wanted) and re.search(rf"(?<![\w.]){wanted}(?!\w)", text, re.IGNORECASE) is not None


def reproduce(
    *,
    quick: bool,
    only: str | None = None,
    folder: Path | None = None,
    note: Callable[[str], None] = lambda line: None,
) -> Reproduction:
    """Compute every entry anew, or take it from the folder where it is finished there.

    ``quick``: fewer runs of the rig and a coarser loop; ``folder``: where finished entries are kept, by the
    hash of the package and the entry; ``note``: called with a line of text for each entry.
    """
    source, chosen = source_hash(), chosen_entries(only)
    outcomes = []
    for number, entry in enumerate(chosen, start=1):
        key = hashlib.sha256(f"{entry.name} {quick} {source}".encode()).hexdigest()
        place = None if folder is None else folder / f"{entry.name}-{key[:24]}.json"
        kept = None if place is None else intact_object(place)
        if kept is None or kept.get("key") != key:
            note(f"{number}/{len(chosen)} {', '.join(entry.covers)}")
            items, panels = entry.judged(quick)
            kept = {"items": [*map(asdict, items)], "panels": [*map(asdict, panels)], "key": key}
            if place is not None:
                place.parent.mkdir(parents=True, exist_ok=True)
                for stale in place.parent.glob(f"{entry.name}-{'[0-9a-f]' * 24}.json"):
                    stale.unlink()
                write_whole(place, json.dumps(with_own_hash(kept), allow_nan=False), force=True)
        found = tuple(Item(**item) for item in kept["items"]), tuple(Panel(**one) for one in kept["panels"])
        outcomes.append((entry, *_narrowed(entry, *found, only)))
    return Reproduction(outcomes=tuple(outcomes), quick=quick, source=source, only=only)


def _narrowed(
    entry: Entry, items: tuple[Item, ...], panels: tuple[Panel, ...], only: str | None
) -> tuple[tuple[Item, ...], tuple[Panel, ...]]:
    """Of an entry that covers several figures or tables, what belongs to the one asked for."""
    if only is None or all(mentions(name, only) for name in entry.covers):
        return items, panels
    few = tuple(item for item in items if mentions(item.source, only))
    drawn = tuple(panel for panel in panels if mentions(panel.figure, only))
    return (few, drawn) if few or drawn else (items, panels)


def source_hash() -> str:
    """Hash of the sources here and of the package, drive files included, but for those of report and door."""
    digest = hashlib.sha256()
    for root in (Path(str(resources.files("cabledrive"))), Path(__file__).parent):
        for path in sorted(path for path in root.rglob("*") if path.suffix in (".py", ".toml", ".txt")):
            name = path.relative_to(root)
            if name.parts[0] not in BEYOND:
                digest.update(name.as_posix().encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()
