"""Text logs: delimiter, decimal mark, comments, header and units recognised from the first lines."""

import codecs
import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.identification.logs.table import Blocks, Table
from cabledrive.parameters import InputRefused

SAMPLE_BYTES = 1 << 16
BLOCK_BYTES = 1 << 24
DELIMITERS = (",", "\t", ";", " ")
MISSING = ("", "NaN", "nan", "NAN", "NA", "N/A", "null")
_UNIT = re.compile(r"^\s*(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]\s*$")


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """How a text log is written.

    Attributes
    ----------
    delimiter : str
        A space stands for any white space.
    decimal : {".", ","}
    encoding : str
        Unicode where the bytes are valid, else Windows-1252, as many a logger writes "°" and "µ".
    skip : int
        Lines before the first row of numbers.
    names : tuple of str
        Columns; numbered from 1 where there is no header.
    units : dict of str to str
    """

    delimiter: str
    decimal: str
    encoding: str
    skip: int
    names: tuple[str, ...]
    units: dict[str, str]


def name_and_unit(head: str) -> tuple[str, str]:
    """Part a column head such as "torque [N m]" or "angle (deg)".

    Parameters
    ----------
    head : str

    Returns
    -------
    name, unit : str
        The unit is empty where the head states none.
    """
    match = _UNIT.match(head)
    return (match[1], match[2]) if match and match[1] else (head.strip(), "")


def split_line(line: str, delimiter: str) -> list[str]:
    """Cells of one line, quotes taken off.

    Parameters
    ----------
    line, delimiter : str

    Returns
    -------
    list of str
    """
    if delimiter == " ":
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), [])]


def dialect_of(path: Path) -> Dialect:
    """Recognise how a text log is written.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Dialect

    Raises
    ------
    InputRefused
        If it is empty, no text, has no row of numbers, or one column only.
    """
    with path.open("rb") as file:
        sample = file.read(SAMPLE_BYTES)
    if not sample.strip():
        raise InputRefused(f"{path.name}: is empty: give a log with a header and rows of numbers")
    encoding = _encoding_of(sample)
    text = sample.decode(encoding, errors="replace")
    if "\0" in text:
        raise InputRefused(
            f"{path.name}: is not text: name its format by the ending (.parquet, .mat, .nc, .mcap)"
        )
    lines = text.splitlines()
    if len(sample) == SAMPLE_BYTES:
        lines = lines[:-1]
    delimiter, decimal, first = _first_numbers(lines, path.name)
    width = len(split_line(lines[first], delimiter))
    if width < 2:
        raise InputRefused(f"{path.name}: one column only: a log needs the time and at least two channels")
    heads = [number for number in range(first) if lines[number].strip() and not lines[number].startswith("#")]
    try:
        names, units = _header([split_line(lines[number], delimiter) for number in heads], width)
    except InputRefused as refusal:
        raise refusal.at(path.name) from None
    return Dialect(
        delimiter=delimiter, decimal=decimal, encoding=encoding, skip=first, names=names, units=units
    )


def open_delimited(path: Path) -> Table:
    """Open a CSV or TSV log.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Table
    """
    dialect = dialect_of(path)
    reader = _read_white_space if dialect.delimiter == " " else _read_arrow

    def read(names: tuple[str, ...]) -> Blocks:
        return reader(path, dialect, names)

    return Table(source=path.name, names=dialect.names, units=dialect.units, rows=None, read=read)


def _encoding_of(sample: bytes) -> str:
    """How the first bytes of a text are written; a character cut off at their end does not count."""
    if sample.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    try:
        codecs.getincrementaldecoder("utf-8-sig")().decode(sample)
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8-sig"


def _first_numbers(lines: list[str], source: str) -> tuple[str, str, int]:
    """Delimiter, decimal mark and number of the first line that holds numbers only."""
    for number, line in enumerate(lines):
        if not line.strip() or line.startswith("#"):
            continue
        for delimiter in DELIMITERS:
            cells = split_line(line, delimiter)
            for decimal in ".," if delimiter != "," else ".":
                filled = [cell for cell in cells if cell not in MISSING]
                if (
                    filled
                    and all(_is_number(cell, decimal) for cell in filled)
                    and (len(cells) > 1 or delimiter == " ")
                ):
                    return delimiter, decimal, number
    shown = next((line.strip() for line in reversed(lines) if line.strip()), "")[:40]
    raise InputRefused(
        f'{source}: no row of numbers up to line {len(lines)}, "{shown}": write every row as numbers alone'
    )


def _is_number(cell: str, decimal: str) -> bool:
    if decimal == "," and "." in cell:
        return False
    try:
        float(cell.replace(",", ".") if decimal == "," else cell)
    except ValueError:
        return False
    return "_" not in cell


def _header(rows: list[list[str]], width: int) -> tuple[tuple[str, ...], dict[str, str]]:
    """Names and units from the lines above the numbers: one line of heads, perhaps one of units below it."""
    rows = [row for row in rows if len(row) == width]
    if not rows:
        return tuple(f"column {k + 1}" for k in range(width)), {}
    parted = [name_and_unit(head) for head in rows[0]]
    names = tuple(name or f"column {k + 1}" for k, (name, _) in enumerate(parted))
    units = {name: unit for name, unit in parted if unit}
    if len(rows) > 1 and not units:
        units = {
            name: cell.strip("[]()") for name, cell in zip(names, rows[1], strict=True) if cell.strip("[]()")
        }
    if len(set(names)) < width:
        twice = next(name for name in names if names.count(name) > 1)
        raise InputRefused(f'two columns are called "{twice}": rename one')
    return names, units


def _read_arrow(path: Path, dialect: Dialect, names: tuple[str, ...]) -> Iterator[dict[str, Any]]:
    import pyarrow as pa
    from pyarrow import csv as arrow

    try:
        reader = arrow.open_csv(
            path,
            read_options=arrow.ReadOptions(
                skip_rows=dialect.skip,
                column_names=list(dialect.names),
                block_size=BLOCK_BYTES,
                encoding=dialect.encoding if dialect.encoding == "utf-16" else "utf8",
            ),
            parse_options=arrow.ParseOptions(delimiter=dialect.delimiter),
            convert_options=arrow.ConvertOptions(
                column_types=dict.fromkeys(dialect.names, pa.float64()),
                include_columns=list(names),
                null_values=list(MISSING),
                decimal_point=dialect.decimal,
            ),
        )
        for batch in reader:
            yield {name: batch.column(name).to_numpy(zero_copy_only=False) for name in names}
    except pa.ArrowInvalid as error:
        raise InputRefused(_fault(path, dialect, str(error))) from None


def _fault(path: Path, dialect: Dialect, message: str) -> str:
    """Where a text log stops being one: first row with another number of cells, or with text."""
    with path.open(encoding=dialect.encoding, errors="replace") as file:
        for number, line in enumerate(file, start=1):
            if number <= dialect.skip or not line.strip():
                continue
            cells = split_line(line, dialect.delimiter)
            if len(cells) != len(dialect.names):
                have, want = len(cells), len(dialect.names)
                return (
                    f"{path.name}: line {number} has {have} cells, the header {want}: mend or cut that line"
                )
            for name, cell in zip(dialect.names, cells, strict=True):
                if cell not in MISSING and not _is_number(cell, dialect.decimal):
                    found = f'{path.name}: line {number}, column "{name}" holds "{cell[:30]}"'
                    return f"{found}: write a number or leave it empty"
    return f"{path.name}: {message}"


def _read_white_space(path: Path, dialect: Dialect, names: tuple[str, ...]) -> Blocks:
    places = [dialect.names.index(name) for name in names]
    comma = dialect.decimal == ","
    with path.open(encoding=dialect.encoding, errors="replace") as file:
        for _ in range(dialect.skip):
            next(file)
        while lines := file.readlines(BLOCK_BYTES):
            try:
                told = [line.replace(",", ".") for line in lines] if comma else lines
                rows = np.loadtxt(told, usecols=places, ndmin=2)
            except ValueError as error:
                raise InputRefused(_fault(path, dialect, str(error))) from None
            yield {name: rows[:, k] for k, name in enumerate(names)}
