"""MATLAB logs: versions 4 to 7 through scipy, 7.3 as the HDF5 file it is; structures by their path."""

from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.identification.logs.hierarchical import is_hdf5, open_hdf5
from cabledrive.identification.logs.table import Array, Reading, Table, check_lengths, sliced
from cabledrive.identification.logs.trial import require_readable
from cabledrive.identification.logs.unpacking import require_fitting, unpacked_matlab
from cabledrive.parameters import InputRefused


def open_matlab(path: Path, reading: Reading | None = None) -> Table:
    """Open a MATLAB file; a column is a variable, a field ``a.b``, or a row of a matrix ``a.b[0]``.

    Raises `InputRefused` if it cannot be read or would unpack to more than `LARGEST_IN_MEMORY`.
    """
    if is_hdf5(path):
        return open_hdf5(path)
    columns: dict[str, Array] = {}
    scalars: dict[str, float] = {}
    for name, value in _variables(path).items():
        _collect(name, value, columns, scalars)
    if not columns:
        raise InputRefused(f"{path.name}: holds no vector of numbers: save the channels as vectors (-v7)")

    def read(names: tuple[str, ...]) -> Any:
        check_lengths({name: len(columns[name]) for name in names}, path.name)
        return sliced({name: columns[name] for name in names})

    rows = max(len(values) for values in columns.values())
    return Table(source=path.name, names=tuple(columns), units={}, rows=rows, read=read, scalars=scalars)


def _variables(path: Path) -> dict[str, Any]:
    from scipy import io

    require_fitting(path, unpacked_matlab(path))
    require_readable(path, lambda: io.loadmat(path))
    try:
        found = io.loadmat(path, squeeze_me=True, struct_as_record=False)
    except Exception as error:  # scipy raises many kinds for a damaged file
        raise InputRefused(
            f"{path.name}: is no readable MATLAB file ({error}): save it again with -v7"
        ) from None
    return {name: value for name, value in found.items() if name and not name.startswith("__")}


def _collect(
    name: str, value: Any, columns: dict[str, Array], scalars: dict[str, float], depth: int = 0
) -> None:
    """Sort a variable, field by field, into columns and single numbers; what is neither is left out."""
    if hasattr(value, "_fieldnames") and depth < 6:
        for field in value._fieldnames:
            _collect(f"{name}.{field}", getattr(value, field), columns, scalars, depth + 1)
        return
    array = np.asarray(value)
    if array.dtype.kind not in "fiub":
        return
    if array.ndim == 0:
        scalars[name] = float(array)
    elif array.ndim == 1 and array.size > 1:
        columns[name] = array  # as it is: a block at a time becomes doubles
    elif array.ndim == 2 and min(array.shape) <= 64:
        across = array if array.shape[0] <= array.shape[1] else array.T
        for k, row in enumerate(across):
            columns[f"{name}[{k}]"] = row
