"""Units at the door: text such as "3 cm" becomes an SI number, once, and never silently the wrong kind."""

import re
from decimal import Decimal
from functools import cache
from typing import Any

from cabledrive.parameters.errors import InputRefused

_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*(.*?)\s*")
_FACTOR = r"[A-Za-zµμΩ°%]+(?:(?:\^|\*\*)-?\d)?"
_UNIT = re.compile(rf"(?:1|{_FACTOR})(?:(?:\s*[*/·]\s*|\s+){_FACTOR})*")
_LONGEST = 80


@cache
def _registry() -> Any:
    """Pint's registry on decimals, so that "0.49 g/m" is 0.00049 kg/m to the last bit."""
    import pint

    return pint.UnitRegistry(non_int_type=Decimal, cache_folder=None)


def _rate(names: set[str], radians: int) -> str:
    """Tell the three meanings of one over time apart: cycles, radians, plain decay."""
    if any(name.endswith("hertz") for name in names):
        return "a frequency [Hz]"
    return "an angular speed [rad/s]" if radians else "a rate [1/s]"


@cache
def _unit(text: str) -> tuple[Decimal, str, str]:
    """Decimal factor to SI, dimension, and, for one over time, which kind of rate it is."""
    import pint

    if not _UNIT.fullmatch(text):
        raise InputRefused(f'"{text}" is not a unit')
    try:
        parsed = _registry().parse_units(text.replace("·", "*").replace("**", "^"))
        factor, base = _registry().get_base_units(parsed)
    except (pint.PintError, ArithmeticError, AttributeError, KeyError, TypeError, ValueError) as error:
        raise InputRefused(f'"{text}" is not a unit this package knows') from error
    if parsed.dimensionality == _registry().kelvin.dimensionality:
        raise InputRefused(f'"{text}" is a temperature')
    names = {str(name) for name in parsed._units}
    dimension = str(parsed.dimensionality)
    kind = _rate(names, base._units.get("radian", 0)) if dimension == "1 / [time]" else ""
    return Decimal(factor), dimension, kind


def to_si(text: str, unit: str) -> float:
    """Read a quantity written as text.

    Parameters
    ----------
    text : str
        A number, or a number with a unit: "5", "3 cm", "2.6 GPa", "1092 rpm".
    unit : str
        The SI unit of the result; a bare number is taken to be in it.

    Returns
    -------
    float
        The value in `unit`, correctly rounded.

    Raises
    ------
    InputRefused
        If the text is no quantity, its unit is unknown or of another dimension, or a frequency
        stands where an angular speed belongs (or the other way round): the one is never converted
        silently into the other.
    """
    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST else None
    if match is None:
        raise InputRefused(f'"{text[:_LONGEST]}" is not a quantity: write a number and a unit, like "3 {unit}"')
    number, given = Decimal(match[1]), match[2]
    if not given:
        return float(number)
    if unit == "1":
        return float(number * _dimensionless(given))
    try:
        factor, dimension, rate = _unit(given)
    except InputRefused as refusal:
        raise InputRefused(f'"{text}": {refusal}: give it in {unit}') from None
    _, wanted, wanted_rate = _unit(unit)
    if dimension != wanted:
        raise InputRefused(f'"{text}" has the dimension of {_spell(dimension)}, not of {unit}: give it in {unit}')
    if rate != wanted_rate:
        raise InputRefused(f'"{text}" is {rate}, not {wanted_rate}: convert it yourself and write {unit}')
    return float(number * factor)


def _dimensionless(given: str) -> Decimal:
    if given == "%":
        return Decimal("0.01")
    factor, dimension, _ = _unit(given)
    if dimension != "dimensionless":
        raise InputRefused(f'"{given}" is a unit, but the quantity is a plain number: leave the unit out')
    return factor


def _spell(dimension: str) -> str:
    return "a plain number" if dimension == "dimensionless" else dimension.replace("[", "").replace("]", "")
