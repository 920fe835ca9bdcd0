"""Natural frequencies against any figure of the drive, each mode followed by its shape."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cabledrive.modal import modes as certified_modes
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.drive import require_two_pulleys
from cabledrive.studies.crossings import Crossing, crossings
from cabledrive.studies.following import Follower, Station
from cabledrive.studies.labels import stamped
from cabledrive.studies.varied_drive import quantity_of, varied

if TYPE_CHECKING:
    import xarray as xr

MOST_MODES = 200


def frequency_against(
    drive: Drive, key: str, values: Sequence[float] | Array, *, modes: int = 4
) -> "xr.Dataset":
    """Longitudinal frequencies against one quantity, each curve followed through crossings and veerings.

    A curve is one mode followed by its shape. Where two curves cross, each keeps its shape and they change
    order; where they veer, they keep their order and exchange shapes. Steps between the values are halved
    until there is no doubt which mode is which, down to gaps of 1e-9 of the frequency.

    Parameters
    ----------
    drive : Drive
    key : str
        Any quantity of the drive file: "cable.pretension", "pulley.0.inertia", "carriage.0.position".
    values : array_like, shape (p,)
        Values in SI, in any order.
    modes : int, default 4
        Every curve is given that is among the lowest so many at one value or more.

    Returns
    -------
    xarray.Dataset
        Over ``mode`` (the curves, numbered by frequency at the smallest value) and ``value``: ``frequency``
        [Hz], ``family``; over ``value``: ``lowest_transverse`` [Hz]; over ``crossing``: ``crossing_kind``
        ("crossing" or "veering"), ``crossing_value``, ``crossing_frequency`` [Hz], ``crossing_gap`` [Hz],
        ``crossing_first`` and ``crossing_second`` (the two curves).

    Raises
    ------
    InputRefused
        If the key names no quantity of this drive, or a value is not allowed.
    NotComputed
        If the modes cannot be followed.
    """
    require_two_pulleys(drive, "`frequency_against`")
    unit, meaning = quantity_of(drive, key)
    ordered, place = np.unique(_checked(values, modes), return_inverse=True)
    drives = {float(value): varied(drive, key, value) for value in ordered}
    follower = Follower(lambda value: drives.get(value) or varied(drive, key, value), cells=256 + 16 * modes)
    path = _complete_path(follower, ordered, modes)
    stations = {station.value: station for station in path}
    shown = [stations[float(value)] for value in ordered]
    curves = [c for c in range(path[0].frequency.size) if any(_rank(s, c) < modes for s in shown)]
    return _dataset(
        drive,
        values=(ordered, place, key, unit, meaning),
        shown=shown,
        curves=curves,
        transverse=[_lowest_transverse(drives[float(value)]) for value in ordered],
        crossings=[m for m in crossings(follower, path) if set(m.curves) <= set(curves)],
    )


def _checked(values: Sequence[float] | Array, modes: int) -> Array:
    array = np.asarray(values, dtype=float)
    if array.ndim != 1 or array.size == 0 or not np.isfinite(array).all():
        raise InputRefused("values: a list of finite numbers is needed: give one or more, in SI")
    if not 0 < modes <= MOST_MODES:
        raise InputRefused(f"modes = {modes} must lie between 1 and {MOST_MODES}: follow fewer at a time")
    return array


def _complete_path(follower: Follower, values: Array, modes: int) -> list[Station]:
    """Follow so many modes that every one among the lowest, at whatever value, is one of them."""
    curves = modes
    while curves <= 4 * modes + 16:
        path = follower.path(values, curves)
        if all(_holds_lowest(follower, station, modes) for station in path):
            return path
        curves += 1 + modes // 4
    raise NotComputed(
        f"a mode among the lowest {modes} starts above the lowest {curves} at the smallest value: "
        "narrow the range"
    )


def _holds_lowest(follower: Follower, station: Station, modes: int) -> bool:
    lowest = follower.modes_at(station.value, modes).frequency[:modes]
    held = np.sort(station.frequency)[:modes]
    return bool(np.allclose(held, lowest, rtol=1e-9, atol=0.0))


def _rank(station: Station, curve: int) -> int:
    return int(np.sum(station.frequency < station.frequency[curve] * (1 - 1e-9)))


def _lowest_transverse(drive: Drive) -> float:
    return certified_modes(drive, count=1).transverse[0].frequency


def _dataset(
    drive: Drive,
    *,
    values: tuple[Array, NDArray[np.intp], str, str, str],
    shown: list[Station],
    curves: list[int],
    transverse: list[float],
    crossings: list[Crossing],
) -> "xr.Dataset":
    import xarray as xr

    ordered, place, key, unit, meaning = values
    number = {curve: i for i, curve in enumerate(curves)}
    frequency = np.array([station.frequency[curves] for station in shown]).T[:, place]
    family = np.array([[station.family[curve] for curve in curves] for station in shown], dtype=object).T
    data = {
        "frequency": (("mode", "value"), frequency, {"units": "Hz", "long_name": "natural frequency"}),
        "family": (("mode", "value"), family[:, place], {"long_name": "what mainly moves"}),
        "lowest_transverse": (
            "value",
            np.array(transverse)[place],
            {"units": "Hz", "long_name": "lowest transverse frequency"},
        ),
        "crossing_kind": ("crossing", np.array([m.kind for m in crossings], dtype=object)),
        "crossing_value": ("crossing", np.array([m.value for m in crossings]), {"units": unit}),
        "crossing_frequency": ("crossing", np.array([m.frequency for m in crossings]), {"units": "Hz"}),
        "crossing_gap": ("crossing", np.array([m.gap for m in crossings]), {"units": "Hz"}),
        "crossing_first": ("crossing", np.array([number[m.curves[0]] for m in crossings], dtype=int)),
        "crossing_second": ("crossing", np.array([number[m.curves[1]] for m in crossings], dtype=int)),
    }
    coordinates = {
        "mode": np.arange(len(curves)),
        "value": ("value", ordered[place], {"units": unit, "long_name": meaning, "key": key}),
    }
    return stamped(xr.Dataset(data, coordinates), drive, f"frequency against {key}")
