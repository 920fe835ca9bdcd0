"""Where the pulleys stand: one length, gravity, inclination."""

from dataclasses import dataclass
from math import cos, pi, sin

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import check_fields, quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """Distance of the pulleys and the direction of gravity.

    Exactly one of the two lengths is given; `Drive.span_length` and `Drive.pulley_distance` give both.

    Attributes
    ----------
    span_length : float or None
        Unstretched length L of a span, pulley to pulley [m].
    pulley_distance : float or None
        Length Le of a span under pretension, pulley to pulley [m].
    gravity : float, default 9.81
        Gravitational acceleration g [m/s^2].
    inclination : float, default 0.0
        Angle of the line from drive pulley to load pulley above the horizontal [rad].
    """

    span_length: float | None = quantity("m", "positive", "unstretched span, pulley to pulley", None)
    pulley_distance: float | None = quantity("m", "positive", "span under pretension, pulley to pulley", None)
    gravity: float = quantity("m/s^2", "nonnegative", "gravitational acceleration", 9.81)
    inclination: float = quantity("rad", "steepness", "slope from drive to load pulley", 0.0)

    def __post_init__(self) -> None:
        check_fields(self)
        if (self.span_length is None) == (self.pulley_distance is None):
            given = "neither is" if self.span_length is None else "both are"
            raise InputRefused(
                f"span_length [m, unstretched] or pulley_distance [m, pretensioned]: {given} given; give one"
            )

    @property
    def gravity_along(self) -> float:
        """Component of gravity from the load pulley towards the drive pulley [m/s^2]."""
        return self.gravity * sin(self.inclination)

    @property
    def gravity_across(self) -> float:
        """Component of gravity across the spans, in the plane of the loop [m/s^2]; exactly 0 if vertical."""
        return 0.0 if abs(self.inclination) == pi / 2 else self.gravity * cos(self.inclination)
