"""Parquet logs, read in batches; units from the column heads or from their metadata."""

from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.identification.logs.delimited import name_and_unit
from cabledrive.identification.logs.table import BLOCK_ROWS, LARGEST_UNPACKED, Blocks, Table
from cabledrive.parameters import InputRefused


def open_parquet(path: Path) -> Table:
    """Open a Parquet log.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Table

    Raises
    ------
    InputRefused
        If it cannot be read, or would unpack to more than `LARGEST_UNPACKED`.
    """
    import pyarrow as pa
    from pyarrow import parquet

    try:
        file = parquet.ParquetFile(path)
    except (pa.ArrowException, OSError) as error:
        raise InputRefused(f"{path.name}: is no readable Parquet file ({error}): write it again") from None
    meta = file.metadata
    unpacked = sum(meta.row_group(k).total_byte_size for k in range(meta.num_row_groups))
    if max(unpacked, 8 * meta.num_rows) > LARGEST_UNPACKED:
        size, most = max(unpacked, 8 * meta.num_rows) / 2**30, LARGEST_UNPACKED / 2**30
        raise InputRefused(
            f"{path.name}: unpacks to {size:.0f} GiB, at most {most:.0f} GiB are read: split it"
        )
    heads = {name_and_unit(entry.name)[0]: entry for entry in file.schema_arrow}
    units = {name: _unit(entry) for name, entry in heads.items() if _unit(entry)}

    def read(names: tuple[str, ...]) -> Blocks:
        wanted = [heads[name].name for name in names]
        try:
            for batch in file.iter_batches(batch_size=BLOCK_ROWS, columns=wanted, use_threads=False):
                yield {name: _floats(batch.column(heads[name].name), name, path.name) for name in names}
        except pa.ArrowException as error:
            raise InputRefused(f"{path.name}: is damaged ({error}): write it again") from None

    return Table(source=path.name, names=tuple(heads), units=units, rows=meta.num_rows, read=read)


def _unit(entry: Any) -> str:
    stated = (entry.metadata or {}).get(b"unit") or (entry.metadata or {}).get(b"units")
    return stated.decode() if stated else name_and_unit(entry.name)[1]


def _floats(column: Any, name: str, source: str) -> Any:
    import pyarrow as pa

    kind = column.type
    if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
        seconds = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}[kind.unit]
        return column.cast(pa.int64()).to_numpy(zero_copy_only=False) * seconds
    if not (pa.types.is_floating(kind) or pa.types.is_integer(kind)):
        raise InputRefused(f'{source}: column "{name}" holds {kind}, not numbers: choose another column')
    return column.to_numpy(zero_copy_only=False).astype(np.float64, copy=False)
