"""Where the records of a run go: into memory, or into files that survive whatever ends the process."""

import io
import json
import os
import shutil
from abc import ABC, abstractmethod
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation.case import Case
from cabledrive.simulation.state import State

Shapes = tuple[tuple[int, ...], tuple[int, ...]]

MOST_MEMORY = 4_000_000_000  # bytes
ROWS, FIELDS, CHECKPOINT, SETTING = "rows.f64", "fields.f64", "checkpoint.npz", "run.json"


class Records(ABC):
    """Rows and fields of a run as they come in."""

    def append(self, rows: Array, fields: Array) -> None:
        """Add records.

        Parameters
        ----------
        rows : ndarray, shape (n, columns)
        fields : ndarray, shape (m, 3, nodes)
        """
        self._append(rows, fields)

    def commit(self, state: State, records: int) -> None:
        """Make what was added so far the point from which a run can be resumed.

        Parameters
        ----------
        state : State
            After the last step.
        records : int
            Records up to there.
        """
        self._commit(state, records)

    def arrays(self) -> tuple[Array, Array]:
        """All rows and all fields.

        Returns
        -------
        rows : ndarray, shape (records, columns)
        fields : ndarray, shape (field records, 3, nodes)
        """
        return self._arrays()

    @abstractmethod
    def _append(self, rows: Array, fields: Array) -> None: ...

    @abstractmethod
    def _commit(self, state: State, records: int) -> None: ...

    @abstractmethod
    def _arrays(self) -> tuple[Array, Array]: ...


class RecordsInMemory(Records):
    """Records kept in memory."""

    def __init__(self, case: Case) -> None:
        size = 8 * ((case.grid.records + 1) * case.width + case.field_records * 3 * case.mesh.nodes)
        if size > MOST_MEMORY:
            raise InputRefused(
                f"the records of this run take {size / 1e9:.1f} GB, at most {MOST_MEMORY / 1e9:.0f} GB are "
                "kept in memory: lower rate or fields, or write to a file with output"
            )
        self._rows: list[Array] = []
        self._fields: list[Array] = []
        self._shapes: Shapes = (0, case.width), (0, 3, case.mesh.nodes)

    def _append(self, rows: Array, fields: Array) -> None:
        self._rows.append(rows.copy())
        self._fields.append(fields.copy())

    def _commit(self, state: State, records: int) -> None:
        pass  # what is in memory ends with the process

    def _arrays(self) -> tuple[Array, Array]:
        rows, fields = self._shapes
        return (
            np.concatenate([np.zeros(rows), *self._rows]),
            np.concatenate([np.zeros(fields), *self._fields]),
        )


class RecordsInFolder(Records):
    """Records appended to plain files in a folder, with a checkpoint that always fits to what lies there.

    The checkpoint is replaced as a whole after the records it stands for have reached the disk. What lies
    behind it (a process was killed in between) is cut off on resuming.
    """

    def __init__(self, folder: Path, case: Case, *, resume: bool) -> None:
        self.folder = folder
        self._row_size, self._field_size = 8 * case.width, 8 * 3 * case.mesh.nodes
        self._shapes: Shapes = (case.width,), (3, case.mesh.nodes)
        self.resumed: tuple[State, int] | None = None
        if resume and folder.exists():
            self._check_setting(case)
            self.resumed = self._load(case)
        else:
            _check_room(folder.parent, case)
            self._make(case)
        done = self.resumed[1] if self.resumed else 0
        kept = -(-done // case.recording.fields) if case.recording.fields else 0
        self._rows = _open_at(folder / ROWS, done * self._row_size)
        self._fields = _open_at(folder / FIELDS, kept * self._field_size)

    def _make(self, case: Case) -> None:
        if self.folder.exists():
            shutil.rmtree(self.folder)
        self.folder.mkdir()
        _replace(self.folder / SETTING, json.dumps(case.fingerprint, indent=1).encode())

    def _check_setting(self, case: Case) -> None:
        try:
            before = json.loads((self.folder / SETTING).read_text())
        except (OSError, ValueError) as error:
            raise InputRefused(
                f"{self.folder}: cannot be resumed ({error}): start again without it"
            ) from None
        differing = [key for key, value in case.fingerprint.items() if before.get(key) != value]
        if differing:
            raise InputRefused(
                f"{self.folder}: holds a run with another {differing[0]}: resume it with the same settings, "
                "or start anew with force"
            )

    def _load(self, case: Case) -> tuple[State, int] | None:
        try:
            with np.load(self.folder / CHECKPOINT) as saved:
                content = {name: saved[name] for name in saved.files}
        except FileNotFoundError:
            return None  # killed before its first checkpoint: begin at the beginning
        except (OSError, ValueError) as error:
            raise InputRefused(
                f"{self.folder}: cannot be resumed ({error}): start again without it"
            ) from None
        records = int(content.pop("records"))
        return State(**content), records

    def _append(self, rows: Array, fields: Array) -> None:
        self._rows.write(rows.tobytes())
        self._fields.write(fields.tobytes())

    def _commit(self, state: State, records: int) -> None:
        for file in (self._rows, self._fields):
            file.flush()
            os.fsync(file.fileno())
        buffer = io.BytesIO()
        content: dict[str, Any] = {**state._asdict(), "records": np.int64(records)}
        np.savez(buffer, **content)
        _replace(self.folder / CHECKPOINT, buffer.getvalue())

    def _arrays(self) -> tuple[Array, Array]:
        for file in (self._rows, self._fields):
            with suppress(OSError):
                file.flush()
        rows, fields = (
            _mapped(self.folder / name, shape)
            for name, shape in zip((ROWS, FIELDS), self._shapes, strict=True)
        )
        return rows, fields

    def close(self) -> None:
        """Close the files; whatever cannot be written any more is left to the checkpoint."""
        for file in (self._rows, self._fields):
            with suppress(OSError):
                file.close()

    def remove(self) -> None:
        """Delete the folder, once its content is in the result."""
        self.close()
        shutil.rmtree(self.folder)


def _check_room(folder: Path, case: Case) -> None:
    """Refuse records that the disk does not hold, once as they come in and once as the result."""
    rows = 8 * (case.grid.records + 1) * case.width
    size = 2 * (rows + 8 * case.field_records * 3 * case.mesh.nodes)
    free = shutil.disk_usage(folder).free
    if size > free:
        raise InputRefused(
            f"the records of this run take {size / 1e9:.3g} GB, {free / 1e9:.3g} GB are free in {folder}: "
            "lower rate or fields, shorten the run, or write to a larger disk"
        )


def _open_at(path: Path, size: int) -> io.BufferedRandom:
    """Open a file for appending after its first bytes."""
    path.touch()
    file = path.open("r+b")
    file.truncate(size)
    file.seek(size)
    return file


def _mapped(path: Path, shape: tuple[int, ...]) -> Array:
    """Content of a file as an array of whole records, read as it is looked at."""
    size = int(np.prod(shape))
    whole = path.stat().st_size // (8 * size)
    if whole == 0:
        return np.zeros((0, *shape))
    return np.memmap(path, dtype=np.float64, mode="r", shape=(whole, *shape))


def _replace(path: Path, content: bytes) -> None:
    """Write a file so that it is either the old one or the new one, on disk."""
    fresh = path.with_suffix(path.suffix + ".new")
    with fresh.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(fresh, path)
