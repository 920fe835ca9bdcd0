"""JSON Schema of the drive file, and a name for its content that is the same on every machine."""

import dataclasses
import hashlib
import json
from math import pi
from typing import Any

from cabledrive.answers.figures import fields_by_key
from cabledrive.parameters.cable import cable_types
from cabledrive.parameters.drive import Drive, carriage_number
from cabledrive.parameters.fields import LARGEST, SMALLEST
from cabledrive.parameters.machine import MOST_CARRIAGES, WORDS
from cabledrive.parameters.route.drive import Machine
from cabledrive.parameters.route.parts import MOVES
from cabledrive.parameters.tables import ARRAYS, KEY, RELATIVE, TABLES, tables_from_drive

_LIMITS: dict[str, dict[str, float]] = {
    "positive": {"minimum": SMALLEST, "maximum": LARGEST},
    "nonnegative": {"minimum": 0, "maximum": LARGEST},
    "finite": {"minimum": -LARGEST, "maximum": LARGEST},
    "steepness": {"minimum": -pi / 2, "maximum": pi / 2},
}


def drive_schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of the drive file.

    Returns
    -------
    dict
        By kind: under "then" that of a file of kind "route", under "else" that of two pulleys. Every table
        and key with its meaning, unit and bound; unknown keys are not allowed.
    """
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "cabledrive drive file",
        "type": "object",
        "if": {"properties": {"kind": {"const": "route"}}, "required": ["kind"]},
        "then": _route_schema(),
        "else": _two_pulley_schema(),
    }


_EXCITATION: dict[str, Any] = {
    "orders": {
        "type": "array",
        "items": {"type": "string", "pattern": "="},
        "description": "what follows the speed: poles=traction sheave*20, rails=car.y/5m",
    },
    "speed": {"type": "string", "pattern": "=.*:", "description": "its range: car.y=0.2m/s:1m/s"},
}


def _whole_schema(machine: type) -> dict[str, Any]:
    """All tables of one kind of file, each key with its meaning, unit and bound."""
    schema = _table_schema(machine)
    parts = {key: _table_schema(table) for key, table in TABLES[machine].items()}
    for key, table in ARRAYS[machine].items():
        parts[key] = {"type": "array", "items": _table_schema(table)}
    parts["excitation"]["properties"] |= _EXCITATION
    schema["properties"] |= {key: {"type": "string"} for key in WORDS} | parts
    return schema


def _two_pulley_schema() -> dict[str, Any]:
    """Files of kind "loop" and "line"."""
    schema = _whole_schema(Drive)
    schema["properties"]["pulley"] |= {"minItems": 2, "maxItems": 2}
    schema["properties"]["carriage"] |= {"maxItems": MOST_CARRIAGES}
    schema["properties"]["layout"] |= {
        "oneOf": [{"required": ["span_length"]}, {"required": ["pulley_distance"]}]
    }
    # a cable of the packaged table, or one whose mass and rigidity the file gives
    of_a_type = {"properties": {"type": {"enum": list(cable_types())}}, "required": ["type"]}
    either = {"anyOf": [{"required": ["youngs_modulus"]}, {"required": ["area"]}]}
    with_rigidity = {
        "required": ["mass_per_length"],
        "not": {"required": ["type"]},
        "oneOf": [
            {"required": ["youngs_modulus", "area"], "not": {"required": ["axial_rigidity"]}},
            {"required": ["axial_rigidity"], "not": either},
        ],
    }
    schema["properties"]["cable"] |= {"anyOf": [of_a_type | {"not": _both_rigidities()}, with_rigidity]}
    schema["properties"]["cable"]["required"] = ["pretension"]
    schema["required"] = ["schema", *schema["required"]]
    return schema


def _both_rigidities() -> dict[str, Any]:
    return {"anyOf": [{"required": ["axial_rigidity", key]} for key in ("youngs_modulus", "area")]}


def _route_schema() -> dict[str, Any]:
    """Files of kind "route"."""
    schema = _whole_schema(Machine)
    keys = schema["properties"]
    keys["kind"]["enum"] = ["route"]
    keys[KEY] = {
        "anyOf": [{"type": "number"}, {"type": "string", "pattern": r"^\s*[+-]?(\d|\.\d)"}],
        "description": "length that places may be written relative to, such as 0.5 shaft - 1 m [m]",
    }
    point, text = _pair_schema("m"), {"type": "string"}
    keys["body"]["items"]["properties"]["moves"] = {
        "anyOf": [{"enum": list(MOVES)}, {"type": "array", "items": {"enum": list(MOVES)}, "minItems": 1}],
        "description": "how it moves; turn: about its pivot",
    }
    keys["body"]["items"]["properties"]["travel"] = {
        "anyOf": [point, {"type": "string", "pattern": ":"}],
        "description": "lowest and highest place of its slide [m], of its turn [rad]: 2 m : 38 m",
    }
    keys["body"]["items"]["required"] = ["name", "at", "moves"]
    keys["pulley"]["items"]["properties"]["at"] = {"anyOf": [point, {"type": "array", "items": point}]}
    position = keys["carriage"]["items"]["properties"]["position"]
    keys["carriage"]["items"]["properties"]["position"] = {
        "anyOf": [position, {"type": "array", "items": position}]
    }
    keys["route"]["items"]["properties"]["path"] = {"type": "array", "items": text, "minItems": 2}
    for table in (keys["route"]["items"], keys["cable"]):
        table["properties"]["type"] = {"enum": list(cable_types())}
        table["not"] = _both_rigidities()
    keys["route"] |= {"minItems": 1}
    keys["carriage"] |= {"maxItems": MOST_CARRIAGES}
    motor = keys["motor"]
    keys["motor"] = {"anyOf": [motor, motor["items"]]}
    for key in ("pulley", "anchor"):
        keys[key]["items"]["required"].insert(0, "name")
    keys["route"]["items"]["required"] = ["name", "path"]
    schema["required"] = ["schema", "kind", "name", "route"]
    return schema


def _pair_schema(unit: str) -> dict[str, Any]:
    text = {"type": "string", "pattern": rf"(^\s*[+-]?(\d|\.\d))|({RELATIVE})"}
    part = {"anyOf": [{"type": "number"}, text]}
    return {"type": "array", "items": part, "minItems": 2, "maxItems": 2, "description": f"x and y [{unit}]"}


def _table_schema(table: type) -> dict[str, Any]:
    fields = fields_by_key(table)
    return {
        "type": "object",
        "description": (table.__doc__ or "").splitlines()[0],
        "properties": {key: _field_schema(field) for key, field in fields.items()},
        "required": [own.name for own in fields.values() if own.default is dataclasses.MISSING],
        "additionalProperties": False,
    }


def _field_schema(field: dataclasses.Field[Any]) -> dict[str, Any]:
    if "options" in field.metadata:
        schema: dict[str, Any] = {"enum": list(field.metadata["options"])}
    elif "unit" in field.metadata:
        whole = field.metadata["unit"] == "count"
        number = {"type": "integer" if whole else "number"} | _LIMITS[field.metadata["bound"]]
        schema = {"anyOf": [number, {"type": "string", "pattern": r"^\s*[+-]?(\d|\.\d)"}]}
    elif "words" in field.metadata:
        schema = {"type": "string"}
    elif "pair" in field.metadata:
        return _pair_schema(field.metadata["pair"]) | {"description": field.metadata["meaning"]}
    else:
        return {}
    unit = field.metadata.get("unit", "1")
    schema["description"] = field.metadata["meaning"] + ("" if unit == "1" else f" [{unit}]")
    if field.default not in (dataclasses.MISSING, None):
        schema["default"] = field.default
    return schema


def content_hash(drive: Machine | Drive) -> str:
    """Hash of everything that can change a result: all SI values, not the words around them.

    Defaults are left out, so that a key added to the format later leaves the hashes of older drives alone;
    so are names and other text.

    Parameters
    ----------
    drive : Machine or Drive

    Returns
    -------
    str
        64 hexadecimal digits (SHA-256 of the canonical JSON of the drive without its words).
    """
    content = tables_from_drive(drive, words=False)
    drive = drive.listed
    if isinstance(drive, Drive):
        if drive.chain_of:
            content["machine"] = tables_from_drive(drive.axis.machine, words=False)
        for number, carriage in enumerate(drive.carriage):
            if carriage.coupled:  # by the number of the other one, which a new name does not change
                content["carriage"][number]["coupled"] = carriage_number(drive, carriage.coupled)
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()
