"""What a run of a body between two motors leaves."""

from dataclasses import dataclass
from typing import Any

from cabledrive.parameters.arrays import Array
from cabledrive.parameters.terminal import ResultCard


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
