"""HDF5, NetCDF and MATLAB files as columns, tried in a process of its own."""

import os
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.identification.logs.log import (
    BLOCK_ROWS,
    LARGEST_CHUNK,
    LARGEST_IN_MEMORY,
    Blocks,
    ColumnMap,
    Table,
    require_fitting,
    too_large,
)
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

SECONDS = 3.0
BYTES_PER_SECOND = 50e6
LONGEST_WAIT = 15.0
"""Wall clock per second of processor time."""
OUT_OF_MEMORY = 1
"""Status of the process that reads on trial."""


def require_readable(path: Path, read: Callable[[], object]) -> None:
    """Refuse a file over which the process that reads it dies, or takes more time or memory than it may.

    Time goes by its size; unpacked it is held twice. Elsewhere than on Linux nothing is tried.
    """
    if sys.platform != "linux":
        return
    import resource

    seconds = SECONDS + path.stat().st_size / BYTES_PER_SECOND

    def tried() -> None:
        """Read, and never return."""
        try:
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends it
            resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 2))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (taken + 2 * LARGEST_IN_MEMORY,) * 2)
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, 1)
            os.dup2(nowhere, 2)
            read()
        except MemoryError:
            os._exit(OUT_OF_MEMORY)
        finally:
            os._exit(0)

    child = get_context("fork").Process(target=tried)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of threads: the child calls one library and ends
        child.start()
    try:
        child.join(LONGEST_WAIT * seconds)
        status = child.exitcode
    finally:
        child.kill()
    if status == OUT_OF_MEMORY:
        raise too_large(path)
    if status is None or status < 0:
        endless = status is None or -status == signal.SIGXCPU
        what = "reading it does not end" if endless else f"its library ends by signal {-(status or 0)}"
        raise InputRefused(f"{path.name}: is damaged ({what}): write it again")


TRIED, MOST_ROWS = 64, 64
"""Columns of which the first block is read on trial; rows of a matrix that are columns of a log."""
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"

Entries = dict[str, tuple[Any, Mapping[str, Any]]]
"""Arrays, or datasets of a file that is open, by the name of their column, each with its attributes."""


def is_hdf5(path: Path) -> bool:
    """Whether a file is HDF5, a MATLAB 7.3 file included."""
    with path.open("rb") as file:
        start = file.read(520)
    return start[:8] == HDF5_SIGNATURE or start[512:520] == HDF5_SIGNATURE


def open_hdf5(path: Path) -> Table:
    """Open an HDF5 log: a column is a dataset ``a.b``, or a row of one, ``a.b[0]``; tried before."""

    def tried() -> None:
        table = table_of(path, lambda: _datasets(path))
        for name in table.names[:TRIED]:
            next(table.read((name,)))

    require_readable(path, tried)
    return table_of(path, lambda: _datasets(path))


@contextmanager
def _datasets(path: Path) -> Iterator[Entries]:
    import h5py

    found: Entries = {}

    def visit(name: str, entry: Any) -> None:
        if not isinstance(entry, h5py.Dataset) or entry.shape is None or name.startswith("#"):
            return
        if entry.external or entry.is_virtual:
            said = f'{path.name}: "{name}" lies in other files (external or virtual)'
            raise InputRefused(f"{said}: write one file, as with h5repack")
        size = int(np.prod(entry.chunks)) * entry.dtype.itemsize if entry.chunks else 0
        if size > LARGEST_CHUNK:
            raise InputRefused(
                f"{path.name}: has chunks of {size / 2**20:.0f} MiB, at most {LARGEST_CHUNK / 2**20:.0f} are "
                "unpacked at once: write smaller ones"
            )
        found[name.replace("/", ".")] = entry, entry.attrs

    with h5py.File(path, "r") as file:
        file.visititems(visit)
        yield found


def open_netcdf(path: Path, reading: ColumnMap) -> Table:
    """Open a NetCDF log, of HDF5 or of the classic kind, which is read whole."""
    if is_hdf5(path):
        return open_hdf5(path)
    from scipy.io import netcdf_file

    require_fitting(path, path.stat().st_size)
    with netcdf_file(str(path), mmap=False) as file:
        found = {name: (v[:].copy(), v._attributes) for name, v in file.variables.items() if v.shape}
    return table_of(path, lambda: nullcontext(found))


def open_matlab(path: Path, reading: ColumnMap) -> Table:
    """Open a MATLAB file; a column is a variable, a field ``a.b``, or a row of a matrix ``a.b[0]``."""
    if is_hdf5(path):
        return open_hdf5(path)
    from scipy import io

    require_readable(path, lambda: io.loadmat(path))
    variables = io.loadmat(path, squeeze_me=True, struct_as_record=False)
    found: Entries = {}

    def visit(name: str, value: Any, depth: int = 0) -> None:
        if hasattr(value, "_fieldnames") and depth < 6:
            for field in value._fieldnames:
                visit(f"{name}.{field}", getattr(value, field), depth + 1)
        else:
            found[name] = np.asarray(value).T, {}  # as HDF5 has it

    for name, value in variables.items():
        if name and not name.startswith("__"):
            visit(name, value)
    return table_of(path, lambda: nullcontext(found))


def table_of(path: Path, opened: Callable[[], AbstractContextManager[Entries]]) -> Table:
    """Vectors of numbers, and rows of flat matrices, as columns; what is neither they nor one number is not.

    A block at a time becomes doubles, packed values unpacked and the fill value NaN.
    """
    columns: dict[str, tuple[str, int | None]] = {}
    units: dict[str, str] = {}
    scalars: dict[str, float] = {}
    rows = 0
    with opened() as entries:
        for name, (values, attributes) in entries.items():
            shape = tuple(k for k in values.shape if k != 1)
            own: dict[str, tuple[str, int | None]] = {}
            if values.dtype.kind not in "fiub" or values.size == 0:
                continue
            if not shape:
                scalars[name] = float(np.ravel(values[()])[0])
            elif len(shape) == 1:
                own = {name: (name, None)}
            elif len(shape) == 2 and min(shape) <= MOST_ROWS:
                own = {f"{name}[{k}]": (name, k) for k in range(min(shape))}
            columns.update(own)
            rows = max(rows, *shape) if own else rows
            unit = attributes.get("units", "")
            if unit := unit.decode(errors="replace") if isinstance(unit, bytes) else str(unit):
                units.update(dict.fromkeys(own, unit))

    def read(names: tuple[str, ...]) -> Blocks:
        with opened() as entries:
            found = {name: entries[columns[name][0]] for name in names}
            lengths = {name: max(values.shape) for name, (values, _) in found.items()}
            if len(set(lengths.values())) > 1:
                said = ", ".join(f"{name} {length}" for name, length in lengths.items())
                said = f"{path.name}: channels differ in length ({said})"
                raise InputRefused(f"{said}: choose channels of one length")
            for start in range(0, max(lengths.values()), BLOCK_ROWS):
                block = {}
                for name, (values, attributes) in found.items():
                    index: list[Any] = [columns[name][1] or 0 if size > 1 else 0 for size in values.shape]
                    index[int(np.argmax(values.shape))] = slice(start, start + BLOCK_ROWS)
                    block[name] = _scaled(values[tuple(index)], attributes)
                yield block

    return Table(source=path.name, names=tuple(columns), units=units, rows=rows, read=read, scalars=scalars)


def _scaled(values: Any, attributes: Mapping[str, Any]) -> Array:
    """Packed values unpacked, and the fill value as NaN."""
    array = np.array(values, dtype=float)
    fill, factor, offset = (
        np.ravel(attributes[name])[0] if name in attributes else default
        for name, default in (("_FillValue", np.nan), ("scale_factor", 1.0), ("add_offset", 0.0))
    )
    array[array == fill] = np.nan
    return array * float(factor) + float(offset)
