"""Frozen results as the plain data of JSON, and back again."""

import dataclasses
import types
import typing
from collections.abc import Mapping
from math import isfinite
from typing import Any

from cabledrive.parameters import Drive
from cabledrive.parameters.route.tables import tables_from_routed
from cabledrive.parameters.route.two_pulleys import AxisDrive
from cabledrive.parameters.tables import drive_from_tables, tables_from_drive


def as_plain(value: Any) -> Any:
    """What JSON can hold of a result, without loss; fields that no comparison sees are left out.

    ``value``: dataclasses, drives, mappings, tuples, finite numbers, words, None.
    Raises `ValueError` if a number is not finite: a result says None instead, and why.
    """
    if isinstance(value, AxisDrive):
        machine = tables_from_routed(value.machine)
        return tables_from_drive(value) | {"machine": machine, "load": value.load, "gain": value.gain}
    if isinstance(value, Drive):
        return tables_from_drive(value)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        seen = (field.name for field in dataclasses.fields(value) if field.compare)
        return {name: as_plain(getattr(value, name)) for name in seen}
    if isinstance(value, Mapping):
        return {str(key): as_plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [as_plain(item) for item in value]
    if isinstance(value, float) and not isfinite(value):
        raise ValueError(f"{value} cannot be kept: give None with a reason")
    return value


def revived(kind: Any, data: Any) -> Any:
    """The result that plain data stand for.

    ``kind``: dataclass, or the annotation of one of its fields; ``data``: from `as_plain`.
    Returns of that kind.
    """
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin in (types.UnionType, typing.Union):
        return None if data is None else revived(_member(arguments, data), data)
    if kind is Drive:
        return drive_from_tables(data)
    if dataclasses.is_dataclass(kind):
        hints = typing.get_type_hints(kind)
        given = {
            field.name: revived(hints[field.name], data[field.name]) for field in dataclasses.fields(kind)
        }
        return typing.cast(Any, kind)(**given)
    if origin is tuple:
        kinds = [arguments[0]] * len(data) if arguments[-1] is Ellipsis else list(arguments)
        return tuple(revived(k, item) for k, item in zip(kinds, data, strict=True))
    if origin is not None and issubclass(origin, Mapping):
        return {key: revived(arguments[1], item) for key, item in data.items()}
    if kind is float and isinstance(data, int):
        return float(data)
    return data


def _member(kinds: tuple[Any, ...], data: Any) -> Any:
    """The kind of a union that data are of: of several dataclasses the one with these fields."""
    found = [kind for kind in kinds if kind is not type(None)]
    if len(found) == 1:
        return found[0]
    return next(kind for kind in found if {field.name for field in dataclasses.fields(kind)} == set(data))
