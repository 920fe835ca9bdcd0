"""Values of the small TOML files that stand beside a drive file: each of its kind, or refused in a line."""

import tomllib
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import Any

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import written
from cabledrive.parameters.units import to_si


def read_toml(path: Path, remedy: str) -> dict[str, Any]:
    """Read a TOML file.

    Parameters
    ----------
    path : Path
    remedy : str
        What to write instead of what is none.

    Returns
    -------
    dict

    Raises
    ------
    InputRefused
        If it cannot be read or is no TOML.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputRefused(f"{path.name}: {error}: {remedy}") from None


def table_of(key: str, value: Any) -> Mapping[str, Any]:
    """A table.

    Parameters
    ----------
    key : str
    value : object

    Returns
    -------
    mapping

    Raises
    ------
    InputRefused
        If it is none.
    """
    if not isinstance(value, Mapping):
        raise InputRefused(f"{key} = {written(value)} is no table: write [{key}] and its keys below")
    return value


def quantity_of(key: str, value: Any, unit: str) -> float:
    """A finite number in SI, or text with a unit.

    Parameters
    ----------
    key : str
    value : object
    unit : str
        SI unit.

    Returns
    -------
    float

    Raises
    ------
    InputRefused
        If it is neither, or of another dimension.
    """
    if isinstance(value, str):
        try:
            value = to_si(value, unit)
        except InputRefused as refusal:
            raise InputRefused(f"{key} = {refusal}") from None
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
        raise InputRefused(
            f'{key} = {written(value)} is no quantity: write one number in {unit}, or "3 {unit}"'
        )
    return float(value)


def quantities_of(key: str, value: Any, unit: str) -> tuple[float, ...]:
    """A list of quantities.

    Parameters
    ----------
    key : str
    value : object
    unit : str
        SI unit.

    Returns
    -------
    tuple of float

    Raises
    ------
    InputRefused
        If it is no list, or holds something else.
    """
    if not isinstance(value, list):
        raise InputRefused(f"{key} = {written(value)} is no list: write such as [1.0, 3.0], in {unit}")
    return tuple(quantity_of(key, item, unit) for item in value)


def whole_of(key: str, value: Any, least: int = 1) -> int:
    """A whole number.

    Parameters
    ----------
    key : str
    value : object
    least : int, default 1

    Returns
    -------
    int

    Raises
    ------
    InputRefused
        If it is none, or too small.
    """
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise InputRefused(f"{key} = {written(value)} must be a whole number of at least {least}: write one")
    return value


def flag_of(key: str, value: Any) -> bool:
    """True or false.

    Parameters
    ----------
    key : str
    value : object

    Returns
    -------
    bool

    Raises
    ------
    InputRefused
        If it is neither.
    """
    if not isinstance(value, bool):
        raise InputRefused(f"{key} = {written(value)} is neither true nor false: write one of them")
    return value
