"""The table ``[vary]`` of a SPEC: how each key is varied, read into the axes of the design."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.campaign.axes import Axis, Multiple, Normal, Range, Spread, Triangular, Values, check_order
from cabledrive.campaign.tables import column_of, digest_of
from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import nearest, written
from cabledrive.parameters.toml_values import quantity_of, table_of, text_of, whole_of

FORMS = ("from", "to", "values", "normal", "lognormal", "triangular", "table", "same_as")
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
    count = 3 if form == "triangular" else 2
    numbers = entry[form]
    if not isinstance(numbers, list) or len(numbers) != count:
        what = "[lowest, likeliest, highest]" if form == "triangular" else "[mean, standard deviation]"
        what = "[median, factor]" if form == "lognormal" else what
        raise InputRefused(f"{key}.{form} = {written(numbers)}: write {what}")
    units = (unit, "1" if form == "lognormal" else unit, unit)
    values = [quantity_of(f"{key}.{form}", value, one) for value, one in zip(numbers, units, strict=False)]
    if form == "triangular":
        low, mode, high = values
        if not low <= mode <= high or low == high:
            raise InputRefused(f"{key}.triangular: give lowest, likeliest and highest, ascending")
        return Triangular(low=low, mode=mode, high=high), {form: values}
    if form == "lognormal":
        if values[0] <= 0.0 or values[1] <= 1.0:
            raise InputRefused(
                f"{key}.lognormal: a median above 0 and a factor above 1 of one standard deviation are needed"
            )
        return Normal(mean=values[0], deviation=float(np.log(values[1])), logarithmic=True), {form: values}
    if values[1] <= 0.0:
        raise InputRefused(f"{key}.normal: standard deviation = {values[1]:.9g} {unit} must be above 0")
    return Normal(mean=values[0], deviation=values[1]), {form: values}


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
