"""A result as a NetCDF file, written block by block so that it need not fit into memory."""

import errno
import os
import shutil
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.parameters.files import put_in_place
from cabledrive.simulation.careful_file import CarefulFile, interrupts_deferred
from cabledrive.simulation.labels import Content, Variable

RECORDS_PER_BLOCK = 50_000
BESIDES = 1 << 20  # bytes a file may need beyond its numbers


def write_netcdf(content: Content, path: Path, temporary: Path, *, force: bool = False) -> None:
    """Write a result, see `cabledrive.simulation.labels`; the file appears whole or not at all.

    ``temporary``: its name until it is whole, on the same disk. Refused if another process has written the
    file meanwhile (without `force`); `OSError` if the disk refuses.
    """
    try:
        _find_room(content, temporary)
        _write_carefully(content, temporary)
        _compare(content, temporary)
        with temporary.open("rb+") as file:
            os.fsync(file.fileno())
        put_in_place(temporary, path, force=force)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def _write_carefully(content: Content, path: Path) -> None:
    with interrupts_deferred() as waiting:
        file = CarefulFile(path)
        try:
            _write(content, file, waiting)
        except Exception as error:  # HDF5 read what could not be written
            raise file.error or error from None
        finally:
            file.close()
        if file.error is not None:
            raise file.error


def _compare(content: Content, path: Path) -> None:
    """Read the file again: errors on closing it are not passed on by its library."""
    import h5netcdf

    with h5netcdf.File(path, "r") as file:
        for variable in (*content.coordinates, *content.variables):
            stored, values = file.variables.get(variable.name), variable.values
            if stored is None or stored.shape != values.shape or not _same(stored, values):
                raise OSError(errno.EIO, f"{variable.name} was not written whole")
        for name, (_, texts) in content.words.items():
            if [bytes(text) for text in file.variables[name][:]] != [text.encode() for text in texts]:
                raise OSError(errno.EIO, f"{name} was not written whole")
        if not set(content.attributes) <= set(file.attrs):
            raise OSError(errno.EIO, "attributes were not written whole")


def _same(stored: Any, values: Any) -> bool:
    blocks = (slice(first, first + RECORDS_PER_BLOCK) for first in range(0, len(values), RECORDS_PER_BLOCK))
    return all(np.array_equal(stored[block], values[block], equal_nan=True) for block in blocks)


def _find_room(content: Content, path: Path) -> None:
    """Refuse to begin where the disk has not enough room: HDF5 does not survive a disk that fills up."""
    numbers = sum(variable.values.nbytes for variable in (*content.coordinates, *content.variables))
    needed = numbers + BESIDES
    if not hasattr(os, "posix_fallocate"):
        if shutil.disk_usage(path.parent).free < needed:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return
    with path.open("wb") as file:
        os.posix_fallocate(file.fileno(), 0, needed)  # knows of quotas, too


def _write(content: Content, target: CarefulFile, waiting: list[int]) -> None:
    """Write all, or a part where an interrupt is waiting."""
    import h5netcdf

    with h5netcdf.File(target, "w") as file:
        described = [*content.coordinates, *content.variables]
        for variable in described:
            for name, size in zip(variable.dimensions, variable.values.shape, strict=True):
                if name not in file.dimensions:
                    file.dimensions[name] = size
        for name, (dimension, values) in content.words.items():
            if dimension not in file.dimensions:
                file.dimensions[dimension] = len(values)
            text = file.create_variable(name, (dimension,), dtype=_text())
            text[:] = np.array(values, dtype=object)
        for variable in described:
            _fill(file, variable, waiting)
        beside = {v.name for v in content.coordinates} | set(content.words)
        file.attrs["coordinates"] = " ".join(sorted(beside - set(file.dimensions)))  # CF: not data
        for key, value in content.attributes.items():
            file.attrs[key] = value


def _text() -> Any:
    import h5py

    return h5py.string_dtype(encoding="utf-8")


def _fill(file: Any, variable: Variable, waiting: list[int]) -> None:
    stored = file.create_variable(variable.name, variable.dimensions, dtype=np.float64)
    for first in range(0, len(variable.values), RECORDS_PER_BLOCK):
        if waiting:
            return
        block = slice(first, first + RECORDS_PER_BLOCK)
        stored[block] = variable.values[block]
    stored.attrs["units"] = variable.unit
    stored.attrs["long_name"] = variable.meaning
