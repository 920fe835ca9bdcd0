"""Parquet logs, read in batches; units from the column heads or from their metadata."""

from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.identification.logs.quantities import name_and_unit
from cabledrive.identification.logs.table import (
    BLOCK_ROWS,
    LARGEST_UNPACKED,
    Blocks,
    Reading,
    Table,
    seconds_of,
)
from cabledrive.parameters import InputRefused


def open_parquet(path: Path, reading: Reading | None = None) -> Table:
    """Open a Parquet log.

    Raises `InputRefused` if two columns have one name, or it would unpack to more than `LARGEST_UNPACKED`.
    """
    from pyarrow import parquet

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
    units = {name: _unit(entry) for name, entry in heads.items() if _unit(entry)}

    def read(names: tuple[str, ...]) -> Blocks:
        return _read(file, heads, names, path.name)

    return Table(source=path.name, names=tuple(heads), units=units, rows=meta.num_rows, read=read)


def _read(file: Any, heads: dict[str, Any], names: tuple[str, ...], source: str) -> Blocks:
    wanted = [heads[name].name for name in names]
    starts: dict[str, int] = {}
    rows = 0
    for batch in file.iter_batches(batch_size=BLOCK_ROWS, columns=wanted, use_threads=False):
        rows += batch.num_rows
        yield {name: _floats(batch.column(heads[name].name), name, source, starts) for name in names}
    if rows != file.metadata.num_rows:
        raise InputRefused(f"{source}: is damaged ({rows} of {file.metadata.num_rows} rows): write it again")


def _unit(entry: Any) -> str:
    stated = (entry.metadata or {}).get(b"unit") or (entry.metadata or {}).get(b"units")
    return stated.decode(errors="replace") if stated else name_and_unit(entry.name)[1]


def _floats(column: Any, name: str, source: str, starts: dict[str, int]) -> Any:
    import pyarrow as pa

    kind = column.type
    if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
        return seconds_of(column, name, starts)
    if not (pa.types.is_floating(kind) or pa.types.is_integer(kind)):
        raise InputRefused(f'{source}: column "{name}" holds {kind}, not numbers: choose another column')
    return column.to_numpy(zero_copy_only=False).astype(np.float64, copy=False)
