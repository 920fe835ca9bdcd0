"""What a drive is made of beside its cable: pulleys, carriages, motor, layout, instruments, excitation."""

from dataclasses import dataclass
from math import cos, inf, isfinite, pi

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import (
    Checked,
    check_fields,
    check_text,
    choice,
    described,
    kind_of,
    quantity,
    words,
)
from cabledrive.parameters.units import to_si


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Pulley(Checked):
    """A pulley the cable does not slip on."""

    radius: float = quantity("m", "positive", "radius at the cable's centre line")
    inertia: float = quantity("kg m^2", "positive", "moment of inertia about the axis")
    viscous_friction: float = quantity("N m s/rad", "nonnegative", "viscous friction b", 0.0)
    coulomb_friction: float = quantity("N m", "nonnegative", "Coulomb friction c", 0.0)
    fixed: bool = choice((False, True), "a rigid support instead of a pulley", False)
    wrap_angle: float | None = quantity("rad", "positive", "angle of wrap, for the no-slip margin", None)
    capstan_friction: float | None = quantity(
        "1", "positive", "friction coefficient of cable on pulley", None
    )

    @property
    def rim_mass(self) -> float:
        """Inertia as the cable feels it at the rim, J / r^2 [kg]."""
        return self.inertia / self.radius**2


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Carriage(Checked):
    """A point mass clamped to the cable."""

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


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Motor(Checked):
    """Motor and gearhead; every quantity at the output shaft unless said otherwise."""

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


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """Distance of the pulleys and the direction of gravity.

    Exactly one of the two lengths is given; `Drive.span_length` and `Drive.pulley_distance` give both.
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
    def gravity_across(self) -> float:
        """Component of gravity across the spans, in the plane of the loop [m/s^2]; exactly 0 if vertical."""
        return 0.0 if abs(self.inclination) == pi / 2 else self.gravity * cos(self.inclination)


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Lumped(Checked):
    """Spring and damper of one span as fitted to a measured response, Table 6.2."""

    cable_stiffness: float | None = quantity("N/m", "positive", "stiffness k of one span", None)
    cable_damping: float | None = quantity("N s/rad", "nonnegative", "damping b_c of one span", None)


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Sensors(Checked):
    """Encoders, load cell and sampling."""

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


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Goal(Checked):
    """What the drive is asked to do, so that `check` can say what stands in the way."""

    tracking_error: float | None = quantity(
        "rad", "positive", "largest error of the load angle allowed", None
    )


MOST_RIPPLE = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """An excitation that follows the motion."""

    name: str
    pulley: str | None = None  # it acts ``number`` times a turn of this pulley, or
    number: float = 1.0
    coordinate: str | None = None  # once in ``length`` of this coordinate's way
    length: float = 1.0  # [m] or [rad]

    def __post_init__(self) -> None:
        for word, value in (("number", self.number), ("length", self.length)):
            if not (isfinite(value) and value > 0.0):
                raise InputRefused(f"order {self.name}: {word} = {value:.9g} must be above 0")


@dataclass(frozen=True, slots=True, kw_only=True)
class StatedExcitation:
    """What excites a machine in operation."""

    torque_ripple: float | None = quantity(
        "1", "positive", "amplitude of the torque ripple as a share of motor.torque_limit", None
    )
    orders: tuple[str, ...] = ()
    """What follows the speed: "poles=traction sheave*20", "rails=car.y/5m"; the ripple acts at those of a
    pulley, without any at every frequency."""
    speed: str = ""  # the range of speed, "car.y=0.2m/s:1m/s"; together with orders

    def __post_init__(self) -> None:
        check_fields(self)
        if not isinstance(self.orders, (list, tuple)):
            raise InputRefused(f'orders is {kind_of(self.orders)}, not an array: write ["poles=motor*20"]')
        for text in (*self.orders, self.speed):
            check_text("orders and speed", text)
        object.__setattr__(self, "orders", tuple(self.orders))
        if self.torque_ripple is not None and self.torque_ripple > MOST_RIPPLE:
            raise InputRefused(
                f"torque_ripple = {self.torque_ripple:.6g} is above 1, the torque limit itself"
            )
        if bool(self.orders) != bool(self.speed):
            missing = "speed" if self.orders else "orders"
            raise InputRefused(f"orders and speed go together: add {missing}, or leave both out")
        if not self.orders and self.torque_ripple is None:
            raise InputRefused("torque_ripple, or orders with speed, must be given: add one, or leave it out")
        names = [order.name for order in self.listed]
        if len(set(names)) < len(names):
            raise InputRefused("orders: two have one name: give each its own")
        if self.speed:
            self.range  # noqa: B018 (refuses what is no range)

    @property
    def listed(self) -> tuple[Order, ...]:
        """The orders."""
        return tuple(order_of(text, "orders") for text in self.orders)

    @property
    def range(self) -> tuple[str, float, float]:
        """The coordinate with the range of its speed [m/s], [rad/s]."""
        return speed_range(self.speed, "speed")


def order_of(text: str, place: str = "--order") -> Order:
    """An order from "sheave=traction sheave", "poles=traction sheave*20" or "rails=car.y/5m"."""
    name, equals, rest = text.partition("=")
    name, rest = name.strip(), rest.strip()
    if not equals or not name or not rest:
        raise InputRefused(f'{place} "{text[:80]}" is not NAME=PULLEY, NAME=PULLEY*N or NAME=KEY/LENGTH')
    part, times, number = rest.rpartition("*")
    if times:
        return Order(name=name, pulley=part.strip(), number=to_si(number, "1"))
    part, over, length = rest.rpartition("/")
    if over:
        unit = "rad" if part.strip().endswith(".turn") else "m"
        return Order(name=name, coordinate=part.strip(), length=to_si(length, unit))
    return Order(name=name, pulley=rest)


def speed_range(text: str, place: str = "--speed") -> tuple[str, float, float]:
    """A coordinate with a range of its speed [m/s], [rad/s], from "car.y=0.2m/s:1m/s"."""
    key, equals, rest = text.partition("=")
    low, colon, high = rest.partition(":")
    if not (equals and colon and key.strip()):
        raise InputRefused(
            f'{place} "{text[:80]}" is not KEY=FROM:TO: write, for instance, car.y=0.1m/s:1m/s'
        )
    unit = "m/s" if key.strip().endswith((".x", ".y")) else "rad/s"
    slow, fast = to_si(low, unit), to_si(high, unit)
    if not 0.0 <= slow < fast < inf:
        raise InputRefused(
            f"{place}: from {slow:.9g} to {fast:.9g} {unit}: give two, the larger last, none negative"
        )
    return key.strip(), slow, fast
