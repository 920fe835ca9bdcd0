r"""Lines of a text log: one notion of a line for every reader, of bounded length, in blocks.

A line ends with ``\n``, ``\r\n`` or ``\r`` and with nothing else: a form feed or U+2028 is part of its line.
"""

import codecs
from collections.abc import Iterator
from pathlib import Path

from cabledrive.parameters import InputRefused

SAMPLE_BYTES = 1 << 18
BLOCK_BYTES = 1 << 24
LONGEST_LINE = 1 << 17
"""Bytes of one line; a longer one is refused before it is read whole."""


def first_lines(path: Path) -> tuple[str, list[str], int]:
    """Encoding and first lines of a text.

    Returns ``encoding``: unicode where the bytes are valid, else Windows-1252, as many a logger writes "°"
    and "µ"; ``lines``: without their ends; a line that is cut off by the end of the sample is left out;
    ``size``: bytes of these lines in the file.
    Raises `InputRefused` if the file is empty, no text, or has a line longer than `LONGEST_LINE`.
    """
    with path.open("rb") as file:
        sample = file.read(SAMPLE_BYTES)
    if not sample.strip():
        raise InputRefused(f"{path.name}: is empty: give a log with a header and rows of numbers")
    encoding = _encoding_of(sample)
    text = sample.decode(encoding, errors="replace")
    if "\0" in text:
        raise InputRefused(
            f"{path.name}: is not text: name its format by the ending (.parquet, .mat, .nc, .mcap, .db3)"
        )
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    last = lines.pop() if len(sample) == SAMPLE_BYTES else ""
    for number, line in enumerate([*lines, last], start=1):
        if len(line) > LONGEST_LINE:
            raise too_long(path.name, number)
    return encoding, lines, len(sample) - len(last.encode())


def too_long(source: str, number: int) -> InputRefused:
    """Refusal of a line that is longer than a row of a log can be.

    ``number``: of the line, from 1.
    """
    return InputRefused(
        f"{source}: line {number} is longer than {LONGEST_LINE} bytes: write one row of numbers per line"
    )


def line_blocks(path: Path, encoding: str, size: int | None = None) -> Iterator[tuple[int, bytes]]:
    r"""Whole lines of a text, block by block.

    ``encoding``: as `first_lines` found it; ``size``: bytes read at a time; default: `BLOCK_BYTES`.
    Returns ``number``: of the first line of the block, from 1; ``block``: ASCII or UTF-8 (Windows-1252 as it
    is); every line ends with ``\n``.
    Raises `InputRefused` if a line is longer than `LONGEST_LINE`, or UTF-16 ends within a character.
    """
    decoder = codecs.getincrementaldecoder("utf-16")() if encoding == "utf-16" else None
    rest, number, first = b"", 1, True
    with path.open("rb") as file:
        while chunk := file.read(size or BLOCK_BYTES):
            data = chunk if decoder is None else _decoded(decoder, chunk, path.name).encode("utf-8")
            data = rest + (data.removeprefix(codecs.BOM_UTF8) if first else data)
            first = False
            held = data[-1:] if data.endswith(b"\r") else b""  # its \n may be the next byte of the file
            data = _one_end(data[: len(data) - len(held)])
            cut = data.rfind(b"\n") + 1
            rest = data[cut:] + held
            lines = data.count(b"\n")
            if len(rest) > LONGEST_LINE:
                raise too_long(path.name, number + lines)
            if cut:
                yield number, data[:cut]
            number += lines
    if decoder is not None:
        _decoded(decoder, b"", path.name)
    if rest:
        yield number, _one_end(rest).removesuffix(b"\n") + b"\n"


def _one_end(data: bytes) -> bytes:
    return data.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in data else data


def _decoded(decoder: codecs.IncrementalDecoder, data: bytes, source: str) -> str:
    try:
        return decoder.decode(data, final=not data)
    except UnicodeDecodeError as error:
        raise InputRefused(f"{source}: is damaged ({error.reason} in UTF-16): write it again") from None


def _encoding_of(sample: bytes) -> str:
    """How the first bytes of a text are written; a character cut off at their end does not count."""
    if sample.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    try:
        codecs.getincrementaldecoder("utf-8-sig")().decode(sample)
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8-sig"
