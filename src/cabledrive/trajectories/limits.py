r"""The polynomial that rises from 0 to 1, and the shortest move of it that keeps within limits.

Of odd order :math:`2n + 1`, with n derivatives zero at both ends, it is the one whose slope is
:math:`s'(\xi) = C\,\xi^n(1 - \xi)^n`; order 9 is that of Eqs. (6.1)-(6.7).
"""

from dataclasses import dataclass
from functools import cache
from math import comb, factorial, inf, isfinite, sqrt

import numpy as np

from cabledrive.parameters import Drive, InputRefused, Machine, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import described, meaning
from cabledrive.parameters.route.two_pulleys import two_pulleys_of

HIGHEST_ORDER = 21


def check_order(order: int) -> int:
    """Number n of derivatives that rest at both ends; an even order, below 3 or above 21, is refused."""
    if order % 2 == 0 or not 3 <= order <= HIGHEST_ORDER:
        raise InputRefused(
            f"order = {order} of the rise must be odd, from 3 to {HIGHEST_ORDER}: 9 is that of (6.1)"
        )
    return (order - 1) // 2


@cache
def rise_coefficients(order: int) -> tuple[float, ...]:
    r"""Coefficients of the rise in powers of :math:`\xi = t/t_f`, the solution of Eqs. (6.2)-(6.3).

    .. math:: a_{n+1+k} = \frac{(2n+1)!}{(n!)^2}\,\frac{(-1)^k}{n+1+k}\binom{n}{k}, \qquad k = 0, \dots, n

    Of an odd order 2 n + 1; from the constant upwards, exact, for they are whole numbers.
    """
    n = check_order(order)
    scale = factorial(2 * n + 1) // factorial(n) ** 2
    tail = [scale * (-1) ** k * comb(n, k) // (n + 1 + k) for k in range(n + 1)]
    return (0.0,) * (n + 1) + tuple(map(float, tail))


def smooth_rise(xi: Array, order: int = 9, derivatives: int = 0) -> Array:
    r"""Rise from 0 to 1 and its derivatives, Eqs. (6.1)-(6.7).

    Beyond the ends it rests. The upper half is taken by the symmetry :math:`s(\xi) = 1 - s(1 - \xi)`, so that
    no digits are lost near the end.

    ``xi``, (p,): time over rise time; ``derivatives``: the highest wanted, with respect to xi.
    Returns (derivatives + 1, p). Raises `InputRefused` if the order is even or out of range.
    """
    polynomial = np.polynomial.Polynomial(rise_coefficients(order))
    late = xi > 0.5
    mirrored = np.where(late, 1.0 - xi, xi)
    moving = (xi >= 0.0) & (xi <= 1.0)
    out = np.zeros((derivatives + 1, xi.size))
    for k in range(derivatives + 1):
        value = polynomial.deriv(k)(mirrored) if k else polynomial(mirrored)
        sign = 1.0 if k % 2 else -1.0
        out[k] = np.where(moving, np.where(late, sign * value + (1.0 if k == 0 else 0.0), value), 0.0)
    out[0, xi > 1.0] = 1.0
    return out


@cache
def peak_factor(order: int, derivative: int) -> float:
    r"""Largest value of the k-th derivative of the unit rise of an odd order, :math:`\max |s^{(k)}|`.

    A move by an angle in a time :math:`t_f` has the peak value angle times this over :math:`t_f^k`.
    """
    polynomial = np.polynomial.Polynomial(rise_coefficients(order)).deriv(derivative)
    roots = polynomial.deriv().roots() if polynomial.degree() > 0 else np.array([])
    inside = roots[(np.abs(roots.imag) < 1e-6) & (roots.real >= 0.0) & (roots.real <= 0.5 + 1e-9)].real
    return float(np.max(np.abs(polynomial(np.concatenate((inside, [0.0, 0.5]))))))


def derivative_jump(order: int) -> float:
    r"""Jump of the first derivative that does not rest at the ends, :math:`s^{(n+1)}(0) = (2n+1)!/n!`.

    The 9th-order rise of (6.1) jumps in its fifth derivative, though Model 4 assumes six bounded ones; order
    11 puts the jump into the sixth, order 13 beyond. A move by an angle has it times that over t_f^(n + 1).
    """
    n = check_order(order)
    return float(factorial(2 * n + 1) // factorial(n))


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class MoveLimits:
    """What a move of the load pulley must not exceed."""

    speed: float = meaning("of the load pulley [rad/s]")
    acceleration: float = meaning("of the load pulley [rad/s^2]")
    torque: float = meaning("at the motor's output shaft [N m]")
    slack_torque: float = meaning(
        "at the drive pulley's rim, the torque the cable transmits before a span goes slack [N m]"
    )
    inertia: float = meaning("whole inertia at the output shaft, load included [kg m^2]")
    load_inertia: float = meaning("the part of it that the cable drives [kg m^2]")
    viscous_friction: float = meaning("at the output shaft [N m s/rad]")
    coulomb_friction: float = meaning("at the output shaft [N m]")
    ratio: float = meaning("speed of the output shaft over speed of the load, r2 / r1 [-]")


def move_limits(drive: Machine | Drive, *, acceleration: float = inf) -> MoveLimits:
    """Limits of a drive's moves, as a rigid machine.

    Parameters
    ----------
    drive : Machine or Drive
        Speed and torque limit come from its motor; without one there is none.
    acceleration : float, optional
        Limit for the load pulley [rad/s^2].

    Returns
    -------
    MoveLimits
    """
    drive = two_pulleys_of(drive, "`move_limits`", chains=True)
    motor, first, second = drive.motor, drive.drive_pulley, drive.load_pulley
    ratio = second.radius / first.radius
    cable = len(drive.spans) * drive.cable.mass_per_length * drive.span_length
    carried = (cable + sum(c.mass for c in drive.carriage)) * first.radius**2
    load = second.inertia / ratio**2
    return MoveLimits(
        speed=(motor.speed_limit / ratio) if motor and motor.speed_limit else inf,
        acceleration=acceleration,
        torque=motor.torque_limit if motor and motor.torque_limit else inf,
        slack_torque=2.0 * first.radius * drive.cable.pretension,
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

    Of the load pulley's ``angle`` [rad] in a time ``rise`` [s]. Returns "speed" [rad/s], "acceleration"
    [rad/s^2], "torque" [N m], "slack_torque" [N m].
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
    bounds = limits.speed, limits.acceleration, limits.torque, limits.slack_torque
    if not isfinite(angle) or angle == 0.0:
        raise InputRefused(f"angle = {angle:.9g} rad must be finite and not 0: give the move's angle")
    if min(bounds) == inf:
        raise InputRefused(
            "no limit of speed, acceleration or torque is known: give one, or a motor that has one"
        )
    if limits.coulomb_friction >= limits.torque:
        raise NotComputed(
            f"torque limit {limits.torque:.4g} N m does not overcome the Coulomb friction "
            f"{limits.coulomb_friction:.4g} N m: no move is possible"
        )

    way, bend = (peak_factor(order, k) * abs(angle) for k in (1, 2))
    drag, push = limits.viscous_friction * limits.ratio * way, limits.inertia * limits.ratio * bend
    left = limits.torque - limits.coulomb_friction
    rises = {
        "speed": way / limits.speed,
        "acceleration": sqrt(bend / limits.acceleration),
        "torque": 0.0 if left == inf else (drag + sqrt(drag**2 + 4.0 * left * push)) / (2.0 * left),
        "slack_torque": sqrt(limits.load_inertia * limits.ratio * bend / limits.slack_torque),
    }
    binding = max(rises, key=lambda name: rises[name])
    return rises[binding], binding
