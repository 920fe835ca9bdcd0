"""What a rope, a pulley and a motor must bear along a planned motion, and what they hold."""

from dataclasses import dataclass

HOLDS, EXCEEDED, UNKNOWN = "holds", "exceeded", "unknown"
FRICTION, TEETH = "friction", "teeth"


@dataclass(frozen=True, slots=True, kw_only=True)
class SpanMargin:
    """Tensions of one rope of a span along a motion [N], and what it holds.

    Attributes
    ----------
    name, route : str
    rest : (float, float)
        Lowest and highest at rest in the poses.
    even : (float, float)
        With forces of inertia and friction, without vibration.
    tension : (float, float)
        With the vibration.
    lowest_at, highest_at : float
        When [s].
    strength, safety_factor : float or None
        Strength over the highest tension; None without a strength.
    """

    name: str
    route: str
    rest: tuple[float, float]
    even: tuple[float, float]
    tension: tuple[float, float]
    lowest_at: float
    highest_at: float
    strength: float | None
    safety_factor: float | None

    @property
    def slack(self) -> bool:
        """Whether it goes slack."""
        return self.tension[0] <= 0.0

    @property
    def verdict(self) -> str:
        """Whether the rope stays tight and unbroken."""
        broken = self.safety_factor is not None and self.safety_factor < 1.0
        return EXCEEDED if self.slack or broken else HOLDS


@dataclass(frozen=True, slots=True, kw_only=True)
class PulleyMargin:
    """What a pulley must transmit along a motion, and what its friction or its teeth hold.

    Attributes
    ----------
    name, route : str
    by : {"friction", "teeth"}
    wrap : float
        Least wrap [rad].
    needed_friction : float or None
        Largest ``abs(ln(T1/T2))`` over the wrap; None where one tension is gone.
    capstan_friction : float or None
        Of the file.
    effective_tension, allowed : float, float or None
        Largest difference of the tensions of one rope, and what the teeth in mesh take [N].
    teeth_in_mesh : int or None
    margin : float or None
        What holds over what is needed; below 1 the rope slips or the teeth are overloaded.
    time : float
        When it is least [s].
    verdict : {"holds", "exceeded", "unknown"}
    """

    name: str
    route: str
    by: str
    wrap: float
    needed_friction: float | None
    capstan_friction: float | None
    effective_tension: float
    allowed: float | None
    teeth_in_mesh: int | None
    margin: float | None
    time: float
    verdict: str


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorMargin:
    """What a motor must give along a motion, at its pulley [N m], [rad/s]; limits None if not in the file."""

    name: str
    peak_torque: float
    rms_torque: float
    holding_torque: float
    torque_limit: float | None
    peak_speed: float
    speed_limit: float | None

    @property
    def verdict(self) -> str:
        """Whether torque and speed stay within the limits."""
        if self.torque_limit is not None and self.peak_torque > self.torque_limit:
            return EXCEEDED
        if self.speed_limit is not None and self.peak_speed > self.speed_limit:
            return EXCEEDED
        return UNKNOWN if self.torque_limit is None else HOLDS
