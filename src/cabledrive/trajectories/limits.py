"""The shortest move that keeps within limits of speed, acceleration and torque."""

from dataclasses import dataclass
from math import inf, isfinite

from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.trajectories.rise import peak_factor

_SEARCH_STEPS = 200


@dataclass(frozen=True, slots=True, kw_only=True)
class MoveLimits:
    """What a move of the load pulley must not exceed.

    Attributes
    ----------
    speed : float
        Of the load pulley [rad/s].
    acceleration : float
        Of the load pulley [rad/s^2].
    torque : float
        At the motor's output shaft [N m].
    slack_torque : float
        At the drive pulley's rim, the torque the cable transmits before a span goes slack [N m].
    inertia : float
        Whole inertia at the output shaft, load included [kg m^2].
    load_inertia : float
        The part of it that the cable drives [kg m^2].
    viscous_friction, coulomb_friction : float
        At the output shaft [N m s/rad], [N m].
    ratio : float
        Speed of the output shaft over speed of the load, r2 / r1 [-].
    """

    speed: float
    acceleration: float
    torque: float
    slack_torque: float
    inertia: float
    load_inertia: float
    viscous_friction: float
    coulomb_friction: float
    ratio: float


def move_limits(drive: Drive, *, acceleration: float = inf, slack_share: float = 1.0) -> MoveLimits:
    """Limits of a drive's moves, as a rigid machine.

    Parameters
    ----------
    drive : Drive
        Speed and torque limit come from its motor; without one there is none.
    acceleration : float, optional
        Limit for the load pulley [rad/s^2].
    slack_share : float, default 1.0
        Share of the slack torque 2 r1 T0 that a move may use.

    Returns
    -------
    MoveLimits
    """
    motor, first, second = drive.motor, drive.drive_pulley, drive.load_pulley
    ratio = second.radius / first.radius
    cable = len(drive.spans) * drive.cable.mass_per_length * drive.span_length
    carried = (cable + sum(c.mass for c in drive.carriage)) * first.radius**2
    load = second.inertia / ratio**2
    return MoveLimits(
        speed=(motor.speed_limit / ratio) if motor and motor.speed_limit else inf,
        acceleration=acceleration,
        torque=motor.torque_limit if motor and motor.torque_limit else inf,
        slack_torque=slack_share * 2.0 * first.radius * drive.cable.pretension,
        inertia=first.inertia + (motor.inertia if motor else 0.0) + carried + load,
        load_inertia=carried + load,
        viscous_friction=first.viscous_friction
        + (motor.viscous_friction if motor else 0.0)
        + second.viscous_friction / ratio**2,
        coulomb_friction=first.coulomb_friction
        + (motor.coulomb_friction if motor else 0.0)
        + second.coulomb_friction / ratio,
        ratio=ratio,
    )


def peak_demand(limits: MoveLimits, angle: float, rise: float, order: int = 9) -> dict[str, float]:
    """What a move asks for at most: each term at its own peak, so that the sum is an upper bound.

    Parameters
    ----------
    limits : MoveLimits
    angle : float
        Of the load pulley [rad].
    rise : float
        Rise time [s].
    order : int, default 9
        Odd order of the rise.

    Returns
    -------
    dict
        "speed" [rad/s], "acceleration" [rad/s^2], "torque" [N m], "slack_torque" [N m].
    """
    speed = peak_factor(order, 1) * abs(angle) / rise
    acceleration = peak_factor(order, 2) * abs(angle) / rise**2
    shaft_speed, shaft_acceleration = limits.ratio * speed, limits.ratio * acceleration
    friction = limits.viscous_friction * shaft_speed + limits.coulomb_friction
    return {
        "speed": speed,
        "acceleration": acceleration,
        "torque": limits.inertia * shaft_acceleration + friction,
        "slack_torque": limits.load_inertia * shaft_acceleration,
    }


def shortest_rise(limits: MoveLimits, angle: float, order: int = 9) -> tuple[float, str]:
    """Shortest rise time of a move within the limits, and the limit that decides.

    Parameters
    ----------
    limits : MoveLimits
    angle : float
        Of the load pulley [rad].
    order : int, default 9
        Odd order of the rise.

    Returns
    -------
    rise : float
        [s].
    binding : str
        "speed", "acceleration", "torque" or "slack_torque".

    Raises
    ------
    InputRefused
        If the angle is zero or not finite, or nothing limits the move.
    NotComputed
        If no move, however slow, keeps within the limits.
    """
    bounds = {name: getattr(limits, name) for name in ("speed", "acceleration", "torque", "slack_torque")}
    if not isfinite(angle) or angle == 0.0:
        raise InputRefused(f"angle = {angle:.9g} rad must be finite and not 0: give the move's angle")
    if all(bound == inf for bound in bounds.values()):
        raise InputRefused(
            "no limit of speed, acceleration or torque is known: give one, or a motor that has one"
        )
    if limits.coulomb_friction >= limits.torque:
        raise NotComputed(
            f"torque limit {limits.torque:.4g} N m does not overcome the Coulomb friction "
            f"{limits.coulomb_friction:.4g} N m: no move is possible"
        )

    def excess(rise: float) -> float:
        demand = peak_demand(limits, angle, rise, order)
        return max(demand[name] / bound for name, bound in bounds.items())

    fast, slow = 1e-6, 1.0
    while excess(slow) > 1.0:
        fast, slow = slow, 2.0 * slow
    while excess(fast) <= 1.0:
        fast *= 0.5
    for _ in range(_SEARCH_STEPS):
        middle = 0.5 * (fast + slow)
        if middle in (fast, slow):
            break
        fast, slow = (middle, slow) if excess(middle) > 1.0 else (fast, middle)
    demand = peak_demand(limits, angle, slow, order)
    return slow, max(bounds, key=lambda name: demand[name] / bounds[name])
