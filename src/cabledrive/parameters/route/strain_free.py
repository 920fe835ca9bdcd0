r"""A machine in another pose: bodies moved along motions that strain no rope.

Rope that meets a pulley passes on by the turn of that pulley, or ends at a cut: a direction fixed in space,
here from the pulley's centre to the middle of the wrap in the pose of the file. Between two cuts a rope has
its free span and two parts of arcs. A motion strains nothing where turns of the pulleys pass on what every
such length gains,

.. math::

   \Delta l_s + r_a \Delta\alpha_a + r_b \Delta\alpha_b = \sigma_a r_a \varphi_a - \sigma_b r_b \varphi_b ,

with the sense of a pulley, 1 against the clock; what no turns can pass on is the strain of the pose.
"""

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations
from math import atan2, cos, sin
from typing import Any

import numpy as np

from cabledrive.parameters.arrays import Array
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.route.drive import Machine, body_number, carried_by
from cabledrive.parameters.route.geometry import FreeSpan, Point
from cabledrive.parameters.route.parts import require_within_travel

POSE = {"x": "m", "y": "m", "turn": "rad"}
"""Last step of a key that moves a body, with its unit."""


def is_pose_key(drive_data: Mapping[str, Any], key: str) -> bool:
    """Whether a key such as "head.x" moves a body of a file's plain data."""
    name, dot, last = key.rpartition(".")
    bodies = drive_data.get("body", [])
    if drive_data.get("kind") != "route" or not dot or not isinstance(bodies, list):
        return False
    return last in POSE and name in [body.get("name") for body in bodies if isinstance(body, dict)]


def posed(drive: Machine, pose: Mapping[str, float]) -> Machine:
    """The machine with these bodies moved and no others, whatever that does to its ropes.

    ``pose``: "head.x", "head.y", new coordinate of the body's `at` [m]; "arm.turn", angle from the pose of
    the file [rad], about its pivot. Bodies that carry others move first.
    Raises `InputRefused` for an unknown body, or a pose in which the machine cannot be.
    """
    names = [body.name for body in drive.body]
    steps = []
    for key, value in pose.items():
        name, _, last = key.rpartition(".")
        if name not in names or last not in POSE:
            known = [f"{body.name}.{move}" for body in drive.body for move in body.moves]
            raise InputRefused(f'"{key[:60]}" moves no body{nearest(key[:60], known)}')
        steps.append((len(carried_by(drive, names.index(name))), names.index(name), last, value))
    parts = {key: list(getattr(drive, key)) for key in ("body", "pulley", "anchor")}
    for _, number, last, value in sorted(steps):
        _move(drive, parts, number, last, value)
    placed: dict[str, Any] = {key: tuple(rows) for key, rows in parts.items()}
    return replace(drive, **placed)


def _move(drive: Machine, parts: dict[str, list[Any]], number: int, last: str, value: float) -> None:
    body = parts["body"][number]
    if body.travel is not None and last in body.moves:
        require_within_travel(body, value)
    if last == "turn":
        if body.pivot is None:
            raise InputRefused(
                f'"{body.name}.turn": body "{body.name}" does not turn: give it moves = "turn"'
            )
        px, py = body.pivot
        c, s = cos(value), sin(value)

        def place(at: Point) -> Point:
            """The point turned about the pivot."""
            dx, dy = at[0] - px, at[1] - py
            return px + c * dx - s * dy, py + s * dx + c * dy
    else:
        axis = "xy".index(last)
        step = value - body.at[axis]

        def place(at: Point) -> Point:
            """The point shifted."""
            return (at[0] + step, at[1]) if axis == 0 else (at[0], at[1] + step)

    for key, rows in parts.items():
        for index, part in enumerate(rows):
            owner = index if key == "body" else body_number(drive, part.on, key)
            if number in carried_by(drive, owner):
                rows[index] = _placed(part, place, last, number == owner and key == "body")


def _placed(part: Any, place: Any, last: str, itself: bool) -> Any:
    pivot = getattr(part, "pivot", None)
    if last == "turn" and not itself and any(move != "turn" for move in getattr(part, "moves", ())):
        raise InputRefused(
            f'body "{part.name}" slides on a body that turns, and its direction is written for the '
            "pose of the file: write the file in that pose"
        )
    new = {"at": place(part.at)} | ({"pivot": place(pivot)} if pivot is not None else {})
    return replace(part, **new)


TOLERANCE = 1e-6
"""Share of a rope's length that may be left over."""
MOST_FOLLOWERS = 3
_STEPS = 30
_NUDGE = 1e-6


def moved(drive: Machine, pose: Mapping[str, float]) -> Machine:
    """The machine with bodies moved and its ropes as long as they are: what has to follow, follows.

    ``pose``: as of `posed`. The fewest bodies follow, the first of the file before later ones; others stay.
    Raises `InputRefused` for an unknown body, a pose in which the machine cannot be, or one that strains a
    rope whatever else moves along; the message has the strain.
    """
    asked = posed(drive, pose)
    passed_on = _passed_on(drive)
    strains = _strains(drive, _left_over(drive, asked, passed_on))
    if strains.max(initial=0.0) <= TOLERANCE:
        return asked
    moving = {key.rpartition(".")[0] for key in pose}
    own = [f"{body.name}.{move}" for body in drive.body if body.name not in moving for move in body.moves]
    for number in range(1, min(MOST_FOLLOWERS, len(own)) + 1):
        for keys in combinations(own, number):
            found = _followed(drive, asked, keys, passed_on)
            if found is not None:
                return found
    worst = int(np.argmax(strains))
    places = ", ".join(f"{key} = {value:.6g}" for key, value in pose.items())
    raise InputRefused(
        f'{places}: rope "{drive.route[worst].name}" would be strained by {100 * strains[worst]:.3g} %, and '
        "no other body can follow: rope lengths are those of the file; give a place they allow, or write "
        "the file in that pose"
    )


def _followed(drive: Machine, asked: Machine, keys: tuple[str, ...], passed_on: Array) -> Machine | None:
    """The machine after Newton's steps of some coordinates; None where they do not undo the strain."""
    step, now, scale = np.zeros(len(keys)), asked, float(_rope_lengths(drive).max())

    loose = replace(asked, body=tuple(replace(body, travel=None) for body in asked.body))

    def at(start: Machine, values: Array) -> Machine:
        places = {key: place_of(asked, key) + float(v) for key, v in zip(keys, values, strict=True)}
        return posed(start, places)

    try:
        left = _left_over(drive, now, passed_on)
        for _ in range(_STEPS):
            columns = [
                (_left_over(drive, at(loose, step + nudge), passed_on) - left) / (_NUDGE * scale)
                for nudge in _NUDGE * scale * np.eye(len(keys))
            ]
            change, _, rank, _ = np.linalg.lstsq(np.column_stack(columns), -left, rcond=1e-6)
            if rank < len(keys):
                return None
            step = step + change
            now = at(loose, step)
            left = _left_over(drive, now, passed_on)
            if np.abs(change).max() < 1e-13 * scale or not np.abs(left).max() > 1e-13 * scale:
                break
        now = at(asked, step)  # refused outside of a travel
    except InputRefused:  # the machine cannot be where a step leads
        return None
    return now if _strains(drive, left).max() <= TOLERANCE else None


def place_of(drive: Machine, key: str) -> float:
    """Where the file has what a key moves, such as ``head.x`` [m]; a turn begins at 0 [rad]."""
    name, _, move = key.rpartition(".")
    body = next(body for body in drive.body if body.name == name)
    return 0.0 if move == "turn" else body.at["xy".index(move)]


def _strains(drive: Machine, left: Array) -> Array:
    """Length that is left over in each route, as a share of the rope's; shape (routes,)."""
    over = np.zeros(len(drive.route))
    np.add.at(over, [span.route for span in drive.free_spans], np.abs(left))
    return over / _rope_lengths(drive)


def _rope_lengths(drive: Machine) -> Array:
    """Length of each route [m], shape (routes,)."""
    whole = np.zeros(len(drive.route))
    for span in drive.free_spans:
        whole[span.route] += span.length + (span.wrap or 0.0) * span.end.radius
    return whole


def _passed_on(drive: Machine) -> Array:
    """Length that unit turns of the pulleys feed into each span, shape (spans, pulleys) [m/rad]."""
    found = np.zeros((len(drive.free_spans), len(drive.pulley)))
    for row, span in zip(found, drive.free_spans, strict=True):
        for place, sign in ((span.start, 1.0), (span.end, -1.0)):
            if place.pulley is not None and not drive.pulley[place.pulley].fixed:
                row[place.pulley] += sign * place.sense * place.radius
    return found


def turns_between(drive: Machine, other: Machine) -> Array:
    """Turns of the pulleys that pass on what the spans gain in another pose, shape (pulleys,) [rad]."""
    return np.asarray(np.linalg.lstsq(_passed_on(drive), _gains(drive, other), rcond=1e-9)[0])


def _left_over(drive: Machine, other: Machine, passed_on: Array) -> Array:
    """What turns of the pulleys cannot pass on of the lengths that the spans gain [m], shape (spans,)."""
    gains = _gains(drive, other)
    return np.asarray(gains - passed_on @ np.linalg.lstsq(passed_on, gains, rcond=1e-9)[0])


def _gains(drive: Machine, other: Machine) -> Array:
    """Length that each span gains between the cuts of its pulleys [m], shape (spans,)."""
    return np.array(
        [
            new.length - old.length + _arc(old, new, start=True) + _arc(old, new, start=False)
            for old, new in zip(drive.free_spans, other.free_spans, strict=True)
        ]
    )


def _arc(old: FreeSpan, new: FreeSpan, *, start: bool) -> float:
    """Gain of the arc between the span's contact and the cut of its pulley [m].

    The contact turns with the span's direction; the cut stays, whatever it was.
    """
    place = new.start if start else new.end
    if place.sense == 0:
        return 0.0
    turned = atan2(
        old.along[0] * new.along[1] - old.along[1] * new.along[0],
        old.along[0] * new.along[0] + old.along[1] * new.along[1],
    )
    return place.sense * place.radius * (turned if start else -turned)
