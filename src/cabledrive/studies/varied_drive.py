"""A drive with one of its figures changed, named by the key of the drive file."""

from dataclasses import fields, is_dataclass, replace
from typing import Any

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.fields import key_of, nearest


def varied(drive: Drive, key: str, value: float) -> Drive:
    """Drive with another value of one quantity; the given one is left as it is.

    ``key``: key of the drive file: "cable.pretension", "pulley.0.inertia", "carriage.2.mass"; ``value``: new
    value, in SI.
    Raises `InputRefused` if the key names no quantity of this drive, or the value is not allowed.
    """
    try:
        return _replaced(drive, key.split("."), float(value), key)
    except InputRefused as refusal:
        raise refusal.at(f"{key} = {value:.9g}") from None


def quantity_of(drive: Drive, key: str) -> tuple[str, str]:
    """Unit and meaning of a quantity of the drive.

    ``key``: key of the drive file.
    Returns ``unit, meaning``: as in the schema of the drive file.
    Raises `InputRefused` if the key names no quantity of this drive.
    """
    *path, last = key.split(".")
    table: Any = drive
    for step in path:
        table = _part(table, step, key)
    metadata = _field(table, last, key).metadata
    return metadata["unit"], metadata["meaning"]


def _replaced(table: Any, path: list[str], value: float, key: str) -> Any:
    step, *rest = path
    if not rest:
        return replace(table, **{_field(table, step, key).name: value})
    part = _replaced(_part(table, step, key), rest, value, key)
    if isinstance(table, tuple):
        return (*table[: int(step)], part, *table[int(step) + 1 :])
    return replace(table, **{step: part})


def _part(table: Any, step: str, key: str) -> Any:
    if isinstance(table, tuple):
        if not (step.isdecimal() and int(step) < len(table)):
            raise InputRefused(
                f'"{key}": there are {len(table)} entries, numbered from 0: choose one of them'
            )
        return table[int(step)]
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
