"""JSON Schemas of what commands answer, from the keys that results declare beside what makes them."""

import dataclasses
from collections.abc import Iterator, Mapping
from functools import reduce
from pkgutil import resolve_name
from types import NoneType
from typing import Any, get_args, get_origin

from cabledrive.answers.keys import HOLDING, Keys

SIMPLE = {bool: "boolean", int: "integer", float: "number", str: "string", NoneType: "null"}
KINDS: dict[str, Any] = {
    "text": {"type": "string"},
    "note": {"type": ["string", "null"]},
    "flag": {"type": ["boolean", "null"]},
    "count": {"type": ["integer", "null"]},
    "number": {"type": ["number", "null"]},
    "numbers": {"type": "array", "items": {"type": ["number", "null"]}},
    "texts": {"type": "array", "items": {"type": "string"}},
    "any": {},
}
"""Of a key of a dictionary; a figure may be null, with its reason beside it."""
ORIGIN = Keys("map: provenance=any text: incomplete?")
ANSWERS = {
    "camera": ("app.commands.camera:CLIP",),
    "check": ("app.checked:LOOP", "app.checked:ROUTE"),
    "compare": ("answers.runs:COMPARED",),
    "drives": ("app.commands.drives:LIST", "app.commands.drives:ONE"),
    "experiment": ("answers.runs:LOGGED", "answers.runs:PLANNED"),
    "export": ("app.commands.export:WRITTEN",),
    "identify": ("app.identified:ANSWER", "app.identified:OF_A_PING", "app.identified:SPLIT"),
    "map": ("app.maps:MAP",),
    "modes": ("report.words:LISTED",),
    "report": ("app.commands.report:PAGE_OF_DRIVES", "app.commands.report:PAGE_OF_A_STORE"),
    "resonance": ("app.resonances:RESONANCE",),
    "response": ("app.identified:MEASURED", "app.identified:COMPUTED"),
    "sensitivity": ("campaign.results:INDICES", "campaign.results:EFFECTS"),
    "shaper": ("report.printer_tables:ANSWER", "report.printer_tables:PRINTER"),
    "simulate": ("simulation.result:SIMULATED",),
    "study": ("report.study.results:STUDY", "report.study.results:WITHOUT_CHAIN"),
    "sway": ("app.maps:SWAYING",),
    "sweep": ("app.commands.sweep:SWEPT",),
    "tolerance": ("campaign.results:YIELD",),
    "track": ("answers.runs:TRACKED", "answers.runs:WOUND"),
}
"""Where the keys of each command's objects are declared."""


def answer_schema(command: str) -> dict[str, Any]:
    """The schema of what a command prints with ``--json``."""
    declared = (resolve_name(f"cabledrive.{place}") for place in ANSWERS[command])
    return {"anyOf": [schema_of(keys, ORIGIN) for keys in declared]}


def schema_of(*declared: Keys) -> dict[str, Any]:
    """The schema of an object that has some keys; of a figure KEY its reason is KEY_reason."""
    made = [one for keys in declared for one in _properties(keys)]
    return {
        "type": "object",
        "properties": {key: kind for key, kind, _ in made},
        "required": [key for key, _, optional in made if not optional],
        "patternProperties": {"_reason$": KINDS["note"]},
        "additionalProperties": False,
    }


def _properties(keys: Keys) -> Iterator[tuple[str, Any, bool]]:
    """Key, schema, whether it may be left out."""
    for key, name, optional, why, kind in keys.each():
        hint = None if kind else reduce(_hint, name.split("."), keys.of)
        part = keys.parts.get(key) if kind in HOLDING else None
        many = kind == "rows" or get_origin(hint) in (tuple, list)
        one = isinstance(part, Keys) and part.of is dict  # what a mapping itself is
        mapped = part is not None and not one and get_origin(hint) not in (None, tuple, list)
        if kind == "map" or mapped:
            found = _free(_part(part or ("number" if name == key else name)))
        elif kind in ("object", "rows") or part is not None:
            found = {"type": "array", "items": _part(part)} if many else _part(part)
        else:
            found = KINDS[kind] if kind else _kind(hint)
        yield key, {"anyOf": [found, {"type": "null"}]} if why and kind not in KINDS else found, optional
    for other in keys.also:
        yield from _properties(other)


def _free(values: dict[str, Any]) -> dict[str, Any]:
    """The schema of an object of free names, with the reasons of those that are null."""
    return {
        "type": "object",
        "patternProperties": {"_reason$": KINDS["note"]},
        "additionalProperties": values,
    }


def _part(part: Any) -> dict[str, Any]:
    """The schema of what is inside: other keys, a kind, a class, or one of several."""
    if isinstance(part, tuple):
        return {"anyOf": [_part(one) for one in part]}
    if isinstance(part, Keys):
        return schema_of(part)
    return KINDS[part] if isinstance(part, str) else _kind(part)


def _hint(of: Any, name: str) -> Any:
    """Type of an attribute, or of an item by its number."""
    if name.isdigit():
        return get_args(of)[0] if get_origin(of) is tuple else list
    own = getattr(of, name, None)
    if made := getattr(own, "fget", None) or getattr(own, "func", None):
        return made.__annotations__["return"]
    annotated = (getattr(one, "__annotations__", {}) for one in of.__mro__)
    return next((names[name] for names in annotated if name in names), Any)


def _kind(hint: Any) -> dict[str, Any]:
    """The schema of a type; every number may be null, which says that it is not finite."""
    origin, inside = get_origin(hint), get_args(hint)
    if hint is Any:
        return {}
    if hint in SIMPLE:
        return KINDS["number"] if hint is float else {"type": SIMPLE[hint]}
    if NoneType in inside:
        return {"anyOf": [_kind(one) for one in inside]}
    if isinstance(hint, type) and dataclasses.is_dataclass(hint):
        return schema_of(Keys("**", of=hint))
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return _free(_kind(inside[1]))
    return {"type": "array"} | ({"items": _kind(inside[0])} if origin in (tuple, list) else {})
