"""A ledger of attacks: one line of JSON for every finished batch, added up over runs."""

import json
import os
from collections import Counter
from pathlib import Path

PLACE = Path(__file__).resolve().parents[2] / "build" / "attack.jsonl"


def note(kind: str, seed: int, outcomes: dict[str, int], place: Path = PLACE) -> None:
    """Add a batch: what was attacked, its seed, how many cases had which outcome. A seed counts once."""
    place.parent.mkdir(parents=True, exist_ok=True)
    line = json.dumps({"kind": kind, "seed": seed, "outcomes": dict(sorted(outcomes.items()))}) + "\n"
    file = os.open(place, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    try:
        os.write(file, line.encode())
    finally:
        os.close(file)


def totals(place: Path = PLACE) -> dict[str, Counter[str]]:
    """Cases by kind and outcome, over all batches; the last of those with one kind and seed counts."""
    if not place.exists():
        return {}
    batches = {}
    for line in place.read_text().splitlines():
        batch = json.loads(line)
        batches[batch["kind"], batch["seed"]] = batch["outcomes"]
    found: dict[str, Counter[str]] = {}
    for (kind, _), outcomes in batches.items():
        found.setdefault(kind, Counter()).update(outcomes)
    return found
