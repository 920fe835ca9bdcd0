"""What a channel measures: recognised from its head, turned into SI."""

import re
from dataclasses import dataclass

from cabledrive.parameters import InputRefused
from cabledrive.parameters.units import to_si

UNITS: dict[str, tuple[str, ...]] = {
    "time": ("s",),
    "torque": ("N m",),
    "force": ("N",),
    "angle": ("rad",),
    "position": ("m",),
    "velocity": ("rad/s", "m/s"),
    "acceleration": ("rad/s^2", "m/s^2"),
    "voltage": ("V",),
    "current": ("A",),
    "tension": ("N",),
}
"""Quantities by the last word of a channel's name, and the SI unit each may have."""

WORDS = {
    "t": "time",
    "timestamp": "time",
    "seconds": "time",
    "tau": "torque",
    "theta": "angle",
    "speed": "velocity",
    "omega": "velocity",
    "command": "voltage",
    "u": "voltage",
}
"""Other words for them."""


_UNIT = re.compile(r"^\s*(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]\s*$")


@dataclass(frozen=True, slots=True, kw_only=True)
class Recognised:
    """A column whose head says what it is.

    Attributes
    ----------
    channel : str
        Name within the package: "torque", "load_angle".
    quantity : str
        Key of `UNITS`.
    """

    channel: str
    quantity: str


def name_and_unit(head: str) -> tuple[str, str]:
    """Part a column head such as "torque [N m]" or "angle (deg)".

    Returns ``name, unit``: the unit is empty where the head states none.
    """
    match = _UNIT.match(head)
    return (match[1], match[2]) if match and match[1] else (head.strip(), "")


def recognise(head: str) -> Recognised | None:
    """Channel that a column head names.

    ``head``: with or without a unit: "torque [N m]", "load angle (deg)", "motor.speed".
    """
    words = [word for word in re.split(r"[^a-z0-9]+", name_and_unit(head)[0].lower()) if word]
    if not words:
        return None
    quantity = WORDS.get(words[-1], words[-1])
    if quantity not in UNITS:
        return None
    return Recognised(channel="_".join([*words[:-1], quantity]), quantity=quantity)


def factor_to_si(quantity: str, unit: str, counts: int | None = None) -> tuple[float, str]:
    """Factor that turns a column into SI, and the SI unit.

    ``quantity``: key of `UNITS`; ``unit``: unit of the column; empty: it is in SI; ``counts``: counts per
    revolution of an encoder whose channel is in counts.
    Raises `InputRefused` if the unit measures something else, or counts cannot be turned into an angle.
    """
    options = UNITS[quantity]
    if not unit:
        return 1.0, options[0]
    if unit.lower() in ("count", "counts", "ticks", "cts"):
        if quantity != "angle" or counts is None:
            raise InputRefused(
                f"{quantity} in {unit}: give counts_per_revolution, and call the channel an angle"
            )
        return to_si(f"{1.0 / counts:.17g} turn", "rad"), "rad"
    refusal: InputRefused | None = None
    for option in options:
        try:
            return to_si(f"1 {unit}", option), option
        except InputRefused as error:
            refusal = refusal or error
    raise InputRefused(f'{quantity} in "{unit}": {refusal}')


def quantity_with(unit: str, asked: str) -> str | None:
    """Quantity that a unit measures where it does not measure the one asked for.

    ``unit``: of the column; ``asked``: key of `UNITS`.
    Returns key of `UNITS`; None: nothing that a log holds.
    """
    for quantity in UNITS:
        try:
            if quantity != asked and factor_to_si(quantity, unit):
                return quantity
        except InputRefused:
            continue
    return None
