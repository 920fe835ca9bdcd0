"""The door to every log file: the format by its ending; Parquet in batches."""

import re
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from cabledrive.identification.logs.column_map import name_and_unit
from cabledrive.identification.logs.delimited import open_delimited
from cabledrive.identification.logs.hierarchical import open_matlab, open_netcdf
from cabledrive.identification.logs.messages import open_mcap, open_rosbag
from cabledrive.identification.logs.table import (
    BLOCK_ROWS,
    LARGEST_UNPACKED,
    Blocks,
    Reading,
    Table,
    floats_of,
)
from cabledrive.parameters import InputRefused
from cabledrive.parameters.files import require_regular


def open_parquet(path: Path, reading: Reading) -> Table:
    """Open a Parquet log."""
    from pyarrow import parquet, types

    file = parquet.ParquetFile(path)
    meta = file.metadata
    unpacked = sum(meta.row_group(k).total_byte_size for k in range(meta.num_row_groups))
    if max(unpacked, 8 * meta.num_rows) > LARGEST_UNPACKED:
        size, most = max(unpacked, 8 * meta.num_rows) / 2**30, LARGEST_UNPACKED / 2**30
        raise InputRefused(
            f"{path.name}: unpacks to {size:.0f} GiB, at most {most:.0f} GiB are read: split it"
        )
    heads: dict[str, Any] = {}
    for entry in file.schema_arrow:
        name = name_and_unit(entry.name)[0]
        if name in heads:
            raise InputRefused(f'{path.name}: two columns are called "{name}": rename one')
        heads[name] = entry

    def read(names: tuple[str, ...]) -> Blocks:
        starts: dict[str, int] = {}
        rows, kinds = 0, ("floating", "integer", "timestamp", "duration")
        for name in names:
            if not any(getattr(types, f"is_{kind}")(heads[name].type) for kind in kinds):
                held = f'column "{name}" holds {heads[name].type}'
                raise InputRefused(f"{path.name}: {held}, not numbers: choose another column")
        wanted = [heads[name].name for name in names]
        for batch in file.iter_batches(batch_size=BLOCK_ROWS, columns=wanted, use_threads=False):
            rows += batch.num_rows
            yield {name: floats_of(batch.column(heads[name].name), name, starts) for name in names}
        if rows != meta.num_rows:
            raise InputRefused(f"{path.name}: is damaged ({rows} of {meta.num_rows} rows): write it again")

    units = {name: unit for name, entry in heads.items() if (unit := _unit(entry))}
    return Table(source=path.name, names=tuple(heads), units=units, rows=meta.num_rows, read=read)


def _unit(entry: Any) -> str:
    stated = (entry.metadata or {}).get(b"unit") or (entry.metadata or {}).get(b"units")
    return stated.decode(errors="replace") if stated else name_and_unit(entry.name)[1]


FORMATS: dict[str, Callable[[Path, Reading], Table]] = {
    ".csv": open_delimited,
    ".tsv": open_delimited,
    ".txt": open_delimited,
    ".dat": open_delimited,
    ".parquet": open_parquet,
    ".mat": open_matlab,
    ".nc": open_netcdf,
    ".h5": open_netcdf,
    ".mcap": open_mcap,
    ".db3": open_rosbag,
}
TEXTS = (".csv", ".tsv", ".txt", ".dat")
LONGEST_CAUSE = 110


def open_table(path: str | Path, reading: Reading | None = None, *, text: bool = False) -> Table:
    """Open a log file of any format; only its head is read, or all of it where its format asks for that.

    ``text``: take the file for a text table whatever its ending is. Whatever a library raises while opening
    or reading is an `InputRefused`.
    """
    path, reading = Path(path), reading or Reading()
    require_regular(path, "give the path of a log")
    ending = ".csv" if text else path.suffix.lower()
    if ending not in FORMATS:
        raise InputRefused(
            f"{path.name}: logs end in {', '.join(FORMATS)}: unpack compressed files, rename others"
        )
    if path.stat().st_size == 0:
        raise InputRefused(f"{path.name}: is empty: give a log with a header and rows of numbers")
    if reading.skip_rows and ending not in TEXTS:
        raise InputRefused(f"{path.name}: --skip-rows is for text logs ({', '.join(TEXTS)}): leave it out")
    with readable(path.name):
        table = FORMATS[ending](path, reading)
    if not table.names:
        raise InputRefused(f"{path.name}: holds no column of numbers: save the channels as vectors")

    def read(names: tuple[str, ...]) -> Blocks:
        blocks = iter(table.read(names))
        while True:
            with readable(path.name):
                block = next(blocks, None)
            if block is None:
                return
            yield block

    return replace(table, read=read)


@contextmanager
def readable(source: str) -> Iterator[None]:
    """Turn whatever a library raises over a file into one refusal; an interrupt comes through."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of the libraries, about files that they read all the same
            yield
    except InputRefused:
        raise
    except MemoryError:
        raise InputRefused(
            f"{source}: is damaged, or holds more than fits into memory: write it again, in smaller parts"
        ) from None
    except Exception as error:  # libraries raise many kinds for a damaged file
        cause = re.sub(r"\s+", " ", getattr(error, "strerror", None) or str(error) or type(error).__name__)
        raise InputRefused(
            f"{source}: is damaged or unreadable ({cause[:LONGEST_CAUSE]}): write it again"
        ) from None
