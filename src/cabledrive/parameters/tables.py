"""The tables of a drive file and how plain data becomes a Drive, and a Drive plain data again."""

import dataclasses
from typing import Any

from cabledrive.parameters.cable import Cable
from cabledrive.parameters.carriage import Carriage
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.instruments import Goal, Lumped, Sensors
from cabledrive.parameters.layout import Layout
from cabledrive.parameters.motor import Motor
from cabledrive.parameters.pulley import Pulley
from cabledrive.parameters.units import to_si

TABLES: dict[str, type] = {
    "cable": Cable,
    "layout": Layout,
    "motor": Motor,
    "lumped": Lumped,
    "sensors": Sensors,
    "goal": Goal,
}
ARRAYS: dict[str, type] = {"pulley": Pulley, "carriage": Carriage}
WORDS = ("schema", "name", "kind", "title", "source")


def drive_from_tables(data: dict[str, Any]) -> Drive:
    """Build a drive from the plain data of its file.

    Parameters
    ----------
    data : dict
        Tables, numbers and text as TOML gives them; quantities are SI numbers or text with a unit.

    Returns
    -------
    Drive

    Raises
    ------
    InputRefused
        For an unknown or missing key, a value of the wrong type, unit or range, or a drive that does not fit together.
    """
    _check_schema(data)
    _check_keys(data, Drive, "")
    content: dict[str, Any] = {key: _word(key, data[key]) for key in WORDS if key in data}
    for key, table in TABLES.items():
        if key in data:
            content[key] = _table(data[key], table, key)
    for key, table in ARRAYS.items():
        if key in data:
            content[key] = _array(data[key], table, key)
    return Drive(**content)


def _check_schema(data: dict[str, Any]) -> None:
    if not data:
        raise InputRefused('no keys: a drive file starts with schema = 1 and name = "..."; see cabledrive schema')
    version = data.get("schema")
    if type(version) is not int or version != 1:
        shown = "missing" if version is None else f"{version!r:.40}"
        raise InputRefused(f"schema is {shown}, but this version reads schema 1: write schema = 1")


def _check_keys(data: dict[str, Any], table: type, place: str) -> None:
    fields = {field.name: field for field in dataclasses.fields(table)}
    for key in data:
        if key not in fields:
            raise InputRefused(f'unknown key "{place}{key[:60]}"{nearest(key[:60], fields, place)}')
    for name, field in fields.items():
        if field.default is dataclasses.MISSING and name not in data:
            meaning = field.metadata.get("meaning", "a table of the drive" if name in TABLES else "a key of the drive")
            raise InputRefused(f'missing key "{place}{name}": {meaning}; add it')


def _word(key: str, value: Any) -> Any:
    if key != "schema" and not isinstance(value, str):
        raise InputRefused(f"{key} is a {type(value).__name__}, not text: write it between quotation marks")
    return value


def _array(rows: Any, table: type, key: str) -> tuple[Any, ...]:
    if not isinstance(rows, list):
        raise InputRefused(f"{key} is not an array of tables: write [[{key}]] above each")
    return tuple(_table(row, table, f"{key}.{number}") for number, row in enumerate(rows))


def _table(data: Any, table: type, place: str) -> Any:
    if not isinstance(data, dict):
        raise InputRefused(f"{place} is a {type(data).__name__}, not a table: write [{place}] above its keys")
    _check_keys(data, table, f"{place}.")
    fields = {field.name: field for field in dataclasses.fields(table)}
    try:
        return table(**{key: _value(value, fields[key], key) for key, value in data.items()})
    except InputRefused as refusal:
        raise InputRefused(f"{place}.{refusal}") from None


def _value(value: Any, field: dataclasses.Field[Any], key: str) -> Any:
    unit = field.metadata.get("unit")
    if unit is None:
        return value
    if value is None or isinstance(value, (list, dict)):
        raise InputRefused(f"{key} is a {type(value).__name__}, not a quantity in {unit}: write one number or text")
    if not isinstance(value, str):
        return value
    try:
        return to_si(value, "1" if unit == "count" else unit)
    except InputRefused as refusal:
        raise InputRefused(f"{key} = {refusal}") from None


def tables_from_drive(drive: Drive) -> dict[str, Any]:
    """Write a drive as the plain data of a file: SI, each quantity with its unit, defaults left out.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    dict
        What `drive_from_tables` turns back into an equal drive.
    """
    data: dict[str, Any] = {key: getattr(drive, key) for key in WORDS if getattr(drive, key) != ""}
    for key in TABLES:
        if getattr(drive, key) is not None:
            data[key] = _plain(getattr(drive, key))
    for key in ARRAYS:
        if getattr(drive, key):
            data[key] = [_plain(row) for row in getattr(drive, key)]
    return data


def _plain(table: Any) -> dict[str, Any]:
    return {
        field.name: _text(getattr(table, field.name), field.metadata.get("unit"))
        for field in dataclasses.fields(table)
        if getattr(table, field.name) != field.default
    }


def _text(value: Any, unit: str | None) -> Any:
    return value if unit in (None, "1", "count") else f"{value!r} {unit}"
