"""From the plain data of a file of kind "route" to the machine, and back."""

import re
from typing import Any

from cabledrive.parameters.cable import Rope, with_type
from cabledrive.parameters.drive_parts import Goal, Sensors
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.excitation import StatedExcitation
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.parameters.route.parts import (
    Anchor,
    Body,
    Route,
    RoutedCarriage,
    RoutedMotor,
    RoutedPulley,
    RouteLayout,
)
from cabledrive.parameters.tables import (
    check_keys,
    plain_table,
    plain_tables,
    rows_of,
    single_tables,
    table_from,
)
from cabledrive.parameters.units import to_si

KEY = "shaft"
RELATIVE = r"^\s*([+-]?[0-9.]+\s*\*?\s*)?shaft\b"
"""How such a place begins: "shaft", "0.5 shaft - 1 m"."""
_TERM = re.compile(r"\s*(?P<factor>[+-]?[0-9]*\.?[0-9]*)\s*\*?\s*shaft\s*(?:(?P<sign>[+-])\s*(?P<rest>.+))?")
_PLACES = {"body": ("at", "pivot", "travel"), "pulley": ("at",), "anchor": ("at",)}


def with_shaft(data: dict[str, Any]) -> dict[str, Any]:
    """Plain data of a file, its relative places in metres; refused without a shaft of a length above 0."""
    given = data.get(KEY)
    length = None
    if given is not None:
        length = to_si(given, "m") if isinstance(given, str) else given
        if isinstance(length, bool) or not isinstance(length, (int, float)) or not 0.0 < length < 1e6:
            raise InputRefused(f'{KEY} = {str(given)[:40]} is no length above 0: write, for instance, "60 m"')
    found = {key: value for key, value in data.items() if key != KEY}
    for table, keys in _PLACES.items():
        rows = found.get(table)
        if isinstance(rows, list):
            found[table] = [
                {key: _placed(value, length) if key in keys else value for key, value in row.items()}
                if isinstance(row, dict)
                else row
                for row in rows
            ]
    return found


def _placed(value: Any, shaft: float | None) -> Any:
    """A place, a range or a list of them with every relative quantity in metres."""
    if isinstance(value, list):
        return [_placed(part, shaft) for part in value]
    if not isinstance(value, str) or KEY not in value:
        return value
    if ":" in value:
        return ":".join(f"{part!r} m" if isinstance(part := _placed(end, shaft), float) else part
                        for end in value.split(":"))  # fmt: skip
    match = _TERM.fullmatch(value)
    if match is None:
        raise InputRefused(f'"{value[:60]}" is no place: write shaft, shaft - 2 m or 0.5 shaft + 1 m')
    if shaft is None:
        raise InputRefused(f'"{value[:60]}" needs {KEY} = "..." at the head of the file: add it')
    factor = match["factor"]
    whole = float(factor if factor not in ("", "+", "-") else f"{factor}1") * shaft
    rest = 0.0 if match["rest"] is None else to_si(match["rest"], "m")
    return whole - rest if match["sign"] == "-" else whole + rest


ROUTE_TABLES: dict[str, type] = {
    "cable": Rope,
    "layout": RouteLayout,
    "sensors": Sensors,
    "goal": Goal,
    "excitation": StatedExcitation,
}
ROUTE_ARRAYS: dict[str, type] = {
    "body": Body,
    "pulley": RoutedPulley,
    "anchor": Anchor,
    "route": Route,
    "carriage": RoutedCarriage,
    "motor": RoutedMotor,
}
TURNING = {"stiffness": "N m/rad", "damping": "N m s/rad", "coulomb_friction": "N m"}
"""Keys of a body with the unit they have where it turns."""


def routed_from_tables(data: dict[str, Any]) -> RoutedDrive:
    """Build a machine of kind "route" from its file's plain data; refused where something does not fit."""
    data = with_shaft(data)
    check_keys(data, RoutedDrive, "")
    content = single_tables(data, ROUTE_TABLES)
    if isinstance(data.get("motor"), dict):  # a single motor may be a plain table
        data = data | {"motor": [data["motor"]]}
    rows = {key: rows_of(data, key) for key in ROUTE_ARRAYS if key in data}
    _expanded(rows)
    completed = {"body": _with_units, "route": with_type}
    for key, table in ROUTE_ARRAYS.items():
        places = [(f"{key}.{number}", row) for number, row in enumerate(rows.get(key, []))]
        if key in completed:
            places = [(place, completed[key](row, place)) for place, row in places]
        content[key] = tuple(table_from(row, table, place) for place, row in places)
    return RoutedDrive(**content)


def tables_from_routed(drive: RoutedDrive, *, words: bool = True) -> dict[str, Any]:
    """Write a machine as the plain data of a file: SI, each quantity with its unit, defaults left out.

    Without ``words``, names and other text, parts are called by their numbers.
    """
    data = plain_tables(drive, ROUTE_TABLES, words)
    for key in ROUTE_ARRAYS:
        if getattr(drive, key):
            data[key] = [_plain_row(row, words) for row in getattr(drive, key)]
    return data if words else _numbered(drive, data)


def _plain_row(row: Any, words: bool) -> dict[str, Any]:
    data = plain_table(row, words)
    if isinstance(row, Body):
        data["moves"] = list(row.moves)
        if row.moves == ("turn",):
            data |= {key: f"{getattr(row, key)!r} {unit}" for key, unit in TURNING.items() if key in data}
            if row.travel is not None:
                data["travel"] = [f"{one!r} rad" for one in row.travel]
        if not words:  # where it may go has no bearing on how it vibrates where it is
            data.pop("travel", None)
    if isinstance(row, Route):
        data["path"] = list(row.path)
    return data


def _numbered(drive: RoutedDrive, data: dict[str, Any]) -> dict[str, Any]:
    """Parts called by number instead of name, so that a hash does not depend on names."""
    for key in ("body", "pulley", "anchor"):
        for part, row in zip(getattr(drive, key), data.get(key, []), strict=False):
            number = drive.body_number(part.on, key)
            if number is not None:
                row["on"] = number
    for places, row in zip(drive.places, data["route"], strict=True):
        row["path"] = [[place.sense, place.pulley if place.sense else place.anchor] for place in places]
    for pulley, row in zip(drive.driven, data.get("motor", []), strict=True):
        row["pulley"] = pulley
    for (span, _), row in zip(drive.carriage_places, data.get("carriage", []), strict=True):
        row["route"] = drive.free_spans[span].route
    return data


def _expanded(rows: dict[str, list[Any]]) -> None:
    """A pulley or carriage at several places becomes as many, "tower 1", ...; paths pass them in order."""
    groups: dict[str, list[str]] = {}
    for key, place in (("pulley", "at"), ("carriage", "position")):
        expanded = []
        for row in rows.get(key, []):
            at = row.get(place) if isinstance(row, dict) else None
            several = isinstance(at, list) and (key == "carriage" or all(isinstance(one, list) for one in at))
            if not isinstance(at, list) or not at or not several:
                expanded.append(row)
                continue
            name = row.get("name", "")
            names = [f"{name} {number + 1}" for number in range(len(at))]
            if key == "pulley":
                groups[name] = names
            for own, one in zip(names, at, strict=True):
                expanded.append(row | {place: one} | ({"name": own} if name or key == "pulley" else {}))
        if key in rows:
            rows[key] = expanded
    for number, row in enumerate(rows.get("route", []) if groups else []):
        path = row.get("path") if isinstance(row, dict) else None
        if isinstance(path, list):
            steps: list[Any] = []
            for step in path:
                known = isinstance(step, str) and step[:1] in ("+", "-") and step[1:].strip() in groups
                steps += [f"{step[0]}{own}" for own in groups[step[1:].strip()]] if known else [step]
            rows["route"][number] = row | {"path": steps}


def _with_units(row: Any, place: str) -> Any:
    """A body's travel, "2 m : 38 m", as two quantities; what a turning one has in the units of a turn."""
    travel = row.get("travel") if isinstance(row, dict) else None
    if isinstance(travel, str):
        low, colon, high = (part.strip() for part in travel.partition(":"))
        if not colon:
            raise InputRefused(f'travel = "{travel[:60]}" needs two places: write "2 m : 38 m"')
        row = row | {"travel": [low, high]}
    if not isinstance(row, dict) or row.get("moves") not in ("turn", ["turn"]):
        return row
    try:
        own: dict[str, Any] = {
            key: to_si(row[key], unit) for key, unit in TURNING.items() if isinstance(row.get(key), str)
        }
        if isinstance(row.get("travel"), list):
            own["travel"] = [to_si(one, "rad") if isinstance(one, str) else one for one in row["travel"]]
    except InputRefused as refusal:
        raise InputRefused(f'body "{row.get("name", "")}": {refusal}') from None
    return row | own
