"""Text logs: delimiter, decimal mark, comments, header and units recognised from the first lines."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.identification.logs.lines import (
    LONGEST_LINE,
    MISSING,
    first_lines,
    heads_of,
    is_number,
    line_blocks,
    split_line,
    too_long,
    zone_of,
)
from cabledrive.identification.logs.table import Blocks, Reading, Table, floats_of
from cabledrive.parameters import InputRefused

DELIMITERS = (",", "\t", ";", " ")
_SIGNS = (b"#", b"EOF", b"\n\n", b"\n ", b"\n\t", b"\n\f", b"\n\v")
"""What a block of text holds where one of its lines is no row, and seldom elsewhere."""
_NO_ROW = re.compile(rb"^[ \t\f\v]*(?:#.*|EOF[ \t,;]*)?$", re.MULTILINE)


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """How a text log is written."""

    delimiter: str  # A space stands for any white space
    decimal: str  # {".", ","}
    encoding: str
    skip: int  # lines before the first row of numbers
    names: tuple[str, ...]  # Columns; numbered from 1 where there is no header
    units: dict[str, str]
    zones: dict[str, str]  # time zone of the columns that hold ISO 8601 times; empty: none is stated
    notes: tuple[str, ...]
    rows: int  # about how many rows the file has


def dialect_of(path: Path, skip_rows: int = 0) -> Dialect:
    """Recognise how a text log is written; refused if it is none, or has one column only."""
    encoding, lines, size = first_lines(path)
    delimiter, decimal, first = _first_numbers(lines, path.name, skip_rows)
    row = split_line(lines[first], delimiter)
    if len(row) < 2:
        raise InputRefused(f"{path.name}: one column only: a log needs the time and at least two channels")
    try:
        heads = heads_of(lines[skip_rows:first], delimiter, decimal, row)
    except InputRefused as refusal:
        raise refusal.at(path.name) from None
    zones = {
        name: zone for name, cell in zip(heads.names, row, strict=True) if (zone := zone_of(cell)) is not None
    }
    per_row = max(1.0, size / max(1, len(lines)))
    return Dialect(
        delimiter=delimiter,
        decimal=decimal,
        encoding=encoding,
        skip=first,
        names=heads.names,
        units=heads.units | dict.fromkeys(zones, "s"),
        zones=zones,
        notes=heads.notes,
        rows=int(path.stat().st_size / per_row),
    )


def open_delimited(path: Path, reading: Reading) -> Table:
    """Open a CSV or TSV log."""
    dialect = dialect_of(path, reading.skip_rows)
    return Table(
        source=path.name,
        names=dialect.names,
        units=dialect.units,
        rows=dialect.rows,
        read=lambda names: _read(path, dialect, names),
        notes=dialect.notes,
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
                    return delimiter, decimal, _with_missing_above(lines, number, delimiter, len(cells))
    shown = next((line.strip() for line in reversed(lines) if line.strip()), "")[:40]
    raise InputRefused(
        f'{source}: no row of numbers up to line {len(lines)}, "{shown}": write every row as numbers alone'
    )


def _with_missing_above(lines: Sequence[str], number: int, delimiter: str, width: int) -> int:
    """The first row also where it and its next are rows of missing values, such as ``---``."""
    while number > 0:
        cells = split_line(lines[number - 1], delimiter)
        if len(cells) != width or not any(cells) or any(cell not in MISSING for cell in cells):
            break
        number -= 1
    return number


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

    codec = "utf-8" if dialect.encoding != "cp1252" else "cp1252"
    found: dict[str, list[Any]] = {name: [] for name in names}
    for place, raw in enumerate(block.removesuffix(b"\n").split(b"\n"), start=number):
        if _NO_ROW.fullmatch(raw):
            continue
        if len(raw) > LONGEST_LINE:
            raise too_long(source, place)
        line = raw.decode(codec, errors="replace")
        cells = split_line(line.partition("#")[0] if dialect.delimiter == " " else line, dialect.delimiter)
        if len(cells) != len(dialect.names):
            raise InputRefused(
                f"{source}: line {place} has {len(cells)} cells, the header {len(dialect.names)}: "
                "mend or cut that line"
            )
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
        return float(cell.replace(",", ".") if dialect.decimal == "," else cell)
    wanted = "a time as in the first row" if stamp else "a number or leave it empty"
    raise InputRefused(f'{source}: line {place}, column "{name}" holds "{cell[:30]}": write {wanted}')


def _kind(zone: str) -> Any:
    import pyarrow as pa

    return pa.timestamp("ns", tz=zone or None)
