"""What is varied: the table ``[vary]`` of a SPEC, its axes, and columns of table files."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from math import log
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import nearest, require_known, written
from cabledrive.parameters.files import require_regular
from cabledrive.parameters.toml_values import quantity_of, table_of, text_of, whole_of

EDGE = 1e-16
"""Shares are kept this far from 0 and 1 where a distribution has no ends."""
LARGEST_TABLE = 2_000_000_000
"""Bytes of a table file."""
SHAPES = {
    "normal": ("mean", "standard deviation"),
    "lognormal": ("median", "factor"),
    "triangular": ("lowest", "likeliest", "highest"),
}
"""What is given of each distribution; a factor of one standard deviation of the logarithm."""
RANGE, LIST = "from", "values"
FORMS = (RANGE, "to", LIST, *SHAPES, "table", "same_as")
KNOWN = (*FORMS, "n", "scale", "column", "factor", "linked")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Spread:
    """Values of one key over the unit interval."""

    form: str  # `RANGE`, `LIST` or one of `SHAPES`
    values: Any  # in SI: both ends, the list (numbers, words, true and false), what is given of the shape
    logarithmic: bool = False  # whether a range is even in the logarithm
    factor: float = 1.0  # of a key that follows another one

    def at(self, share: Array) -> NDArray[Any]:
        """Values at shares between 0 and 1, shape (n,), the ends of a range exact."""
        if self.form == LIST:
            place = np.minimum((share * self.values.size).astype(np.int64), self.values.size - 1)
            found = self.values[place]
        elif self.form != RANGE:
            found = self._quantiles(np.clip(share, EDGE, 1.0 - EDGE))
        else:
            low, high = self.values
            ends = (log(low), log(high)) if self.logarithmic else (low, high)
            found = (1.0 - share) * ends[0] + share * ends[1]
            found = np.clip(np.exp(found), low, high) if self.logarithmic else found
        return np.asarray(found if self.factor == 1.0 else self.factor * found)

    def _quantiles(self, share: Array) -> Array:
        from scipy import stats

        first, second, *last = self.values
        if self.form == "triangular":
            width = last[0] - first
            return np.asarray(stats.triang.ppf(share, (second - first) / width, loc=first, scale=width))
        if self.form == "lognormal":
            return np.asarray(stats.lognorm.ppf(share, log(second), scale=first))
        return np.asarray(stats.norm.ppf(share, loc=first, scale=second))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Axis:
    """One dimension of a design; linked keys and the columns of one table share it."""

    spreads: dict[str, Spread]  # by key
    units: dict[str, str]  # by key
    levels: int | None  # number of points on a grid; None: not stated

    @property
    def counted(self) -> bool:
        """Whether it has values one by one, and not a range."""
        return any(spread.form == LIST for spread in self.spreads.values())

    def shares(self, count: int) -> Array:
        """Where the points of a grid lie: ends included on a range, the middle of each part elsewhere."""
        if all(spread.form == RANGE for spread in self.spreads.values()) and count > 1:
            return np.arange(count) / (count - 1)
        return (np.arange(count) + 0.5) / count


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Varied:
    """One key as ``[vary]`` gives it."""

    spread: Spread | None  # None: a multiple of another key
    unit: str
    levels: int | None  # points on a grid
    group: str  # keys of one group share an axis
    said: dict[str, Any]  # what the SPEC says, in SI: distinguishes campaigns


def varied_keys(table: Mapping[str, Any], unit_of: Callable[[str], str], folder: Path) -> dict[str, Varied]:
    """The entries of ``[vary]``, by key; ``folder``: from which table files are named. Refuses an entry."""
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


def _varied(key: str, entry: Mapping[str, Any], unit: str, folder: Path) -> Varied:
    for word in entry:
        require_known(word, KNOWN, f'{key}: unknown key "{word}"')
    forms = [form for form in FORMS if form in entry and form != "to"]
    if len(forms) != 1:
        words = "from and to, values, normal, lognormal, triangular, table or same_as"
        raise InputRefused(f"{key}: {len(forms)} ways to vary it are given: give one of {words}")
    form, said, spread = forms[0], dict[str, Any](), None
    group = text_of(f"{key}.linked", entry["linked"]) if "linked" in entry else key
    levels = whole_of(f"{key}.n", entry["n"]) if "n" in entry else None
    if form == "same_as":
        group, levels = text_of(f"{key}.same_as", entry["same_as"]), None
        said = {"same_as": group, "factor": quantity_of(f"{key}.factor", entry.get("factor", 1.0), "1")}
    elif form == "table":
        path = folder / text_of(f"{key}.table", entry["table"])
        column = text_of(f"{key}.column", entry.get("column", key))
        values, given = column_of(path, column)
        array = _array(f"{key}: column {column} of {entry['table']}", values, unit, given)
        spread, levels, group = Spread(form=LIST, values=array), array.size, f"table {path}"
        said = {"table": digest_of(path), "column": column}
    elif form == LIST:
        values = entry["values"]
        if not isinstance(values, list) or not values:
            raise InputRefused(f"{key}.values = {written(values)} is no list: write such as [1.0, 3.0]")
        array = _array(f"{key}.values", values, unit, unit)
        spread, levels, said = Spread(form=LIST, values=array), array.size, {"values": array.tolist()}
    else:
        if not unit:
            raise InputRefused(f"{key}: takes words or true and false: give values = [...]")
        spread, said = (_range if form == RANGE else _shape)(key, form, entry, unit)
        said |= {"n": levels} if levels else {}
        said |= {"linked": group} if "linked" in entry else {}
    return Varied(spread=spread, unit=unit, levels=levels, group=group, said=said)


def _range(key: str, form: str, entry: Mapping[str, Any], unit: str) -> tuple[Spread, dict[str, Any]]:
    if "to" not in entry:
        raise InputRefused(f"{key}: to is missing: give from and to")
    low, high = (quantity_of(f"{key}.{word}", entry[word], unit) for word in ("from", "to"))
    if not low < high:
        raise InputRefused(f"{key}: {low:.9g} {unit} is not below {high:.9g} {unit}: give them ascending")
    scale = text_of(f"{key}.scale", entry.get("scale", "linear"))
    if scale not in ("linear", "log"):
        raise InputRefused(f'{key}.scale = "{scale}" is not known: write linear or log')
    if scale == "log" and low <= 0.0:
        raise InputRefused(f"{key}.from = {low:.9g} {unit} must be above 0 on a logarithmic scale")
    spread = Spread(form=form, values=(low, high), logarithmic=scale == "log")
    return spread, {"from": low, "to": high, "scale": scale}


def _shape(key: str, form: str, entry: Mapping[str, Any], unit: str) -> tuple[Spread, dict[str, Any]]:
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
    return Spread(form=form, values=tuple(values)), {form: values}


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
    return column.to_pylist(), headings[name].partition("[")[2].partition("]")[0].strip()


@cache
def _read(path: Path, digest: str) -> Any:
    """The table; ``digest``: of its content, so that a changed file is read again."""
    import pyarrow
    from pyarrow.csv import read_csv
    from pyarrow.parquet import read_table

    try:
        return (read_table if path.suffix.lower() in (".parquet", ".pq") else read_csv)(path)
    except (pyarrow.ArrowException, OSError, ValueError) as error:
        words = f"is no table that can be read ({str(error).splitlines()[0]}): give CSV or Parquet"
        raise InputRefused(words).at(str(path)) from None


def axes_of(varied: Mapping[str, Varied]) -> tuple[Axis, ...]:
    """Axes in the order of the SPEC: keys of one group together, a multiple with the key that it follows."""
    groups: dict[str, dict[str, Varied]] = {}
    for key, one in varied.items():
        groups.setdefault(_root(key, one, varied), {})[key] = one
    axes = []
    for name, members in groups.items():
        spreads = {}
        for key, one in members.items():
            if one.spread is None and one.unit != (other := varied[one.group].unit):
                said = f"in {other or 'words'}, and this key in {one.unit or 'words'}"
                raise InputRefused(f"vary.{key}.same_as: {one.group} is {said}: name a key of the same unit")
            followed = varied[one.group].spread if one.spread is None else one.spread
            assert followed is not None
            spreads[key] = followed if one.spread else replace(followed, factor=one.said["factor"])
        levels = {one.levels for one in members.values() if one.levels is not None}
        if len(levels) > 1:
            raise InputRefused(f"vary.{name}: linked keys have {sorted(levels)} values: give as many of each")
        units = {key: one.unit for key, one in members.items()}
        axes.append(Axis(spreads=spreads, units=units, levels=levels.pop() if levels else None))
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
