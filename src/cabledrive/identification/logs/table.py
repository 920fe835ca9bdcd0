"""What every log format looks like from inside: named columns that are read in blocks."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import nearest

Array = NDArray[np.float64]
Blocks = Iterator[dict[str, Array]]

BLOCK_ROWS = 1 << 20
TICKS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
"""Seconds in a tick of a calendar time."""
LARGEST_UNPACKED = 16 * 2**30
"""Bytes that the columns of one compressed file may unpack to; more is refused as a possible bomb."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """What a format has to know before it opens a file.

    Attributes
    ----------
    skip_rows : int
        Lines at the top of a text log that are not part of it.
    resample : bool
        Whether topics sampled at different times may be put onto the times of one of them.
    """

    skip_rows: int = 0
    resample: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Columns of a log file.

    Attributes
    ----------
    source : str
        Name of the file.
    names : tuple of str
        Columns, as the file calls them.
    units : dict of str to str
        Units that the file states, by column.
    rows : int or None
        Number of rows; of a text log an estimate from its first lines; None where only reading shows it.
    read : callable
        ``read(names)`` yields blocks of equal columns; a missing value is NaN.
    scalars : dict of str to float
        Single numbers in the file, such as a drive gain.
    notes : tuple of str
        What a reader of the log has to know about the file, in words.
    """

    source: str
    names: tuple[str, ...]
    units: dict[str, str]
    rows: int | None
    read: Callable[[tuple[str, ...]], Blocks]
    scalars: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def require(self, name: str) -> str:
        """Refuse a column that is not there.

        Returns the name itself.
        Raises `InputRefused` with the nearest column that is there.
        """
        if name not in self.names:
            raise InputRefused(f'{self.source}: no column "{name}"{nearest(name, self.names)}')
        return name


def check_lengths(lengths: Mapping[str, int], source: str) -> None:
    """Refuse columns of different lengths.

    ``lengths``: by column; ``source``: name of the file.
    Raises `InputRefused` if they differ.
    """
    if len(set(lengths.values())) > 1:
        found = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise InputRefused(f"{source}: channels differ in length ({found}): choose channels of one length")


def sliced(columns: dict[str, Array], rows: int = BLOCK_ROWS) -> Blocks:
    """Columns in memory as blocks.

    ``columns``: equally long; ``rows``: rows per block.
    """
    length = len(next(iter(columns.values()), ()))
    for start in range(0, length, rows):
        yield {
            name: np.asarray(values[start : start + rows], dtype=float) for name, values in columns.items()
        }


def seconds_of(column: Any, name: str, starts: dict[str, int]) -> Array:
    """Times of a calendar in seconds from the first of the file, subtracted before a double rounds them.

    ``column``: of time stamps or durations; ``starts``: first of each column, in ticks; kept from block to
    block.
    Returns NaN where a value is missing.
    """
    import pyarrow as pa

    ticks = column.cast(pa.int64())
    missing = np.asarray(ticks.is_null().to_numpy(zero_copy_only=False), dtype=bool)
    whole = np.asarray(ticks.fill_null(0).to_numpy(zero_copy_only=False), dtype=np.int64)
    if name not in starts and not missing.all():
        starts[name] = int(whole[~missing][0])
    return np.where(missing, np.nan, (whole - starts.get(name, 0)) * TICKS[column.type.unit])
