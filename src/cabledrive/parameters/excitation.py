"""What excites a machine without a planned motion: torque ripple, and orders that follow its speed."""

from dataclasses import dataclass
from math import inf, isfinite

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import check_fields, check_text, kind_of, quantity
from cabledrive.parameters.units import to_si

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
