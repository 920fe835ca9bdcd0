"""Natural frequencies against any figure of the drive."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cabledrive.modal import modes as certified_modes
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.drive import require_two_pulleys
from cabledrive.studies.following import Follower, Station, crossings
from cabledrive.studies.varied_drive import quantity_of, stamped, varied

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
    ranks = [np.sum(s.frequency < s.frequency[:, None] * (1 - 1e-9), axis=1) for s in shown]
    curves = np.flatnonzero(np.min(ranks, axis=0) < modes).tolist()
    transverse = [certified_modes(drives[float(value)], count=1).transverse[0].frequency for value in ordered]
    met = [m for m in crossings(follower, path) if set(m.curves) <= set(curves)]
    import xarray as xr

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
        "crossing_kind": ("crossing", np.array([m.kind for m in met], dtype=object)),
        "crossing_value": ("crossing", np.array([m.value for m in met]), {"units": unit}),
        "crossing_frequency": ("crossing", np.array([m.frequency for m in met]), {"units": "Hz"}),
        "crossing_gap": ("crossing", np.array([m.gap for m in met]), {"units": "Hz"}),
        "crossing_first": ("crossing", np.array([number[m.curves[0]] for m in met], dtype=int)),
        "crossing_second": ("crossing", np.array([number[m.curves[1]] for m in met], dtype=int)),
    }
    coordinates = {
        "mode": np.arange(len(curves)),
        "value": ("value", ordered[place], {"units": unit, "long_name": meaning, "key": key}),
    }
    return stamped(xr.Dataset(data, coordinates), drive, f"frequency against {key}")


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

    def holds_lowest(station: Station) -> bool:
        lowest = follower.modes_at(station.value, modes).frequency[:modes]
        return np.allclose(np.sort(station.frequency)[:modes], lowest, rtol=1e-9, atol=0.0)

    while curves <= 4 * modes + 16:
        path = follower.path(values, curves)
        if all(map(holds_lowest, path)):
            return path
        curves += 1 + modes // 4
    raise NotComputed(
        f"a mode among the lowest {modes} starts above the lowest {curves} at the smallest value: "
        "narrow the range"
    )
