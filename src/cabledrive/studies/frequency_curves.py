"""A drive with figures changed, and its natural frequencies against one of them."""

from collections.abc import Mapping, Sequence
from dataclasses import Field, fields, is_dataclass, replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from cabledrive.modal import modes as certified_modes
from cabledrive.parameters import Drive, InputRefused, NotComputed, content_hash
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import key_of, require_known
from cabledrive.parameters.route import RoutedDrive, moved
from cabledrive.parameters.route.drive import require_two_pulleys
from cabledrive.parameters.route.strain_free import POSE
from cabledrive.studies.following import Follower, Station, crossings

if TYPE_CHECKING:
    import xarray as xr


Machine = TypeVar("Machine", bound=Drive | RoutedDrive)
Steps = tuple[Any, ...]


def varied_together(drive: Machine, values: Mapping[str, Any]) -> Machine:
    """Drive with other values of several keys, those of one table at once; bodies move together."""
    pose = {key: float(value) for key, value in values.items() if _moves(drive, key)}
    try:
        found: Any = _replaced(
            drive, {_located(drive, key)[0]: value for key, value in values.items() if key not in pose}
        )
        if pose:
            assert isinstance(found, RoutedDrive)
            found = moved(found, pose)
    except InputRefused as refusal:
        if str(refusal).startswith(tuple(values)):
            raise
        shown = ((key, f"{v:.9g}" if isinstance(v, float) else v) for key, v in values.items())
        raise refusal.at(", ".join(f"{key} = {value}" for key, value in shown)) from None
    return found


def quantity_of(drive: Drive | RoutedDrive, key: str) -> tuple[str, str]:
    """Unit and meaning of a quantity of the drive: ``unit, meaning``: as in the schema of the drive file."""
    unit, (name, _, last) = unit_in_file(drive, key), key.rpartition(".")
    if unit in ("", "count"):
        raise InputRefused(f'key "{key}" is not a quantity with a unit')
    if _moves(drive, key):
        return unit, f"turn of {name}" if last == "turn" else f"{last} of {name}"
    return unit, _located(drive, key)[1].metadata["meaning"]


def unit_in_file(drive: Drive | RoutedDrive, key: str) -> str:
    """Unit of a key, "count" of a whole number, "" of a choice; refused: one that no result depends on."""
    if _moves(drive, key):
        return POSE[key.rpartition(".")[2]]
    metadata = _located(drive, key)[1].metadata
    if "unit" not in metadata and "options" not in metadata:
        raise InputRefused(f'key "{key}" is neither a quantity nor a choice')
    return str(metadata.get("unit", ""))


def _moves(drive: Drive | RoutedDrive, key: str) -> bool:
    """Whether a key moves a body."""
    name, dot, last = key.rpartition(".")
    if not isinstance(drive, RoutedDrive) or not dot or last not in POSE:
        return False
    return name in [body.name for body in drive.body]


def _located(drive: Drive | RoutedDrive, key: str) -> tuple[Steps, Field[Any]]:
    """The way to a key by fields and numbers of entries, and its field."""
    part: Any = drive
    steps: list[Any] = []
    left = key.split(".")
    while left:
        if isinstance(part, tuple):
            number, left = _entry(part, left, key)
            steps.append(number)
            part = part[number]
        known = {key_of(field): field for field in fields(part)} if is_dataclass(part) else {}
        require_known(left[0], known, f'unknown key "{key}"', key.removesuffix(".".join(left)))
        field = known[left.pop(0)]
        steps.append(field.name)
        part = getattr(part, field.name)
        if part is None and left:
            raise InputRefused(f'"{key}": this drive has no [{field.name}]: add the table to its file')
    if isinstance(part, tuple) or is_dataclass(part):
        raise InputRefused(f'"{key}" names a part and none of its quantities: add one, such as .inertia')
    return tuple(steps), field


def _entry(table: tuple[Any, ...], path: list[str], key: str) -> tuple[int, list[str]]:
    """Number of the entry that a path enters, and the rest of the path."""
    step, *rest = path
    if step.isdecimal() and int(step) < len(table) and rest:
        return int(step), rest
    names = [getattr(part, "name", "") for part in table]
    if step in names and rest:
        return names.index(step), rest
    if len(table) == 1 and is_dataclass(table[0]) and step in {key_of(field) for field in fields(table[0])}:
        return 0, path  # a single [motor] is written without a number
    known = f", or by name: {', '.join(filter(None, names))}" if any(names) else ""
    raise InputRefused(f'"{key}": there are {len(table)} entries, numbered from 0{known}: choose one of them')


def _replaced(part: Any, values: Mapping[Steps, Any], place: str = "") -> Any:
    """A part of a drive with other values by the way to them; ``place``: of the part in the file."""
    if not values:
        return part
    inside: dict[Any, dict[Steps, Any]] = {}
    for (step, *rest), value in values.items():
        inside.setdefault(step, {})[tuple(rest)] = value
    old = part.__getitem__ if isinstance(part, tuple) else partial(getattr, part)
    new = {
        step: below[()] if () in below else _replaced(old(step), below, f"{place}{step}.")
        for step, below in inside.items()
    }
    if isinstance(part, tuple):
        return tuple(new.get(number, one) for number, one in enumerate(part))
    try:
        return replace(part, **new)
    except InputRefused as refusal:
        raise InputRefused(f"{place}{refusal}") from None


def stamped(data: "xr.Dataset", drive: Drive | RoutedDrive, title: str) -> "xr.Dataset":
    """Add title, drive, hash, version and method to a result as attributes."""
    from cabledrive.parameters.version import __version__

    return data.assign_attrs(
        title=title,
        drive=drive.name,
        drive_hash=content_hash(drive),
        version=__version__,
        method="exact dynamic stiffness, modes isolated by counting",
    )


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
    array = np.asarray(values, dtype=float)
    if array.ndim != 1 or array.size == 0 or not np.isfinite(array).all():
        raise InputRefused("values: a list of finite numbers is needed: give one or more, in SI")
    if not 0 < modes <= MOST_MODES:
        raise InputRefused(f"modes = {modes} must lie between 1 and {MOST_MODES}: follow fewer at a time")
    ordered, place = np.unique(array, return_inverse=True)
    drive_at = cache(lambda value: varied_together(drive, {key: float(value)}))
    for value in ordered:  # refused before anything is followed
        drive_at(value)
    follower = Follower(drive_at, cells=256 + 16 * modes)
    path = _complete_path(follower, ordered, modes)
    stations = {station.value: station for station in path}
    shown = [stations[float(value)] for value in ordered]
    ranks = [np.sum(s.frequency < s.frequency[:, None] * (1 - 1e-9), axis=1) for s in shown]
    curves = np.flatnonzero(np.min(ranks, axis=0) < modes).tolist()
    transverse = [certified_modes(drive_at(value), count=1).transverse[0].frequency for value in ordered]
    met = [m for m in crossings(follower, path) if set(m.curves) <= set(curves)]
    import xarray as xr

    number = {curve: i for i, curve in enumerate(curves)}
    frequency = np.array([station.frequency[curves] for station in shown]).T[:, place]
    family = np.array([[station.family[curve] for curve in curves] for station in shown], dtype=object).T
    lowest = {"units": "Hz", "long_name": "lowest transverse frequency"}
    data = {
        "frequency": (("mode", "value"), frequency, {"units": "Hz", "long_name": "natural frequency"}),
        "family": (("mode", "value"), family[:, place], {"long_name": "what mainly moves"}),
        "lowest_transverse": ("value", np.array(transverse)[place], lowest),
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
    said = f"a mode among the lowest {modes} starts above the lowest {curves} at the smallest value"
    raise NotComputed(f"{said}: narrow the range")
