"""Disturbances, payloads and failures of sensors as words: ``load:0.05:0.3:0.6``, ``3:0.7s``."""

from math import isfinite

from cabledrive.parameters import InputRefused
from cabledrive.parameters.units import to_si
from cabledrive.rig.setting import PAYLOAD_RANGE, Disturbance, Payload

SHAFTS = ("motor", "drive", "load")


def parse_disturbance(words: str) -> Disturbance:
    """A torque or a force that steps in: shaft or coordinate, size, start and end.

    ``words``: such as ``load:0.05:0.3:0.6``, ``motor:20 mN m:0.1 s:0.2 s`` or ``camera.y:-20 N:1 s``; without
    an end it stays.
    Raises `InputRefused` if it is not understood.
    """
    parts = words.split(":")
    if len(parts) not in (3, 4):
        raise InputRefused(
            f'disturbance "{words[:60]}" is not SHAFT:TORQUE:START:END: write load:0.05:0.3:0.6, or for a '
            "body between two winches COORDINATE:FORCE:START:END, such as camera.x:30:1:1.5"
        )
    end = to_si(parts[3], "s") if len(parts) == 4 else float("inf")
    unit = "N" if "." in parts[0] else "N m"
    return Disturbance(torque=to_si(parts[1], unit), start=to_si(parts[2], "s"), end=end, on=parts[0])


def parse_encoder_dropout(words: str | None) -> tuple[str, float, float] | None:
    """An encoder that gives no number for a while: shaft, start and end.

    ``words``: such as ``load:0.1:0.11``.
    Returns shaft, start and end [s].
    Raises `InputRefused` if it is not understood.
    """
    if words is None:
        return None
    parts = words.split(":")
    if len(parts) != 3 or parts[0] not in SHAFTS:
        raise InputRefused(f'encoder dropout "{words[:60]}" is not SHAFT:START:END: write load:0.1:0.11')
    start, end = to_si(parts[1], "s"), to_si(parts[2], "s")
    if not (isfinite(start) and isfinite(end) and 0.0 <= start <= end):
        raise InputRefused(
            f'encoder dropout "{words[:60]}": from {start:.4g} s to {end:.4g} s is no time: swap them'
        )
    return parts[0], start, end


def parse_payload(words: str) -> Payload:
    """A load from a time on, such as ``3:0.7 s``; without a time from the beginning.

    Raises `InputRefused` if it is not understood.
    """
    factor, colon, start = words.partition(":")
    return Payload(factor=to_si(factor, "1"), start=to_si(start, "s") if colon else 0.0)


def parse_payload_range(words: str | None) -> tuple[float, float]:
    """Least and largest load of a design, such as ``0.5:3``; None: that by default.

    Raises `InputRefused` if it is not understood.
    """
    if words is None:
        return PAYLOAD_RANGE
    low, colon, high = words.partition(":")
    if not colon:
        raise InputRefused(f'payload range "{words[:60]}" is not LOW:HIGH: write 0.5:3')
    return to_si(low, "1"), to_si(high, "1")
