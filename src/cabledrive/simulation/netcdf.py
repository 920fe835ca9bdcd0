"""A result as labelled data, in memory or in a NetCDF file that is written block by block."""

import errno
import io
import json
import os
import shutil
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.files import put_in_place
from cabledrive.simulation.channels import CHANNELS
from cabledrive.simulation.result import SimulationResult

if TYPE_CHECKING:
    import xarray


class CarefulFile(io.RawIOBase):
    """A new file, or one in another's place, that takes everything; ``error`` holds the first error."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.error: OSError | None = None
        self._file = path.open("wb+", buffering=0)

    def readable(self) -> bool:
        """True."""
        return True

    def writable(self) -> bool:
        """True."""
        return True

    def seekable(self) -> bool:
        """True."""
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET, /) -> int:
        """As of any file."""
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        """As of any file."""
        return self._file.tell()

    def readinto(self, buffer: Any, /) -> int:
        """As of any file; what lies behind the end is zero."""
        size = self._file.readinto(buffer) or 0
        memoryview(buffer).cast("B")[size:] = bytes(len(buffer) - size)
        return len(buffer)

    def write(self, data: Any, /) -> int:
        """Write all, or remember why not; the size of all."""
        left = memoryview(data).cast("B")
        size = len(left)
        try:
            while len(left) and self.error is None:
                left = left[self._file.write(left) :]
        except OSError as error:
            self.error = error
        return size

    def truncate(self, size: int | None = None, /) -> int:
        """Cut or lengthen, or remember why not."""
        size = self.tell() if size is None else size
        try:
            self._file.truncate(size)
        except OSError as error:
            self.error = self.error or error
        return size

    def close(self) -> None:
        """Close the file; the errors of this, too, are remembered."""
        try:
            self._file.close()
        except OSError as error:
            self.error = self.error or error
        super().close()


@contextmanager
def interrupts_deferred() -> Iterator[list[int]]:
    """Keep interrupts back until the end, where `KeyboardInterrupt` is raised if one came.

    The list is not empty once one is waiting, so that long work can end early by itself.
    """
    waiting: list[int] = []
    usual = threading.current_thread() is threading.main_thread()
    if not usual or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield waiting
        return
    signal.signal(signal.SIGINT, lambda number, frame: waiting.append(number))
    try:
        yield waiting
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if waiting:
            raise KeyboardInterrupt


PLANES = ["u", "v", "w"]


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


def content_of(result: SimulationResult) -> Content:
    """All of a result of a loop or a line."""
    return Content(coordinates(result), variables(result), words(result), attributes(result))


def coordinates(result: SimulationResult) -> list[Variable]:
    """Coordinates that are numbers."""
    places = np.array([place for _, place in result.probes])
    found = [
        Variable("time", ("time",), result.time, "s", "time of a record"),
        Variable(
            "position", ("span", "node"), result.position, "m", "distance of a node from its span's start"
        ),
        Variable("probe_position", ("probe",), places, "m", "distance of a probe from its span's start"),
    ]
    if len(result.field_time):
        found.append(Variable("field_time", ("field_time",), result.field_time, "s", "time of a whole field"))
    return found


def words(result: SimulationResult) -> dict[str, tuple[str, list[str]]]:
    """Coordinates that are words: name to dimension and values."""
    return {
        "span": ("span", list(result.spans)),
        "plane": ("plane", PLANES),
        "probe_span": ("probe", [span for span, _ in result.probes]),
    }


def variables(result: SimulationResult) -> list[Variable]:
    """All arrays of a result but its coordinates."""
    missing = [span for span in ("upper", "lower") if span not in result.spans]
    found = [
        Variable(channel.name, ("time",), result.channel(channel.name), channel.unit, channel.meaning)
        for channel in CHANNELS
        if not any(channel.name.endswith(span) for span in missing)
    ]
    found.append(
        Variable(
            "budget_error", ("time",), result.budget_error, "J", "error of the energy budget, 0 at the start"
        )
    )
    probes = np.stack([result.probe(number) for number in range(len(result.probes))], axis=1)
    found.append(
        Variable("displacement", ("time", "probe", "plane"), probes, "m", "displacement of the probes")
    )
    if len(result.field_time):
        found.append(
            Variable(
                "field",
                ("field_time", "span", "node", "plane"),
                by_span(result),
                "m",
                "displacement of all nodes",
            )
        )
    return found


def by_span(result: SimulationResult) -> Array:
    """Whole fields span by span, the rims in both, (field records, spans, n + 1, 3): displacements [m]."""
    n = result.position.shape[1] - 1
    spans = [result.fields[:, :, k * n : (k + 1) * n + 1] for k in range(len(result.spans))]
    return np.stack(spans, axis=1).transpose(0, 1, 3, 2)


def attributes(result: SimulationResult) -> dict[str, Any]:
    """What is known of a result as a whole but any time of day: the same run gives the same file."""
    whole = {**result.provenance, **result.summary()}
    del whole["wall_time"]
    if whole["error_estimate"] is None:
        del whole["error_estimate"]
    return storable(whole)


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
