"""Logs that were dropped onto the page: streamed to disk, drawn by least and largest values."""

import re
import secrets
import shutil
import threading
from collections import OrderedDict
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import anyio
import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.logs.log import Table, name_and_unit, recognise
from cabledrive.identification.logs.reading import FORMATS, open_table
from cabledrive.parameters import InputRefused

BUCKET = 256
"""Rows of a bucket."""


@dataclass(frozen=True, slots=True, eq=False)
class Column:
    """A column: ``rows`` on disk, and of every bucket the least and the largest value."""

    rows: NDArray[Any]
    low: NDArray[Any]
    high: NDArray[Any]


class GrowingColumn:
    """A column that takes blocks of rows, kept on disk at ``path`` as numbers of one kind."""

    def __init__(self, path: Path, kind: type) -> None:
        self._path, self._kind = path, kind
        self._file = path.open("wb")
        self._rest: NDArray[Any] = np.empty(0, dtype=kind)
        self._parts: list[tuple[NDArray[Any], NDArray[Any]]] = []

    def add(self, values: NDArray[Any]) -> None:
        """Take the next rows."""
        with np.errstate(over="ignore"):  # beyond single precision: infinite, as the plot shows it
            kept: NDArray[Any] = np.ascontiguousarray(values, dtype=self._kind)
        self._file.write(kept.data)
        joined = np.concatenate((self._rest, kept)) if self._rest.size else kept
        whole = joined.size - joined.size % BUCKET
        self._parts.append(_buckets(joined[:whole]))
        self._rest = joined[whole:].copy()

    def finished(self) -> Column:
        """The column, when all rows are there."""
        self._file.close()
        if self._rest.size:
            self._parts.append(_buckets(self._rest, self._rest.size))
        low, high = (np.concatenate([part[k] for part in self._parts]) for k in (0, 1))
        return Column(np.memmap(self._path, dtype=self._kind, mode="r"), low, high)

    def close(self) -> None:
        """Take no more rows."""
        self._file.close()


def _buckets(values: NDArray[Any], size: int = BUCKET) -> tuple[NDArray[Any], NDArray[Any]]:
    """Least and largest value of each bucket; missing values do not count."""
    by = values.reshape(-1, size)
    low, high = by.min(axis=1), by.max(axis=1)
    holes = np.isnan(low)
    if holes.any():
        low[holes], high[holes] = np.fmin.reduce(by[holes], axis=1), np.fmax.reduce(by[holes], axis=1)
    return low, high


MOST_POINTS = 4000
MOST_ROWS = 1_000_000_000


class Curves:
    """Columns of one log, read once each and kept in a folder; without a column of time, rows count."""

    def __init__(self, table: Table, time: str | None, folder: Path) -> None:
        self.table, self.time = table, time
        self._folder = folder
        self._columns: dict[str, Column] = {}
        self._lock = threading.Lock()

    def window(
        self, names: tuple[str, ...], start: float | None, end: float | None, points: int
    ) -> dict[str, Any]:
        """Least and largest value of columns for each of some pixels from start to end, or the whole log.

        A column that is not there or cannot be read is refused.
        """
        for name in names:
            self.table.require(name)
        with self._lock:
            self._read(names)
        rows = self._columns[names[0]].rows.size
        first, last = self._bounds(rows, start, end)
        edges = np.unique(np.linspace(first, last, min(points, MOST_POINTS) + 1).astype(np.int64))
        edges = edges if edges.size > 1 else np.array([first, last])
        return {
            "rows": rows,
            "x": plain(self._time_at(edges[:-1])),
            "start": float(self._time_at(np.array([first]))[0]),
            "end": float(self._time_at(np.array([last - 1]))[0]),
            "series": [
                {"name": name, "low": plain(low), "high": plain(high)}
                for name in names
                for low, high in (_extremes(self._columns[name], edges),)
            ],
        }

    def _bounds(self, rows: int, start: float | None, end: float | None) -> tuple[int, int]:
        """First row and the row behind the last one; at least two rows."""
        if self.time is None:
            first = 0 if start is None else int(np.clip(start, 0, rows))
            last = rows if end is None else int(np.clip(end + 1, 0, rows))
        else:
            time = self._columns[self.time].rows
            first = 0 if start is None else int(np.searchsorted(time, start))
            last = rows if end is None else int(np.searchsorted(time, end, side="right"))
        first = min(first, max(rows - 2, 0))
        return first, min(max(last, first + 2), rows)

    def _time_at(self, places: NDArray[np.int64]) -> NDArray[np.float64]:
        if self.time is None:
            return places.astype(float)
        return np.asarray(self._columns[self.time].rows[places], dtype=float)

    def _read(self, names: tuple[str, ...]) -> None:
        """Read what is missing in one pass over the file."""
        wanted = dict.fromkeys((*([self.time] if self.time else []), *names))
        missing = tuple(name for name in wanted if name not in self._columns)
        if not missing:
            return
        self._folder.mkdir(exist_ok=True)
        number = len(self._columns)
        growing = {
            name: GrowingColumn(
                self._folder / f"{number + k}.bin", np.float64 if name == self.time else np.float32
            )
            for k, name in enumerate(missing)
        }
        try:
            self._grow(growing)
            self._columns |= {name: column.finished() for name, column in growing.items()}
        finally:
            for column in growing.values():
                column.close()
        if self.time in missing and not _ascends(self._columns[self.time].rows):
            self.time = None  # nothing can be found by a time that goes back: rows are counted

    def _grow(self, growing: dict[str, GrowingColumn]) -> None:
        """Read a block while the one before is kept: two threads, both outside the interpreter's lock."""
        size, kept = 0, None
        with ThreadPoolExecutor(1) as helper:
            for block in self.table.read(tuple(growing)):
                size += next(iter(block.values())).size
                if size > MOST_ROWS:
                    raise InputRefused(f"{self.table.source}: more than {MOST_ROWS} rows: cut the log")
                if kept is not None:
                    kept.result()
                kept = helper.submit(_keep, growing, block)
            if kept is not None:
                kept.result()
        if size == 0:
            raise InputRefused(f"{self.table.source}: holds no row of numbers: record it again")


def _keep(growing: dict[str, GrowingColumn], block: dict[str, NDArray[Any]]) -> None:
    for name, values in block.items():
        growing[name].add(values)


def _ascends(time: NDArray[Any]) -> bool:
    """Whether a column of times never goes back and has no gap; looked at in pieces."""
    pieces = (time[first : first + (1 << 20) + 1] for first in range(0, time.size, 1 << 20))
    return all(bool(np.all(np.diff(piece) >= 0.0)) and bool(np.isfinite(piece[-1])) for piece in pieces)


def _extremes(column: Column, edges: NDArray[np.int64]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Least and largest value between neighbouring edges, from buckets where a pixel holds many."""
    if edges[-1] - edges[0] > 4 * BUCKET * edges.size:
        # A pixel ends at the bucket that its last row is in: off by less than a quarter of a pixel.
        places, low, high = edges // BUCKET, column.low, column.high
    else:
        places = edges - edges[0]
        low = high = np.asarray(column.rows[edges[0] : edges[-1]])
    starts = np.minimum(places[:-1], low.size - 1)
    ends = int(np.clip(places[-1], starts[-1] + 1, low.size))
    return np.fmin.reduceat(low[:ends], starts), np.fmax.reduceat(high[:ends], starts)


def plain(values: NDArray[Any]) -> list[float | None]:
    """Numbers for JSON; what is not finite is a gap."""
    wide = np.asarray(values, dtype=float)
    return [None if not good else value for value, good in zip(wide.tolist(), np.isfinite(wide), strict=True)]


LARGEST = 2_000_000_000
"""Bytes of one log."""
SOUND = ".wav"
MOST_OPEN = 4
MOST_SHOWN = 4
"""Columns that are shown unasked."""
_ID = re.compile(r"[0-9a-f]{16}")


class LogStore:
    """The logs of a studio, in one folder each."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._open: OrderedDict[str, Curves] = OrderedDict()
        self._lock = threading.Lock()

    async def receive(self, name: str, content: AsyncIterator[bytes]) -> str:
        """Write an upload to disk as it comes; its name in the studio.

        Raises `InputRefused` if its name ends like no log, or it is longer than `LARGEST`.
        """
        kept = safe_name(name)
        log = secrets.token_hex(8)
        place = self._folder / f".{log}"
        place.mkdir(parents=True)
        try:
            size = 0
            async with await anyio.open_file(place / kept, "wb") as file:
                async for part in content:
                    size += len(part)
                    if size > LARGEST:
                        raise InputRefused(f"{kept}: larger than {LARGEST / 1e9:g} GB: cut the log")
                    await file.write(part)
            if size == 0:
                raise InputRefused(f"{kept}: is empty: give a log with rows of numbers")
            place.rename(self._folder / log)
        except BaseException:
            shutil.rmtree(place, ignore_errors=True)
            raise
        return log

    def path(self, log: str) -> Path:
        """File of a log. Raises `InputRefused` if there is none of that name."""
        place = self._folder / log
        if _ID.fullmatch(log) and place.is_dir() and not place.is_symlink():
            for path in sorted(place.iterdir()):
                if path.is_file() and not path.is_symlink():
                    return path
        raise InputRefused(f'"{log[:40]}" is no log of this studio: drop the file again')

    def listed(self) -> list[tuple[str, str]]:
        """Names in the studio and of the files, the newest first."""
        places = [place for place in self._folder.glob("*") if _ID.fullmatch(place.name) and place.is_dir()]
        newest = sorted(places, key=lambda place: -place.stat().st_mtime)
        return [(place.name, self.path(place.name).name) for place in newest if any(place.glob("*.*"))]

    def table(self, log: str) -> Table:
        """The columns of a log; only its head is read. Raises `InputRefused` if the reader does."""
        path = self.path(log)
        if path.suffix.lower() == SOUND:
            raise InputRefused(f"{path.name}: a recording: use it for the tension of a plucked span")
        return open_table(path)

    def curves(self, log: str) -> Curves:
        """What is drawn of a log; a few logs are kept ready."""
        with self._lock:
            if log not in self._open:
                table = self.table(log)
                self._open[log] = Curves(table, time_column(table), self._folder / log / ".columns")
            self._open.move_to_end(log)
            while len(self._open) > MOST_OPEN:
                self._open.popitem(last=False)
            return self._open[log]


def safe_name(name: str) -> str:
    """A file name of letters, digits and ``. _ -`` only; refused if it ends like no log."""
    kept = re.sub(r"[^A-Za-z0-9._-]+", "_", name.replace("\\", "/").rpartition("/")[2]).lstrip("._-")[-80:]
    if Path(kept).suffix.lower() not in (*FORMATS, SOUND):
        raise InputRefused(f"{name[:80]!r}: logs end in {', '.join((*FORMATS, SOUND))}: rename or unpack it")
    return kept


def time_column(table: Table) -> str | None:
    """The one column whose head says that it is the time."""
    found = [name for name in table.names if recognise(name) == "time"]
    return found[0] if len(found) == 1 else None


def shown_columns(table: Table) -> list[str]:
    """Columns that are drawn unasked: those that a head recognises, else the first ones."""
    time = time_column(table)
    rest = [name for name in table.names if name != time]
    known = [name for name in rest if recognise(name)]
    return (known or rest)[:MOST_SHOWN]


def unit_of(table: Table, column: str) -> str:
    """Unit that a log states for a column; empty where it states none."""
    return table.units.get(column) or name_and_unit(column)[1]
