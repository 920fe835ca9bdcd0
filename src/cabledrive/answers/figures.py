"""Figures as people read them: numbers, quantities, and the rows that results declare of themselves."""

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields
from functools import cache, reduce
from math import degrees, floor, isfinite, log10, pi
from typing import Any, NamedTuple

SPACE = "\N{NARROW NO-BREAK SPACE}"
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PREFIXES = {3: "k", 6: "M", 9: "G", 12: "T"}
_PREFIXED = {"N", "Pa", "Hz", "N/m", "N m", "N m/rad"}


def number(value: float, digits: int = 5) -> str:
    """A number of some significant digits, trailing zeros dropped: "0.03", "116.33", "7.316 × 10⁻⁶"."""
    if not isfinite(value):
        return "infinite" if value > 0 else "minus infinite" if value < 0 else "not a number"
    rounded = float(f"{value:.{digits}g}")
    if rounded == 0.0:
        return "0"
    if 1e-3 <= abs(rounded) < 1e6:
        return f"{rounded:.{max(digits, 6)}g}".replace("-", "−")
    exponent = floor(log10(abs(value)))
    mantissa = f"{value / 10.0**exponent:.{digits}g}"
    if abs(float(mantissa)) >= 10.0:  # 9.99999 rounds up
        mantissa, exponent = f"{float(mantissa) / 10:.{digits}g}", exponent + 1
    return f"{mantissa}{SPACE}×{SPACE}10{str(exponent).translate(RAISED)}".replace("-", "−")


def stated(value: float | None, digits: int) -> str:
    """A `number`; nothing where there is none."""
    return "" if value is None else number(value, digits)


def fixed(value: float, decimals: int) -> str:
    """A number with a given count of decimals, for columns that line up."""
    return f"{value:.{decimals}f}".replace("-", "−")


def unit_name(unit: str) -> str:
    """A unit of a drive file as it is printed: "kg m²" for "kg m^2"; nothing for a plain number."""
    if unit == "1":
        return ""
    head, *powers = unit.split("^")
    return head + "".join(p[0].translate(RAISED) + p[1:] for p in powers)


def quantity(value: float, unit: str, digits: int = 5) -> str:
    """A quantity in SI in the unit people use for its size: "2.6 GPa", "0.49 g/m", "3 cm", "1092 rpm"."""
    value, unit = _customary(value, unit)
    name = unit_name(unit)
    gap = "" if name.startswith("°") else SPACE
    return f"{number(value, digits)}{gap}{name}" if name else number(value, digits)


def _customary(value: float, unit: str) -> tuple[float, str]:
    size = abs(value)
    if unit == "rad":
        return degrees(value), "°"
    if unit == "rad/s":
        return value * 30 / pi, "rpm"
    if unit == "m^2" and size < 1e-2:
        return value * 1e6, "mm^2"
    if unit == "m" and 0 < size < 0.1:
        return (value * 1e3, "mm") if size >= 1e-4 else (value * 1e6, "µm")
    if unit in ("kg", "kg/m") and 0 < size < 0.1:
        return value * 1e3, unit.replace("kg", "g")
    if unit in _PREFIXED and size >= 1e3:
        power = min(3 * floor(log10(size) / 3 + 1e-12), 12)
        return value / 10.0**power, _PREFIXES[power] + unit
    if unit in ("N", "N m") and 0 < size < 0.1:
        return value * 1e3, "m" + unit
    return value, unit


class Row(NamedTuple):
    """A figure that a result declares, once for text, card, page, table and the schema of its JSON."""

    key: str  # where it is, inside parts behind points
    words: str
    unit: str = ""  # in which it is shown; of a quantity that of the value
    # a format, or digits of a `number`, or what makes the words; "d": a count; "": a `quantity`
    form: str | int | Callable[[Any], str] = ".4g"
    scale: float = 1.0  # from the result's own unit
    kind: str = "number"  # in JSON, see `Keys`
    none: str = ""  # what stands in a table where there is none

    def of(self, data: Any) -> Any:
        """The value in a result or a mapping; None where it is not."""
        return reduce(part_of, self.key.split("."), data)

    def text(self, value: Any) -> str:
        """The value as it stands in a column, whose head has the unit; a quantity has its own."""
        if value is None:
            return self.none
        if callable(self.form):
            return self.form(value)
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, str):
            return value
        if isinstance(value, list | tuple):
            return " and ".join(map(self.full, value))
        if self.form == "":
            return quantity(value, self.unit)
        if isinstance(self.form, int):
            return number(self.scale * value, self.form)
        return format(self.scale * value, ".0f" if self.form == "d" else self.form)

    def full(self, value: Any) -> str:
        """The value with its unit."""
        plain = self.form == "" or isinstance(value, bool | str | list | tuple)
        return self.text(value) if plain else f"{self.text(value)} {self.unit}".rstrip()


def part_of(data: Any, key: str) -> Any:
    """An item of a mapping or an attribute; None where there is none."""
    return data.get(key) if isinstance(data, Mapping) else getattr(data, key, None)


def inside(rows: Iterable[Row], part: str) -> tuple[Row, ...]:
    """The rows of what lies in a part, as they are seen from there."""
    return tuple(row._replace(key=row.key[len(part) + 1 :]) for row in rows if row.key.startswith(f"{part}."))


def shown(rows: Iterable[Row], data: Any) -> list[tuple[str, str]]:
    """Words and value of each figure that there is, but no counts of none; of several texts a line each."""
    found: list[tuple[str, str]] = []
    for row in rows:
        value = row.of(data)
        if value is None or ((isinstance(value, str | list | tuple) or row.form == "d") and not value):
            continue
        several = isinstance(value, list | tuple) and isinstance(value[0], str)
        lines = value if several else [row.full(value)]
        found += [(row.words if not k else "", line) for k, line in enumerate(lines)]
    return found


def aligned(pairs: Iterable[tuple[str, str]]) -> list[str]:
    """Words and values as lines of text."""
    pairs = list(pairs)
    width = max((len(words) for words, _ in pairs), default=0)
    return [f"  {words:<{width}}  {value}" for words, value in pairs]


MOST_PARTS = 4
"""Of a kind, whose quantities are listed."""


def key_of(own: dataclasses.Field[Any]) -> str:
    """Name of a field in the drive file."""
    return str(own.metadata.get("key", own.name))


@cache
def fields_by_key(table: type) -> dict[str, dataclasses.Field[Any]]:
    """Fields of a table by their keys in the drive file, those left out that stand in none; else nothing."""
    found = fields(table) if dataclasses.is_dataclass(table) else ()
    return {key_of(own): own for own in found if own.metadata.get("file", True)}


def figure(
    unit: str,
    words: str,
    under: str = "",
    why: str = "",
    *,
    key: str = "",
    default: Any = dataclasses.MISSING,
) -> Any:
    """Declare a figure of a result: SI unit, words, the heading it is shown under, why it may be None.

    ``key``: name in JSON, and where it is looked up, if it is not the field's.
    """
    metadata = {"unit": unit, "meaning": words, "under": under, "why": why} | ({"key": key} if key else {})
    return dataclasses.field(default=default, metadata=metadata)


def figures_of(*tables: type) -> dict[str, tuple[Row, ...]]:
    """The figures that some results declare, by the headings that they are shown under."""
    found: dict[str, tuple[Row, ...]] = {}
    for own in (own for table in tables for own in fields(table)):
        about = own.metadata
        if about.get("under"):
            row = Row(key_of(own), about["meaning"], about["unit"], "")
            found[about["under"]] = (*found.get(about["under"], ()), row)
    return found


def given(of: Any, place: str = "") -> Iterator[tuple[str, str]]:
    """Key and value of each quantity that is stated of a thing and its parts, as `--set` has them."""
    for name, own in fields_by_key(of.__class__).items():
        value, unit, key = getattr(of, own.name), own.metadata.get("unit"), f"{place}{name}"
        if dataclasses.is_dataclass(value):
            yield from given(value, f"{key}.")
        elif isinstance(value, tuple):
            for k, one in enumerate(value[:MOST_PARTS]):
                yield from given(one, f"{key}.{k}.") if dataclasses.is_dataclass(one) else ()
        elif unit is not None and value is not None and not (value == 0.0 and own.default == 0.0):
            yield key, f"{value:d}" if unit == "count" else quantity(value, unit)


def percent(share: float, unit: str = " %") -> str:
    """A share in per cent that is never rounded up to the next tenth: it claims no more than was seen."""
    return f"{floor(1e3 * share + 1e-9) / 10:g}{unit}"


def rounded(value: float, digits: int) -> str:
    """Show a number to some digits, 246000 rather than 2.46e+05."""
    return f"{float(f'{value:.{digits}g}'):.9g}"
