"""JSON Schema of the drive file, for editors, made from the same declarations the loader uses."""

import dataclasses
from math import pi
from typing import Any

from cabledrive.parameters.drive import MOST_CARRIAGES, WORDS, Drive
from cabledrive.parameters.fields import LARGEST, SMALLEST, key_of
from cabledrive.parameters.tables import ARRAYS, TABLES

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
        Every table and key with its meaning, unit and bound; unknown keys are not allowed.
    """
    schema = _table_schema(Drive)
    for key in WORDS:
        schema["properties"][key] = {"type": "string"}
    for key, table in TABLES.items():
        schema["properties"][key] = _table_schema(table)
    for key, table in ARRAYS.items():
        schema["properties"][key] = {"type": "array", "items": _table_schema(table)}
    schema["properties"]["pulley"] |= {"minItems": 2, "maxItems": 2}
    schema["properties"]["carriage"] |= {"maxItems": MOST_CARRIAGES}
    schema["properties"]["layout"] |= {
        "oneOf": [{"required": ["span_length"]}, {"required": ["pulley_distance"]}]
    }
    schema["properties"]["cable"] |= {
        "oneOf": [
            {"required": ["youngs_modulus", "area"], "not": {"required": ["axial_rigidity"]}},
            {
                "required": ["axial_rigidity"],
                "not": {"anyOf": [{"required": ["youngs_modulus"]}, {"required": ["area"]}]},
            },
        ]
    }
    schema["required"] = ["schema", *schema["required"]]
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "cabledrive drive file"}
    return head | schema


def _table_schema(table: type) -> dict[str, Any]:
    fields = dataclasses.fields(table)
    return {
        "type": "object",
        "description": (table.__doc__ or "").splitlines()[0],
        "properties": {key_of(field): _field_schema(field) for field in fields},
        "required": [field.name for field in fields if field.default is dataclasses.MISSING],
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
    else:
        return {}
    unit = field.metadata.get("unit", "1")
    schema["description"] = field.metadata["meaning"] + ("" if unit == "1" else f" [{unit}]")
    if field.default not in (dataclasses.MISSING, None):
        schema["default"] = field.default
    return schema
