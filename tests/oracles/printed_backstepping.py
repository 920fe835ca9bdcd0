"""The backstepping law of the dissertation with its errata mended, written out by hand for four states."""

from dataclasses import dataclass
from types import SimpleNamespace


@dataclass(frozen=True)
class Gains:
    """Feedback gains of (6.71), (6.76), (6.82), (6.90); the robust ones k_ir constant."""

    k1: float
    k2g1: float
    k2g2: float
    k2r: float
    k3g2: float
    k3g3: float
    k3r: float
    k4g2: float
    k4g3: float
    k4g4: float
    k4r: float


def corrected_backstepping(x, y, p, k, beta_n, S):
    """Law, errors, partial derivatives and regressors of (6.70)-(6.93), corrected.

    x: x1, x2 and, with the bar, x3, x4. y: y_d and four derivatives. p: the seven estimates. S: S_f(x2 + x4).
    """
    x1, x2, x3, x4 = x
    p1, p2, p3, p4, p5, p6, p7 = p
    k2, k3, k4 = k.k2g2 + k.k2r, k.k3g3 + k.k3r, k.k4g4 + k.k4r

    z1 = x1 - y[0]
    alpha1 = y[1] - k.k1 * z1
    alpha1_t, alpha1_x1 = y[2] + k.k1 * y[1], -k.k1

    z2 = x2 - alpha1
    alpha1_rate = alpha1_t + alpha1_x1 * x2  # (6.74)
    alpha2 = (alpha1_rate - p2 - k2 * z2 - k.k2g1 * z1) / p1
    alpha2_t = (y[3] + k.k1 * y[2] + k2 * (y[2] + k.k1 * y[1]) + k.k2g1 * y[1]) / p1  # (6.81)
    alpha2_x1 = -(k2 * k.k1 + k.k2g1) / p1
    alpha2_x2 = -(k.k1 + k2) / p1

    z3 = x3 - alpha2
    x2_rate = p1 * x3 + p2  # as estimated
    alpha3 = alpha2_t + alpha2_x1 * x2 + alpha2_x2 * x2_rate - k3 * z3 - k.k3g2 * z2
    alpha2_tt = (y[4] + k.k1 * y[3] + k2 * (y[3] + k.k1 * y[2]) + k.k2g1 * y[2]) / p1
    alpha3_t = alpha2_tt + k3 * alpha2_t + k.k3g2 * alpha1_t  # (6.89)
    alpha3_x1 = k3 * alpha2_x1 + k.k3g2 * alpha1_x1
    alpha3_x2 = alpha2_x1 + k3 * alpha2_x2 - k.k3g2
    alpha3_x3 = p1 * alpha2_x2 - k3

    z4 = x4 - alpha3
    speed = x2 + x4 / beta_n  # of the motor
    alpha3_rate = alpha3_t + alpha3_x1 * x2 + alpha3_x2 * x2_rate + alpha3_x3 * x4
    wanted = p3 * x3 + p4 * speed + p5 * S - p6 + alpha3_rate - k4 * z4 - k.k4g3 * z3 - k.k4g2 * z2
    u = wanted / (beta_n * p7)  # (6.90)

    return SimpleNamespace(
        u=u,
        z=(z1, z2, z3, z4),
        alpha=(alpha1, alpha2, alpha3),
        alpha2_partials=(alpha2_t, alpha2_x1, alpha2_x2),
        alpha3_partials=(alpha3_t, alpha3_x1, alpha3_x2, alpha3_x3),
        phi2=(alpha2, 1, 0, 0, 0, 0, 0),
        phi3=(-alpha2_x2 * x3, -alpha2_x2, 0, 0, 0, 0, 0),
        phi4=(-alpha3_x2 * x3, -alpha3_x2, -x3, -speed, -S, 1, beta_n * u),
    )


def plant(x, u, p, d2, d, beta_n, S):
    """Eq. (6.69), d2 the load's disturbance over J2 and d that of x4bar'."""
    speed = x[1] + x[3] / beta_n
    x4_rate = beta_n * p[6] * u - p[2] * x[2] - p[3] * speed - p[4] * S + p[5] + d
    return x[1], p[0] * x[2] + p[1] + d2, x[3], x4_rate
