"""Backstepping on 3 inertias, written by `cabledrive.control.generation`; change it there."""
# fmt: off

from math import tanh
from typing import Any

from cabledrive.control.numbers import Array
from cabledrive.mechanics.compiled import njit

# Step and error of each gain.
GAINS = ((1, 1), (2, 1), (2, 2), (3, 2), (3, 3), (4, 3), (4, 4), (5, 4), (5, 5), (6, 4), (6, 5), (6, 6))


@njit
def backstepping_six(
    gains: Array, scalars: Array, estimate: Array, states: Array, reference: Array, k: int, tau: Array
) -> tuple[float, float]:
    """Command and first error; writes the adaptation function tau."""
    k11 = gains[0, 0]
    k21 = gains[0, 1]
    k22 = gains[0, 2]
    k32 = gains[0, 3]
    k33 = gains[0, 4]
    k43 = gains[0, 5]
    k44 = gains[0, 6]
    k54 = gains[0, 7]
    k55 = gains[0, 8]
    k64 = gains[0, 9]
    k65 = gains[0, 10]
    k66 = gains[0, 11]
    s1 = gains[0, 12]
    s2 = gains[0, 13]
    p1 = estimate[0]
    p2 = estimate[1]
    p3 = estimate[2]
    p4 = estimate[3]
    p5 = estimate[4]
    p6 = estimate[5]
    p7 = estimate[6]
    p8 = estimate[7]
    p9 = estimate[8]
    p10 = estimate[9]
    x1, x2 = states[2], states[5]
    x3 = s1 * (states[1] - states[2])
    x4 = s1 * (states[4] - states[5])
    x5 = s2 * (states[0] - states[1])
    x6 = s2 * (states[3] - states[4])
    speed = states[3]
    friction = tanh(scalars[2] * (reference[k, 16] if scalars[3] > 0.0 else speed))
    y0 = reference[k, 0]
    y1 = reference[k, 1]
    y2 = reference[k, 2]
    y3 = reference[k, 3]
    y4 = reference[k, 4]
    y5 = reference[k, 5]
    y6 = reference[k, 6]
    w1_0 = reference[k, 7]
    w1_1 = reference[k, 8]
    w1_2 = reference[k, 9]
    w1_3 = reference[k, 10]
    w1_4 = reference[k, 11]
    w2_0 = reference[k, 12]
    w2_1 = reference[k, 13]
    w2_2 = reference[k, 14]
    w3_0 = reference[k, 15]
    z1 = x1 - y0
    alpha1 = -k11*z1 + y1
    a1_x1 = -k11
    a1_y0 = k11
    a1_y1 = 1
    z2 = -alpha1 + x2
    alpha2 = (a1_x1*x2 + a1_y0*y1 + a1_y1*y2 - k21*z1 - k22*z2 - p2 - w1_0)/p1
    a2_x1 = (a1_x1*k22 - k21)/p1
    a2_x2 = (a1_x1 - k22)/p1
    a2_y0 = (a1_y0*k22 + k21)/p1
    a2_y1 = (a1_y0 + a1_y1*k22)/p1
    a2_y2 = a1_y1/p1
    a2_w1_0 = -1/p1
    z3 = -alpha2 + x3
    alpha3 = (
        a2_w1_0*w1_1 + a2_x1*x2 + a2_x2*(p1*x3 + p2 + w1_0) + a2_y0*y1 + a2_y1*y2 + a2_y2*y3 -
        k32*z2 - k33*z3
    )
    a3_x1 = a1_x1*k32 + a2_x1*k33
    a3_x2 = a2_x1 + a2_x2*k33 - k32
    a3_x3 = a2_x2*p1 - k33
    a3_y0 = a1_y0*k32 + a2_y0*k33
    a3_y1 = a1_y1*k32 + a2_y0 + a2_y1*k33
    a3_y2 = a2_y1 + a2_y2*k33
    a3_y3 = a2_y2
    a3_w1_0 = a2_w1_0*k33 + a2_x2
    a3_w1_1 = a2_w1_0
    z4 = -alpha3 + x4
    alpha4 = (
        (a3_w1_0*w1_1 + a3_w1_1*w1_2 + a3_x1*x2 + a3_x2*(p1*x3 + p2 + w1_0) + a3_x3*x4 + a3_y0*y1 +
        a3_y1*y2 + a3_y2*y3 + a3_y3*y4 - k43*z3 - k44*z4 + p2*s1 + p4*x3 - w2_0)/p3
    )
    a4_x1 = (a2_x1*k43 + a3_x1*k44)/p3
    a4_x2 = (a2_x2*k43 + a3_x1 + a3_x2*k44)/p3
    a4_x3 = (a3_x2*p1 + a3_x3*k44 - k43 + p4)/p3
    a4_x4 = (a3_x3 - k44)/p3
    a4_y0 = (a2_y0*k43 + a3_y0*k44)/p3
    a4_y1 = (a2_y1*k43 + a3_y0 + a3_y1*k44)/p3
    a4_y2 = (a2_y2*k43 + a3_y1 + a3_y2*k44)/p3
    a4_y3 = (a3_y2 + a3_y3*k44)/p3
    a4_y4 = a3_y3/p3
    a4_w1_0 = (a2_w1_0*k43 + a3_w1_0*k44 + a3_x2)/p3
    a4_w1_1 = (a3_w1_0 + a3_w1_1*k44)/p3
    a4_w1_2 = a3_w1_1/p3
    a4_w2_0 = -1/p3
    z5 = -alpha4 + x5
    alpha5 = (
        a4_w1_0*w1_1 + a4_w1_1*w1_2 + a4_w1_2*w1_3 + a4_w2_0*w2_1 + a4_x1*x2 + a4_x2*(p1*x3 + p2 +
        w1_0) + a4_x3*x4 + a4_x4*(-p2*s1 + p3*x5 - p4*x3 + w2_0) + a4_y0*y1 + a4_y1*y2 + a4_y2*y3 +
        a4_y3*y4 + a4_y4*y5 - k54*z4 - k55*z5
    )
    a5_x1 = a3_x1*k54 + a4_x1*k55
    a5_x2 = a3_x2*k54 + a4_x1 + a4_x2*k55
    a5_x3 = a3_x3*k54 + a4_x2*p1 + a4_x3*k55 - a4_x4*p4
    a5_x4 = a4_x3 + a4_x4*k55 - k54
    a5_x5 = a4_x4*p3 - k55
    a5_y0 = a3_y0*k54 + a4_y0*k55
    a5_y1 = a3_y1*k54 + a4_y0 + a4_y1*k55
    a5_y2 = a3_y2*k54 + a4_y1 + a4_y2*k55
    a5_y3 = a3_y3*k54 + a4_y2 + a4_y3*k55
    a5_y4 = a4_y3 + a4_y4*k55
    a5_y5 = a4_y4
    a5_w1_0 = a3_w1_0*k54 + a4_w1_0*k55 + a4_x2
    a5_w1_1 = a3_w1_1*k54 + a4_w1_0 + a4_w1_1*k55
    a5_w1_2 = a4_w1_1 + a4_w1_2*k55
    a5_w1_3 = a4_w1_2
    a5_w2_0 = a4_w2_0*k55 + a4_x4
    a5_w2_1 = a4_w2_0
    z6 = -alpha5 + x6
    u = (
        (a5_w1_0*w1_1 + a5_w1_1*w1_2 + a5_w1_2*w1_3 + a5_w1_3*w1_4 + a5_w2_0*w2_1 + a5_w2_1*w2_2 +
        a5_x1*x2 + a5_x2*(p1*x3 + p2 + w1_0) + a5_x3*x4 + a5_x4*(-p2*s1 + p3*x5 - p4*x3 + w2_0) +
        a5_x5*x6 + a5_y0*y1 + a5_y1*y2 + a5_y2*y3 + a5_y3*y4 + a5_y4*y5 + a5_y5*y6 + friction*p8 -
        k64*z4 - k65*z5 - k66*z6 + p5*x5 - p6*x3 + p7*speed - p9 - w3_0)/(p10*s2)
    )
    cross2 = a2_x2*z3 + a3_x2*z4 + a4_x2*z5 + a5_x2*z6
    cross4 = a4_x4*z5 + a5_x4*z6
    tau[0] = -cross2*x3 + x3*z2
    tau[1] = -cross2 + cross4*s1 - s1*z4 + z2
    tau[2] = -cross4*x5 + x5*z4
    tau[3] = cross4*x3 - x3*z4
    tau[4] = -x5*z6
    tau[5] = x3*z6
    tau[6] = -speed*z6
    tau[7] = -friction*z6
    tau[8] = z6
    tau[9] = s2*u*z6
    return u, z1


def backstepping_six_reference(
    gains: Any, estimate: Any, x: Any, signals: Any, speed: Any, friction: Any
) -> tuple[Any, tuple[Any, ...], tuple[Any, ...], list[list[Any]]]:
    """Command, errors z, virtual controls alpha, regressors phi, from scaled states; any numbers."""
    k11, k21, k22, k32, k33, k43, k44, k54, k55, k64, k65, k66, s1, s2, = gains
    p1, p2, p3, p4, p5, p6, p7, p8, p9, p10, = estimate
    x1, x2, x3, x4, x5, x6, = x
    y0, y1, y2, y3, y4, y5, y6, w1_0, w1_1, w1_2, w1_3, w1_4, w2_0, w2_1, w2_2, w3_0, = signals
    z1 = x1 - y0
    alpha1 = -k11*z1 + y1
    a1_x1 = -k11
    a1_y0 = k11
    a1_y1 = 1
    z2 = -alpha1 + x2
    alpha2 = (a1_x1*x2 + a1_y0*y1 + a1_y1*y2 - k21*z1 - k22*z2 - p2 - w1_0)/p1
    a2_x1 = (a1_x1*k22 - k21)/p1
    a2_x2 = (a1_x1 - k22)/p1
    a2_y0 = (a1_y0*k22 + k21)/p1
    a2_y1 = (a1_y0 + a1_y1*k22)/p1
    a2_y2 = a1_y1/p1
    a2_w1_0 = -1/p1
    z3 = -alpha2 + x3
    alpha3 = (
        a2_w1_0*w1_1 + a2_x1*x2 + a2_x2*(p1*x3 + p2 + w1_0) + a2_y0*y1 + a2_y1*y2 + a2_y2*y3 -
        k32*z2 - k33*z3
    )
    a3_x1 = a1_x1*k32 + a2_x1*k33
    a3_x2 = a2_x1 + a2_x2*k33 - k32
    a3_x3 = a2_x2*p1 - k33
    a3_y0 = a1_y0*k32 + a2_y0*k33
    a3_y1 = a1_y1*k32 + a2_y0 + a2_y1*k33
    a3_y2 = a2_y1 + a2_y2*k33
    a3_y3 = a2_y2
    a3_w1_0 = a2_w1_0*k33 + a2_x2
    a3_w1_1 = a2_w1_0
    z4 = -alpha3 + x4
    alpha4 = (
        (a3_w1_0*w1_1 + a3_w1_1*w1_2 + a3_x1*x2 + a3_x2*(p1*x3 + p2 + w1_0) + a3_x3*x4 + a3_y0*y1 +
        a3_y1*y2 + a3_y2*y3 + a3_y3*y4 - k43*z3 - k44*z4 + p2*s1 + p4*x3 - w2_0)/p3
    )
    a4_x1 = (a2_x1*k43 + a3_x1*k44)/p3
    a4_x2 = (a2_x2*k43 + a3_x1 + a3_x2*k44)/p3
    a4_x3 = (a3_x2*p1 + a3_x3*k44 - k43 + p4)/p3
    a4_x4 = (a3_x3 - k44)/p3
    a4_y0 = (a2_y0*k43 + a3_y0*k44)/p3
    a4_y1 = (a2_y1*k43 + a3_y0 + a3_y1*k44)/p3
    a4_y2 = (a2_y2*k43 + a3_y1 + a3_y2*k44)/p3
    a4_y3 = (a3_y2 + a3_y3*k44)/p3
    a4_y4 = a3_y3/p3
    a4_w1_0 = (a2_w1_0*k43 + a3_w1_0*k44 + a3_x2)/p3
    a4_w1_1 = (a3_w1_0 + a3_w1_1*k44)/p3
    a4_w1_2 = a3_w1_1/p3
    a4_w2_0 = -1/p3
    z5 = -alpha4 + x5
    alpha5 = (
        a4_w1_0*w1_1 + a4_w1_1*w1_2 + a4_w1_2*w1_3 + a4_w2_0*w2_1 + a4_x1*x2 + a4_x2*(p1*x3 + p2 +
        w1_0) + a4_x3*x4 + a4_x4*(-p2*s1 + p3*x5 - p4*x3 + w2_0) + a4_y0*y1 + a4_y1*y2 + a4_y2*y3 +
        a4_y3*y4 + a4_y4*y5 - k54*z4 - k55*z5
    )
    a5_x1 = a3_x1*k54 + a4_x1*k55
    a5_x2 = a3_x2*k54 + a4_x1 + a4_x2*k55
    a5_x3 = a3_x3*k54 + a4_x2*p1 + a4_x3*k55 - a4_x4*p4
    a5_x4 = a4_x3 + a4_x4*k55 - k54
    a5_x5 = a4_x4*p3 - k55
    a5_y0 = a3_y0*k54 + a4_y0*k55
    a5_y1 = a3_y1*k54 + a4_y0 + a4_y1*k55
    a5_y2 = a3_y2*k54 + a4_y1 + a4_y2*k55
    a5_y3 = a3_y3*k54 + a4_y2 + a4_y3*k55
    a5_y4 = a4_y3 + a4_y4*k55
    a5_y5 = a4_y4
    a5_w1_0 = a3_w1_0*k54 + a4_w1_0*k55 + a4_x2
    a5_w1_1 = a3_w1_1*k54 + a4_w1_0 + a4_w1_1*k55
    a5_w1_2 = a4_w1_1 + a4_w1_2*k55
    a5_w1_3 = a4_w1_2
    a5_w2_0 = a4_w2_0*k55 + a4_x4
    a5_w2_1 = a4_w2_0
    z6 = -alpha5 + x6
    u = (
        (a5_w1_0*w1_1 + a5_w1_1*w1_2 + a5_w1_2*w1_3 + a5_w1_3*w1_4 + a5_w2_0*w2_1 + a5_w2_1*w2_2 +
        a5_x1*x2 + a5_x2*(p1*x3 + p2 + w1_0) + a5_x3*x4 + a5_x4*(-p2*s1 + p3*x5 - p4*x3 + w2_0) +
        a5_x5*x6 + a5_y0*y1 + a5_y1*y2 + a5_y2*y3 + a5_y3*y4 + a5_y4*y5 + a5_y5*y6 + friction*p8 -
        k64*z4 - k65*z5 - k66*z6 + p5*x5 - p6*x3 + p7*speed - p9 - w3_0)/(p10*s2)
    )
    phi = [[0.0] * 10 for _ in range(6)]
    phi[1][0] = x3
    phi[1][1] = 1
    phi[2][0] = -a2_x2*x3
    phi[2][1] = -a2_x2
    phi[3][0] = -a3_x2*x3
    phi[3][1] = -a3_x2 - s1
    phi[3][2] = x5
    phi[3][3] = -x3
    phi[4][0] = -a4_x2*x3
    phi[4][1] = -a4_x2 + a4_x4*s1
    phi[4][2] = -a4_x4*x5
    phi[4][3] = a4_x4*x3
    phi[5][0] = -a5_x2*x3
    phi[5][1] = -a5_x2 + a5_x4*s1
    phi[5][2] = -a5_x4*x5
    phi[5][3] = a5_x4*x3
    phi[5][4] = -x5
    phi[5][5] = x3
    phi[5][6] = -speed
    phi[5][7] = -friction
    phi[5][8] = 1
    phi[5][9] = s2*u
    return u, (z1, z2, z3, z4, z5, z6), (alpha1, alpha2, alpha3, alpha4, alpha5), phi
