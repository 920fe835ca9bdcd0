"""Values of the small TOML files that stand beside a drive file: each of its kind, or refused in a line."""

import re
import tomllib
from collections.abc import Callable, Mapping
from math import isfinite
from pathlib import Path
from typing import Any, TypeVar

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import written
from cabledrive.parameters.units import to_si

LARGEST_FILE = 16_000_000
LARGEST_WHOLE = 2**53
"""Whole numbers up to here are floats as well."""
_DEEP_KEY = re.compile(r"(?<![^\s.=])(?:[^\s.=,\[\]{}]+[ \t]*\.[ \t]*){20}")  # would take tomllib minutes

Made = TypeVar("Made")


def read_toml(path: str | Path, remedy: str, make: Callable[[dict[str, Any]], Made]) -> Made:
    """What ``make`` makes of a TOML file, which its refusals name; refused if unreadable or none."""
    path = Path(path)
    try:
        content = toml_of(content_of(path))
    except FileNotFoundError:
        raise InputRefused("is not there: check the path").at(str(path)) from None
    except IsADirectoryError:
        raise InputRefused("is a folder: name a file in it").at(str(path)) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None)
        shown = f"cannot be read ({reason}): check the path" if reason else f"{error}; {remedy}"
        raise InputRefused(shown).at(str(path) if reason else path.name) from None
    try:
        return make(content)
    except InputRefused as refusal:
        raise refusal.at(path.name) from None


def content_of(path: Path) -> bytes:
    """Bytes of a file of moderate size; a device or a pipe is refused."""
    if path.exists() and not path.is_dir() and not path.is_file():
        raise InputRefused("is a device or a pipe, no regular file: give the path of a file")
    with path.open("rb") as file:
        content = file.read(LARGEST_FILE + 1)
    if len(content) > LARGEST_FILE:
        raise InputRefused(f"larger than the {LARGEST_FILE / 1e6:.0f} MB that are read")
    return content


def toml_of(content: bytes) -> dict[str, Any]:
    """What a TOML file holds; refused if it is none, or cannot be read in reasonable time."""
    try:
        text = content.decode("utf-8-sig")
        if _DEEP_KEY.search(text):
            raise RecursionError
        return tomllib.loads(text)
    except UnicodeDecodeError as error:
        raise InputRefused(f"not text (byte {error.start} is not UTF-8): give a TOML file") from None
    except tomllib.TOMLDecodeError as error:
        raise InputRefused(f"not TOML: {error}; correct that line") from None
    except (RecursionError, ValueError):
        raise InputRefused(
            "not TOML that can be read: nested too deeply, or a number of absurd length"
        ) from None


def table_of(key: str, value: Any) -> Mapping[str, Any]:
    """A table. Raises `InputRefused` if it is none."""
    if not isinstance(value, Mapping):
        raise InputRefused(f"{key} = {written(value)} is no table: write [{key}] and its keys below")
    return value


def quantity_of(key: str, value: Any, unit: str) -> float:
    """A finite number in SI, or text with a unit of the same dimension; else refused."""
    if isinstance(value, str):
        try:
            value = to_si(value, unit)
        except InputRefused as refusal:
            raise InputRefused(f"{key} = {refusal}") from None
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not _finite(value):
        raise InputRefused(
            f'{key} = {written(value)} is no quantity: write one number in {unit}, or "3 {unit}"'
        )
    return float(value)


def _finite(value: int | float) -> bool:
    try:
        return isfinite(value)
    except OverflowError:  # a whole number of more digits than a double holds
        return False


def quantities_of(key: str, value: Any, unit: str) -> tuple[float, ...]:
    """A list of quantities, as `quantity_of`; else refused."""
    if not isinstance(value, list):
        raise InputRefused(f"{key} = {written(value)} is no list: write such as [1.0, 3.0], in {unit}")
    return tuple(quantity_of(key, item, unit) for item in value)


def whole_of(key: str, value: Any, least: int = 1) -> int:
    """A whole number. Raises `InputRefused` if it is none, too small, or above `LARGEST_WHOLE`."""
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise InputRefused(f"{key} = {written(value)} must be a whole number of at least {least}: write one")
    if value > LARGEST_WHOLE:
        raise InputRefused(f"{key} = {written(value)} is above {LARGEST_WHOLE}: write a smaller number")
    return value


def flag_of(key: str, value: Any) -> bool:
    """True or false. Raises `InputRefused` if it is neither."""
    if not isinstance(value, bool):
        raise InputRefused(f"{key} = {written(value)} is neither true nor false: write one of them")
    return value


def text_of(key: str, value: Any) -> str:
    """A text. Raises `InputRefused` if it is none."""
    if not isinstance(value, str):
        raise InputRefused(f"{key} = {written(value)} is no text: write it in quotation marks")
    return value
