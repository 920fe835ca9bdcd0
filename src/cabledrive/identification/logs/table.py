"""What every log format looks like from inside, and how much a packed one unpacks to."""

import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

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

PIECE = 1 << 20
COMPRESSED, MATRIX = 15, 14
"""Types of an element of a MATLAB file that hold others: a packed one, and a matrix, cell or structure."""
WIDTHS = {3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8, 17: 2, 18: 4}
"""Bytes of one number of the other types; 1 for those not listed."""
ELEMENT = 256
"""Bytes that an element takes as an object of Python, however short it is."""
CHUNK = 6
"""Opcode of a chunk of an MCAP file."""
LZ4_RATIO = 255
"""Bytes that one byte of LZ4 can unpack to."""


def require_fitting(path: Path, size: int) -> None:
    """Refuse a container that its library reads whole and that holds too much for that [bytes]."""
    if size > LARGEST_IN_MEMORY:
        most = LARGEST_IN_MEMORY / 2**30
        raise InputRefused(f"{path.name}: unpacks to more than {most:.0f} GiB: cut it into parts")


def unpacked_matlab(path: Path, limit: int = LARGEST_IN_MEMORY) -> int:
    """Bytes that the numbers of a MATLAB file take in memory, counted up to a limit.

    A number counts as a double, however short it is stored: MATLAB 5 to 7 store a matrix of small whole
    numbers in bytes and call it double.
    """
    with path.open("rb") as file:
        head = file.read(128)
        if len(head) < 128 or head[126:128] not in (b"IM", b"MI"):
            return path.stat().st_size  # version 4: nothing in it is packed
        return _walked(_Source(file), "<" if head[126:128] == b"IM" else ">", limit, 0)


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


class _Source:
    """Bytes of a file, or of one packed element of it, unpacked piece by piece and thrown away."""

    def __init__(self, file: BinaryIO, size: int | None = None) -> None:
        self.file, self.left = file, size
        self.engine = None if size is None else zlib.decompressobj()
        self.ahead, self.place = b"", 0

    def take(self, count: int) -> bytes:
        """The next bytes; fewer where it ends."""
        if self.engine is None:
            return self.file.read(count)
        while len(self.ahead) - self.place < count and (piece := self._piece()):
            self.ahead, self.place = self.ahead[self.place :] + piece, 0
        self.place += count
        return self.ahead[self.place - count : self.place]

    def skip(self, count: int) -> int:
        """Leave bytes out; how many there were."""
        if self.engine is None:
            place = self.file.tell()
            there = max(0, min(count, self.file.seek(0, 2) - place))
            self.file.seek(place + there)
            return there
        self.place += count
        while self.place > len(self.ahead) and (piece := self._piece()):
            self.ahead, self.place = piece, self.place - len(self.ahead)
        missing = max(0, self.place - len(self.ahead))
        self.place -= missing
        return count - missing

    def _piece(self) -> bytes:
        assert self.engine is not None
        assert self.left is not None
        while not self.engine.eof:
            packed = self.engine.unconsumed_tail or self.file.read(min(self.left, PIECE))
            if not self.engine.unconsumed_tail:
                self.left -= len(packed)
            if not packed:
                return b""
            try:
                if piece := self.engine.decompress(packed, 16 * PIECE):
                    return piece
            except zlib.error:
                return b""
        return b""


def _walked(source: _Source, order: str, limit: int, depth: int) -> int:
    """Numbers of the elements of a MATLAB 5 file, in bytes of doubles; a matrix is the elements in it."""
    total = 0
    while total <= limit and len(tag := source.take(8)) == 8:
        kind, size = struct.unpack(f"{order}II", tag)
        total += ELEMENT
        if kind >> 16:  # a short element: its size and up to four bytes of it lie in the tag
            total += 8 * ((kind >> 16) // WIDTHS.get(kind & 0xFFFF, 1))
        elif kind == COMPRESSED and depth == 0:
            after = source.file.tell() + size
            total += _walked(_Source(source.file, size), order, limit - total, depth + 1)
            source.file.seek(after)
        elif kind != MATRIX:
            width = WIDTHS.get(kind, 1)
            enough = width * ((limit - total) // 8 + 1)  # no more is unpacked than it takes to be too much
            if size > enough:
                total += 8 * (source.skip(enough) // width)
                source.skip(0 if total > limit else size - enough)
            else:
                total += 8 * (min(size, source.skip(size + (-size) % 8)) // width)
    return total
