"""How much a packed container unpacks to, counted without keeping it: no bomb gets as far as memory."""

import struct
import zlib
from pathlib import Path
from typing import BinaryIO

LARGEST_IN_MEMORY = 2 * 2**30
"""Bytes that a container may unpack to which its library can only read whole (MATLAB 5 to 7, MCAP)."""
LARGEST_CHUNK = 256 * 2**20
"""Bytes of one packed chunk of an HDF5 file, which is unpacked at once."""

PIECE = 1 << 20
COMPRESSED = 15
"""Type of a packed element of a MATLAB file."""
CHUNK = 6
"""Opcode of a chunk of an MCAP file."""
LZ4_RATIO = 255
"""Bytes that one byte of LZ4 can unpack to."""


def unpacked_matlab(path: Path, limit: int = LARGEST_IN_MEMORY) -> int:
    """Bytes of a MATLAB 5 to 7 file unpacked, counted up to a limit; 0 where it is no such file.

    Parameters
    ----------
    path : Path
    limit : int
        Counting ends above it.

    Returns
    -------
    int
    """
    with path.open("rb") as file:
        head = file.read(128)
        if len(head) < 128 or head[126:128] not in (b"IM", b"MI"):
            return 0
        order = "<" if head[126:128] == b"IM" else ">"
        total = 0
        while total <= limit and len(tag := file.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", tag)
            after = file.tell() + size
            total += _inflated(file, size, limit - total) if kind == COMPRESSED else size
            file.seek(after)
    return total


def unpacked_mcap(path: Path, limit: int = LARGEST_IN_MEMORY) -> int:
    """Bytes of the chunks of an MCAP file unpacked, as their heads state them and as LZ4 allows.

    Parameters
    ----------
    path : Path
    limit : int
        Counting ends above it.

    Returns
    -------
    int
    """
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


def _inflated(file: BinaryIO, size: int, limit: int) -> int:
    """Bytes of one packed element, unpacked piece by piece and thrown away."""
    engine, total = zlib.decompressobj(), 0
    while size > 0 and total <= limit:
        piece = file.read(min(size, PIECE))
        if not piece:
            break
        size -= len(piece)
        try:
            while piece and total <= limit:
                total += len(engine.decompress(piece, 16 * PIECE))
                piece = engine.unconsumed_tail
        except zlib.error:
            return total
    return total
