"""A machine in another pose: a body moved, with all that it carries."""

from collections.abc import Mapping
from dataclasses import replace
from math import cos, sin
from typing import Any

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.parameters.route.geometry import Point
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


def posed(drive: RoutedDrive, pose: Mapping[str, float]) -> RoutedDrive:
    """The machine with these bodies moved and no others, whatever that does to its ropes.

    Bodies that carry others move first.

    Parameters
    ----------
    drive : RoutedDrive
    pose : mapping of str to float
        "head.x", "head.y": new coordinate of the body's `at` [m]; "arm.turn": angle from the pose of the file
        [rad], about its pivot.

    Returns
    -------
    RoutedDrive

    Raises
    ------
    InputRefused
        For an unknown body, or a pose in which the machine cannot be.
    """
    names = [body.name for body in drive.body]
    steps = []
    for key, value in pose.items():
        name, _, last = key.rpartition(".")
        if name not in names or last not in POSE:
            known = [f"{body.name}.{move}" for body in drive.body for move in body.moves]
            raise InputRefused(f'"{key[:60]}" moves no body{nearest(key[:60], known)}')
        steps.append((len(drive.carried_by(names.index(name))), names.index(name), last, value))
    parts = {key: list(getattr(drive, key)) for key in ("body", "pulley", "anchor")}
    for _, number, last, value in sorted(steps):
        _move(drive, parts, number, last, value)
    placed: dict[str, Any] = {key: tuple(rows) for key, rows in parts.items()}
    return replace(drive, **placed)


def _move(drive: RoutedDrive, parts: dict[str, list[Any]], number: int, last: str, value: float) -> None:
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
            owner = index if key == "body" else drive.body_number(part.on, key)
            if number in drive.carried_by(owner):
                rows[index] = _placed(part, place, last, number == owner and key == "body")


def _placed(part: Any, place: Any, last: str, itself: bool) -> Any:
    pivot = getattr(part, "pivot", None)
    if last == "turn" and not itself and any(move != "turn" for move in getattr(part, "moves", ())):
        raise InputRefused(
            f'body "{part.name}" slides on a body that turns, and its direction is written for the '
            "pose of the "
            "file: write the file in that pose"
        )
    new = {"at": place(part.at)} | ({"pivot": place(pivot)} if pivot is not None else {})
    return replace(part, **new)
