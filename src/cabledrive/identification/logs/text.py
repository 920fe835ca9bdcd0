r"""Text logs: lines, cells and heads; delimiter, decimal mark, comments and units from the first lines.

A line ends with ``\n``, ``\r\n`` or ``\r`` and with nothing else: a form feed or U+2028 is part of its line.
"""

import codecs
import csv
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.identification.logs.log import Blocks, ColumnMap, Table, floats_of, name_and_unit, recognise
from cabledrive.parameters import InputRefused

SAMPLE_BYTES = 1 << 18
BLOCK_BYTES = 1 << 24
LONGEST_LINE = 1 << 17
"""Bytes of one line; a longer one is refused before it is read whole."""


def first_lines(path: Path) -> tuple[str, list[str], int]:
    """Encoding of a text, its first whole lines without their ends, and their bytes in the file."""
    with path.open("rb") as file:
        sample = file.read(SAMPLE_BYTES)
    if not sample.strip():
        raise InputRefused(f"{path.name}: is empty: give a log with a header and rows of numbers")
    encoding = "utf-8-sig"
    if sample.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encoding = "utf-16"
    else:
        try:  # a character cut off at the end does not count
            codecs.getincrementaldecoder(encoding)().decode(sample)
        except UnicodeDecodeError:
            encoding = "cp1252"
    text = sample.decode(encoding, errors="replace")
    if "\0" in text:
        raise InputRefused(f"{path.name}: is not text: name its format by the ending, as .mat")
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    last = lines.pop() if len(sample) == SAMPLE_BYTES else ""
    for number, line in enumerate([*lines, last], start=1):
        if len(line) > LONGEST_LINE:
            raise too_long(path.name, number)
    return encoding, lines, len(sample) - len(last.encode())


def too_long(source: str, number: int) -> InputRefused:
    """Refusal of a line, numbered from 1, that is longer than a row of a log can be."""
    return InputRefused(f"{source}: line {number} is longer than {LONGEST_LINE} bytes: write one row a line")


def line_blocks(path: Path, encoding: str) -> Iterator[tuple[int, bytes]]:
    r"""Whole lines of a text in blocks of UTF-8, with the number of the first from 1; all end with ``\n``."""
    rest, number = "", 1
    # what is no character is replaced, as it is no number either; of UTF-16 the rest would be shifted
    errors = "strict" if encoding == "utf-16" else "replace"
    with path.open(encoding=encoding, errors=errors) as file:
        while chunk := file.read(BLOCK_BYTES):
            whole, end, rest = (rest + chunk).rpartition("\n")
            lines = whole.count("\n") + len(end)
            if len(rest) > LONGEST_LINE:
                raise too_long(path.name, number + lines)
            if end:
                yield number, f"{whole}\n".encode()
            number += lines
    if rest:
        yield number, f"{rest}\n".encode()


MISSING = (
    "",
    *("NaN", "nan", "NAN", "-nan", "NA", "N/A", "n/a", "#N/A"),
    *("null", "NULL", "None", "-", "--", "---"),
)
_STAMP = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(?:\.\d{1,9})?(Z|[+-]\d\d:?\d\d)?")
_CLOCK = re.compile(r"\d{1,2}:\d\d:\d\d(?:[.,]\d+)?[^\d:]")


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

Heads = tuple[tuple[str, ...], dict[str, str], tuple[str, ...]]
"""Names of the columns of a text log, their units, and what a reader of the log has to know."""


def heads_of(lines: Sequence[str], delimiter: str, decimal: str, row: Sequence[str]) -> Heads:
    """Heads among the lines above the first row of numbers: the one that names most channels.

    It may stand behind a comment sign, and has as many cells as the numbers; where none names a channel it is
    the first of the last two such lines. A line of units may follow; other lines are metadata.
    """

    def cells_of(line: str, sign: str) -> list[str]:
        """Of a line that has as many as the numbers; the empty last cell of every row may be left out."""
        stripped = line.strip() if delimiter != "\t" else line.rstrip("\n")
        if not stripped.strip() or stripped.lstrip().startswith("#") != bool(sign):
            return []
        cells = split_line(stripped.lstrip().lstrip("#") if sign else stripped, delimiter)
        cells += [""] if len(cells) == len(row) - 1 and not row[-1] else []
        return cells if len(cells) == len(row) else []

    def channels(entry: tuple[int, list[str]]) -> int:
        return sum(bool(recognise(cell)) for cell in entry[1])

    plain, behind = (
        [(k, cells) for k, line in enumerate(lines) if (cells := cells_of(line, sign))] for sign in ("", "#")
    )
    exported = _twincat([cells for _, cells in plain], len(row))
    if exported is not None:
        return exported
    best = max([*plain, *behind], key=channels, default=None)
    if best is None or not channels(best):
        rest = plain[-2:] or (behind[-1:] if delimiter != " " else [])
        best = rest[0] if rest else None
    if best is None:
        return tuple(f"column {k + 1}" for k in range(len(row))), {}, ()
    parted = [name_and_unit(head) for head in best[1]]
    names = _different(name or f"column {k + 1}" for k, (name, _) in enumerate(parted))
    units = {name: unit for name, (_, unit) in zip(names, parted, strict=True) if unit}
    below = next((later for k, later in plain if k == best[0] + 1), [])
    if not units and not any(is_number(cell, decimal) for cell in below):
        units = {name: unit for name, cell in zip(names, below, strict=False) if (unit := cell.strip("[]()"))}
    # Lines of text and numbers below the heads: what they hold in the columns of numbers is not read.
    later = plain[plain.index(best) + 1 :] if best in plain else plain
    filled = [k for k, cell in enumerate(row) if cell not in MISSING]
    mixed = sum(any(is_number(cells[k], mark) for k in filled for mark in ".,") for _, cells in later)
    words = f"{mixed} lines above the first row of numbers hold text beside numbers and are not read"
    return names, units, (words,) if mixed else ()


def _different(names: Iterable[str]) -> tuple[str, ...]:
    """Names of columns; refused if two are the same."""
    names = tuple(names)
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InputRefused(f'two columns are called "{twice}": rename one')
    return names


def _twincat(lines: Sequence[Sequence[str]], width: int) -> Heads | None:
    """Heads of a TwinCAT Scope export: rows of metadata by column, a time in ms before every group."""
    keys = [cells[0] for cells in lines]
    if TWINCAT_INTERVAL not in keys or "Name" not in keys:
        return None
    heads = lines[keys.index("Name")]
    starts = [k for k in range(width) if heads[k] == "Name"]
    found = [cell or f"column {k + 1}" for k, cell in enumerate(heads)]
    for number, k in enumerate(starts, start=1):
        found[k] = "time" if number == 1 else f"time of group {number}"
    names = _different(found)
    stated = lines[keys.index("Unit")] if "Unit" in keys else [""] * width
    units = {names[k]: stated[k] for k in range(width) if k not in starts and stated[k] not in NO_UNIT}
    units |= {names[k]: "ms" for k in starts}
    several = f"the file has {len(starts)} time columns, the first of them is taken for all channels"
    return names, units, (several,) if len(starts) > 1 else ()


DELIMITERS = (",", "\t", ";", " ")
_SIGNS = (b"#", b"EOF", b"\n\n", b"\n ", b"\n\t", b"\n\f", b"\n\v")
"""What a block of text holds where one of its lines is no row, and seldom elsewhere."""
_NO_ROW = re.compile(rb"^[ \t\f\v]*(?:#.*|EOF[ \t,;]*)?$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Dialect:
    """How a text log is written."""

    delimiter: str  # A space stands for any white space
    decimal: str  # {".", ","}
    encoding: str
    skip: int  # lines before the first row of numbers
    names: tuple[str, ...]  # Columns; numbered from 1 where there is no header
    zones: dict[str, str]  # time zone of the columns that hold ISO 8601 times; empty: none is stated


def open_delimited(path: Path, reading: ColumnMap) -> Table:
    """Open a CSV or TSV log; refused if it is none, or has one column only."""
    encoding, lines, size = first_lines(path)
    delimiter, decimal, first = _first_numbers(lines, path.name, reading.skip_rows)
    row = split_line(lines[first], delimiter)
    if len(row) < 2:
        raise InputRefused(f"{path.name}: one column only: a log needs the time and at least two channels")
    try:
        names, units, notes = heads_of(lines[reading.skip_rows : first], delimiter, decimal, row)
    except InputRefused as refusal:
        raise refusal.at(path.name) from None
    zones = {name: zone for name, cell in zip(names, row, strict=True) if (zone := zone_of(cell)) is not None}
    dialect = Dialect(delimiter, decimal, encoding, first, names, zones)
    return Table(
        source=path.name,
        names=names,
        units=units | dict.fromkeys(zones, "s"),
        rows=int(path.stat().st_size / max(1.0, size / max(1, len(lines)))),
        read=lambda names: _read(path, dialect, names),
        notes=notes,
    )


def _first_numbers(lines: Sequence[str], source: str, skip_rows: int) -> tuple[str, str, int]:
    """Delimiter, decimal mark and number of the first line that holds numbers only."""
    for number, line in enumerate(lines):
        if number < skip_rows or not line.strip() or line.lstrip().startswith("#"):
            continue
        for delimiter in DELIMITERS:
            cells = split_line(line, delimiter)
            for decimal in ".," if delimiter != "," else ".":
                filled = [cell for cell in cells if cell not in MISSING]
                if (
                    any(is_number(cell, decimal) for cell in filled)
                    and all(is_number(cell, decimal) or zone_of(cell) is not None for cell in filled)
                    and (len(cells) > 1 or delimiter == " ")
                ):
                    # The first row also where it and its next are rows of missing values, such as ``---``.
                    while number > 0:
                        above = split_line(lines[number - 1], delimiter)
                        if len(above) != len(cells) or not any(above) or not set(above) <= set(MISSING):
                            break
                        number -= 1
                    return delimiter, decimal, number
    if any(_CLOCK.match(line.strip()) for line in lines):
        said = f"{source}: times such as 12:00:07.022 state no date"
        raise InputRefused(f"{said}: write ISO 8601 with a date, as 2024-03-01T12:00:07.022, or seconds")
    shown = next((line.strip() for line in reversed(lines) if line.strip()), "")[:40]
    raise InputRefused(f'{source}: no row of numbers up to line {len(lines)}, "{shown}": write numbers alone')


def _read(path: Path, dialect: Dialect, names: tuple[str, ...]) -> Blocks:
    """Rows in blocks; each block has as many rows as lines that are neither empty nor a comment."""
    starts: dict[str, int] = {}
    for number, whole in line_blocks(path, dialect.encoding):
        block, above = whole, 0
        if number <= dialect.skip:
            above = dialect.skip - number + 1
            block = b"".join(part + b"\n" for part in whole.split(b"\n")[above:-1])
        found = _rows(block, dialect, names)
        if found is None:
            found = _by_cells(block, number + above, dialect, names, path.name)
        if len(next(iter(found.values()))):
            yield {name: floats_of(found[name], name, starts) for name in names}


def _rows(block: bytes, dialect: Dialect, names: tuple[str, ...]) -> dict[str, Any] | None:
    """Columns of a block; nothing where it does not hold one row of numbers for each line."""
    import pyarrow as pa
    from pyarrow import csv as arrow

    lines = block.removesuffix(b"\n")
    if lines[:1].isspace() or any(sign in lines for sign in _SIGNS):
        lines = b"\n".join(line for line in lines.split(b"\n") if not _NO_ROW.fullmatch(line))
    count = lines.count(b"\n") + 1 if lines else 0
    if not count:
        return {name: np.empty(0) for name in names}
    delimiter = dialect.delimiter
    if delimiter == " ":
        delimiter = ";"
        lines = b"\n".join(b";".join(line.partition(b"#")[0].split()) for line in lines.split(b"\n"))
    kinds = {name: _kind(dialect.zones[name]) for name in dialect.zones}
    try:
        table = arrow.read_csv(
            pa.BufferReader(lines + b"\n"),
            read_options=arrow.ReadOptions(column_names=list(dialect.names)),
            parse_options=arrow.ParseOptions(delimiter=delimiter),
            convert_options=arrow.ConvertOptions(
                column_types=dict.fromkeys(dialect.names, pa.float64()) | kinds,
                include_columns=list(names),
                null_values=list(MISSING),
                decimal_point=dialect.decimal,
            ),
        )
    except pa.ArrowInvalid:
        return None
    return {name: table.column(name) for name in names} if table.num_rows == count else None


def _by_cells(
    block: bytes, number: int, dialect: Dialect, names: tuple[str, ...], source: str
) -> dict[str, Any]:
    """The columns cell by cell, for what the fast reader does not take; it says which cell is no number."""
    import pyarrow as pa

    found: dict[str, list[Any]] = {name: [] for name in names}
    for place, raw in enumerate(block.removesuffix(b"\n").split(b"\n"), start=number):
        if _NO_ROW.fullmatch(raw):
            continue
        if len(raw) > LONGEST_LINE:
            raise too_long(source, place)
        line = raw.decode()
        cells = split_line(line.partition("#")[0] if dialect.delimiter == " " else line, dialect.delimiter)
        if len(cells) != len(dialect.names):
            said = f"{source}: line {place} has {len(cells)} cells, the header {len(dialect.names)}"
            raise InputRefused(f"{said}: mend or cut that line")
        for name, cell in zip(dialect.names, cells, strict=True):
            if name in found:
                found[name].append(_value(cell, name, place, dialect, source))
    return {
        name: pa.array(values, pa.string()).cast(_kind(dialect.zones[name]))
        if name in dialect.zones
        else np.array(values)
        for name, values in found.items()
    }


def _value(cell: str, name: str, place: int, dialect: Dialect, source: str) -> Any:
    stamp = name in dialect.zones
    if cell in MISSING:
        return None if stamp else np.nan
    if stamp and zone_of(cell) == dialect.zones[name]:
        return cell
    if not stamp and is_number(cell, dialect.decimal):
        return float(cell.replace(",", "."))
    wanted = "a time as in the first row" if stamp else "a number or leave it empty"
    raise InputRefused(f'{source}: line {place}, column "{name}" holds "{cell[:30]}": write {wanted}')


def _kind(zone: str) -> Any:
    import pyarrow as pa

    return pa.timestamp("ns", tz=zone or None)
