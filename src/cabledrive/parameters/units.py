"""Units at the door: text such as "3 cm" becomes an SI number, once, and never silently."""

import re
from decimal import Context, Decimal
from functools import cache
from typing import Any, NamedTuple

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import written

USUAL: dict[str, tuple[str, str, str]] = {
    "1": ("1", "dimensionless", "a plain number"),
    "1/s": ("1", "1 / [time]", "a rate [1/s]"),
    "GPa": ("1E+9", "[mass] / [length] / [time] ** 2", ""),
    "Hz": ("1", "1 / [time]", "a frequency [Hz]"),
    "MPa": ("1E+6", "[mass] / [length] / [time] ** 2", ""),
    "N": ("1", "[length] * [mass] / [time] ** 2", ""),
    "N m": ("1", "[length] ** 2 * [mass] / [time] ** 2", ""),
    "N m s/rad": ("1", "[length] ** 2 * [mass] / [time]", "a multiple of rad^-1"),
    "N m/V": ("1", "[current] * [time]", ""),
    "N m/rad": ("1", "[length] ** 2 * [mass] / [time] ** 2", "a multiple of rad^-1"),
    "N m^2": ("1", "[length] ** 3 * [mass] / [time] ** 2", ""),
    "N mm": ("0.001", "[length] ** 2 * [mass] / [time] ** 2", ""),
    "N s": ("1", "[length] * [mass] / [time]", ""),
    "N s/m": ("1", "[mass] / [time]", ""),
    "N s/rad": ("1", "[length] * [mass] / [time]", "a multiple of rad^-1"),
    "N/m": ("1", "[mass] / [time] ** 2", ""),
    "N/mm": ("1E+3", "[mass] / [time] ** 2", ""),
    "Pa": ("1", "[mass] / [length] / [time] ** 2", ""),
    "cm": ("0.01", "[length]", ""),
    "count": ("1", "dimensionless", "a plain number"),
    "deg": ("0.01745329251994329576923690768", "dimensionless", "an angle [rad]"),
    "deg/s": ("0.01745329251994329576923690768", "1 / [time]", "an angular speed [rad/s]"),
    "g": ("0.001", "[mass]", ""),
    "g cm^2": ("1E-7", "[length] ** 2 * [mass]", ""),
    "g/m": ("0.001", "[mass] / [length]", ""),
    "kHz": ("1E+3", "1 / [time]", "a frequency [Hz]"),
    "kN": ("1E+3", "[length] * [mass] / [time] ** 2", ""),
    "kN m": ("1E+3", "[length] ** 2 * [mass] / [time] ** 2", ""),
    "kN s": ("1E+3", "[length] * [mass] / [time]", ""),
    "kg": ("1", "[mass]", ""),
    "kg cm^2": ("0.0001", "[length] ** 2 * [mass]", ""),
    "kg m^2": ("1", "[length] ** 2 * [mass]", ""),
    "kg/m": ("1", "[mass] / [length]", ""),
    "m": ("1", "[length]", ""),
    "m/s": ("1", "[length] / [time]", ""),
    "m/s^2": ("1", "[length] / [time] ** 2", ""),
    "mN m": ("0.001", "[length] ** 2 * [mass] / [time] ** 2", ""),
    "m^2": ("1", "[length] ** 2", ""),
    "mm": ("0.001", "[length]", ""),
    "mm/s": ("0.001", "[length] / [time]", ""),
    "mm^2": ("0.000001", "[length] ** 2", ""),
    "ms": ("0.001", "[time]", ""),
    "rad": ("1", "dimensionless", "an angle [rad]"),
    "rad/s": ("1", "1 / [time]", "an angular speed [rad/s]"),
    "rpm": ("0.1047197551196597746154214461", "1 / [time]", "an angular speed [rad/s]"),
    "s": ("1", "[time]", ""),
    "um": ("0.000001", "[length]", ""),
    "us": ("0.000001", "[time]", ""),
}
"""By the text as it is written: factor to SI, then dimension and meaning as pint gives them."""


_QUANTITY = re.compile(r"\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(.*?)\s*")
_FACTOR = r"[A-Za-zµμΩ°%]+(?:\^-?[0-9])?"
_UNIT = re.compile(rf"(?:1|{_FACTOR})(?:(?:\s*[*/]\s*|\s+){_FACTOR})*")
_NEWTON_METRE = re.compile(r"(?<![A-Za-z])([mkM]?)Nm(?![A-Za-z])")  # to pint "Nm" is a yarn count
_NOT_A_MULTIPLE = {"decibel", "neper", "octave", "decade"}
_BASE = {"meter", "kilogram", "second", "ampere", "kelvin", "mole", "candela", "radian", "count"}
_LONGEST = 80
_EXACT = Context(prec=200, traps=[])  # exact for what fits into _LONGEST; infinite where a double is


class _Unit(NamedTuple):
    """Factor to SI; dimension; and what the dimension alone does not say, see `_meaning`."""

    factor: Decimal
    dimension: str
    meaning: str


@cache
def _registry() -> Any:
    """Pint's registry on decimals, so that "0.49 g/m" is 0.00049 kg/m to the last bit."""
    import pint

    return pint.UnitRegistry(non_int_type=Decimal, cache_folder=None)


def _meaning(dimension: str, hertz: bool, radians: int) -> str:
    """Distinguish what has one dimension: cycles, radians, plain decay; angles and numbers."""
    if dimension == "dimensionless":
        return {0: "a plain number", 1: "an angle [rad]"}.get(radians, "a power of an angle")
    if dimension != "1 / [time]":
        power = "of a frequency [Hz]" if hertz else f"of rad^{radians}" if radians else ""
        return power and f"a multiple {power}"
    kinds = {
        (True, 0): "a frequency [Hz]",
        (False, 1): "an angular speed [rad/s]",
        (False, 0): "a rate [1/s]",
    }
    return kinds.get((hertz, radians), "a mixture of angle and time")


def _unit(text: str) -> _Unit:
    if text in USUAL:
        factor, dimension, meaning = USUAL[text]
        return _Unit(Decimal(factor), dimension, meaning)
    return _by_pint(text)


@cache
def _by_pint(text: str) -> _Unit:
    import pint

    text = text.replace("²", "^2").replace("³", "^3").replace("**", "^").replace("·", "*")
    if not _UNIT.fullmatch(text):
        raise InputRefused(f'"{text}" is not a unit')
    try:
        parsed = _registry().parse_units(_NEWTON_METRE.sub(r"(\1N*m)", text))
        factor, base = _registry().get_base_units(parsed)
    except (pint.PintError, ArithmeticError, AttributeError, KeyError, TypeError, ValueError) as error:
        raise InputRefused(f'"{text}" is not a known unit') from error
    names = {str(name) for name in parsed._units}
    if names & _NOT_A_MULTIPLE or not _BASE.issuperset(base._units):
        raise InputRefused(f'"{text}" is not a unit of mechanics')
    hertz = any(name.endswith("hertz") for name in names)
    dimension = str(type(parsed.dimensionality)(sorted(parsed.dimensionality.items())))  # in one order
    return _Unit(Decimal(factor), dimension, _meaning(dimension, hertz, base._units.get("radian", 0)))


def to_si(text: str, unit: str) -> float:
    """Read a quantity written as text, "5", "3 cm", "2.6 GPa", "1092 rpm", in an SI unit, correctly rounded.

    A bare number is taken to be in it, "1" is that of a plain number. Refused if the text is no quantity, its
    unit is unknown or of another dimension, or a frequency stands where an angular speed belongs (or the
    other way round): the one is never converted silently into the other; nor is a plain number, like the per
    cent of a slope, taken for an angle.
    """
    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST else None
    if match is None:
        remedy = "write one number, like 3" if unit == "1" else f'write a number and a unit, like "3 {unit}"'
        raise InputRefused(f"{written(text)} is not a quantity: {remedy}")
    number = _EXACT.create_decimal(match[1])
    if not match[2]:
        return float(number)
    asked, remedy = (unit, f"give it in {unit}") if unit != "1" else ("a plain number", "leave the unit out")
    wanted = _unit(unit)
    try:
        given = _unit(match[2])
    except InputRefused as refusal:
        raise InputRefused(f'"{text}": {refusal}: {remedy}') from None
    # The radian may be left out of N m/rad, but not be put into N m.
    if given.dimension != wanted.dimension or given.meaning not in ("", wanted.meaning):
        kind = given.meaning or f"of dimension {given.dimension}"
        raise InputRefused(f'"{text}" is {kind}, not {asked}: {remedy}')
    return float(_EXACT.multiply(number, given.factor))
