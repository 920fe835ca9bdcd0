"""A result as labelled data, in memory or in a NetCDF file that is written block by block."""

import io
import json
import os
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
        key: json.dumps(one) if isinstance(one, bool) or not isinstance(one, int | float | str) else one
        for key, one in known.items()
    }


RECORDS_PER_BLOCK = 50_000


def write_netcdf(content: Content, path: Path, temporary: Path, *, force: bool = False) -> None:
    """Write a result, see `cabledrive.simulation.netcdf`; the file appears whole or not at all.

    ``temporary``: its name until it is whole, on the same disk. Refused if another process has written the
    file meanwhile (without `force`); `OSError` if the disk refuses.
    """
    try:
        with Patient(temporary) as file:
            _write(content, file)
            if file.refusal is not None:
                raise file.refusal
            os.fsync(file.fileno())
        put_in_place(temporary, path, force=force)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


class Patient(io.FileIO):
    """A file that keeps the first refusal of the disk: HDF5 does not survive one, now or on closing."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, "w+")
        self.refusal: OSError | None = None

    def write(self, content: Any) -> int:
        """Write all of it, or nothing more once the disk has refused."""
        left = memoryview(content).cast("B")
        try:
            while left and self.refusal is None:
                left = left[super().write(left) :]
        except OSError as error:
            self.refusal = error
        return len(content)

    def truncate(self, size: int | None = None) -> int:
        """Make the file so long."""
        try:
            return super().truncate(size)
        except OSError as error:
            self.refusal = self.refusal or error
            return size or 0

    def readinto(self, into: Any) -> int:
        """Read; what was never written reads as zeros."""
        found = super().readinto(into) or 0
        memoryview(into).cast("B")[found:] = bytes(len(into) - found)
        return len(into)


def _write(content: Content, target: Patient) -> None:
    import h5netcdf
    import h5py

    with h5netcdf.File(target, "w") as file:
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

    numbers, others = (
        {v.name: (v.dimensions, v.values, {"units": v.unit, "long_name": v.meaning}) for v in variables}
        for variables in (content.coordinates, content.variables)
    )
    return xarray.Dataset(others, numbers | content.words, content.attributes)
