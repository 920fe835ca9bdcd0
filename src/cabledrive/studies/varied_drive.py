"""A drive with one or several of its figures changed, and what every labelled result says of itself."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any, TypeVar

from cabledrive.parameters import Drive, InputRefused, content_hash
from cabledrive.parameters.fields import key_of, nearest
from cabledrive.parameters.route import RoutedDrive, moved
from cabledrive.parameters.route.strain_free import POSE

if TYPE_CHECKING:
    import xarray as xr


Machine = TypeVar("Machine", Drive, RoutedDrive)


def varied(drive: Machine, key: str, value: float) -> Machine:
    """Drive with another value of one quantity; the given one is left as it is."""
    return varied_together(drive, {key: value})


def varied_together(drive: Machine, values: Mapping[str, float]) -> Machine:
    """Drive with other values of several quantities, as `varied`; bodies move together."""
    pose = {key: float(value) for key, value in values.items() if _moves(drive, key)}
    for key, value in values.items():
        if key not in pose:
            try:
                drive = _replaced(drive, key.split("."), float(value), key)
            except InputRefused as refusal:
                raise refusal.at(f"{key} = {value:.9g}") from None
    if pose:
        assert isinstance(drive, RoutedDrive)
        try:
            drive = moved(drive, pose)
        except InputRefused as refusal:
            raise refusal.at(", ".join(f"{key} = {value:.9g}" for key, value in pose.items())) from None
    return drive


def quantity_of(drive: Drive | RoutedDrive, key: str) -> tuple[str, str]:
    """Unit and meaning of a quantity of the drive: ``unit, meaning``: as in the schema of the drive file."""
    if _moves(drive, key):
        name, _, last = key.rpartition(".")
        return POSE[last], f"turn of {name}" if last == "turn" else f"{last} of {name}"
    path, table = key.split("."), drive
    while isinstance(table, tuple) or len(path) > 1:
        if isinstance(table, tuple):
            place, path = _entry(table, path, key)
            table = table[place]
        else:
            table, path = _part(table, path[0], key), path[1:]
    metadata = _field(table, path[0], key).metadata
    return metadata["unit"], metadata["meaning"]


def _moves(drive: Drive | RoutedDrive, key: str) -> bool:
    """Whether a key moves a body."""
    name, dot, last = key.rpartition(".")
    if not isinstance(drive, RoutedDrive) or not dot or last not in POSE:
        return False
    return name in [body.name for body in drive.body]


def _replaced(table: Any, path: list[str], value: float, key: str) -> Any:
    if isinstance(table, tuple):
        place, rest = _entry(table, path, key)
        return (*table[:place], _replaced(table[place], rest, value, key), *table[place + 1 :])
    step, *rest = path
    if not rest:
        return replace(table, **{_field(table, step, key).name: value})
    return replace(table, **{step: _replaced(_part(table, step, key), rest, value, key)})


def _entry(table: tuple[Any, ...], path: list[str], key: str) -> tuple[int, list[str]]:
    """Number of the entry that a path enters, and the rest of the path."""
    if not path:
        raise InputRefused(f'"{key}" names a part and none of its quantities: add one, such as .inertia')
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


def _part(table: Any, step: str, key: str) -> Any:
    known = [field.name for field in fields(table)] if is_dataclass(table) else []
    if step not in known:
        raise InputRefused(f'unknown key "{key}"{nearest(step, known)}')
    part = getattr(table, step)
    if part is None:
        raise InputRefused(f'"{key}": this drive has no [{step}]: add the table to its file')
    return part


def _field(table: Any, name: str, key: str) -> Any:
    known = {key_of(field): field for field in fields(table)} if is_dataclass(table) else {}
    numeric = {k: field for k, field in known.items() if field.metadata.get("unit") not in (None, "count")}
    if name not in numeric:
        what = "is not a quantity with a unit" if name in known else "is unknown"
        raise InputRefused(f'key "{key}" {what}{nearest(name, numeric)}')
    return numeric[name]


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
