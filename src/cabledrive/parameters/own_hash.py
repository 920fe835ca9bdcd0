"""JSON objects that carry a hash of their own content, by which a changed or cut file is known."""

import hashlib
import json
from pathlib import Path
from typing import Any

OWN_HASH = "sha256"


def with_own_hash(data: dict[str, Any]) -> dict[str, Any]:
    """An object of JSON, numbers finite, with the hash of its content under `OWN_HASH` at the end."""
    content = {key: value for key, value in data.items() if key != OWN_HASH}
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return content | {OWN_HASH: hashlib.sha256(canonical.encode()).hexdigest()}


def intact_object(path: Path) -> dict[str, Any] | None:
    """The object of a file from `with_own_hash`; None where it is absent or does not agree with its hash."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    if not isinstance(data, dict) or OWN_HASH not in data:
        return None
    return data if with_own_hash(data)[OWN_HASH] == data[OWN_HASH] else None
