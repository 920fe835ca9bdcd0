"""The dissertation's laws written by hand: of Models 1 to 4 as printed, backstepping with errata mended."""

from dataclasses import dataclass
from fractions import Fraction as F
from types import SimpleNamespace

import numpy as np


@dataclass(frozen=True)
class Machine:
    """Table 6.1, 6.2, and 4.1; SI units."""

    J11: F = F("0.0011")
    J12: F = F("0.000642")
    J2: F = F("0.00235")
    kk: F = F("2.72")  # 2 k r^2
    k_m: F = F("135")

    @property
    def J1(self):
        return self.J11 + self.J12


# --- the printed laws -------------------------------------------------------------------------------------
#
# x: printed states, without bars. y: y_d and its derivatives. p: estimates of p2 .. p5. S: S_f at the motor.
# They return u, sigma, phi and mu.


def law_1(machine, x, y, p, lam, K_sigma, S):
    """Rigid joint, rigid cable: Eq. (6.16)-(6.20)."""
    z1, z2 = x[0] - y[0], x[1] - y[1]
    sigma = z2 + lam * z1
    z_eq = y[2] - lam * z2
    phi = np.array([-z_eq, -x[1], -S, 1])
    u = -phi @ p - K_sigma * sigma
    return u, sigma, phi, machine.J1 + machine.J2


def law_of_two(spring, near, far, x, y, p, lam, K_sigma, S):
    """Two inertias on a spring: Eq. (6.40)-(6.43), (6.48)-(6.53), y[4] in z_eq."""
    beta = spring / far
    x1, x2, x3, x4 = x
    x3bar, x4bar = beta * x3, beta * x4
    z1, z2, z3, z4 = x1 - y[0], x2 - y[1], x3bar - y[2], x4bar - y[3]
    sigma = z4 + 3 * lam * z3 + 3 * lam**2 * z2 + lam**3 * z1
    z_eq = y[4] - 3 * lam * z4 - 3 * lam**2 * z3 - lam**3 * z2
    phi = np.array([-x3bar - z_eq / beta, -(x2 + x4), -S, 1])
    u = far * x3bar - phi @ p - K_sigma * sigma
    return u, sigma, phi, near / beta


def law_2(machine, *others):
    """Flexible joint, rigid cable."""
    return law_of_two(machine.k_m, machine.J11, machine.J2 + machine.J12, *others)


def law_3(machine, *others):
    """Rigid joint, flexible cable."""
    return law_of_two(machine.kk, machine.J1, machine.J2, *others)


def law_4(machine, x, y, p, lam, K_sigma, S):
    """Flexible joint, flexible cable: Eq. (6.59)-(6.63)."""
    J12, J2, kk, k_m = machine.J12, machine.J2, machine.kk, machine.k_m
    beta = kk / J2
    x1, x2, x3, x4, x5, x6 = x
    x3bar, x4bar, x5bar, x6bar = beta * x3, beta * x4, beta * x5, beta * x6
    x4bar_rate = -kk * (1 / J12 + 1 / J2) * x3bar + k_m / J12 * x5bar  # (6.58d)
    z1, z2, z3, z4 = x1 - y[0], x2 - y[1], x3bar - y[2], x4bar - y[3]
    z5 = x4bar_rate - y[4]
    z6 = -kk * (1 / J12 + 1 / J2) * x4bar + k_m / J12 * x6bar - y[5]
    sigma = z6 + 5 * lam * z5 + 10 * lam**2 * z4 + 10 * lam**3 * z3 + 5 * lam**4 * z2 + lam**5 * z1
    z_eq = y[6] - 5 * lam * z6 - 10 * lam**2 * z5 - 10 * lam**3 * z4 - 5 * lam**4 * z3 - lam**5 * z2
    phi_2 = J12 / k_m * ((1 + J2 / J12) * x4bar_rate + z_eq / beta) - (
        J2 / J12 * x3bar - k_m / (beta * J12) * x5bar
    )
    phi = np.array([-phi_2, -(x2 + x4 + x6), -S, 1])
    u = k_m / beta * x5bar - phi @ p - K_sigma * sigma
    return u, sigma, phi, machine.J11 * J12 / (beta * k_m)


def printed_states(q):
    """x1, x2 of the load, then twist and its rate, link by link to the motor: (6.38), (6.46), (6.57)."""
    n = len(q) // 2
    x = [q[n - 1], q[2 * n - 1]]
    for i in range(n - 2, -1, -1):
        x += [q[i] - q[i + 1], q[n + i] - q[n + i + 1]]
    return np.array(x)


LAWS = {1: law_1, 2: law_2, 3: law_3, 4: law_4}


# --- Backstepping for four states


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
