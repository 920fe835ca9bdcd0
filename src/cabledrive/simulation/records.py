"""What a run asks of what moves in it, and where its records go."""

import json
import os
import shutil
import zipfile
from abc import ABC, abstractmethod
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.simulation.case import Recording
from cabledrive.simulation.checkpoint import (
    CHECKPOINT,
    FIELDS,
    MADE_HERE,
    NEW,
    ROWS,
    SETTING,
    Damaged,
    RecordsHash,
    checkpoint_bytes,
    clear,
    left_behind,
    open_at,
    read_checkpoint,
    replace_whole,
)
from cabledrive.simulation.methods import TimeGrid


class Stepper(Protocol):
    """Takes the steps of one run. A state is a NamedTuple of arrays, with the steps done in ``counts``."""

    def chunk(self, state: Any, done: int, count: int) -> tuple[Array, Array, str | None]:
        """Steps of some records, into ``state``; ``done``: records before them.

        Returns rows, shape (n, width), whole fields, and why n is less than ``count``, if so.
        """
        ...

    def last(self, state: Any) -> tuple[Array, Array, str | None]:
        """The record at the end of the run; ``state`` keeps no more than extremes and events of it."""
        ...


class PreparedRun(Protocol):
    """A run that has not begun."""

    @property
    def grid(self) -> TimeGrid:
        """Steps and records."""
        ...

    @property
    def recording(self) -> Recording:
        """What is kept."""
        ...

    @property
    def width(self) -> int:
        """Numbers per record."""
        ...

    @property
    def nodes(self) -> int:
        """Nodes of all ropes."""
        ...

    @property
    def field_records(self) -> int:
        """Whole fields that are kept."""
        ...

    @property
    def fingerprint(self) -> dict[str, Any]:
        """What a resumed run must have in common with the interrupted one; plain data."""
        ...

    def first_state(self) -> Any:
        """State before the first step."""
        ...

    def stepper(self) -> Stepper:
        """What takes its steps."""
        ...


Shapes = tuple[tuple[int, ...], tuple[int, ...]]

MOST_MEMORY = 4_000_000_000  # bytes


class Records(ABC):
    """Rows and fields of a run as they come in."""

    def append(self, rows: Array, fields: Array) -> None:
        """Add records: rows, (n, columns), and fields, (m, 3, nodes)."""
        self._append(rows, fields)

    def commit(self, state: Any, records: int) -> None:
        """Make the records so far, and the state after their last step, a point to resume the run from."""
        self._commit(state, records)

    def arrays(self) -> tuple[Array, Array]:
        """All rows, (records, columns), and all fields, (field records, 3, nodes)."""
        return self._arrays()

    @abstractmethod
    def _append(self, rows: Array, fields: Array) -> None: ...

    @abstractmethod
    def _commit(self, state: Any, records: int) -> None: ...

    @abstractmethod
    def _arrays(self) -> tuple[Array, Array]: ...


class RecordsInMemory(Records):
    """Records kept in memory."""

    def __init__(self, case: PreparedRun) -> None:
        size = 8 * ((case.grid.records + 1) * case.width + case.field_records * 3 * case.nodes)
        if size > MOST_MEMORY:
            raise InputRefused(
                f"the records of this run take {size / 1e9:.1f} GB, at most {MOST_MEMORY / 1e9:.0f} GB are "
                "kept in memory: lower rate or fields, or write to a file with output"
            )
        self._rows: list[Array] = []
        self._fields: list[Array] = []
        self._shapes: Shapes = (0, case.width), (0, 3, case.nodes)

    def _append(self, rows: Array, fields: Array) -> None:
        self._rows.append(rows.copy())
        self._fields.append(fields.copy())

    def _commit(self, state: Any, records: int) -> None:
        pass  # what is in memory ends with the process

    def _arrays(self) -> tuple[Array, Array]:
        rows, fields = self._shapes
        return (
            np.concatenate([np.zeros(rows), *self._rows]),
            np.concatenate([np.zeros(fields), *self._fields]),
        )


class RecordsInFolder(Records):
    """Records appended to plain files in a folder, with a checkpoint that always fits to what lies there.

    The checkpoint is replaced as a whole after the records it stands for have reached the disk, and holds
    their hashes. What lies behind it (a process was killed in between) is cut off on resuming; where less
    lies there, or something else, the run is not resumed. The folder is held by this process alone
    (`cabledrive.parameters.files`).
    """

    def __init__(self, folder: Path, case: PreparedRun, *, resume: bool) -> None:
        self.folder = folder
        self._row_size, self._field_size = 8 * case.width, 8 * 3 * case.nodes
        self._shapes: Shapes = (case.width,), (3, case.nodes)
        self._every = case.recording.fields
        self._hash = RecordsHash()
        self._setting = sha256(_setting_of(case)).hexdigest()
        self.resumed: tuple[Any, int] | None = None
        left = left_behind(folder)
        if resume and set(left) - {SETTING + NEW}:  # else killed before it had begun
            self._check_setting(case)
            self.resumed = self._load(case)
        else:
            _check_room(folder.parent, case)
            self._make(case, left)
        rows, fields = self._sizes(self.resumed[1] if self.resumed else 0)
        self._rows = open_at(folder / ROWS, rows)
        self._fields = open_at(folder / FIELDS, fields)

    def _sizes(self, records: int) -> tuple[int, int]:
        """Bytes of rows and of fields that belong to a number of records."""
        kept = -(-records // self._every) if self._every else 0
        return records * self._row_size, kept * self._field_size

    def _make(self, case: PreparedRun, left: list[str]) -> None:
        foreign = sorted(set(left) - MADE_HERE)
        if foreign:
            raise InputRefused(f"{self.folder}: holds {foreign[0]}, which is no run's: move it elsewhere")
        clear(self.folder, left)
        replace_whole(self.folder / SETTING, _setting_of(case))

    def _check_setting(self, case: PreparedRun) -> None:
        try:
            before = json.loads((self.folder / SETTING).read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError) as error:
            raise self._not_resumed(error) from None
        if not isinstance(before, dict):
            raise self._not_resumed(f"{SETTING} holds no settings")
        differing = [key for key, value in case.fingerprint.items() if before.get(key) != value]
        if differing:
            raise InputRefused(
                f"{self.folder}: holds a run with another {differing[0]}: resume it with the same settings, "
                "or start anew with force"
            )

    def _load(self, case: PreparedRun) -> tuple[Any, int] | None:
        """State and records of the checkpoint, once the records it stands for have been read and compared."""
        try:
            state, records, hashes = read_checkpoint(
                self.folder / CHECKPOINT, case.first_state(), case.grid.every, self._setting
            )
            sizes = self._sizes(records)
            parts = zip((self.folder / ROWS, self.folder / FIELDS), sizes, strict=True)
            if self._hash.read(records, *parts) != hashes:
                raise Damaged("its records are not those that were written")
        except FileNotFoundError as error:
            if Path(error.filename or "").name == CHECKPOINT:
                return None  # killed before its first checkpoint: begin at the beginning
            raise self._not_resumed(error) from None
        except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
            raise self._not_resumed(error) from None
        return state, records

    def _not_resumed(self, why: object) -> InputRefused:
        return InputRefused(f"{self.folder}: cannot be resumed ({why}): start anew with force")

    def _append(self, rows: Array, fields: Array) -> None:
        content = rows.tobytes(), fields.tobytes()
        self._rows.write(content[0])
        self._fields.write(content[1])
        self._hash.add(len(rows), *content)

    def _commit(self, state: Any, records: int) -> None:
        for file in (self._rows, self._fields):
            file.flush()
            os.fsync(file.fileno())
        content = checkpoint_bytes(state, records, self._setting, self._hash.at(records))
        replace_whole(self.folder / CHECKPOINT, content)

    def _arrays(self) -> tuple[Array, Array]:
        for file in (self._rows, self._fields):
            with suppress(OSError):
                file.flush()
        rows, fields = (
            _mapped(self.folder / name, shape)
            for name, shape in zip((ROWS, FIELDS), self._shapes, strict=True)
        )
        return rows, fields

    def check(self, records: int) -> None:
        """Refuse, by `NotComputed`, files that hold other records than were appended, or a full disk."""
        try:
            for file in (self._rows, self._fields):
                file.flush()
        except OSError as error:
            raise NotComputed(
                f"{self.folder}: cannot be written ({error.strerror}): free space and resume"
            ) from None
        try:
            parts = zip((self.folder / ROWS, self.folder / FIELDS), self._sizes(records), strict=True)
            same = RecordsHash().read(records, *parts) == self._hash.at(records)
        except (OSError, KeyError) as error:
            raise self._not_kept(error) from None
        if not same:
            raise self._not_kept(f"not the {records} that were made")

    def _not_kept(self, why: object) -> NotComputed:
        return NotComputed(
            f"{self.folder}: its records were changed from outside ({why}): give the command again with force"
        )

    def close(self) -> None:
        """Close the files; whatever cannot be written any more is left to the checkpoint."""
        for file in (self._rows, self._fields):
            with suppress(OSError):
                file.close()

    def remove(self) -> None:
        """Delete the folder, once its content is in the result."""
        self.close()
        clear(self.folder, left_behind(self.folder))


def _setting_of(case: PreparedRun) -> bytes:
    return json.dumps(case.fingerprint, indent=1).encode()


def _check_room(folder: Path, case: PreparedRun) -> None:
    """Refuse records that the disk does not hold, once as they come in and once as the result."""
    rows = 8 * (case.grid.records + 1) * case.width
    size = 2 * (rows + 8 * case.field_records * 3 * case.nodes)
    free = shutil.disk_usage(folder).free
    if size > free:
        raise InputRefused(
            f"the records of this run take {size / 1e9:.3g} GB, {free / 1e9:.3g} GB are free in {folder}: "
            "lower rate or fields, shorten the run, or write to a larger disk"
        )


def _mapped(path: Path, shape: tuple[int, ...]) -> Array:
    """Content of a file as an array of whole records, read as it is looked at."""
    size = int(np.prod(shape))
    whole = path.stat().st_size // (8 * size)
    if whole == 0:
        return np.zeros((0, *shape))
    return np.memmap(path, dtype=np.float64, mode="r", shape=(whole, *shape))
