"""Backstepping on 2 inertias, written by `cabledrive.control.generation`; change it there."""
# fmt: off

from math import tanh
from typing import Any

from cabledrive.control.numbers import Array
from cabledrive.mechanics.compiled import njit

# Step and error of each gain.
GAINS = ((1, 1), (2, 1), (2, 2), (3, 2), (3, 3), (4, 2), (4, 3), (4, 4))


@njit
def backstepping_four(
    gains: Array, scalars: Array, estimate: Array, states: Array, reference: Array, k: int, tau: Array
) -> tuple[float, float]:
    """Command and first error; writes the adaptation function tau."""
    k11 = gains[0, 0]
    k21 = gains[0, 1]
    k22 = gains[0, 2]
    k32 = gains[0, 3]
    k33 = gains[0, 4]
    k42 = gains[0, 5]
    k43 = gains[0, 6]
    k44 = gains[0, 7]
    s1 = gains[0, 8]
    p1 = estimate[0]
    p2 = estimate[1]
    p3 = estimate[2]
    p4 = estimate[3]
    p5 = estimate[4]
    p6 = estimate[5]
    p7 = estimate[6]
    x1, x2 = states[1], states[3]
    x3 = s1 * (states[0] - states[1])
    x4 = s1 * (states[2] - states[3])
    speed = states[2]
    friction = tanh(scalars[2] * (reference[k, 5] if scalars[3] > 0.0 else speed))
    y0 = reference[k, 0]
    y1 = reference[k, 1]
    y2 = reference[k, 2]
    y3 = reference[k, 3]
    y4 = reference[k, 4]
    z1 = x1 - y0
    alpha1 = -k11*z1 + y1
    a1_x1 = -k11
    a1_y0 = k11
    a1_y1 = 1
    z2 = -alpha1 + x2
    alpha2 = (a1_x1*x2 + a1_y0*y1 + a1_y1*y2 - k21*z1 - k22*z2 - p2)/p1
    a2_x1 = (a1_x1*k22 - k21)/p1
    a2_x2 = (a1_x1 - k22)/p1
    a2_y0 = (a1_y0*k22 + k21)/p1
    a2_y1 = (a1_y0 + a1_y1*k22)/p1
    a2_y2 = a1_y1/p1
    z3 = -alpha2 + x3
    alpha3 = a2_x1*x2 + a2_x2*(p1*x3 + p2) + a2_y0*y1 + a2_y1*y2 + a2_y2*y3 - k32*z2 - k33*z3
    a3_x1 = a1_x1*k32 + a2_x1*k33
    a3_x2 = a2_x1 + a2_x2*k33 - k32
    a3_x3 = a2_x2*p1 - k33
    a3_y0 = a1_y0*k32 + a2_y0*k33
    a3_y1 = a1_y1*k32 + a2_y0 + a2_y1*k33
    a3_y2 = a2_y1 + a2_y2*k33
    a3_y3 = a2_y2
    z4 = -alpha3 + x4
    u = (
        (a3_x1*x2 + a3_x2*(p1*x3 + p2) + a3_x3*x4 + a3_y0*y1 + a3_y1*y2 + a3_y2*y3 + a3_y3*y4 +
        friction*p5 - k42*z2 - k43*z3 - k44*z4 + p3*x3 + p4*speed - p6)/(p7*s1)
    )
    cross2 = a2_x2*z3 + a3_x2*z4
    tau[0] = alpha2*z2 - cross2*x3
    tau[1] = -cross2 + z2
    tau[2] = -x3*z4
    tau[3] = -speed*z4
    tau[4] = -friction*z4
    tau[5] = z4
    tau[6] = s1*u*z4
    return u, z1


def backstepping_four_reference(
    gains: Any, estimate: Any, x: Any, signals: Any, speed: Any, friction: Any
) -> tuple[Any, tuple[Any, ...], tuple[Any, ...], list[list[Any]]]:
    """Command, errors z, virtual controls alpha, regressors phi, from scaled states; any numbers."""
    k11, k21, k22, k32, k33, k42, k43, k44, s1, = gains
    p1, p2, p3, p4, p5, p6, p7, = estimate
    x1, x2, x3, x4, = x
    y0, y1, y2, y3, y4, = signals
    z1 = x1 - y0
    alpha1 = -k11*z1 + y1
    a1_x1 = -k11
    a1_y0 = k11
    a1_y1 = 1
    z2 = -alpha1 + x2
    alpha2 = (a1_x1*x2 + a1_y0*y1 + a1_y1*y2 - k21*z1 - k22*z2 - p2)/p1
    a2_x1 = (a1_x1*k22 - k21)/p1
    a2_x2 = (a1_x1 - k22)/p1
    a2_y0 = (a1_y0*k22 + k21)/p1
    a2_y1 = (a1_y0 + a1_y1*k22)/p1
    a2_y2 = a1_y1/p1
    z3 = -alpha2 + x3
    alpha3 = a2_x1*x2 + a2_x2*(p1*x3 + p2) + a2_y0*y1 + a2_y1*y2 + a2_y2*y3 - k32*z2 - k33*z3
    a3_x1 = a1_x1*k32 + a2_x1*k33
    a3_x2 = a2_x1 + a2_x2*k33 - k32
    a3_x3 = a2_x2*p1 - k33
    a3_y0 = a1_y0*k32 + a2_y0*k33
    a3_y1 = a1_y1*k32 + a2_y0 + a2_y1*k33
    a3_y2 = a2_y1 + a2_y2*k33
    a3_y3 = a2_y2
    z4 = -alpha3 + x4
    u = (
        (a3_x1*x2 + a3_x2*(p1*x3 + p2) + a3_x3*x4 + a3_y0*y1 + a3_y1*y2 + a3_y2*y3 + a3_y3*y4 +
        friction*p5 - k42*z2 - k43*z3 - k44*z4 + p3*x3 + p4*speed - p6)/(p7*s1)
    )
    phi = [[0.0] * 7 for _ in range(4)]
    phi[1][0] = alpha2
    phi[1][1] = 1
    phi[2][0] = -a2_x2*x3
    phi[2][1] = -a2_x2
    phi[3][0] = -a3_x2*x3
    phi[3][1] = -a3_x2
    phi[3][2] = -x3
    phi[3][3] = -speed
    phi[3][4] = -friction
    phi[3][5] = 1
    phi[3][6] = s1*u
    return u, (z1, z2, z3, z4), (alpha1, alpha2, alpha3), phi
