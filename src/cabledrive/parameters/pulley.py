"""A pulley, or a rigid support in its place."""

from dataclasses import dataclass

from cabledrive.parameters.fields import check_fields, choice, quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Pulley:
    """A pulley the cable does not slip on.

    Attributes
    ----------
    radius : float
        Radius r at the cable's centre line [m].
    inertia : float
        Moment of inertia J about its axis [kg m^2]; of the drive pulley: without the motor.
    viscous_friction : float, default 0.0
        Viscous friction b [N m s/rad].
    coulomb_friction : float, default 0.0
        Coulomb friction c [N m].
    fixed : bool, default False
        A rigid support instead of a pulley: it does not turn.
    wrap_angle : float or None, default None
        Angle the cable wraps round the pulley [rad], for the capstan's no-slip margin.
    capstan_friction : float or None, default None
        Coefficient of friction between cable and pulley [-].
    """

    radius: float = quantity("m", "positive", "radius at the cable's centre line")
    inertia: float = quantity("kg m^2", "positive", "moment of inertia about the axis")
    viscous_friction: float = quantity("N m s/rad", "nonnegative", "viscous friction b", 0.0)
    coulomb_friction: float = quantity("N m", "nonnegative", "Coulomb friction c", 0.0)
    fixed: bool = choice((False, True), "a rigid support instead of a pulley", False)
    wrap_angle: float | None = quantity("rad", "positive", "angle of wrap, for the no-slip margin", None)
    capstan_friction: float | None = quantity(
        "1", "positive", "friction coefficient of cable on pulley", None
    )

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def rim_mass(self) -> float:
        """Inertia as the cable feels it at the rim, J / r^2 [kg]."""
        return self.inertia / self.radius**2
