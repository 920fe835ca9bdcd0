"""What a drive is made of beside its cable: pulleys, carriages, motor, layout, instruments."""

from dataclasses import dataclass
from math import cos, pi, sin

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import check_fields, choice, quantity, words


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Carriage:
    """A point mass clamped to the cable.

    Attributes
    ----------
    mass : float
        Mass m [kg].
    position : float
        Unstretched distance [m] from the pulley at which the span starts (upper: drive, lower: load).
    span : {"upper", "lower"}, default "upper"
        The span that carries it.
    guided : bool, default True
        Rides on a rail and so has no transverse motion; False: it hangs on the cable.
    name : str, default ""
        Name by which it can be called, among the carriages of a drive its own; no part of the content hash.
    coupled : str, default ""
        Name of another carriage that moves together with this one, or "carriage 0" by its number in the file.
    direction : {1, -1}, default 1
        Whether the positions of the two grow together or against each other. Two carriages clamped to one
        loop, one on each span, have 1: each position counts from the pulley where its span starts.
    """

    mass: float = quantity("kg", "positive", "mass clamped to the cable")
    position: float = quantity("m", "positive", "unstretched distance from the pulley where its span starts")
    span: str = choice(("upper", "lower"), "the span that carries it", "upper")
    guided: bool = choice(
        (False, True), "rides on a rail (no transverse motion); false: hangs on the cable", True
    )
    name: str = words("name by which it can be called", "")
    coupled: str = words("name of the carriage that moves together with this one", "")
    direction: int = choice(
        (1, -1), "whether their positions grow together (1) or against each other (-1)", 1
    )

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Motor:
    """Motor and gearhead; every quantity at the output shaft unless said otherwise.

    Attributes
    ----------
    inertia : float
        Moment of inertia J11 [kg m^2], on top of the drive pulley's.
    viscous_friction, coulomb_friction : float, default 0.0
        Friction b1 [N m s/rad] and c1 [N m].
    offset_torque : float, default 0.0
        Constant torque d0 on the motor's side of the balance, Eq. (4.16) [N m].
    joint_stiffness : float or None, default None
        Stiffness k_m of the joint to the drive pulley [N m/rad]; None: rigid.
    joint_damping : float, default 0.0
        Damping b_m of the joint [N m s/rad].
    torque_limit : float or None, default None
        Largest torque [N m].
    torque_per_volt : float or None, default None
        Gain of amplifier, motor and gear [N m/V].
    speed_limit : float or None, default None
        Largest speed [rad/s].
    gear_ratio : float or None, default None
        Motor revolutions per revolution of the output shaft [-].
    rotor_inertia : float or None, default None
        Inertia of the bare rotor, at the motor's own shaft [kg m^2]; a check on `inertia`.
    holding_stiffness : float or None, default None
        Stiffness that holds the rotor where it is commanded [N m/rad]: the magnetic spring of a stepper, or
        the proportional gain of a position loop. None: no such spring.
    backlash : float, default 0.0
        Backlash of the gearhead at the output shaft [rad].
    current_bandwidth : float or None, default None
        Bandwidth of the first-order torque loop [Hz]; None: ideal.
    """

    inertia: float = quantity("kg m^2", "positive", "moment of inertia at the output shaft")
    viscous_friction: float = quantity("N m s/rad", "nonnegative", "viscous friction b1", 0.0)
    coulomb_friction: float = quantity("N m", "nonnegative", "Coulomb friction c1", 0.0)
    offset_torque: float = quantity("N m", "finite", "constant torque d0 added to the motor's", 0.0)
    joint_stiffness: float | None = quantity(
        "N m/rad", "positive", "joint stiffness k_m; absent: rigid", None
    )
    joint_damping: float = quantity("N m s/rad", "nonnegative", "joint damping b_m", 0.0)
    torque_limit: float | None = quantity("N m", "positive", "largest torque", None)
    torque_per_volt: float | None = quantity("N m/V", "positive", "gain of amplifier, motor and gear", None)
    speed_limit: float | None = quantity("rad/s", "positive", "largest speed of the output shaft", None)
    gear_ratio: float | None = quantity("1", "positive", "motor revolutions per output revolution", None)
    rotor_inertia: float | None = quantity("kg m^2", "positive", "bare rotor, at the motor's own shaft", None)
    holding_stiffness: float | None = quantity(
        "N m/rad", "positive", "spring from the rotor to its commanded angle; absent: none", None
    )
    backlash: float = quantity("rad", "nonnegative", "backlash at the output shaft", 0.0)
    current_bandwidth: float | None = quantity(
        "Hz", "positive", "first-order torque loop; absent: ideal", None
    )

    def __post_init__(self) -> None:
        check_fields(self)


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Lumped:
    """Spring and damper of one span as fitted to a measured response, Table 6.2.

    Attributes
    ----------
    cable_stiffness : float or None, default None
        Stiffness k of one span [N/m]; None: EA / L.
    cable_damping : float or None, default None
        Damping b_c of one span, force per relative pulley speed [N s/rad]; None: from `Cable.axial_damping`.
    """

    cable_stiffness: float | None = quantity("N/m", "positive", "stiffness k of one span", None)
    cable_damping: float | None = quantity("N s/rad", "nonnegative", "damping b_c of one span", None)

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensors:
    """Encoders, load cell and sampling.

    Attributes
    ----------
    motor_encoder, drive_encoder, load_encoder : int or None, default None
        Counts per revolution, at the output shaft, drive pulley and load pulley; None: not fitted.
    load_cell_noise : float or None, default None
        Standard deviation of the tension measurement [N].
    sample_rate : float or None, default None
        Samples per second [Hz].
    delay : float, default 0.0
        Time from sampling to torque [s].
    """

    motor_encoder: int | None = quantity(
        "count", "positive", "counts per revolution at the output shaft", None
    )
    drive_encoder: int | None = quantity(
        "count", "positive", "counts per revolution at the drive pulley", None
    )
    load_encoder: int | None = quantity("count", "positive", "counts per revolution at the load pulley", None)
    load_cell_noise: float | None = quantity("N", "nonnegative", "standard deviation of the tension", None)
    sample_rate: float | None = quantity("Hz", "positive", "samples per second", None)
    delay: float = quantity("s", "nonnegative", "from sampling to torque", 0.0)

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Goal:
    """What the drive is asked to do, so that `check` can say what stands in the way.

    Attributes
    ----------
    tracking_error : float or None, default None
        Largest error of the load angle that is allowed [rad].
    """

    tracking_error: float | None = quantity(
        "rad", "positive", "largest error of the load angle allowed", None
    )

    def __post_init__(self) -> None:
        check_fields(self)
