"""What an interrupted run goes on from: its folder, its point in time, running hashes of its records."""

import hashlib
import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from cabledrive.parameters.files import LOCK, sync_folder
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


BLOCK = 1 << 24  # bytes


class RecordsHash:
    """SHA-256 of rows and fields as they are appended.

    The digests of the last two record counts are kept: a commit that was called for by an interrupt may stand
    for fewer records than have been appended.
    """

    def __init__(self) -> None:
        self._hashes = [hashlib.sha256(), hashlib.sha256()]
        self._count = 0
        self._digests = {0: self._now()}

    def add(self, records: int, *content: bytes) -> None:
        """Count in records by their rows and their fields."""
        for running, part in zip(self._hashes, content, strict=True):
            running.update(part)
        self._count += records
        kept = dict(list(self._digests.items())[-1:])
        self._digests = kept | {self._count: self._now()}

    def at(self, records: int) -> list[str]:
        """Digests of rows and fields up to one of the last two numbers of records counted in."""
        return self._digests[records]

    def read(self, records: int, *parts: tuple[Path, int]) -> list[str]:
        """Digests of what lies in files already, counted in before anything else.

        ``*parts``: file of the rows and of the fields, and how many of its bytes belong to these records.
        `OSError` if a file is shorter, or cannot be read.
        """
        for running, (path, size) in zip(self._hashes, parts, strict=True):
            _hash_file(running, path, size)
        self._count = records
        self._digests = {records: self._now()}
        return self.at(records)

    def _now(self) -> list[str]:
        return [running.hexdigest() for running in self._hashes]


def _hash_file(running: Any, path: Path, size: int) -> None:
    left = size
    with path.open("rb") as file:
        while left > 0:
            part = file.read(min(left, BLOCK))
            if not part:
                raise OSError(f"{path.name} holds {size - left} of {size} bytes")
            running.update(part)
            left -= len(part)


ROWS, FIELDS, CHECKPOINT, SETTING = "rows.f64", "fields.f64", "checkpoint", "run.json"
RESULT, NEW = "result.nc", ".new"
MADE_HERE = {name + end for name in (ROWS, FIELDS, CHECKPOINT, SETTING, RESULT) for end in ("", NEW)}
MADE_HERE |= {"checkpoint.npz"}  # by version 0.1


def clear(folder: Path, names: list[str]) -> None:
    """Delete files `left_behind` so that what is left by a kill can be resumed: the setting last."""
    for name in sorted(names, key=lambda name: (name == SETTING, name != CHECKPOINT)):
        (folder / name).unlink()


def part_of(path: Path) -> Path:
    """Folder of a run in progress, from the path of the result."""
    return path.with_name(path.name + ".part")


def left_behind(folder: Path) -> list[str]:
    """Names of what an ended run left in its folder, if it is there."""
    return [name for name in os.listdir(folder) if name != LOCK] if folder.is_dir() else []


def open_at(path: Path, size: int) -> BinaryIO:
    """Open a file, made where it is absent, for appending after the first bytes, which are kept."""
    path.touch()
    file = path.open("r+b")
    file.truncate(size)
    file.seek(size)
    return file


def replace_whole(path: Path, content: bytes) -> None:
    """Write a file so that it is either the old one or the new one, on disk."""
    fresh = path.with_name(path.name + NEW)
    with fresh.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(fresh, path)
    sync_folder(path.parent)
