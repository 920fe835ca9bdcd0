"""The tables of a drive file, and how its plain data becomes a machine, and a machine plain data again."""

import dataclasses
import re
from collections.abc import Mapping
from typing import Any

from cabledrive.answers.figures import fields_by_key
from cabledrive.parameters import drive_parts as parts
from cabledrive.parameters.cable import Cable, Rope, with_type
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import check_text, kind_of, nearest, written
from cabledrive.parameters.machine import SCHEMA_VERSION, WORDS, check_count
from cabledrive.parameters.route.drive import Machine, body_number
from cabledrive.parameters.route.parts import (
    Anchor,
    Body,
    Route,
    RoutedCarriage,
    RoutedMotor,
    RoutedPulley,
    RouteLayout,
)
from cabledrive.parameters.units import to_si

TABLES: dict[type, dict[str, type]] = {
    Drive: {"cable": Cable, "layout": parts.Layout, "motor": parts.Motor, "lumped": parts.Lumped},
    Machine: {"cable": Rope, "layout": RouteLayout},
}
"""Tables that stand in a file once, by the kind of machine."""
for _tables in TABLES.values():
    _tables |= {"sensors": parts.Sensors, "goal": parts.Goal, "excitation": parts.StatedExcitation}
ARRAYS: dict[type, dict[str, type]] = {
    Drive: {"pulley": parts.Pulley, "carriage": parts.Carriage},
    Machine: {"body": Body, "pulley": RoutedPulley, "anchor": Anchor, "route": Route}
    | {"carriage": RoutedCarriage, "motor": RoutedMotor},
}
"""Tables that stand there any number of times."""
HEAD = ("schema", "name", "kind", "title", "source")
OTHER_WORDS = {
    "cable.EA": "give axial_rigidity",
    "cable.stiffness": "that of a span is axial_rigidity / layout.span_length: give axial_rigidity",
    "cable.capstan_friction": "that of a wrap is capstan_friction of its [[pulley]]: give it there",
    "cable.diameter": "give area, the cross-section that carries load",
    "cable.density": "give mass_per_length, density times cross-section",
    "pulley.diameter": "give radius, half of it",
    "carriage.weight": "give mass",
}
"""Words of data sheets that are no keys, each with the key that says it."""


def drive_from_tables(data: dict[str, Any]) -> Machine | Drive:
    """Build what a file lists, a machine or two pulleys, from its tables, numbers (SI) and text.

    Refused: an unknown or missing key, a value of the wrong type, unit or range, parts that do not fit.
    """
    if not data:
        raise InputRefused(
            'no keys: a drive file starts with schema = 1 and name = "..."; see cabledrive schema'
        )
    version = data.get("schema")
    if type(version) is not int or version != SCHEMA_VERSION:
        shown = "is missing" if version is None else f"= {written(version)}"
        raise InputRefused(
            f"schema {shown}, but this version reads schema {SCHEMA_VERSION}: write schema = {SCHEMA_VERSION}"
        )
    machine: type[Machine | Drive] = Machine if data.get("kind") == "route" else Drive
    if machine is Machine:
        data = with_shaft(data)
        if isinstance(data.get("motor"), dict):  # a single motor may be a plain table
            data = data | {"motor": [data["motor"]]}
    check_keys(data, machine, "")
    content: dict[str, Any] = {key: data[key] for key in HEAD if key in data}
    for key, table in TABLES[machine].items():
        if key in data:
            given = with_type(data[key], key) if key == "cable" else data[key]
            content[key] = table_from(given, table, key)
    rows = {key: _rows_of(data, key) for key in ARRAYS[machine] if key in data}
    if machine is Machine:
        _expand(rows)
    check_count(len(rows.get("carriage", [])))
    completed = {"body": _with_units, "route": with_type}
    for key, given in rows.items():
        places = [(f"{key}.{number}", row) for number, row in enumerate(given)]
        if key in completed:
            places = [(place, completed[key](row, place)) for place, row in places]
        content[key] = tuple(table_from(row, ARRAYS[machine][key], place) for place, row in places)
    return machine(**content)


def check_keys(data: dict[str, Any], table: type, place: str) -> None:
    """Refuse keys that a table does not know, and a table that lacks one; ``place``: "cable."."""
    fields = fields_by_key(table)
    for key in data:
        if key not in fields:
            other = OTHER_WORDS.get(f"{place.split('.')[0]}.{key}")
            hint = f": {other}" if other else nearest(key[:60], fields, place)
            raise InputRefused(f'unknown key "{place}{key[:60]}"{hint}')
    for name, field in fields.items():
        if field.default is dataclasses.MISSING and name not in data:
            table_or_key = "table" if name in TABLES[Drive] or name in ARRAYS[Drive] else "key"
            meaning = field.metadata.get("meaning", f"a {table_or_key} of the drive")
            raise InputRefused(f'missing key "{place}{name}": {meaning}; add it')


def _rows_of(data: dict[str, Any], key: str) -> list[Any]:
    """Tables of one array of a file."""
    rows = data[key]
    if not isinstance(rows, list):
        raise InputRefused(f"{key} is {kind_of(rows)}, not an array of tables: write [[{key}]] above each")
    return list(rows)


def table_from(data: Any, table: type, place: str) -> Any:
    """One table of a file as its dataclass; ``place``: where it stands, "pulley.0"."""
    if not isinstance(data, dict):
        head, dot, _ = place.partition(".")
        remedy = f"[[{head}]]" if dot else f"[{place}]"
        raise InputRefused(f"{place} is {kind_of(data)}, not a table: write {remedy} above its keys")
    check_keys(data, table, f"{place}.")
    fields = fields_by_key(table)
    try:
        return table(**{fields[key].name: _value(value, fields[key], key) for key, value in data.items()})
    except InputRefused as refusal:
        raise InputRefused(f"{place}.{refusal}") from None


def _value(value: Any, field: dataclasses.Field[Any], key: str) -> Any:
    """A value of a file, texts with a unit as numbers; `check_fields` refuses what is no pair."""
    unit, pair = field.metadata.get("unit"), field.metadata.get("pair")
    try:
        if pair and isinstance(value, list):
            return tuple(to_si(part, pair) if isinstance(part, str) else part for part in value)
        if unit and isinstance(value, str):
            return to_si(value, "1" if unit == "count" else unit)
    except InputRefused as refusal:
        raise InputRefused(f"{key} = {refusal}") from None
    if unit and (value is None or isinstance(value, (list, dict))):
        raise InputRefused(f"{key} is {kind_of(value)}, not a quantity in {unit}: write one number or text")
    return value


def tables_from_drive(drive: Machine | Drive, *, words: bool = True) -> dict[str, Any]:
    """Write a machine as the plain data of a file: SI, each quantity with its unit, defaults left out.

    With ``words``, names and other text without bearing on results, it reads back as an equal machine;
    without them parts of one with routes are called by their numbers.
    """
    drive = drive.listed
    data: dict[str, Any] = {
        key: getattr(drive, key)
        for key in HEAD
        if (words or key not in WORDS) and (key == "name" or getattr(drive, key) != "")
    }
    machine = Machine if isinstance(drive, Machine) else Drive
    fields = fields_by_key(machine)
    for key in TABLES[machine]:
        table = getattr(drive, key)
        if table is not None and table != fields[key].default:
            data[key] = _plain(table, words)
    for key in ARRAYS[machine]:
        if getattr(drive, key):
            data[key] = [_plain(row, words) for row in getattr(drive, key)]
    return _numbered(drive, data) if isinstance(drive, Machine) and not words else data


def _plain(table: Any, words: bool) -> dict[str, Any]:
    """A table as plain data, each quantity with its unit, defaults left out; ``words``: texts included."""
    data = {
        key: _text(getattr(table, field.name), field.metadata)
        for key, field in fields_by_key(table.__class__).items()
        if getattr(table, field.name) != field.default and (words or "words" not in field.metadata)
    }
    if isinstance(table, Body) and table.moves == ("turn",):
        data |= {key: f"{getattr(table, key)!r} {unit}" for key, unit in TURNING.items() if key in data}
        if table.travel is not None:
            data["travel"] = [f"{one!r} rad" for one in table.travel]
    if isinstance(table, Body) and not words:  # where it may go has no bearing on how it vibrates where it is
        data.pop("travel", None)
    return data


def _text(value: Any, metadata: Mapping[str, Any]) -> Any:
    if "pair" in metadata:
        return [f"{part!r} {metadata['pair']}" for part in value]
    if isinstance(value, tuple):
        return list(value)
    unit = metadata.get("unit")
    return value if unit in (None, "1", "count") else f"{value!r} {unit}"


TURNING = {"stiffness": "N m/rad", "damping": "N m s/rad", "coulomb_friction": "N m"}
"""Keys of a body with the unit they have where it turns."""


def _numbered(drive: Machine, data: dict[str, Any]) -> dict[str, Any]:
    """Parts called by number instead of name, so that a hash does not depend on names."""
    for key in ("body", "pulley", "anchor"):
        for part, row in zip(getattr(drive, key), data.get(key, []), strict=False):
            number = body_number(drive, part.on, key)
            if number is not None:
                row["on"] = number
    for places, row in zip(drive.places, data["route"], strict=True):
        row["path"] = [[place.sense, place.pulley if place.sense else place.anchor] for place in places]
    for pulley, row in zip(drive.driven, data.get("motor", []), strict=True):
        row["pulley"] = pulley
    for (span, _), row in zip(drive.carriage_places, data.get("carriage", []), strict=True):
        row["route"] = drive.free_spans[span].route
    return data


def _expand(rows: dict[str, list[Any]]) -> None:
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
            check_text(f"{key}.name", name := row.get("name", ""))
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
        ends = (_placed(end, shaft) for end in value.split(":"))
        return ":".join(f"{end!r} m" if isinstance(end, float) else end for end in ends)
    match = _TERM.fullmatch(value)
    if match is None:
        raise InputRefused(f'"{value[:60]}" is no place: write shaft, shaft - 2 m or 0.5 shaft + 1 m')
    if shaft is None:
        raise InputRefused(f'"{value[:60]}" needs {KEY} = "..." at the head of the file: add it')
    factor = match["factor"]
    whole = float(factor if factor not in ("", "+", "-") else f"{factor}1") * shaft
    rest = 0.0 if match["rest"] is None else to_si(match["rest"], "m")
    return whole - rest if match["sign"] == "-" else whole + rest
