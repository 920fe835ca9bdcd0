r"""Lines, cells and heads of a text log.

A line ends with ``\n``, ``\r\n`` or ``\r`` and with nothing else: a form feed or U+2028 is part of its line.
"""

import codecs
import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from cabledrive.identification.logs.column_map import name_and_unit, recognise
from cabledrive.parameters import InputRefused

SAMPLE_BYTES = 1 << 18
BLOCK_BYTES = 1 << 24
LONGEST_LINE = 1 << 17
"""Bytes of one line; a longer one is refused before it is read whole."""


def first_lines(path: Path) -> tuple[str, list[str], int]:
    """Encoding of a text, its first whole lines without their ends, and their bytes in the file.

    Unicode where the bytes are valid, else Windows-1252, as many a logger writes "°" and "µ".
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
    """Refusal of a line, numbered from 1, that is longer than a row of a log can be."""
    return InputRefused(
        f"{source}: line {number} is longer than {LONGEST_LINE} bytes: write one row of numbers per line"
    )


def line_blocks(path: Path, encoding: str, size: int | None = None) -> Iterator[tuple[int, bytes]]:
    r"""Whole lines of a text block by block, with the number of the first from 1; all end with ``\n``.

    ASCII or UTF-8, Windows-1252 as it is; ``size``: bytes read at a time, default: `BLOCK_BYTES`.
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


MISSING = (
    "",
    *("NaN", "nan", "NAN", "-nan", "NA", "N/A", "n/a", "#N/A"),
    *("null", "NULL", "None", "-", "--", "---"),
)
_STAMP = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(?:\.\d{1,9})?(Z|[+-]\d\d:?\d\d)?")


def split_line(line: str, delimiter: str) -> list[str]:
    """Cells of one line, quotes taken off; the delimiter " " stands for any white space."""
    if delimiter == " ":
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), [])]


def is_number(cell: str, decimal: str) -> bool:
    """Whether a cell is one number, with the decimal mark "." or ","."""
    if (decimal == "," and "." in cell) or "_" in cell or not cell.isascii():
        return False
    try:
        float(cell.replace(",", ".") if decimal == "," else cell)
    except ValueError:
        return False
    return True


def zone_of(cell: str) -> str | None:
    """Time zone of an ISO 8601 time: "UTC" where it states its distance, else ""; None: it is no time."""
    match = _STAMP.fullmatch(cell)
    return None if match is None else "UTC" if match[1] else ""


TWINCAT_INTERVAL = "SampleTime[ms]"
NO_UNIT = ("", "-", "(None)", "None")


@dataclass(frozen=True, slots=True, kw_only=True)
class Heads:
    """Columns of a text log."""

    names: tuple[str, ...]
    units: dict[str, str]
    notes: tuple[str, ...] = ()  # what a reader of the log has to know


def heads_of(lines: Sequence[str], delimiter: str, decimal: str, row: Sequence[str]) -> Heads:
    """Find the heads among the lines above the first row of numbers; other lines there are metadata.

    The line that names most channels is the line of heads, also behind a comment sign; where none names any,
    the first of the last two lines that have as many cells as the numbers. A line of units may follow.
    """
    width = len(row)
    plain = [(k, cells) for k, line in enumerate(lines) if (cells := _cells(line, delimiter, row, sign=""))]
    behind = [(k, cells) for k, line in enumerate(lines) if (cells := _cells(line, delimiter, row, sign="#"))]
    exported = _twincat([cells for _, cells in plain], width)
    if exported is not None:
        return exported
    best = max([*plain, *behind], key=lambda entry: _channels(entry[1]), default=None)
    if best is None or not _channels(best[1]):
        rest = plain[-2:] or (behind[-1:] if delimiter != " " else [])
        best = rest[0] if rest else None
    if best is None:
        return Heads(names=tuple(f"column {k + 1}" for k in range(width)), units={}, notes=())
    place, cells = best
    below = next((later for k, later in plain if k == place + 1), None)
    names, units = _names(cells, below, decimal)
    notes = _numbers_above(plain[[k for k, _ in plain].index(place) + 1 :] if best in plain else plain, row)
    return Heads(names=names, units=units, notes=notes)


def _cells(line: str, delimiter: str, row: Sequence[str], sign: str) -> list[str]:
    """Cells of a line that has as many as the numbers; the empty last cell of every row may be left out."""
    stripped = line.strip() if delimiter != "\t" else line.rstrip("\n")
    if not stripped.strip() or stripped.lstrip().startswith("#") != bool(sign):
        return []
    cells = split_line(stripped.lstrip().lstrip("#") if sign else stripped, delimiter)
    if len(cells) == len(row) - 1 and not row[-1]:
        cells.append("")
    return cells if len(cells) == len(row) else []


def _channels(cells: Sequence[str]) -> int:
    return sum(recognise(cell) is not None for cell in cells)


def _names(
    heads: Sequence[str], below: Sequence[str] | None, decimal: str
) -> tuple[tuple[str, ...], dict[str, str]]:
    """Names and units from a line of heads, and perhaps one of units below it."""
    parted = [name_and_unit(head) for head in heads]
    names = tuple(name or f"column {k + 1}" for k, (name, _) in enumerate(parted))
    units = {name: unit for name, (_, unit) in zip(names, parted, strict=True) if unit}
    if below is not None and not units and not any(is_number(cell, decimal) for cell in below):
        units = {
            name: cell.strip("[]()") for name, cell in zip(names, below, strict=True) if cell.strip("[]()")
        }
    _require_different(names)
    return names, units


def _require_different(names: Sequence[str]) -> None:
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InputRefused(f'two columns are called "{twice}": rename one')


def _numbers_above(lines: Sequence[tuple[int, Sequence[str]]], row: Sequence[str]) -> tuple[str, ...]:
    """Lines of text and numbers below the heads: what they hold in the columns of numbers is not read."""
    filled = [k for k, cell in enumerate(row) if cell not in MISSING]
    mixed = sum(
        any(is_number(cells[k], ".") or is_number(cells[k], ",") for k in filled) for _, cells in lines
    )
    if not mixed:
        return ()
    return (f"{mixed} lines above the first row of numbers hold text beside numbers and are not read",)


def _twincat(lines: Sequence[Sequence[str]], width: int) -> Heads | None:
    """Heads of a TwinCAT Scope export: rows of metadata by column, a time in ms before every group."""
    keys = [cells[0] for cells in lines]
    if TWINCAT_INTERVAL not in keys or "Name" not in keys:
        return None
    heads = lines[keys.index("Name")]
    starts = [k for k in range(width) if heads[k] == "Name"]
    names = [cell or f"column {k + 1}" for k, cell in enumerate(heads)]
    for number, k in enumerate(starts, start=1):
        names[k] = "time" if number == 1 else f"time of group {number}"
    _require_different(names)
    stated = lines[keys.index("Unit")] if "Unit" in keys else [""] * width
    units = {names[k]: stated[k] for k in range(width) if k not in starts and stated[k] not in NO_UNIT}
    units |= {names[k]: "ms" for k in starts}
    several = f"the file has {len(starts)} time columns, the first of them is taken for all channels"
    return Heads(names=tuple(names), units=units, notes=(several,) if len(starts) > 1 else ())
