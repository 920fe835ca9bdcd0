"""A result as labelled data, in memory or in a NetCDF file that is written block by block."""

import errno
import json
import os
import shutil
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.files import put_in_place

if TYPE_CHECKING:
    import xarray


class Variable(NamedTuple):
    """One array with what it takes to read it."""

    name: str
    dimensions: tuple[str, ...]
    values: Array
    unit: str
    meaning: str


class Content(NamedTuple):
    """All that a result holds: numbers that are coordinates, other numbers, words, and what is known."""

    coordinates: list[Variable]
    variables: list[Variable]
    words: dict[str, tuple[str, list[str]]]
    attributes: dict[str, Any]


def storable(known: dict[str, Any]) -> dict[str, Any]:
    """What is known, as numbers and text that a file takes."""
    return {
        key: value
        if isinstance(value, int | float | str) and value is not True and value is not False
        else json.dumps(value)
        for key, value in known.items()
    }


RECORDS_PER_BLOCK = 50_000
BESIDES = 1 << 20  # bytes a file may need beyond its numbers


def write_netcdf(content: Content, path: Path, temporary: Path, *, force: bool = False) -> None:
    """Write a result, see `cabledrive.simulation.netcdf`; the file appears whole or not at all.

    ``temporary``: its name until it is whole, on the same disk. Refused if another process has written the
    file meanwhile (without `force`); `OSError` if the disk refuses.
    """
    try:
        _find_room(content, temporary)
        _write(content, temporary)
        _compare(content, temporary)
        with temporary.open("rb+") as file:
            os.fsync(file.fileno())
        put_in_place(temporary, path, force=force)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def _compare(content: Content, path: Path) -> None:
    """Read the numbers again: errors on closing a file are not passed on by its library."""
    import h5netcdf

    with h5netcdf.File(path, "r") as file:
        for name, _, values, *_ in (*content.coordinates, *content.variables):
            stored = file.variables.get(name)
            blocks = (slice(i, i + RECORDS_PER_BLOCK) for i in range(0, len(values), RECORDS_PER_BLOCK))
            if stored is None or not all(
                np.array_equal(stored[b], values[b], equal_nan=True) for b in blocks
            ):
                raise OSError(errno.EIO, f"{name} was not written whole")


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


def _write(content: Content, path: Path) -> None:
    import h5netcdf
    import h5py

    with h5netcdf.File(path, "w") as file:
        described = [*content.coordinates, *content.variables]
        for variable in described:
            for name, size in zip(variable.dimensions, variable.values.shape, strict=True):
                if name not in file.dimensions:
                    file.dimensions[name] = size
        for name, (dimension, values) in content.words.items():
            if dimension not in file.dimensions:
                file.dimensions[dimension] = len(values)
            text = file.create_variable(name, (dimension,), dtype=h5py.string_dtype(encoding="utf-8"))
            text[:] = np.array(values, dtype=object)
        for variable in described:
            stored = file.create_variable(variable.name, variable.dimensions, dtype=np.float64)
            for first in range(0, len(variable.values), RECORDS_PER_BLOCK):
                block = slice(first, first + RECORDS_PER_BLOCK)
                stored[block] = variable.values[block]
            stored.attrs["units"] = variable.unit
            stored.attrs["long_name"] = variable.meaning
        beside = {v.name for v in content.coordinates} | set(content.words)
        file.attrs["coordinates"] = " ".join(sorted(beside - set(file.dimensions)))  # CF: not data
        for key, value in content.attributes.items():
            file.attrs[key] = value


def dataset_of(content: Content) -> "xarray.Dataset":
    """All arrays of a result over time, probe, plane, span, node and field_time, with units and meanings."""
    import xarray

    described = {
        variable.name: (
            variable.dimensions,
            variable.values,
            {"units": variable.unit, "long_name": variable.meaning},
        )
        for variable in (*content.coordinates, *content.variables)
    }
    numbers = {variable.name for variable in content.coordinates}
    return xarray.Dataset(
        {name: content for name, content in described.items() if name not in numbers},
        coords={name: content for name, content in described.items() if name in numbers} | content.words,
        attrs=content.attributes,
    )
