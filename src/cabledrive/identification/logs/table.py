"""What every log format looks like from inside, and how much a packed one unpacks to."""

import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import nearest

Blocks = Iterator[dict[str, Array]]

BLOCK_ROWS = 1 << 20
TICKS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
"""Seconds in a tick of a calendar time."""
LARGEST_UNPACKED = 16 * 2**30
"""Bytes that the columns of one compressed file may unpack to; more is refused as a possible bomb."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """What a format has to know before it opens a file."""

    skip_rows: int = 0  # lines at the top of a text log that are not part of it
    # whether topics sampled at different times may be put onto the times of one of them
    resample: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Columns of a log file."""

    source: str  # name of the file
    names: tuple[str, ...]  # Columns, as the file calls them
    units: dict[str, str]  # units that the file states, by column
    # number of rows; of a text log an estimate from its first lines; None where only reading shows it
    rows: int | None
    # ``read(names)`` yields blocks of equal columns; a missing value is NaN
    read: Callable[[tuple[str, ...]], Blocks]
    # single numbers in the file, such as a drive gain
    scalars: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()  # what a reader of the log has to know about the file, in words

    def require(self, name: str) -> str:
        """A column's name; refused, with the nearest, if it is not there."""
        if name not in self.names:
            raise InputRefused(f'{self.source}: no column "{name}"{nearest(name, self.names)}')
        return name


def check_lengths(lengths: Mapping[str, int], source: str) -> None:
    """Refuse columns of different lengths."""
    if len(set(lengths.values())) > 1:
        found = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise InputRefused(f"{source}: channels differ in length ({found}): choose channels of one length")


def sliced(columns: dict[str, Array], rows: int = BLOCK_ROWS) -> Blocks:
    """Equally long columns in memory as blocks."""
    length = len(next(iter(columns.values()), ()))
    for start in range(0, length, rows):
        yield {
            name: np.asarray(values[start : start + rows], dtype=float) for name, values in columns.items()
        }


def floats_of(column: Any, name: str, starts: dict[str, int]) -> Array:
    """A column of Arrow or NumPy as doubles; times of a calendar in seconds from the first of the file.

    That is subtracted before a double rounds them. ``starts``: first of each column, in ticks, kept from
    block to block; a missing value is NaN.
    """
    if isinstance(column, np.ndarray):
        return np.asarray(column, dtype=float)
    import pyarrow as pa

    if not (pa.types.is_timestamp(column.type) or pa.types.is_duration(column.type)):
        return np.asarray(column.to_numpy(zero_copy_only=False), dtype=float)
    ticks = column.cast(pa.int64())
    missing = np.asarray(ticks.is_null().to_numpy(zero_copy_only=False), dtype=bool)
    whole = np.asarray(ticks.fill_null(0).to_numpy(zero_copy_only=False), dtype=np.int64)
    if name not in starts and not missing.all():
        starts[name] = int(whole[~missing][0])
    return np.where(missing, np.nan, (whole - starts.get(name, 0)) * TICKS[column.type.unit])


LARGEST_IN_MEMORY = 2**30
"""Bytes that a container may unpack to which its library can only read whole (MATLAB 5 to 7, MCAP)."""
LARGEST_CHUNK = 256 * 2**20
"""Bytes of one packed chunk of an HDF5 file, which is unpacked at once."""

CHUNK = 6
"""Opcode of a chunk of an MCAP file."""
LZ4_RATIO = 255
"""Bytes that one byte of LZ4 can unpack to."""


def require_fitting(path: Path, size: int) -> None:
    """Refuse a container that its library reads whole and that holds too much for that [bytes]."""
    if size > LARGEST_IN_MEMORY:
        raise too_large(path)


def too_large(path: Path) -> InputRefused:
    """Refusal of a container that unpacks to more than is read whole."""
    most = LARGEST_IN_MEMORY / 2**30
    return InputRefused(f"{path.name}: unpacks to more than {most:.0f} GiB: cut it into parts")


def unpacked_mcap(path: Path, limit: int = LARGEST_IN_MEMORY) -> int:
    """Bytes of the chunks of an MCAP file unpacked, as heads state them and LZ4 allows, to a limit."""
    total, end = 0, path.stat().st_size
    with path.open("rb") as file:
        file.seek(8)
        while total <= limit and len(head := file.read(9)) == 9:
            code, size = struct.unpack("<BQ", head)
            after = min(file.tell() + size, end)
            if code == CHUNK and len(start := file.read(32)) == 32:
                stated = struct.unpack("<QQQII", start)
                scheme = file.read(min(stated[4], 16))
                total += max(stated[2], size if scheme == b"" else 0)
                if scheme == b"lz4" and stated[2] > LZ4_RATIO * size:
                    return limit + 1
            file.seek(after)
    return total
