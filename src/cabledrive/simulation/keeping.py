"""Records of a run: in memory, or in a folder from which an interrupted run goes on to the same bytes."""

import hashlib
import io
import json
import os
import shutil
import zipfile
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.files import LOCK, sync_folder
from cabledrive.simulation.prepared import PreparedRun

MOST_MEMORY = 4_000_000_000  # bytes
DIGEST = 64  # hexadecimal digits at the start of a checkpoint
ROWS, FIELDS, CHECKPOINT, SETTING = "rows.f64", "fields.f64", "checkpoint", "run.json"
RESULT, NEW = "result.nc", ".new"
MADE_HERE = {name + end for name in (ROWS, FIELDS, CHECKPOINT, SETTING, RESULT) for end in ("", NEW)}


class Records:
    """Rows and fields of a run as they come in, kept in memory."""

    def __init__(self, case: PreparedRun) -> None:
        if (size := case.record_size) > MOST_MEMORY:
            raise InputRefused(
                f"the records of this run take {size / 1e9:.1f} GB, at most {MOST_MEMORY / 1e9:.0f} GB are "
                "kept in memory: lower rate or fields, or write to a file with output"
            )
        self._rows, self._fields = [np.zeros((0, len(case.channels)))], [np.zeros((0, 3, case.nodes))]

    def append(self, rows: Array, fields: Array) -> None:
        """Add records: rows, (n, columns), and fields, (m, 3, nodes)."""
        self._rows.append(rows.copy())
        self._fields.append(fields.copy())

    def commit(self, state: Any, records: int) -> None:
        """Make the records so far, and the state after their last step, a point to resume the run from."""

    def arrays(self) -> tuple[Array, Array]:
        """All rows, (records, columns), and all fields, (field records, 3, nodes)."""
        return np.concatenate(self._rows), np.concatenate(self._fields)


class RecordsInFolder(Records):
    """Records appended to plain files in a folder, with a checkpoint that always fits to what lies there.

    The checkpoint is replaced as a whole after the records it stands for have reached the disk. What lies
    behind them (a process was killed in between) is cut off on resuming; where less lies there, the run is
    not resumed. The folder is held by this process alone.
    """

    def __init__(self, folder: Path, case: PreparedRun, *, resume: bool) -> None:
        self.folder = folder
        self._shapes: tuple[tuple[int, ...], ...] = (len(case.channels),), (3, case.nodes)
        self._every = case.recording.fields
        self.resumed: tuple[Any, int] | None = None
        left = left_behind(folder)
        if resume and set(left) - {SETTING + NEW}:  # else killed before it had begun
            self.resumed = self._load(case)
        else:
            # once as they come in and once as the result
            size, free = 2 * case.record_size, shutil.disk_usage(folder.parent).free
            if size > free:
                raise InputRefused(
                    f"the records of this run take {size / 1e9:.3g} GB, {free / 1e9:.3g} GB are free in "
                    f"{folder.parent}: lower rate or fields, shorten the run, or write to a larger disk"
                )
            foreign = sorted(set(left) - MADE_HERE)
            if foreign:
                raise InputRefused(f"{folder}: holds {foreign[0]}, which is no run's: move it elsewhere")
            _clear(folder, left)
            _replace_whole(folder / SETTING, json.dumps(case.fingerprint, indent=1).encode())
        sizes = self._sizes(self.resumed[1] if self.resumed else 0)
        self.files: list[BinaryIO] = []
        for name, size in zip((ROWS, FIELDS), sizes, strict=True):
            self.files.append((folder / name).open("ab"))
            self.files[-1].truncate(size)

    def _sizes(self, records: int) -> tuple[int, int]:
        """Bytes of rows and of fields that belong to a number of records."""
        row, field = (8 * int(np.prod(shape)) for shape in self._shapes)
        return records * row, (-(-records // self._every) if self._every else 0) * field

    def _load(self, case: PreparedRun) -> tuple[Any, int] | None:
        """State and records of the checkpoint, once its settings and its records have been compared."""
        try:
            before = dict(json.loads((self.folder / SETTING).read_text(encoding="utf-8")))
            for key, value in case.fingerprint.items():
                if before.get(key) != value:
                    said = f"{self.folder}: holds a run with another {key}"
                    raise InputRefused(f"{said}: resume it with the same settings, or start anew with force")
            if not (self.folder / CHECKPOINT).exists():
                return None  # killed before its first checkpoint: begin at the beginning
            content = (self.folder / CHECKPOINT).read_bytes()
            if hashlib.sha256(content[DIGEST:]).hexdigest().encode() != content[:DIGEST]:
                raise ValueError(f"{CHECKPOINT} is damaged")
            with np.load(io.BytesIO(content[DIGEST:])) as saved:
                state = type(first := case.first_state())(*(saved[name] for name in first._fields))
                records = int(saved["records"])
            for name, size in zip((ROWS, FIELDS), self._sizes(records), strict=True):
                if (self.folder / name).stat().st_size < size:
                    raise ValueError(f"{name} holds less than was written")
        except InputRefused:
            raise
        except (OSError, ValueError, TypeError, EOFError, RecursionError, zipfile.BadZipFile) as error:
            raise InputRefused(f"{self.folder}: cannot be resumed ({error}): start anew with force") from None
        return state, records

    def append(self, rows: Array, fields: Array) -> None:
        """As of records in memory; `OSError` if the disk refuses."""
        for file, added in zip(self.files, (rows, fields), strict=True):
            file.write(added.tobytes())

    def commit(self, state: Any, records: int) -> None:
        """As of records in memory; `OSError` if the disk refuses."""
        for file in self.files:
            file.flush()
            os.fsync(file.fileno())
        buffer = io.BytesIO()
        np.savez(buffer, **state._asdict(), records=records)
        data = buffer.getvalue()
        _replace_whole(self.folder / CHECKPOINT, hashlib.sha256(data).hexdigest().encode() + data)

    def arrays(self) -> tuple[Array, Array]:
        """As of records in memory, read as they are looked at."""
        found = []
        for file, name, shape in zip(self.files, (ROWS, FIELDS), self._shapes, strict=True):
            with suppress(OSError):
                file.flush()
            path = self.folder / name
            shape = (path.stat().st_size // (8 * int(np.prod(shape))), *shape)  # whole records
            found.append(np.memmap(path, np.float64, "r", shape=shape) if shape[0] else np.zeros(shape))
        return found[0], found[1]

    def close(self) -> None:
        """Close the files; whatever cannot be written any more is left to the checkpoint."""
        for file in self.files:
            with suppress(OSError):
                file.close()

    def remove(self) -> None:
        """Delete the folder's content, once it is in the result."""
        self.close()
        _clear(self.folder, left_behind(self.folder))


def part_of(path: Path) -> Path:
    """Folder of a run in progress, from the path of the result."""
    return path.with_name(path.name + ".part")


def left_behind(folder: Path) -> list[str]:
    """Names of what an ended run left in its folder, if it is there."""
    return [name for name in os.listdir(folder) if name != LOCK] if folder.is_dir() else []


def _clear(folder: Path, names: list[str]) -> None:
    """Delete files so that what is left by a kill can be resumed: the setting last."""
    for name in sorted(names, key=lambda name: (name == SETTING, name != CHECKPOINT)):
        (folder / name).unlink()


def _replace_whole(path: Path, content: bytes) -> None:
    """Write a file so that it is either the old one or the new one, on disk."""
    fresh = path.with_name(path.name + NEW)
    with fresh.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(fresh, path)
    sync_folder(path.parent)
