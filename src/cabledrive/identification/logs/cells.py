"""Cells of a text log: numbers with a decimal mark, ISO 8601 times, and the words for a missing value."""

import csv
import re

MISSING = (
    "",
    *("NaN", "nan", "NAN", "-nan", "NA", "N/A", "n/a", "#N/A"),
    *("null", "NULL", "None", "-", "--", "---"),
)
_STAMP = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(?:\.\d{1,9})?(Z|[+-]\d\d:?\d\d)?")


def split_line(line: str, delimiter: str) -> list[str]:
    """Cells of one line, quotes taken off.

    ``delimiter``: a space stands for any white space.
    """
    if delimiter == " ":
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), [])]


def is_number(cell: str, decimal: str) -> bool:
    """Whether a cell is one number.

    ``decimal``, {".", ","}.
    """
    if (decimal == "," and "." in cell) or "_" in cell or not cell.isascii():
        return False
    try:
        float(cell.replace(",", ".") if decimal == "," else cell)
    except ValueError:
        return False
    return True


def zone_of(cell: str) -> str | None:
    """Time zone of an ISO 8601 time such as ``2026-01-02T03:04:05.678Z``.

    Returns "UTC" where it states its distance from it, else empty; None: the cell is no such time.
    """
    match = _STAMP.fullmatch(cell)
    return None if match is None else "UTC" if match[1] else ""
