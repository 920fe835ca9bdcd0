"""Columns of a long log ready to be drawn: least and largest value of every 256 rows, the rows on disk."""

import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.logs.table import Table
from cabledrive.parameters import InputRefused
from cabledrive.studio.growing_column import BUCKET, Column, GrowingColumn

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
            "x": _plain(self._time_at(edges[:-1])),
            "start": float(self._time_at(np.array([first]))[0]),
            "end": float(self._time_at(np.array([last - 1]))[0]),
            "series": [
                {"name": name, "low": _plain(low), "high": _plain(high)}
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


def _plain(values: NDArray[Any]) -> list[float | None]:
    """Numbers for JSON; what is not finite is a gap."""
    wide = np.asarray(values, dtype=float)
    return [None if not good else value for value, good in zip(wide.tolist(), np.isfinite(wide), strict=True)]
