"""Columns of a table file, CSV or Parquet, as values of varied keys."""

import hashlib
from functools import cache
from pathlib import Path
from typing import Any

from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.files import require_regular

LARGEST_TABLE = 2_000_000_000
"""Bytes of a table file."""


def digest_of(path: Path) -> str:
    """Hash of the content of a table file. Raises `InputRefused` if it is no regular file or too large."""
    require_regular(path, "give a CSV or Parquet file")
    if path.stat().st_size > LARGEST_TABLE:
        raise InputRefused(f"larger than the {LARGEST_TABLE / 1e9:.0f} GB that are read").at(str(path))
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def column_of(path: Path, name: str) -> tuple[list[Any], str]:
    """Values of a column without gaps, and the unit in its heading, ``cable.pretension [N]``, or none."""
    table = _read(path, digest_of(path))
    headings = {str(heading).partition("[")[0].strip(): str(heading) for heading in table.column_names}
    if name not in headings:
        raise InputRefused(f'no column "{name}"{nearest(name, headings)}').at(str(path))
    column = table.column(headings[name])
    if column.null_count or not len(column):
        raise InputRefused(f'column "{name}" is empty or has gaps: fill them').at(str(path))
    unit = headings[name].partition("[")[2].partition("]")[0].strip()
    return column.to_pylist(), unit


@cache
def _read(path: Path, digest: str) -> Any:
    """The table; ``digest``: of its content, so that a changed file is read again."""
    import pyarrow

    try:
        if path.suffix.lower() in (".parquet", ".pq"):
            from pyarrow.parquet import read_table

            return read_table(path)
        from pyarrow.csv import read_csv

        return read_csv(path)
    except (pyarrow.ArrowException, OSError, ValueError) as error:
        why = str(error).splitlines()[0]
        raise InputRefused(f"is no table that can be read ({why}): give CSV or Parquet").at(
            str(path)
        ) from None
