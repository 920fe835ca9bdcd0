"""Texts of the options of `map`: ranges of keys, orders of excitation, ranges of speed."""

import numpy as np

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.units import to_si
from cabledrive.studies.excitation_orders import Order
from cabledrive.studies.varied_drive import quantity_of

ALONE, EACH = 31, 11
"""Values of a key where no number is given: of the only one, of several."""


def vary_of(drive: Drive | RoutedDrive, texts: tuple[str, ...]) -> dict[tuple[str, ...], np.ndarray]:
    """Values by keys, from texts such as "head.x=60mm:360mm:30" or "car.y=5m:35m,counterweight.y=35m:5m"."""
    found: dict[tuple[str, ...], np.ndarray] = {}
    for text in texts:
        keys, ends, numbers = [], [], set()
        for part in text.split(","):
            key, low, high, number = _range(drive, part)
            keys.append(key)
            ends.append((low, high))
            numbers |= {number} - {None}
        if len(numbers) > 1:
            raise InputRefused(f'--vary "{text[:80]}": keys that move together need one number of values')
        count = numbers.pop() if numbers else ALONE if len(texts) == 1 else EACH
        assert count is not None
        found[tuple(keys)] = np.array([np.linspace(low, high, count) for low, high in ends])
    return found


def _range(drive: Drive | RoutedDrive, text: str) -> tuple[str, float, float, int | None]:
    key, equals, rest = text.strip().partition("=")
    steps = rest.split(":")
    if not equals or len(steps) not in (2, 3):
        raise InputRefused(
            f'--vary "{text[:80]}" is not KEY=FROM:TO or KEY=FROM:TO:N: write, for instance, '
            "head.x=60mm:360mm:13"
        )
    key = key.strip()
    try:
        unit, _ = quantity_of(drive, key)
        low, high = (to_si(step, unit) for step in steps[:2])
    except InputRefused as refusal:
        raise refusal.at(f"--vary {key[:60]}") from None
    if len(steps) == 2:
        return key, low, high, None
    if not (steps[2].strip().isascii() and steps[2].strip().isdigit() and 1 <= int(steps[2]) <= 20_000):
        raise InputRefused(f'--vary {key}: "{steps[2][:20]}" is no number of values: write 1 to 20000')
    return key, low, high, int(steps[2])


def order_of(text: str) -> Order:
    """An order from "sheave=traction sheave", "poles=traction sheave*20" or "rails=car.y/5m"."""
    name, equals, rest = text.partition("=")
    name, rest = name.strip(), rest.strip()
    if not equals or not name or not rest:
        raise InputRefused(f'--order "{text[:80]}" is not NAME=PULLEY, NAME=PULLEY*N or NAME=KEY/LENGTH')
    part, times, number = rest.rpartition("*")
    if times:
        return Order(name=name, pulley=part.strip(), number=to_si(number, "1"))
    part, over, length = rest.rpartition("/")
    if over:
        unit = "rad" if part.strip().endswith(".turn") else "m"
        return Order(name=name, coordinate=part.strip(), length=to_si(length, unit))
    return Order(name=name, pulley=rest)


def speed_range(text: str) -> tuple[str, float, float]:
    """A coordinate with a range of its speed, from "car.y=0.2m/s:1m/s"."""
    key, equals, rest = text.partition("=")
    low, colon, high = rest.partition(":")
    if not (equals and colon and key.strip()):
        raise InputRefused(
            f'--speed "{text[:80]}" is not KEY=FROM:TO: write, for instance, car.y=0.1m/s:1m/s'
        )
    unit = "m/s" if key.strip().endswith((".x", ".y")) else "rad/s"
    return key.strip(), to_si(low, unit), to_si(high, unit)
