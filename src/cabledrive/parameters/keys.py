"""Figures of a machine by their keys in its file: units, meanings, and the machine with other values."""

from collections.abc import Mapping
from dataclasses import Field, is_dataclass, replace
from functools import partial
from typing import Any

from cabledrive.answers.figures import fields_by_key
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import require_known
from cabledrive.parameters.route.drive import Machine
from cabledrive.parameters.route.strain_free import POSE, moved

Steps = tuple[Any, ...]


def varied_together(drive: Machine, values: Mapping[str, Any]) -> Machine:
    """Machine with other values of several keys, those of one table at once; bodies move together."""
    pose = {key: float(value) for key, value in values.items() if _moves(drive, key)}
    try:
        found: Machine = _replaced(
            drive.listed, {_located(drive, key)[0]: value for key, value in values.items() if key not in pose}
        ).machine
        if pose:
            found = moved(found, pose)
    except InputRefused as refusal:
        if str(refusal).startswith(tuple(values)):
            raise
        shown = ((key, f"{v:.9g}" if isinstance(v, float) else v) for key, v in values.items())
        raise refusal.at(", ".join(f"{key} = {value}" for key, value in shown)) from None
    return found


def quantity_of(drive: Machine, key: str) -> tuple[str, str]:
    """Unit and meaning of a quantity of the drive: ``unit, meaning``: as in the schema of the drive file."""
    unit, (name, _, last) = unit_in_file(drive, key), key.rpartition(".")
    if unit in ("", "count"):
        raise InputRefused(f'key "{key}" is not a quantity with a unit')
    if _moves(drive, key):
        return unit, f"turn of {name}" if last == "turn" else f"{last} of {name}"
    return unit, _located(drive, key)[1].metadata["meaning"]


def unit_in_file(drive: Machine, key: str) -> str:
    """Unit of a key, "count" of a whole number, "" of a choice; refused: one that no result depends on."""
    if _moves(drive, key):
        return POSE[key.rpartition(".")[2]]
    metadata = _located(drive, key)[1].metadata
    if "unit" not in metadata and "options" not in metadata:
        raise InputRefused(f'key "{key}" is neither a quantity nor a choice')
    return str(metadata.get("unit", ""))


def _moves(drive: Machine, key: str) -> bool:
    """Whether a key moves a body."""
    name, dot, last = key.rpartition(".")
    return bool(dot) and last in POSE and name in [body.name for body in getattr(drive, "body", ())]


def _located(drive: Machine, key: str) -> tuple[Steps, Field[Any]]:
    """The way to a key by fields and numbers of entries, and its field."""
    part: Any = drive.listed
    steps: list[Any] = []
    left = key.split(".")
    while left:
        if isinstance(part, tuple):
            number, left = _entry(part, left, key)
            steps.append(number)
            part = part[number]
        known = fields_by_key(part.__class__)
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
    if len(table) == 1 and step in fields_by_key(table[0].__class__):
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
