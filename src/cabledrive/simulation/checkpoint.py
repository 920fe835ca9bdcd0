"""The point from which an interrupted run goes on, as a file that is whole or not believed."""

import hashlib
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.simulation.plan import STEPS

_DIGEST = 64  # hexadecimal digits at the start of the file


class Damaged(ValueError):
    """A file of an interrupted run is not what was written."""


def checkpoint_bytes(state: Any, records: int, bound_to: str, hashes: list[str]) -> bytes:
    """Checkpoint after some records: their digests, and that of the settings it is bound to."""
    content: dict[str, Any] = {**state._asdict(), "records": np.int64(records)}
    content |= {"bound_to": np.array(bound_to), "hashes": np.array(hashes)}
    buffer = io.BytesIO()
    np.savez(buffer, **content)
    data = buffer.getvalue()
    return hashlib.sha256(data).hexdigest().encode() + data


def read_checkpoint(path: Path, like: Any, every: int, bound_to: str) -> tuple[Any, int, list[str]]:
    """State, records and digests of a checkpoint; ``like``: a state of the same run, for the shapes.

    ``every``: steps per record. `Damaged` if it is not what was written, or bound to other settings;
    `OSError` if it cannot be read.
    """
    digest, data = path.read_bytes()[:_DIGEST], path.read_bytes()[_DIGEST:]
    if hashlib.sha256(data).hexdigest().encode() != digest:
        raise Damaged(f"{path.name} is damaged")
    with np.load(io.BytesIO(data)) as saved:  # without pickles
        content = {name: saved[name] for name in saved.files}
    return _checked(path.name, content, like, every, bound_to)


def _checked(
    name: str, content: Mapping[str, Any], like: Any, every: int, bound_to: str
) -> tuple[Any, int, list[str]]:
    if set(content) != {*like._fields, "records", "bound_to", "hashes"}:
        raise Damaged(f"{name} holds other variables")
    if str(content["bound_to"]) != bound_to:
        raise Damaged(f"{name} belongs to a run with other settings")
    state = type(like)(*(content[field] for field in like._fields))
    if [(a.shape, a.dtype) for a in state] != [(a.shape, a.dtype) for a in like]:
        raise Damaged(f"{name} holds a state of another size")
    records = int(content["records"])
    if int(state.counts[STEPS]) != records * every:
        raise Damaged(f"{name} counts {int(state.counts[STEPS])} steps for {records} records")
    return state, records, [str(digest) for digest in content["hashes"]]
