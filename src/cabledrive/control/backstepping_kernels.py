"""Compiled command of the backstepping law on the rigid joint and flexible cable, (6.70)-(6.95) corrected."""

from math import tanh

from cabledrive.control.numbers import Array
from cabledrive.mechanics.compiled import njit


@njit
def backstepping_command(
    gains: Array, scalars: Array, estimate: Array, states: Array, reference: Array, k: int, tau: Array
) -> tuple[float, float]:
    """Command and first error; writes the adaptation function tau of (6.95), shape (7,).

    ``states``: theta_1, theta_2 and their speeds; ``gains[0]``: k1, k21, k22, k32, k33, k42, k43, k44;
    ``scalars`` as in `LawNumbers`.
    """
    k1, k21, k22, k32, k33 = gains[0, 0], gains[0, 1], gains[0, 2], gains[0, 3], gains[0, 4]
    k42, k43, k44 = gains[0, 5], gains[0, 6], gains[0, 7]
    beta = scalars[6]
    p1, p2, p3, p4 = estimate[0], estimate[1], estimate[2], estimate[3]
    p5, p6, p7 = estimate[4], estimate[5], estimate[6]
    x1, x2 = states[1], states[3]
    x3, x4 = beta * (states[0] - x1), beta * (states[2] - x2)
    y0, y1, y2 = reference[k, 0], reference[k, 1], reference[k, 2]
    y3, y4 = reference[k, 3], reference[k, 4]

    z1 = x1 - y0
    z2 = x2 - y1 + k1 * z1
    alpha2 = (y2 - k1 * (x2 - y1) - p2 - k22 * z2 - k21 * z1) / p1
    alpha2_t = (y3 + k1 * y2 + k22 * (y2 + k1 * y1) + k21 * y1) / p1
    alpha2_x1 = -(k22 * k1 + k21) / p1
    alpha2_x2 = -(k1 + k22) / p1

    z3 = x3 - alpha2
    x2_rate = p1 * x3 + p2
    alpha3 = alpha2_t + alpha2_x1 * x2 + alpha2_x2 * x2_rate - k33 * z3 - k32 * z2
    alpha2_tt = (y4 + k1 * y3 + k22 * (y3 + k1 * y2) + k21 * y2) / p1
    alpha3_t = alpha2_tt + k33 * alpha2_t + k32 * (y2 + k1 * y1)
    alpha3_x1 = k33 * alpha2_x1 - k32 * k1
    alpha3_x2 = alpha2_x1 + k33 * alpha2_x2 - k32
    alpha3_x3 = p1 * alpha2_x2 - k33

    z4 = x4 - alpha3
    speed = states[2]
    friction = tanh(scalars[2] * speed)
    alpha3_rate = alpha3_t + alpha3_x1 * x2 + alpha3_x2 * x2_rate + alpha3_x3 * x4
    wanted = p3 * x3 + p4 * speed + p5 * friction - p6 + alpha3_rate
    u = (wanted - k44 * z4 - k43 * z3 - k42 * z2) / (beta * p7)

    cross = alpha2_x2 * z3 + alpha3_x2 * z4
    tau[0] = alpha2 * z2 - x3 * cross
    tau[1] = z2 - cross
    tau[2], tau[3], tau[4] = -x3 * z4, -speed * z4, -friction * z4
    tau[5], tau[6] = z4, beta * u * z4
    return u, z1
