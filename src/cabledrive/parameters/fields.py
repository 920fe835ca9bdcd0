"""One way to declare a quantity of the drive: unit, bound and meaning beside the dataclass field."""

import dataclasses
import difflib
import inspect
import math
import numbers
import re
import unicodedata
from collections.abc import Iterable
from functools import lru_cache
from typing import Any, TypeVar

from cabledrive.answers.figures import key_of
from cabledrive.parameters.errors import InputRefused

Made = TypeVar("Made")
SMALLEST, LARGEST = 1e-24, 1e24  # products of a dozen such quantities stay within a double
_BOUNDS = {
    "positive": (lambda v: v > 0.0, "must be above 0"),
    "nonnegative": (lambda v: v >= 0.0, "must not be negative"),
    "finite": (lambda v: True, "must be finite"),
    "steepness": (lambda v: abs(v) <= math.pi / 2, "must lie between -90 deg and 90 deg"),
}
_KINDS: dict[type, str] = {
    bool: "true or false",
    numbers.Real: "a number",
    str: "text",
    list: "an array",
    dict: "a table",
    type(None): "nothing",
}


def quantity(
    unit: str, bound: str, meaning: str, default: Any = dataclasses.MISSING, *, key: str | None = None
) -> Any:
    """Declare a physical quantity as a dataclass field, described by its metadata.

    ``unit``: SI unit; "1" for a plain number, "count" for a whole number; ``bound``, {"positive",
    "nonnegative", "finite", "steepness"}: what a value must satisfy, besides being finite; ``meaning``: one
    line for the schema and the reference; ``default``: value when the file is silent; None means "not
    stated". Without it the key is required; ``key``: name in the drive file where it is not the field's.
    """
    metadata = {"unit": unit, "bound": bound, "meaning": meaning} | ({"key": key} if key else {})
    return dataclasses.field(default=default, metadata=metadata)


def choice(options: tuple[Any, ...], meaning: str, default: Any = dataclasses.MISSING) -> Any:
    """Declare a field that takes one of a few values; without a default the key is required.

    ``meaning``: one line for the schema and the reference.
    """
    return dataclasses.field(default=default, metadata={"options": options, "meaning": meaning})


def words(meaning: str, default: Any = dataclasses.MISSING) -> Any:
    """Declare a field that holds text without any bearing on results: it is no part of the content hash."""
    return dataclasses.field(default=default, metadata={"words": True, "meaning": meaning})


def pair(unit: str, meaning: str, default: Any = dataclasses.MISSING) -> Any:
    """Declare two quantities of one SI unit along x and y as a dataclass field, with a default."""
    return dataclasses.field(default=default, metadata={"pair": unit, "meaning": meaning})


def meaning(text: str, default: Any = dataclasses.MISSING, *, factory: Any = dataclasses.MISSING) -> Any:
    """Declare a field of any kind with what it means, unit and shape included; see `described`."""
    if factory is not dataclasses.MISSING:
        return dataclasses.field(default_factory=factory, metadata={"meaning": text})
    return dataclasses.field(default=default, metadata={"meaning": text})


def described(table: type[Made]) -> type[Made]:
    """Add to the docstring of a dataclass what its fields say of themselves, as numpydoc has it."""
    lines = [inspect.getdoc(table) or "", "", "Attributes", "----------"]
    for field in dataclasses.fields(table):  # type: ignore[arg-type]  # a dataclass
        if "meaning" in field.metadata:
            unit = field.metadata.get("unit", field.metadata.get("pair", "1"))
            kind = field.type.__name__ if isinstance(field.type, type) else str(field.type)
            kind = re.sub(r"[\w.]+\.(\w+)", r"\1", kind)  # without the modules
            kind = ", ".join(map(repr, field.metadata.get("options", ()))) or kind
            default = "" if field.default is dataclasses.MISSING else f", default {field.default!r}"
            shown = "" if unit in ("1", "count") else f" [{unit}]"
            lines += [f"{field.name} : {kind}{default}", f"    {field.metadata['meaning']}{shown}"]
    table.__doc__ = "\n".join(lines)
    return table


class Checked:
    """A table whose first value outside its declared bound is refused when it is made: results trust it."""

    __slots__ = ()

    def __post_init__(self) -> None:
        check_fields(self)


def check_fields(table: Any) -> None:
    """Refuse a table's first value outside its declared bound."""
    for field in dataclasses.fields(table):
        value = getattr(table, field.name)
        if "unit" in field.metadata and not (value is None and field.default is None):
            object.__setattr__(table, field.name, _checked(field, value))
        elif "words" in field.metadata:
            check_text(field.name, value)
        elif "pair" in field.metadata and not (value is None and field.default is None):
            object.__setattr__(table, field.name, _checked_pair(field, value))
        elif (options := field.metadata.get("options")) and not any(
            type(value) is type(option) and value == option for option in options
        ):
            known = " or ".join(written(option) for option in options)
            raise InputRefused(f"{field.name} = {written(value)} is not one of its values: write {known}")


def check_text(key: str, text: Any) -> None:
    """Refuse what is not text under a key, or holds characters that no file or page can show."""
    if not isinstance(text, str):
        raise InputRefused(f"{key} is {kind_of(text)}, not text: write it between quotation marks")
    bad = _unseen(text)
    if bad:
        raise InputRefused(f"{key} holds the character {bad!r}, which no file or page can show: leave it out")


@lru_cache(maxsize=256)
def _unseen(text: str) -> str:
    """First character of a text that cannot be shown; empty: none. Rows of a campaign share their texts."""
    return next((c for c in text if c not in "\n\t" and unicodedata.category(c) in ("Cc", "Cs")), "")


def kind_of(value: Any) -> str:
    """Name the kind of a value in the words of a drive file: "text", "a number", "an array"."""
    for kind, words in _KINDS.items():
        if isinstance(value, kind):
            return words
    return "a date or time" if hasattr(value, "isoformat") else f"a {type(value).__name__}"


def written(value: Any) -> str:
    """Show a value as in a drive file, ``true``, ``"text"``, ``1.5``, or its kind where that is long."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"' if len(value) <= 60 else f'"{value[:60]}..."'
    if isinstance(value, (int, float)) and abs(value) < 1e15:
        return f"{value:.9g}"
    return kind_of(value)


def _checked(field: dataclasses.Field[Any], value: Any) -> float | int:
    unit, bound = field.metadata["unit"], field.metadata["bound"]
    number = value if type(value) is float else _number(key_of(field), value, unit)
    least = SMALLEST if bound == "positive" else -LARGEST
    holds, words = _BOUNDS[bound]
    fits = least <= number <= LARGEST and holds(number)
    if fits and unit == "count" and number == int(number):
        return int(number)
    if fits and unit != "count":
        return number + 0.0  # not -0.0: equal drives have equal hashes
    shown = f"{key_of(field)} = {number:.9g}" + ("" if unit in ("1", "count") else f" {unit}")
    if not math.isfinite(number):
        raise InputRefused(f"{shown} must be finite: give a number")
    if not holds(number):
        raise InputRefused(f"{shown} {words}: {field.metadata['meaning']}")
    if fits:
        raise InputRefused(f"{shown} must be a whole number of counts per revolution")
    raise InputRefused(f"{shown} is no size of a machine ({SMALLEST:g} to {LARGEST:g}): check its unit")


def _checked_pair(field: dataclasses.Field[Any], value: Any) -> tuple[float, float]:
    name, unit = field.name, field.metadata["pair"]
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise InputRefused(
            f'{name} is {kind_of(value)}, not two quantities along x and y: write ["1 {unit}", "2 {unit}"]'
        )
    numbers_found = [_number(name, part, unit) for part in value]
    for number in numbers_found:
        if not abs(number) <= LARGEST:
            raise InputRefused(
                f"{name} = {number:.9g} {unit} must be finite and below {LARGEST:g}: check its unit"
            )
    return numbers_found[0] + 0.0, numbers_found[1] + 0.0


def _number(name: str, value: Any, unit: str) -> float:
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise InputRefused(
            f"{name} is {kind_of(value)}, not a number: give it in {unit}, or as text with a unit"
        )
    try:
        return float(value)
    except OverflowError:
        raise InputRefused(f"{name} has more digits than a double can hold: give a finite number") from None


def require_known(word: str, known: Iterable[str], line: str, place: str = "") -> None:
    """Refuse a word that is none of those known, by a line to which the nearest one is added."""
    if word not in known:
        raise InputRefused(line + nearest(word, known, place))


def nearest(word: str, known: Iterable[str], place: str = "") -> str:
    """Suggest the known word, behind a place like "cable.", that a mistyped one probably meant, or all."""
    known = sorted(known)
    close = difflib.get_close_matches(word, known, n=1, cutoff=0.5)
    return f' (did you mean "{place}{close[0]}"?)' if close else f" (known: {', '.join(known)})"
