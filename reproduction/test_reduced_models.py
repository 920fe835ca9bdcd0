"""Sections 4.3, 6.1 and 6.2: the lists of the pulse, the transfer functions and state forms of the chains.

The equations of motion are derived here from the energy, the dissipation and the torque at the motor, and the
printed formulas are held against them as rational functions: an identity leaves exactly zero.
"""

import math
from itertools import pairwise

import pytest
import sympy as sp

# The lists of (6.3b)-(6.3e), which (6.7b)-(6.7e) repeat with b_j: (factor, power of t_f) of a_5 .. a_9.
PRINTED_LISTS = (
    [(5, 4), (6, 5), (7, 6), (8, 7), (9, 8)],
    [(20, 3), (30, 4), (42, 5), (56, 6), (72, 7)],
    [(60, 2), (120, 3), (210, 4), (336, 5), (504, 6)],
    [(120, 1), (360, 2), (840, 3), (1680, 4), (3024, 5)],
)


def test_lists_of_6_3_are_the_derivatives_of_order_one_to_four():
    """`erratum-6-2-dots`: (6.3e), (6.5e), (6.7e) carry three dots over the list of the fourth derivative."""
    for order, printed in enumerate(PRINTED_LISTS, start=1):
        assert printed == [(math.perm(j, order), j - order) for j in range(5, 10)]
    for orders, rank in (((0, 1, 2, 3, 4), 5), ((0, 1, 3, 3, 3), 3)):  # read as scanned, two stay free
        rows = [[sp.factorial(n) if j == n else 0 for j in range(10)] for n in orders]
        assert sp.Matrix(rows).rank() == rank


# --- transfer functions -----------------------------------------------------------------------------------

s = sp.Symbol("s")
J1, J2, J11, J12, k, r, k_m = sp.symbols("J1 J2 J11 J12 k r k_m", positive=True)
b_1, b_c, b_m = sp.symbols("b_1 b_c b_m", nonnegative=True)
net = sp.Symbol("tau_c")  # motor torque less Coulomb friction, plus the offsets
kk, bb = 2 * k * r**2, 2 * b_c * r  # two cable spans seen as one rotational spring and damper
ANGLES, SPEEDS = sp.symbols("theta_11 theta_12 theta_2"), sp.symbols("omega_11 omega_12 omega_2")


def accelerations(inertias, springs, dampers):
    """J_i theta_i'' = -dU/dtheta_i - dR/domega_i of a chain, the net torque and b_1 at the first."""
    theta, omega = ANGLES[: len(inertias)], SPEEDS[: len(inertias)]
    potential = sum(c * (a - b) ** 2 / 2 for c, (a, b) in zip(springs, pairwise(theta), strict=True))
    loss = sum(c * (a - b) ** 2 / 2 for c, (a, b) in zip(dampers, pairwise(omega), strict=True))
    loss += b_1 * omega[0] ** 2 / 2
    torques = [-sp.diff(potential, q) - sp.diff(loss, w) for q, w in zip(theta, omega, strict=True)]
    torques[0] += net
    return [torque / inertia for torque, inertia in zip(torques, inertias, strict=True)]


def models(b_m=b_m, bb=bb):
    """(6.10), (6.11), (6.13): a flexible joint, a flexible cable, both."""
    return {
        2: accelerations([J11, J2 + J12], [k_m], [b_m]),
        3: accelerations([J1, J2], [kk], [bb]),
        4: accelerations([J11, J12, J2], [k_m, kk], [b_m, bb]),
    }


def transfer(chain):
    """Angles over the net torque in the Laplace domain."""
    n = len(chain)
    motion = {w: s * q for q, w in zip(ANGLES[:n], SPEEDS[:n], strict=True)}
    equations = [s**2 * q - a.subs(motion) for q, a in zip(ANGLES[:n], chain, strict=True)]
    solution = sp.solve(equations, ANGLES[:n], dict=True)[0]
    return [sp.cancel(solution[q] / net) for q in ANGLES[:n]]


def is_zero(expression):
    return sp.cancel(sp.together(expression)) == 0


def test_both_lines_of_4_19_and_eq_6_12_from_the_equations_of_motion():
    """`confirmed-4-19-first-line`; `erratum-4-19-second-line`: b1/J11 is missing; `confirmed-6-12`."""
    speed = s * transfer(accelerations([J11, J12], [k_m], [b_m]))[0]
    drive, pulley = J11 * s**2 + (b_1 + b_m) * s + k_m, J12 * s**2 + b_m * s + k_m
    assert is_zero(speed - pulley * s / (drive * pulley - (k_m + b_m * s) ** 2))
    numerator = s**2 / J11 + b_m / (J11 * J12) * s + k_m / (J11 * J12)
    linear = k_m / J11 + k_m / J12 + b_1 * b_m / (J11 * J12)
    denominator = s**3 + b_m * (1 / J11 + 1 / J12) * s**2 + linear * s + b_1 * k_m / (J11 * J12)
    assert is_zero(speed - numerator / (denominator + b_1 / J11 * s**2))
    assert not is_zero(speed - numerator / denominator)

    linear = kk / J1 + kk / J2 + b_1 * bb / (J1 * J2)
    denominator = s**3 + ((b_1 + bb) / J1 + bb / J2) * s**2 + linear * s + kk * b_1 / (J1 * J2)
    assert is_zero(s * transfer(models()[3])[0] - (s**2 + bb / J2 * s + kk / J2) / J1 / denominator)


def test_eq_6_14_needs_its_corrections():
    """`erratum-6-14-first-line`: the print has k_m = 0 below; `erratum-6-14-second-line`: over J11."""
    motor, drive, _ = transfer(models()[4])
    coupling = sp.cancel(drive / motor)  # G_1
    cable = s**2 + bb / J2 * s + kk / J2
    printed = s**4 + (bb / J2 + b_m / J12 + bb / J12) * s**3
    printed += (kk / J2 + bb * b_m / (J12 * J2) + kk / J12) * s**2 + kk * b_m / (J12 * J2) * s
    right = printed + k_m / J12 * s**2 + bb * k_m / (J12 * J2) * s + kk * k_m / (J12 * J2)
    assert is_zero(coupling - b_m / J12 * (s + k_m / b_m) * cable / right)
    for numerator in (s + b_m / k_m, s + k_m / b_m):
        assert not is_zero(coupling - b_m / J12 * numerator * cable / printed)
    assert sp.limit(coupling, s, 0) == 1, "motor and drive pulley turn together at rest"
    assert printed.subs(s, 0) == 0, "the print has an integrator there"

    own, coupled = s**2 + (b_1 + b_m) / J11 * s + k_m / J11, coupling * b_m * (s + k_m / b_m)
    assert is_zero(s * motor - (s / J11) / (own - coupled / J11))
    assert not is_zero(s * motor - (s / J11) / (own - coupled))


# --- state forms ------------------------------------------------------------------------------------------

x2, *X = sp.symbols("x2 x3:7")  # speed of the load; twist and its rate, link by link to the motor
BETAS = {2: k_m / (J2 + J12), 3: kk / J2, 4: kk / J2}


def state_form(model, chain):
    """x2' and the rates of the scaled twist rates, (6.38), (6.46), (6.57)."""
    n = len(chain)
    angle, speed = sp.Symbol("x1"), x2
    motion = {ANGLES[n - 1]: angle, SPEEDS[n - 1]: speed}
    for link in range(n - 1):
        angle, speed = angle + X[2 * link], speed + X[2 * link + 1]
        motion |= {ANGLES[n - 2 - link]: angle, SPEEDS[n - 2 - link]: speed}
    *others, load = (a.subs(motion) for a in chain)
    twists = [BETAS[model] * (near - far) for near, far in pairwise([*others, load])]
    return [load, *reversed(twists)]


def printed_state_form(model):
    """(6.39), (6.47) with the bar on the left of its line d, (6.58)."""
    beta, (x3, x4, x5, x6) = BETAS[model], X
    x3bar, x5bar = beta * x3, beta * x5
    if model == 2:
        return x3bar, beta / J11 * (net - b_1 * (x2 + x4) - (J11 + k_m / beta) * x3bar)
    if model == 3:
        return x3bar, beta / J1 * (net - (J2 + J1) * x3bar - b_1 * (x4 + x2))
    joint = J2 / J12 * x3bar - k_m / (beta * J12) * x5bar
    motor = net - b_1 * (x2 + x4 + x6) - k_m / beta * x5bar + J11 * joint
    return x3bar, -kk * (1 / J12 + 1 / J2) * x3bar + k_m / J12 * x5bar, beta / J11 * motor


@pytest.mark.parametrize("model", [2, 3, 4])
def test_state_forms_drop_the_joint_and_cable_damping(model):
    """`erratum-6-39-damping`: (6.39), (6.47), (6.58) lack b_m and b_c, and nothing else.

    `confirmed-6-39-6-45`, `confirmed-6-57-6-65`: without damping they are right; `erratum-6-47d`: for the
    scaled state only.
    """
    printed = printed_state_form(model)
    right, whole = (state_form(model, some[model]) for some in (models(b_m=0, bb=0), models()))
    assert all(is_zero(true - line) for true, line in zip(right, printed, strict=True))
    assert not any(is_zero(true - line) for true, line in zip(whole, printed, strict=True))
    assert model != 3 or not is_zero(right[1] / BETAS[3] - printed[1])


def test_backstepping_plant_6_66_is_model_3_not_model_1():
    """`erratum-6-7-title`: (6.66), (6.67) are (6.11) without b_c; Model 1 is their sum with a rigid cable."""
    th1, th2, om1, om2 = *ANGLES[:2], *SPEEDS[:2]
    pull = 2 * k * r * (r * th1 - r * th2)
    printed = (net - pull - b_1 * om1) / J1, pull / J2
    drive, load = models(bb=0)[3]
    assert is_zero(printed[0] - drive)
    assert is_zero(printed[1] - load)
    together = ((J1 * drive + J2 * load) / (J1 + J2)).subs({th2: th1, om2: om1})
    assert is_zero(together - (net - b_1 * om1) / (J1 + J2))
    assert not is_zero(drive - together)
