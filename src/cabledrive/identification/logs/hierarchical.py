"""HDF5 files (MATLAB 7.3, NetCDF 4) and classic NetCDF as columns; datasets by their path."""

from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.identification.logs.table import (
    BLOCK_ROWS,
    LARGEST_UNPACKED,
    Array,
    Blocks,
    Table,
    check_lengths,
)
from cabledrive.identification.logs.unpacking import LARGEST_CHUNK
from cabledrive.parameters import InputRefused

HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def is_hdf5(path: Path) -> bool:
    """Whether a file is HDF5, a MATLAB 7.3 file included.

    Parameters
    ----------
    path : Path

    Returns
    -------
    bool
    """
    with path.open("rb") as file:
        start = file.read(520)
    return start[:8] == HDF5_SIGNATURE or start[512:520] == HDF5_SIGNATURE


def open_hdf5(path: Path) -> Table:
    """Open an HDF5 log: a column is a dataset ``a.b``, or a row of one, ``a.b[0]``.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Table

    Raises
    ------
    InputRefused
        If it is damaged, holds no vector, or would unpack to more than `LARGEST_UNPACKED`.
    """
    import h5py

    columns: dict[str, tuple[str, int | None]] = {}
    units: dict[str, str] = {}
    scalars: dict[str, float] = {}

    def visit(name: str, entry: Any) -> None:
        if isinstance(entry, h5py.Dataset) and entry.dtype.kind in "fiu" and not name.startswith("#"):
            _collect(name, entry, columns, units, scalars)

    try:
        with h5py.File(path, "r") as file:
            file.visititems(visit)
            chunks = [_chunk_bytes(file[dataset]) for dataset, _ in columns.values()]
            sizes = {dataset: int(np.prod(file[dataset].shape)) for dataset, _ in columns.values()}
    except (OSError, RuntimeError) as error:
        raise InputRefused(f"{path.name}: is no readable HDF5 file ({error}): write it again") from None
    if not columns:
        raise InputRefused(
            f"{path.name}: holds no vector of numbers (objects cannot be read): save plain vectors"
        )
    largest = 8 * max(sizes.values())
    if largest > LARGEST_UNPACKED:
        raise InputRefused(f"{path.name}: unpacks to {largest / 2**30:.0f} GiB: split it")
    if max(chunks) > LARGEST_CHUNK:
        size, most = max(chunks) / 2**20, LARGEST_CHUNK / 2**20
        raise InputRefused(
            f"{path.name}: has chunks of {size:.0f} MiB, at most {most:.0f} are unpacked at once: "
            "write smaller ones"
        )

    def read(names: tuple[str, ...]) -> Blocks:
        return _read(path, columns, names)

    return Table(source=path.name, names=tuple(columns), units=units, rows=None, read=read, scalars=scalars)


def open_classic_netcdf(path: Path) -> Table:
    """Open a NetCDF 3 log.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Table

    Raises
    ------
    InputRefused
        If it is damaged.
    """
    from scipy.io import netcdf_file

    try:
        with netcdf_file(str(path), mmap=False) as file:
            found = {name: (v[:].copy(), v._attributes) for name, v in file.variables.items()}
    except Exception as error:  # scipy raises many kinds for a damaged file
        raise InputRefused(f"{path.name}: is no readable NetCDF file ({error}): write it again") from None
    vectors = {name: v for name, v in found.items() if v[0].ndim == 1 and v[0].dtype.kind in "fiu"}
    units = {name: _text(a["units"]) for name, (_, a) in vectors.items() if "units" in a}

    def read(names: tuple[str, ...]) -> Blocks:
        check_lengths({name: len(vectors[name][0]) for name in names}, path.name)
        yield {name: _scaled(vectors[name][0], vectors[name][1]) for name in names}

    return Table(source=path.name, names=tuple(vectors), units=units, rows=None, read=read)


def open_netcdf(path: Path) -> Table:
    """Open a NetCDF log of either kind.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Table
    """
    return open_hdf5(path) if is_hdf5(path) else open_classic_netcdf(path)


def _chunk_bytes(dataset: Any) -> int:
    """Bytes of one chunk unpacked; 0 where the dataset lies in the file as it is."""
    return int(np.prod(dataset.chunks)) * dataset.dtype.itemsize if dataset.chunks else 0


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
    factor = float(np.ravel(attributes.get("scale_factor", 1.0))[0])
    return array * factor + float(np.ravel(attributes.get("add_offset", 0.0))[0])


def _text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)
