"""Texts of the options of `map`: ranges of keys."""

import numpy as np

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.units import to_si
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
