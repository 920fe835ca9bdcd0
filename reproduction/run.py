"""The whole dissertation, entry by entry; what is finished is kept and not done again."""

import hashlib
import json
import re
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module, resources
from pathlib import Path
from typing import Any

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.files import intact_object, with_own_hash, write_whole
from cabledrive.parameters.version import __version__
from reproduction.item import AGREES, VERDICTS, Entry, Item, Outcome
from reproduction.judge import INPUT
from reproduction.panel import panel_of
from reproduction.registry import entries

SUFFIXES = (".py", ".toml")
BEYOND = ("report", "app")
"""Rooms that no number depends on."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Reproduction:
    """The dissertation beside what is computed.

    Attributes
    ----------
    outcomes : tuple of (Entry, Outcome)
        In the order of the print.
    seconds : tuple of float
        What each took when it was computed.
    quick : bool
    source : str
        Hash of the package that computed it.
    only : str or None, default None
        The part that was asked for.
    """

    outcomes: tuple[tuple[Entry, Outcome], ...]
    seconds: tuple[float, ...]
    quick: bool
    source: str
    only: str | None = None

    @property
    def items(self) -> tuple[Item, ...]:
        """Every item."""
        return tuple(item for _, outcome in self.outcomes for item in outcome.items)

    @property
    def counts(self) -> dict[str, int]:
        """Number of items by verdict."""
        found = Counter(item.verdict for item in self.items)
        return {verdict: found[verdict] for verdict in VERDICTS}

    @property
    def inputs(self) -> int:
        """How many of the items that agree are inputs: held as printed, not computed."""
        return sum(item.verdict == AGREES and INPUT in item.note for item in self.items)

    @property
    def untested(self) -> dict[str, int]:
        """Number of items by verdict that test nothing computed, and so cannot fail."""
        found = Counter(item.verdict for item in self.items if not item.tested)
        return {verdict: found[verdict] for verdict in VERDICTS}

    def plain(self) -> dict[str, Any]:
        """What results.json holds.

        Returns
        -------
        dict
        """
        return {
            "items": [item.plain() for item in self.items],
            "counts": self.counts,
            "inputs": self.inputs,
            "cannot_fail": self.untested,
            "figures": [
                panel.plain() | {"call": call_of(entry, self.quick)}
                for entry, outcome in self.outcomes
                for panel in outcome.panels
            ],
            "quick": self.quick,
            **({"only": self.only} if self.only is not None else {}),
            "provenance": {"cabledrive": __version__, "source_hash": self.source},
        }


def call_of(entry: Entry, quick: bool = False) -> str:
    """The call in Python that computes an entry: items and the data of its figures.

    Returns such as ``reproduction.chapter_5_conditions.figure_5_3(quick=False)``.
    """
    made = entry.compute
    values: tuple[Any, ...] = getattr(made, "args", ())
    function = getattr(made, "func", made)
    given = ", ".join([*(_written(value) for value in values), f"quick={quick}"])
    return f"{function.__module__}.{function.__qualname__}({given})"


def _written(value: Any) -> str:
    """An argument as a reader would write it: text, or the object's name in its module."""
    if isinstance(value, str):
        return repr(value)
    home = import_module(type(value).__module__)
    for name, held in vars(home).items():
        if isinstance(held, tuple) and value in held:
            return f"{name}[{held.index(value)}]"
    return repr(value)


def chosen_entries(only: str | None = None) -> tuple[Entry, ...]:
    """Entries that a text asks for.

    ``only``: part of what an entry covers, "Fig. 5.3", "Table 3.2", "Section 6", or of its name; all unless
    given.
    Raises `InputRefused` if no entry has it.
    """
    every = entries()
    if only is None:
        return every
    found = tuple(
        entry for entry in every if any(mentions(name, only) for name in (*entry.covers, entry.name))
    )
    if not found:
        known = [name for entry in every for name in entry.covers]
        raise InputRefused(
            f'--only "{only[:60]}" is no part of the dissertation that is computed{nearest(only[:60], known)}'
        )
    return found


def mentions(text: str, only: str) -> bool:
    """Whether a text holds another as a whole: "Fig. 5.3" is in "Fig. 5.3, Fig. 5.4", not in "Fig. 5.30"."""
    wanted = re.escape(" ".join(only.split()))
    return bool(wanted) and re.search(rf"(?<![\w.]){wanted}(?!\w)", text, re.IGNORECASE) is not None


def _narrowed(entry: Entry, outcome: Outcome, only: str | None) -> Outcome:
    """Of an entry that covers several figures or tables, what belongs to the one asked for."""
    if only is None or sum(mentions(name, only) for name in entry.covers) == len(entry.covers):
        return outcome
    items = tuple(item for item in outcome.items if mentions(item.source, only))
    panels = tuple(panel for panel in outcome.panels if mentions(panel.figure, only))
    return Outcome(items=items, panels=panels) if items or panels else outcome


def reproduce(
    *,
    quick: bool,
    only: str | None = None,
    folder: Path | None = None,
    note: Callable[[str], None] = lambda line: None,
) -> Reproduction:
    """Compute every entry anew, or take it from the folder where it is finished there.

    Parameters
    ----------
    quick : bool
        Fewer runs of the rig and a coarser loop.
    only : str, optional
        The part that is wanted, see `chosen_entries`; all unless given.
    folder : Path, optional
        Where finished entries are kept, by the hash of the package and the entry.
    note : callable, optional
        Called with a line of text for each entry.

    Returns
    -------
    Reproduction

    Raises
    ------
    InputRefused
        If no entry has what `only` asks for.
    """
    source, all_entries = source_hash(), chosen_entries(only)
    outcomes, seconds = [], []
    for number, entry in enumerate(all_entries, start=1):
        key = _key(entry, quick, source)
        place = None if folder is None else folder / f"{entry.name}-{key[:24]}.json"
        kept = _kept(place, key)
        if kept is None:
            note(f"{number}/{len(all_entries)} {', '.join(entry.covers)}")
            began = time.perf_counter()
            kept = _plain(entry.compute(quick), time.perf_counter() - began)
            if place is not None:
                place.parent.mkdir(parents=True, exist_ok=True)
                for stale in place.parent.glob(f"{entry.name}-{'[0-9a-f]' * 24}.json"):
                    stale.unlink()
                whole = with_own_hash(kept | {"key": key})
                write_whole(place, json.dumps(whole, allow_nan=False), force=True)
        outcomes.append((entry, _narrowed(entry, _revived(kept), only)))
        seconds.append(float(kept["seconds"]))
    return Reproduction(
        outcomes=tuple(outcomes), seconds=tuple(seconds), quick=quick, source=source, only=only
    )


def source_hash() -> str:
    """Hash of the sources here and of the package, drive files included, but for those of report and door.

    Returns 64 hexadecimal digits.
    """
    digest = hashlib.sha256()
    for root in (Path(str(resources.files("cabledrive"))), Path(__file__).parent):
        for path in sorted(path for path in root.rglob("*") if path.suffix in SUFFIXES):
            name = path.relative_to(root)
            if name.parts[0] not in BEYOND:
                digest.update(name.as_posix().encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()


def _key(entry: Entry, quick: bool, source: str) -> str:
    return hashlib.sha256(f"{entry.name} {quick} {source}".encode()).hexdigest()


def _kept(place: Path | None, key: str) -> dict[str, Any] | None:
    data = None if place is None else intact_object(place)
    return data if data is not None and data.get("key") == key else None


def _plain(outcome: Outcome, seconds: float) -> dict[str, Any]:
    data = {
        "seconds": round(seconds, 3),
        "items": [item.plain() for item in outcome.items],
        "panels": [panel.plain() for panel in outcome.panels],
    }
    plain: dict[str, Any] = json.loads(json.dumps(data, allow_nan=False))
    return plain


def _revived(data: dict[str, Any]) -> Outcome:
    return Outcome(
        items=tuple(Item(**item) for item in data["items"]),
        panels=tuple(panel_of(panel) for panel in data["panels"]),
    )
