"""The whole dissertation, entry by entry; what is finished is kept and not done again."""

import hashlib
import json
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from cabledrive.parameters.files import write_whole
from cabledrive.parameters.version import __version__
from cabledrive.studies.reproduction.item import AGREES, VERDICTS, Entry, Item, Outcome
from cabledrive.studies.reproduction.judge import INPUT
from cabledrive.studies.reproduction.panel import panel_of
from cabledrive.studies.reproduction.registry import entries

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
    """

    outcomes: tuple[tuple[Entry, Outcome], ...]
    seconds: tuple[float, ...]
    quick: bool
    source: str

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
            "figures": [panel.plain() for _, outcome in self.outcomes for panel in outcome.panels],
            "quick": self.quick,
            "provenance": {"cabledrive": __version__, "source_hash": self.source},
        }


def reproduce(
    *, quick: bool, folder: Path | None = None, note: Callable[[str], None] = lambda line: None
) -> Reproduction:
    """Compute every entry anew, or take it from the folder where it is finished there.

    Parameters
    ----------
    quick : bool
        Fewer runs of the rig and a coarser loop.
    folder : Path, optional
        Where finished entries are kept, by the hash of the package and the entry.
    note : callable, optional
        Called with a line of text for each entry.

    Returns
    -------
    Reproduction
    """
    source, all_entries = source_hash(), entries()
    outcomes, seconds = [], []
    for number, entry in enumerate(all_entries, start=1):
        place = None if folder is None else folder / f"{entry.name}-{_key(entry, quick, source)[:24]}.json"
        kept = _kept(place)
        if kept is None:
            note(f"{number}/{len(all_entries)} {', '.join(entry.covers)}")
            began = time.perf_counter()
            kept = _plain(entry.compute(quick), time.perf_counter() - began)
            if place is not None:
                place.parent.mkdir(parents=True, exist_ok=True)
                for stale in place.parent.glob(f"{entry.name}-{'[0-9a-f]' * 24}.json"):
                    stale.unlink()
                write_whole(place, json.dumps(kept, allow_nan=False), force=True)
        outcomes.append((entry, _revived(kept)))
        seconds.append(float(kept["seconds"]))
    return Reproduction(outcomes=tuple(outcomes), seconds=tuple(seconds), quick=quick, source=source)


def source_hash() -> str:
    """Hash of every source and drive file of the package but for those of report and door.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    root = Path(str(resources.files("cabledrive")))
    digest = hashlib.sha256()
    for path in sorted(path for path in root.rglob("*") if path.suffix in SUFFIXES):
        name = path.relative_to(root)
        if name.parts[0] not in BEYOND:
            digest.update(name.as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()


def _key(entry: Entry, quick: bool, source: str) -> str:
    return hashlib.sha256(f"{entry.name} {quick} {source}".encode()).hexdigest()


def _kept(place: Path | None) -> dict[str, Any] | None:
    if place is None:
        return None
    try:
        data = json.loads(place.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return data if isinstance(data, dict) else None


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
