"""The same machine by other units of mass, length and time: every figure times what its unit says."""

import re
from dataclasses import fields, is_dataclass, replace

from cabledrive.parameters.tables import TURNING

POWERS = {
    "kg": (1, 0, 0),
    "m": (0, 1, 0),
    "s": (0, 0, 1),
    "N": (1, 1, -2),
    "Pa": (1, -1, -2),
    "Hz": (0, 0, -1),
}


def factor(unit, by):
    """What a figure in some unit, "N m s/rad", is multiplied by; ``by``: mass, length, time."""
    found, sign = 1.0, 1
    for word in re.findall(r"/|[^\s/]+", unit):
        if word == "/":
            sign = -1
            continue
        name, _, power = word.partition("^")
        for scale, own in zip(by, POWERS.get(name, (0, 0, 0)), strict=True):
            found *= scale ** (sign * own * int(power or 1))
    return found


def in_other_units(part, by):
    """A machine, or a part of one, by units that many times smaller."""
    changed = {}
    turns = getattr(part, "moves", ()) == ("turn",)
    for field in fields(part):
        value = getattr(part, field.name)
        unit = field.metadata.get("unit") or field.metadata.get("pair")
        if turns:
            unit = TURNING.get(field.name, "rad" if field.name == "travel" else unit)
        if is_dataclass(value):
            changed[field.name] = in_other_units(value, by)
        elif isinstance(value, tuple) and value and is_dataclass(value[0]):
            changed[field.name] = tuple(in_other_units(one, by) for one in value)
        elif unit and value is not None and unit != "count":
            k = factor(unit, by)
            changed[field.name] = tuple(k * one for one in value) if isinstance(value, tuple) else k * value
    return replace(part, **changed)
