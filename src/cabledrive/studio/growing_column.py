"""A column of a log as it is read: its rows go to disk, its extremes are kept."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

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
