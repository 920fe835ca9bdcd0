"""What is asked of a body between two motors beside its motion, and what a run of it leaves."""

from dataclasses import dataclass
from math import isfinite
from typing import Any

from cabledrive.mechanics.network.motion import Array
from cabledrive.parameters import InputRefused
from cabledrive.parameters.result_card import ResultCard
from cabledrive.parameters.units import to_si


@dataclass(frozen=True, slots=True, kw_only=True)
class Push:
    """A force on the body that steps in.

    Attributes
    ----------
    on : str
        Coordinate, such as "camera.x".
    force : float
        [N].
    start, end : float
        [s].
    """

    on: str
    force: float
    start: float
    end: float

    def __post_init__(self) -> None:
        if not isfinite(self.force):
            raise InputRefused(f"disturbance = {self.force:.4g} N must be finite: give a force")
        if not 0.0 <= self.start < self.end:
            raise InputRefused(
                f"disturbance from {self.start:.4g} s to {self.end:.4g} s is no time: swap them"
            )


def parse_push(words: str) -> Push:
    """A force that steps in: coordinate, force, start and end.

    ``words``: such as ``camera.x:30:1:1.5`` or ``camera.y:-20 N:1 s``; without an end it stays.
    Raises `InputRefused` if it is not understood.
    """
    parts = words.split(":")
    if len(parts) not in (3, 4):
        raise InputRefused(
            f'disturbance "{words[:60]}" is not COORDINATE:FORCE:START:END: write camera.x:30:1:1.5'
        )
    end = to_si(parts[3], "s") if len(parts) == 4 else float("inf")
    return Push(on=parts[0], force=to_si(parts[1], "N"), start=to_si(parts[2], "s"), end=end)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class TwoMotorTracking(ResultCard):
    """A run of a body between two motors.

    Attributes
    ----------
    summary : dict
        What `cabledrive track --json` prints.
    time : ndarray, shape (samples,)
        [s].
    reference, place : ndarray, shape (samples, m)
        Wanted and true place of the body from where it rests [m].
    tensions, torques : ndarray, shape (samples, 2)
        Of the lines [N]; of the motors, positive winding in [N m].
    incomplete : str or None
        What was not kept, and why.
    """

    summary: dict[str, Any]
    time: Array
    reference: Array
    place: Array
    tensions: Array
    torques: Array
    incomplete: str | None

    def _card(self) -> list[tuple[str, str]]:
        said = self.summary
        rows = [
            ("Tracking", f"{said['controller']} on {said['plant']}"),
            ("peak error", f"{said['peak_error_mm']:.4g} mm"),
            ("least tension", f"{said['least_tension']:.4g} N (allowed: {said['least_allowed']:.4g} N)"),
            ("peak torque", f"{said['peak_torque']:.4g} N m"),
        ]
        return [*rows, *([("not kept", self.incomplete)] if self.incomplete else [])]
