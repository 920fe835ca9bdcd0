"""What is varied: the table ``[vary]`` of a SPEC, its axes, and columns of table files."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from math import log
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import nearest, written
from cabledrive.parameters.files import require_regular
from cabledrive.parameters.toml_values import quantity_of, table_of, text_of, whole_of

EDGE = 1e-16
"""Shares are kept this far from 0 and 1 where a distribution has no ends."""


class Spread(Protocol):
    """Values of one key over the unit interval."""

    def at(self, share: Array) -> NDArray[Any]:
        """Values in SI. ``share``, shape (n,): between 0 and 1."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Range:
    """Evenly between two values, or evenly in their logarithm."""

    low: float
    high: float
    logarithmic: bool = False

    def at(self, share: Array) -> NDArray[Any]:
        """Values at shares of the way, the ends exact."""
        if self.logarithmic:
            inside = np.exp((1.0 - share) * log(self.low) + share * log(self.high))
            return np.clip(inside, self.low, self.high)
        return np.asarray((1.0 - share) * self.low + share * self.high)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Values:
    """A list of values, each with the same share of the interval."""

    values: NDArray[Any]  # (n,): numbers in SI, words, or true and false

    def at(self, share: Array) -> NDArray[Any]:
        """The value in whose part of the interval a share lies."""
        place = np.minimum((share * self.values.size).astype(np.int64), self.values.size - 1)
        return np.asarray(self.values[place])


@dataclass(frozen=True, slots=True, kw_only=True)
class Distribution:
    """Quantiles of a distribution."""

    form: str  # of `SHAPES`
    values: tuple[float, ...]  # as the SPEC gives them, in SI

    def at(self, share: Array) -> NDArray[Any]:
        """Quantiles."""
        from scipy import stats

        share, (first, second, *last) = np.clip(share, EDGE, 1.0 - EDGE), self.values
        if self.form == "triangular":
            width = last[0] - first
            return np.asarray(stats.triang.ppf(share, (second - first) / width, loc=first, scale=width))
        if self.form == "lognormal":
            return np.asarray(stats.lognorm.ppf(share, log(second), scale=first))
        return np.asarray(stats.norm.ppf(share, loc=first, scale=second))


@dataclass(frozen=True, slots=True, kw_only=True)
class Multiple:
    """A key that follows another one."""

    of: Spread  # of the other key
    factor: float

    def at(self, share: Array) -> NDArray[Any]:
        """The other key's values times the factor."""
        return np.asarray(self.factor * self.of.at(share))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Axis:
    """One dimension of a design; linked keys and the columns of one table share it."""

    spreads: dict[str, Spread]  # by key
    units: dict[str, str]  # by key
    levels: int | None  # number of points on a grid; None: not stated

    @property
    def counted(self) -> bool:
        """Whether it has values one by one, and not a range."""
        return any(isinstance(spread, Values) for spread in self.spreads.values())

    def shares(self, count: int) -> Array:
        """Where the points of a grid lie: ends included on a range, the middle of each part elsewhere."""
        if all(isinstance(spread, (Range, Multiple)) for spread in self.spreads.values()) and count > 1:
            return np.arange(count) / (count - 1)
        return (np.arange(count) + 0.5) / count


def check_order(key: str, *values: float, unit: str) -> None:
    """Refuse values that do not ascend. ``unit``: in which they are."""
    for low, high in pairwise(values):
        if not low < high:
            raise InputRefused(f"{key}: {low:.9g} {unit} is not below {high:.9g} {unit}: give them ascending")


LARGEST_TABLE = 2_000_000_000
"""Bytes of a table file."""


def digest_of(path: Path) -> str:
    """Hash of the content of a table file. Raises `InputRefused` if it is no regular file or too large."""
    require_regular(path, "give a CSV or Parquet file")
    if path.stat().st_size > LARGEST_TABLE:
        raise InputRefused(f"larger than the {LARGEST_TABLE / 1e9:.0f} GB that are read").at(str(path))
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def column_of(path: Path, name: str) -> tuple[list[Any], str]:
    """Values of a column without gaps, and the unit in its heading, ``cable.pretension [N]``, or none."""
    table = _read(path, digest_of(path))
    headings = {str(heading).partition("[")[0].strip(): str(heading) for heading in table.column_names}
    if name not in headings:
        raise InputRefused(f'no column "{name}"{nearest(name, headings)}').at(str(path))
    column = table.column(headings[name])
    if column.null_count or not len(column):
        raise InputRefused(f'column "{name}" is empty or has gaps: fill them').at(str(path))
    unit = headings[name].partition("[")[2].partition("]")[0].strip()
    return column.to_pylist(), unit


@cache
def _read(path: Path, digest: str) -> Any:
    """The table; ``digest``: of its content, so that a changed file is read again."""
    import pyarrow

    try:
        if path.suffix.lower() in (".parquet", ".pq"):
            from pyarrow.parquet import read_table

            return read_table(path)
        from pyarrow.csv import read_csv

        return read_csv(path)
    except (pyarrow.ArrowException, OSError, ValueError) as error:
        why = str(error).splitlines()[0]
        raise InputRefused(f"is no table that can be read ({why}): give CSV or Parquet").at(
            str(path)
        ) from None


SHAPES = {
    "normal": ("mean", "standard deviation"),
    "lognormal": ("median", "factor"),
    "triangular": ("lowest", "likeliest", "highest"),
}
"""What is given of each distribution; a factor of one standard deviation of the logarithm."""
FORMS = ("from", "to", "values", *SHAPES, "table", "same_as")
OTHER_WORDS = ("n", "scale", "column", "factor", "linked")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Varied:
    """One key as ``[vary]`` gives it."""

    spread: Spread | None  # None: a multiple of another key
    unit: str
    levels: int | None  # points on a grid
    group: str  # keys of one group share an axis
    said: dict[str, Any]  # what the SPEC says, in SI: distinguishes campaigns


def flattened(table: Mapping[str, Any], place: str = "") -> dict[str, Any]:
    """Entries by whole key, whether it was written in quotation marks or as nested tables; else refused."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        whole = f"{place}{key}"
        inner = table_of(f"vary.{whole}", value)
        if inner and all(isinstance(part, Mapping) for part in inner.values()):
            found |= flattened(inner, f"{whole}.")
        else:
            found[whole] = inner
    return found


def axes_of(table: Mapping[str, Any], unit_of: Callable[[str], str], folder: Path) -> tuple[Axis, ...]:
    """Axes of a design, in the order of the SPEC; ``folder``: from which table files are named."""
    return _grouped(varied_keys(table, unit_of, folder))


def varied_keys(table: Mapping[str, Any], unit_of: Callable[[str], str], folder: Path) -> dict[str, Varied]:
    """The entries of ``[vary]``, by key. Raises `InputRefused` if an entry is not understood."""
    found = {}
    for key, entry in flattened(table).items():
        try:
            unit = unit_of(key)
        except InputRefused as refusal:
            raise InputRefused(f"[vary]: {refusal}") from None
        try:
            found[key] = _varied(key, entry, unit, folder)
        except InputRefused as refusal:
            raise InputRefused(f"vary.{refusal}") from None
    return found


def _varied(key: str, entry: Mapping[str, Any], unit: str, folder: Path) -> Varied:
    known = (*FORMS, *OTHER_WORDS)
    for word in entry:
        if word not in known:
            raise InputRefused(f'{key}: unknown key "{word}"{nearest(word, known)}')
    forms = [form for form in FORMS if form in entry and form != "to"]
    if len(forms) != 1:
        words = "from and to, values, normal, lognormal, triangular, table or same_as"
        raise InputRefused(f"{key}: {len(forms)} ways to vary it are given: give one of {words}")
    group = text_of(f"{key}.linked", entry["linked"]) if "linked" in entry else key
    levels = whole_of(f"{key}.n", entry["n"]) if "n" in entry else None
    if forms[0] == "same_as":
        factor = quantity_of(f"{key}.factor", entry.get("factor", 1.0), "1")
        other = text_of(f"{key}.same_as", entry["same_as"])
        return Varied(
            spread=None, unit=unit, levels=None, group=other, said={"same_as": other, "factor": factor}
        )
    if forms[0] == "table":
        return _from_table(key, entry, unit, folder)
    if forms[0] == "values":
        return _listed(key, entry["values"], unit, group)
    if not unit:
        raise InputRefused(f"{key}: takes words or true and false: give values = [...]")
    spread, said = _distribution(key, forms[0], entry, unit)
    said |= {"n": levels} if levels else {}
    said |= {"linked": group} if "linked" in entry else {}
    return Varied(spread=spread, unit=unit, levels=levels, group=group, said=said)


def _distribution(key: str, form: str, entry: Mapping[str, Any], unit: str) -> tuple[Spread, dict[str, Any]]:
    if form == "from":
        if "to" not in entry:
            raise InputRefused(f"{key}: to is missing: give from and to")
        low, high = (quantity_of(f"{key}.{word}", entry[word], unit) for word in ("from", "to"))
        check_order(key, low, high, unit=unit)
        scale = text_of(f"{key}.scale", entry.get("scale", "linear"))
        if scale not in ("linear", "log"):
            raise InputRefused(f'{key}.scale = "{scale}" is not known: write linear or log')
        if scale == "log" and low <= 0.0:
            raise InputRefused(f"{key}.from = {low:.9g} {unit} must be above 0 on a logarithmic scale")
        return Range(low=low, high=high, logarithmic=scale == "log"), {
            "from": low,
            "to": high,
            "scale": scale,
        }
    shape, numbers = SHAPES[form], entry[form]
    if not isinstance(numbers, list) or len(numbers) != len(shape):
        raise InputRefused(f"{key}.{form} = {written(numbers)}: write [{', '.join(shape)}]")
    units = (unit, "1" if form == "lognormal" else unit, unit)
    values = [quantity_of(f"{key}.{form}", value, one) for value, one in zip(numbers, units, strict=False)]
    if form == "triangular" and not (values[0] <= values[1] <= values[2] and values[0] < values[2]):
        raise InputRefused(f"{key}.triangular: give lowest, likeliest and highest, ascending")
    if form == "lognormal" and (values[0] <= 0.0 or values[1] <= 1.0):
        raise InputRefused(
            f"{key}.lognormal: a median above 0 and a factor above 1 of one standard deviation are needed"
        )
    if form == "normal" and values[1] <= 0.0:
        raise InputRefused(f"{key}.normal: standard deviation = {values[1]:.9g} {unit} must be above 0")
    return Distribution(form=form, values=tuple(values)), {form: values}


def _listed(key: str, values: Any, unit: str, group: str) -> Varied:
    if not isinstance(values, list) or not values:
        raise InputRefused(f"{key}.values = {written(values)} is no list: write such as [1.0, 3.0]")
    array = _array(f"{key}.values", values, unit, unit)
    said = {"values": array.tolist()}
    return Varied(spread=Values(values=array), unit=unit, levels=array.size, group=group, said=said)


def _array(key: str, values: list[Any], unit: str, given: str) -> Any:
    """Values in SI; ``given``: the unit in which plain numbers stand."""
    if not unit:
        kinds = {type(value) for value in values}
        if kinds not in ({str}, {bool}):
            raise InputRefused(f"{key}: takes words, or true and false: write them in quotation marks")
        return np.array(values, dtype=bool if kinds == {bool} else object)
    if given not in ("", unit):
        values = [f"{value!r} {given}" if isinstance(value, (int, float)) else value for value in values]
    plain = "1" if unit == "count" else unit
    return np.array([quantity_of(key, value, plain) for value in values])


def _from_table(key: str, entry: Mapping[str, Any], unit: str, folder: Path) -> Varied:
    name = text_of(f"{key}.table", entry["table"])
    column = text_of(f"{key}.column", entry.get("column", key))
    path = folder / name
    values, given = column_of(path, column)
    array = _array(f"{key}: column {column} of {name}", values, unit, given)
    said = {"table": digest_of(path), "column": column}
    return Varied(spread=Values(values=array), unit=unit, levels=array.size, group=f"table {path}", said=said)


def _grouped(varied: Mapping[str, Varied]) -> tuple[Axis, ...]:
    """Axes: keys of one group together, a multiple with the key that it follows."""
    groups: dict[str, dict[str, Varied]] = {}
    for key, one in varied.items():
        groups.setdefault(_root(key, one, varied), {})[key] = one
    axes = []
    for name, members in groups.items():
        spreads: dict[str, Spread] = {
            key: one.spread for key, one in members.items() if one.spread is not None
        }
        for key, one in members.items():
            if one.spread is None:
                spreads[key] = Multiple(of=spreads[one.group], factor=one.said["factor"])
        levels = {one.levels for one in members.values() if one.levels is not None}
        if len(levels) > 1:
            raise InputRefused(f"vary.{name}: linked keys have {sorted(levels)} values: give as many of each")
        axes.append(
            Axis(
                spreads={key: spreads[key] for key in members},
                units={key: one.unit for key, one in members.items()},
                levels=levels.pop() if levels else None,
            )
        )
    return tuple(axes)


def _root(key: str, one: Varied, varied: Mapping[str, Varied]) -> str:
    """Name of the group of a key."""
    if one.group == key or one.group.startswith("table "):
        return one.group
    other = varied.get(one.group)
    if other is None:
        raise InputRefused(f'vary.{key}: "{one.group}" is not varied{nearest(one.group, varied)}')
    if other.spread is None or (other.group != one.group and not other.group.startswith("table ")):
        raise InputRefused(f'vary.{key}: "{one.group}" follows another key itself: name that one')
    return other.group
