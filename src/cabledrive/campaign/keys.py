"""Keys that a campaign may vary: of the drive file, of the motion, of the goals, of the computation."""

import dataclasses
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from functools import cache
from typing import Any

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.fields import key_of, nearest
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.tables import ARRAYS, HEAD, TABLES, drive_with_tables
from cabledrive.studies.varied_drive import quantity_of, varied_together

DRIVE, PLANT, MOTION, GOALS, COMPUTE, OWN = "drive", "plant", "motion", "goals", "compute", "own"
MOTION_UNITS = {"angle": "rad", "rise": "s", "dwell": "s", "pulses": "count", "order": "count"}
WORD = ""
"""In place of a unit: a key that takes text, or true and false."""


@cache
def goal_units() -> dict[str, str]:
    """SI unit of each goal of a study, by name; "count" for a whole number."""
    from cabledrive.studies.study.goals import QUANTITIES  # a study brings most of the package with it

    return {**QUANTITIES, "pulses": "count", "order": "count"}


def unit_of(key: str, options: Mapping[str, str], routed: RoutedDrive | None = None) -> str:
    """SI unit of a key, "1" for a plain number, "count" for a whole one, "" for text or true and false.

    ``options``: units of the numbers that the computation takes; ``routed``: the machine, where it has
    routes. An unknown key is refused.
    """
    space, _, rest = key.partition(".")
    if key == DRIVE:
        return WORD
    if space == OWN and rest:
        return "1"
    if space == GOALS:
        return _known(key, rest, goal_units(), f"{GOALS}.")
    for name, units in ((MOTION, MOTION_UNITS), (COMPUTE, options)):
        if space == name:
            return _known(key, rest, units, f"{name}.")
    own = rest if space == PLANT else key
    return _unit_in_file(key, own.split(".")) if routed is None else quantity_of(routed, own)[0]


def _known(key: str, name: str, units: Mapping[str, str], place: str) -> str:
    if not units:
        raise InputRefused(f'unknown key "{key}": this computation has no number that can be varied')
    if name not in units:
        raise InputRefused(f'unknown key "{key}"{nearest(name, units, place)}')
    return units[name]


def _unit_in_file(key: str, path: Sequence[str]) -> str:
    """Unit of a key of the drive file."""
    if list(path) == ["kind"]:
        return WORD
    table: type | None = TABLES.get(path[0])
    rest = path[1:]
    if table is None and path[0] in ARRAYS:
        table, rest = ARRAYS[path[0]], path[2:]
        if len(path) < 2 or not path[1].isdecimal():
            raise InputRefused(f'unknown key "{key}": number the entries, such as {path[0]}.0.{path[-1]}')
    if table is None:
        spaces = (PLANT, MOTION, GOALS, COMPUTE, OWN)
        if key in spaces:
            raise InputRefused(f'unknown key "{key}": add a name, such as {key}.x')
        own = ".".join(path)
        close = get_close_matches(own, _whole_keys(path), n=1, cutoff=0.5)
        known = close or [*TABLES, *ARRAYS, *HEAD, *spaces]
        raise InputRefused(f'unknown key "{key}"{nearest(own, known, key[: len(key) - len(own)])}')
    fields = {key_of(field): field for field in dataclasses.fields(table)}
    if len(rest) != 1 or rest[0] not in fields:
        place = key[: len(key) - len(".".join(rest))]
        raise InputRefused(f'unknown key "{key}"{nearest(".".join(rest), fields, place)}')
    unit: str | None = fields[rest[0]].metadata.get("unit")
    return WORD if unit is None else unit


def _whole_keys(path: Sequence[str]) -> list[str]:
    """Keys that another may have meant: of a drive file, with the number of its entry, and of the motion."""
    number = next((part for part in path if part.isdecimal()), "0")
    of_tables = [f"{name}.{key_of(one)}" for name in TABLES for one in dataclasses.fields(TABLES[name])]
    of_arrays = [
        f"{name}.{number}.{key_of(one)}" for name in ARRAYS for one in dataclasses.fields(ARRAYS[name])
    ]
    return [*of_tables, *of_arrays, *(f"{MOTION}.{name}" for name in MOTION_UNITS)]


def si_tables(drive: Drive | RoutedDrive) -> dict[str, Any]:
    """A drive as tables of numbers in SI without defaults; of a machine with routes none are needed."""
    if isinstance(drive, RoutedDrive):
        return {}
    data: dict[str, Any] = {key: getattr(drive, key) for key in HEAD}
    for key in TABLES:
        if getattr(drive, key) is not None:
            data[key] = _plain(getattr(drive, key))
    for key in ARRAYS:
        if getattr(drive, key):
            data[key] = [_plain(row) for row in getattr(drive, key)]
    return data


def _plain(table: Any) -> dict[str, Any]:
    return {
        key_of(field): getattr(table, field.name)
        for field in dataclasses.fields(table)
        if getattr(table, field.name) != field.default
    }


def drive_with(
    drive: Drive | RoutedDrive, tables: Mapping[str, Any], settings: Mapping[str, Any]
) -> Drive | RoutedDrive:
    """The drive of one row, from its `si_tables` and values by key, in SI; refused if it is none."""
    if not settings:
        return drive
    if isinstance(drive, RoutedDrive):
        return varied_together(drive, settings)
    heads = {key.partition(".")[0] for key in settings}
    data = {head: _copied(tables[head]) for head in heads if head in tables}
    for key, value in settings.items():
        *path, last = key.split(".")
        _table(data, path, key)[last] = value
    return drive_with_tables(drive, data)


def _copied(value: Any) -> Any:
    """A table, an array of tables or a word of a file."""
    if isinstance(value, list):
        return [dict(row) for row in value]
    return dict(value) if isinstance(value, dict) else value


def _table(data: dict[str, Any], path: Sequence[str], key: str) -> dict[str, Any]:
    """The table of a key; one that the file does not have is begun."""
    if not path:
        return data
    if path[0] not in ARRAYS:
        return data.setdefault(path[0], {})
    rows, number = data.setdefault(path[0], []), int(path[1])
    if number > len(rows):
        raise InputRefused(f'"{key}": {path[0]} has {len(rows)} entries, numbered from 0')
    if number == len(rows):
        rows.append({})
    row: dict[str, Any] = rows[number]
    return row


def settings_of(values: Mapping[str, Any], space: str) -> dict[str, Any]:
    """Values of the keys in one name space, without its name; "" stands for the drive file."""
    if space:
        return {key[len(space) + 1 :]: value for key, value in values.items() if key.startswith(f"{space}.")}
    spaces = (PLANT, MOTION, GOALS, COMPUTE, OWN)
    return {key: value for key, value in values.items() if key != DRIVE and key.split(".")[0] not in spaces}
