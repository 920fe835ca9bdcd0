"""HDF5 files (MATLAB 7.3, NetCDF 4) and classic NetCDF as columns; datasets by their path."""

from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.identification.logs.table import (
    BLOCK_ROWS,
    Array,
    Blocks,
    Reading,
    Table,
    check_lengths,
)
from cabledrive.identification.logs.trial import require_readable
from cabledrive.identification.logs.unpacking import LARGEST_CHUNK, require_fitting
from cabledrive.parameters import InputRefused

TRIED = 64
"""Columns of which the first block is read on trial."""
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def is_hdf5(path: Path) -> bool:
    """Whether a file is HDF5, a MATLAB 7.3 file included."""
    with path.open("rb") as file:
        start = file.read(520)
    return start[:8] == HDF5_SIGNATURE or start[512:520] == HDF5_SIGNATURE


def open_hdf5(path: Path) -> Table:
    """Open an HDF5 log: a column is a dataset ``a.b``, or a row of one, ``a.b[0]``.

    It is opened, and its first block read, in a process of its own before.

    Raises `InputRefused` if it holds no vector, keeps numbers outside itself, has chunks larger than
    `LARGEST_CHUNK`, or the library crashes over it.
    """
    require_readable(
        path, lambda: [next(table.read((n,))) for table in (_opened(path),) for n in table.names[:TRIED]]
    )
    return _opened(path)


def _opened(path: Path) -> Table:
    import h5py

    columns: dict[str, tuple[str, int | None]] = {}
    units: dict[str, str] = {}
    scalars: dict[str, float] = {}

    def visit(name: str, entry: Any) -> None:
        if isinstance(entry, h5py.Dataset) and entry.shape is not None and not name.startswith("#"):
            _require_inside(name, entry, path.name)
            if entry.dtype.kind in "fiu":
                _collect(name, entry, columns, units, scalars)

    with h5py.File(path, "r") as file:
        file.visititems(visit)
        sizes = [max(file[dataset].shape) for dataset, _ in columns.values()]
    if not columns:
        raise InputRefused(
            f"{path.name}: holds no vector of numbers (objects cannot be read): save plain vectors"
        )

    def read(names: tuple[str, ...]) -> Blocks:
        return _read(path, columns, names)

    return Table(
        source=path.name, names=tuple(columns), units=units, rows=max(sizes), read=read, scalars=scalars
    )


def _require_inside(name: str, entry: Any, source: str) -> None:
    """Refuse numbers of other files, and chunks that unpack to more than memory should hold."""
    if entry.external or entry.is_virtual:
        raise InputRefused(
            f'{source}: "{name}" lies in other files (external or virtual storage): write one file, as with '
            "h5repack"
        )
    size = int(np.prod(entry.chunks)) * entry.dtype.itemsize if entry.chunks else 0
    if size > LARGEST_CHUNK:
        raise InputRefused(
            f"{source}: has chunks of {size / 2**20:.0f} MiB, at most {LARGEST_CHUNK / 2**20:.0f} are "
            "unpacked at once: write smaller ones"
        )


def open_classic_netcdf(path: Path) -> Table:
    """Open a NetCDF 3 log.

    Raises `InputRefused` if it is larger than `LARGEST_IN_MEMORY`, as it is read whole.
    """
    from scipy.io import netcdf_file

    require_fitting(path, path.stat().st_size)
    with netcdf_file(str(path), mmap=False) as file:
        found = {name: (v[:].copy(), v._attributes) for name, v in file.variables.items() if v.shape}
    vectors = {name: v for name, v in found.items() if v[0].ndim == 1 and v[0].dtype.kind in "fiu"}
    units = {name: _text(a["units"]) for name, (_, a) in vectors.items() if "units" in a}

    def read(names: tuple[str, ...]) -> Blocks:
        check_lengths({name: len(vectors[name][0]) for name in names}, path.name)
        yield {name: _scaled(vectors[name][0], vectors[name][1]) for name in names}

    rows = max((len(values) for values, _ in vectors.values()), default=0)
    return Table(source=path.name, names=tuple(vectors), units=units, rows=rows, read=read)


def open_netcdf(path: Path, reading: Reading | None = None) -> Table:
    """Open a NetCDF log of either kind."""
    return open_hdf5(path) if is_hdf5(path) else open_classic_netcdf(path)


def _collect(
    name: str, entry: Any, columns: dict[str, Any], units: dict[str, str], scalars: dict[str, float]
) -> None:
    path = name.replace("/", ".")
    unit = _text(entry.attrs.get("units", ""))
    shape = tuple(k for k in entry.shape if k != 1)
    if not shape and entry.size == 1:
        scalars[path] = float(np.ravel(entry[()])[0])
    elif len(shape) == 1:
        columns[path] = (name, None)
    elif len(shape) == 2 and min(shape) <= 64:
        columns |= {f"{path}[{k}]": (name, k) for k in range(min(shape))}
    for column in (path, *(f"{path}[{k}]" for k in range(64))):
        if unit and column in columns:
            units[column] = unit


def _read(path: Path, columns: dict[str, tuple[str, int | None]], names: tuple[str, ...]) -> Blocks:
    import h5py

    with h5py.File(path, "r") as file:
        lengths = {name: max(file[columns[name][0]].shape) for name in names}
        check_lengths(lengths, path.name)
        for start in range(0, max(lengths.values()), BLOCK_ROWS):
            part = slice(start, start + BLOCK_ROWS)
            yield {name: _slice(file[columns[name][0]], columns[name][1], part) for name in names}


def _slice(dataset: Any, row: int | None, part: slice) -> Array:
    shape = dataset.shape
    along = int(np.argmax(shape))
    index = tuple(part if k == along else (row or 0 if shape[k] > 1 else 0) for k in range(len(shape)))
    return _scaled(dataset[index], dataset.attrs)


def _scaled(values: Any, attributes: Any) -> Array:
    """Packed values unpacked, and the fill value as NaN."""
    array = np.array(values, dtype=float)
    if "_FillValue" in attributes:
        array[array == np.ravel(attributes["_FillValue"])[0]] = np.nan
    if "scale_factor" in attributes:
        array *= float(np.ravel(attributes["scale_factor"])[0])
    if "add_offset" in attributes:
        array += float(np.ravel(attributes["add_offset"])[0])
    return array


def _text(value: Any) -> str:
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)
