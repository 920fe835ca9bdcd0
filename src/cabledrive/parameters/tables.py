"""The tables of a drive file and how plain data becomes a Drive, and a Drive plain data again."""

import dataclasses
from collections.abc import Mapping
from functools import cache
from typing import Any

from cabledrive.parameters.cable import Cable, with_type
from cabledrive.parameters.drive import SCHEMA_VERSION, WORDS, Drive, check_count
from cabledrive.parameters.drive_parts import Carriage, Goal, Layout, Lumped, Motor, Pulley, Sensors
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.excitation import StatedExcitation
from cabledrive.parameters.fields import key_of, kind_of, nearest, written
from cabledrive.parameters.units import to_si

TABLES: dict[str, type] = {
    "cable": Cable,
    "layout": Layout,
    "motor": Motor,
    "lumped": Lumped,
    "sensors": Sensors,
    "goal": Goal,
    "excitation": StatedExcitation,
}
ARRAYS: dict[str, type] = {"pulley": Pulley, "carriage": Carriage}
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


def drive_from_tables(data: dict[str, Any]) -> Drive:
    """Build a drive from the tables, numbers (SI) and text of its file.

    Refused: an unknown or missing key, a value of the wrong type, unit or range, parts that do not fit.
    """
    check_schema(data)
    check_keys(data, Drive, "")
    content = single_tables(data, TABLES)
    for key, table in ARRAYS.items():
        if key in data:
            rows = rows_of(data, key)
            if key == "carriage":
                check_count(len(rows))
            content[key] = tuple(table_from(row, table, f"{key}.{i}") for i, row in enumerate(rows))
    return Drive(**content)


def single_tables(data: dict[str, Any], tables: Mapping[str, type]) -> dict[str, Any]:
    """Words and tables of a file that stand there once, as fields of a drive."""
    content: dict[str, Any] = {key: data[key] for key in HEAD if key in data}
    for key, table in tables.items():
        if key in data:
            given = with_type(data[key], key) if key == "cable" else data[key]
            content[key] = table_from(given, table, key)
    return content


def check_schema(data: dict[str, Any]) -> None:
    """Refuse a file that is empty or of another version."""
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


def check_keys(data: dict[str, Any], table: type, place: str) -> None:
    """Refuse keys that a table does not know, and a table that lacks one; ``place``: "cable."."""
    fields = _fields_by_key(table)
    for key in data:
        if key not in fields:
            other = OTHER_WORDS.get(f"{place.split('.')[0]}.{key}")
            hint = f": {other}" if other else nearest(key[:60], fields, place)
            raise InputRefused(f'unknown key "{place}{key[:60]}"{hint}')
    for name, field in fields.items():
        if field.default is dataclasses.MISSING and name not in data:
            table_or_key = "table" if name in TABLES or name in ARRAYS else "key"
            meaning = field.metadata.get("meaning", f"a {table_or_key} of the drive")
            raise InputRefused(f'missing key "{place}{name}": {meaning}; add it')


@cache
def _fields_by_key(table: type) -> dict[str, dataclasses.Field[Any]]:
    """Fields of a table by their keys in the drive file."""
    return {key_of(field): field for field in dataclasses.fields(table)}


def rows_of(data: dict[str, Any], key: str) -> list[Any]:
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
    fields = _fields_by_key(table)
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


def tables_from_drive(drive: Drive, *, words: bool = True) -> dict[str, Any]:
    """Write a drive as the plain data of a file: SI, each quantity with its unit, defaults left out.

    With ``words``, names and other text without bearing on results, it reads back as an equal drive.
    """
    return plain_tables(drive, TABLES, words) | {
        key: [plain_table(row, words) for row in getattr(drive, key)] for key in ARRAYS if getattr(drive, key)
    }


def plain_tables(drive: Any, tables: Mapping[str, type], words: bool) -> dict[str, Any]:
    """Words and tables of a machine that stand there once, as plain data."""
    data = {
        key: getattr(drive, key)
        for key in HEAD
        if (words or key not in WORDS) and (key == "name" or getattr(drive, key) != "")
    }
    kind: type = type(drive)
    fields = _fields_by_key(kind)
    return data | {
        key: plain_table(getattr(drive, key), words)
        for key in tables
        if getattr(drive, key) is not None and getattr(drive, key) != fields[key].default
    }


def plain_table(table: Any, words: bool) -> dict[str, Any]:
    """A table as plain data, each quantity with its unit, defaults left out; ``words``: texts included."""
    return {
        key_of(field): _text(getattr(table, field.name), field.metadata)
        for field in dataclasses.fields(table)
        if getattr(table, field.name) != field.default and (words or "words" not in field.metadata)
    }


def _text(value: Any, metadata: Mapping[str, Any]) -> Any:
    if "pair" in metadata:
        return [f"{part!r} {metadata['pair']}" for part in value]
    if isinstance(value, tuple):
        return list(value)
    unit = metadata.get("unit")
    return value if unit in (None, "1", "count") else f"{value!r} {unit}"
