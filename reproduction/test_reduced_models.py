"""Sections 4.3, 6.1 and 6.2: the pulse, the chains behind the laws, their transfer functions and state forms.

The equations of motion are derived here from the energy, the dissipation and the torque at the motor, and the
printed formulas are held against them as rational functions: an identity leaves exactly zero.
"""

import math
from itertools import pairwise

import numpy as np
import pytest
import sympy as sp

from reproduction import oracles
from reproduction.oracles import (
    BB,
    BETA,
    JOINT,
    JOINT_DAMPING,
    KK,
    VISCOUS,
    link_matrix,
    pairs_of,
    state_matrix,
)

INERTIAS = oracles.J11, oracles.J12, oracles.J2
SPRINGS = link_matrix([JOINT, KK])
DAMPERS = link_matrix([JOINT_DAMPING, BB]) + np.diag([VISCOUS, 0, 0])


def test_what_the_print_says_of_torques_and_bounds():
    """`erratum-slack-torque`: 2 r T0. `erratum-4-1-achievable-torque`: 46 N m. `erratum-6-6-1-bounds`: J11.

    `number-rig-results`: 0.17 deg are about five, 0.055 deg less than two steps of 10,000 a turn.
    """
    for radius, pretension, torque in ((0.04, 7.0, 0.56), (0.03, 5.0, 0.30)):
        for stiffness in (850.0, 438.0):  # of a span: the relative angle at T0 - k r (theta_1 - theta_2) = 0
            assert 2 * stiffness * radius**2 * (pretension / (stiffness * radius)) == pytest.approx(torque)
    assert pytest.approx(46.4, abs=0.05) == 8.920 * 5.2
    assert pytest.approx(oracles.J11, rel=1e-12) == (0.0009 + 0.0013) / 2
    np.testing.assert_allclose(np.array([0.17, 0.055]) / (360 / 10_000), [4.72, 1.53], atol=5e-3)


# --- the pulse of Section 6.1 -----------------------------------------------------------------------------

t, t_f, theta_f = sp.symbols("t t_f theta_f", positive=True)
# The lists of (6.3b)-(6.3e), which (6.7b)-(6.7e) repeat with b_j: (factor, power of t_f) of a_5 .. a_9.
PRINTED_LISTS = (
    [(5, 4), (6, 5), (7, 6), (8, 7), (9, 8)],
    [(20, 3), (30, 4), (42, 5), (56, 6), (72, 7)],
    [(60, 2), (120, 3), (210, 4), (336, 5), (504, 6)],
    [(120, 1), (360, 2), (840, 3), (1680, 4), (3024, 5)],
)


def rest_to_rest(order):
    """Move from 0 to theta_f whose derivatives 1 .. (order - 1)/2 vanish at both ends, Eq. (6.1)-(6.3)."""
    a = sp.symbols(f"a0:{order + 1}")
    y = sum(a_j * t**j for j, a_j in enumerate(a))
    conditions = [y.subs(t, 0), y.subs(t, t_f) - theta_f]
    for n in range(1, (order + 1) // 2):
        conditions += [sp.diff(y, t, n).subs(t, 0), sp.diff(y, t, n).subs(t, t_f)]
    return y.subs(sp.solve(conditions, a, dict=True)[0])


def end_values(y, n):
    """The n-th derivative just inside the move, at its start and at its end; outside it is zero."""
    return tuple(sp.simplify(sp.diff(y, t, n).subs(t, place)) for place in (0, t_f))


def test_lists_of_6_3_are_the_derivatives_of_order_one_to_four():
    """`erratum-6-2-dots`: (6.3e), (6.5e), (6.7e) carry three dots over the list of the fourth derivative."""
    for order, printed in enumerate(PRINTED_LISTS, start=1):
        assert printed == [(math.perm(j, order), j - order) for j in range(5, 10)]
    for orders, rank in (((0, 1, 2, 3, 4), 5), ((0, 1, 3, 3, 3), 3)):  # read as scanned, two stay free
        rows = [[sp.factorial(n) if j == n else 0 for j in range(10)] for n in orders]
        assert sp.Matrix(rows).rank() == rank


def test_ninth_order_pulse_jumps_in_its_fifth_derivative():
    """`erratum-6-1-smoothness`: 0.27 mN m at the printed K_sigma; `confirmed-6-4-6-7`: its mirror image."""
    nine, eleven = rest_to_rest(9), rest_to_rest(11)
    assert end_values(nine, 4) == end_values(eleven, 5) == (0, 0)
    assert end_values(nine, 5) == (15120 * theta_f / t_f**5, 15120 * theta_f / t_f**5)
    assert end_values(eleven, 6) == (332640 * theta_f / t_f**6, -332640 * theta_f / t_f**6)
    jump = 15120 * math.radians(45) / 0.5**5
    k_sigma = 2 * math.pi * 25 * oracles.J11 * oracles.J12 / (BETA * JOINT)
    assert k_sigma * jump == pytest.approx(2.7e-4, rel=0.01)
    assert end_values(theta_f - nine, 0) == (theta_f, 0)
    assert all(end_values(theta_f - nine, n) == (0, 0) for n in range(1, 5))


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


def test_table_6_2_gives_8_27_and_92_2_hz():
    """`erratum-figure-6-3`: poles and zeros of (6.14), and what 7 and 120 Hz would need."""
    np.testing.assert_allclose(
        pairs_of(state_matrix(INERTIAS, SPRINGS, DAMPERS)), [[8.27, 92.2], [0.147, 0.173]], rtol=4e-3
    )
    held = state_matrix(INERTIAS[1:], SPRINGS[1:, 1:], DAMPERS[1:, 1:])
    np.testing.assert_allclose(pairs_of(held)[0], [5.36, 73.7], rtol=1e-3)
    for joint, cable, mode, hertz in ((JOINT, KK * 606 / 850, 0, 7.0), (229.0, KK, 1, 120.0)):
        found = pairs_of(state_matrix(INERTIAS, link_matrix([joint, cable]), 0 * DAMPERS))[0]
        assert found[mode] == pytest.approx(hertz, rel=3e-3)


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
    printed, (_, x4, _, x6) = printed_state_form(model), X
    for true, line in zip(state_form(model, models(b_m=0, bb=0)[model]), printed, strict=True):
        assert is_zero(true - line)
    lost = [true - line for true, line in zip(state_form(model, models()[model]), printed, strict=True)]
    load, drive = bb * x4 / J2, (b_m * x6 - bb * x4) / J12
    if model == 2:
        load = b_m * x4 / (J2 + J12)
    ends = {
        2: [-b_m * x4 / J11 - load],
        3: [-bb * x4 / J1 - load],
        4: [drive - load, -b_m * x6 / J11 - drive],
    }
    for found, expected in zip(lost, [load, *(BETAS[model] * end for end in ends[model])], strict=True):
        assert is_zero(found - expected)
    if model == 3:
        assert not is_zero(state_form(3, models(bb=0)[3])[1] / BETAS[3] - printed[1])


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


# --- the encoder that the laws of Models 1 and 3 mean by theta_1 ------------------------------------------


def law_of_model_3(encoder):
    """Row of u = L x of (6.53), nominal parameters; theta_1 read at the motor (0) or the drive pulley (1)."""
    lam, unit = 2 * np.pi * 11.0, np.eye(6)
    twist, twist_rate = unit[encoder] - unit[2], unit[encoder + 3] - unit[5]
    z = unit[2], unit[5], BETA * twist, BETA * twist_rate
    sigma = z[3] + 3 * lam * z[2] + 3 * lam**2 * z[1] + lam**3 * z[0]
    z_eq = -3 * lam * z[3] - 3 * lam**2 * z[2] - lam**3 * z[1]
    feedforward = oracles.J2 * z[2] + oracles.J1 * (z[2] + z_eq / BETA) + VISCOUS * (twist_rate + unit[5])
    return feedforward - 2 * np.pi * 13.0 * oracles.J1 / BETA * sigma


def law_of_model_1(encoder, bandwidth):
    """Row of u = L x of (6.20); K_sigma = 13/11 lambda mu as in Model 3, for none is printed."""
    unit, lam, inertia = np.eye(6), 2 * np.pi * bandwidth, sum(INERTIAS)
    angle, rate = unit[encoder], unit[encoder + 3]
    return -lam * inertia * rate + VISCOUS * rate - 13 / 11 * lam * inertia * (rate + lam * angle)


def least_damped(row):
    """Frequency [Hz] and damping ratio of the least damped mode in the loop of Model 4."""
    torque = np.array([0, 0, 0, 1 / oracles.J11, 0, 0])
    values = np.linalg.eigvals(state_matrix(INERTIAS, SPRINGS, DAMPERS) + np.outer(torque, row))
    worst = max(values[np.abs(values) > 1e-6], key=lambda value: value.real / abs(value))
    return abs(worst) / (2 * np.pi), -worst.real / abs(worst)


def test_models_1_and_3_need_the_motor_encoder():
    """`convention-theta-1`: the drive pulley's loses the joint mode, Model 1 from 7 Hz of bandwidth on."""
    assert least_damped(law_of_model_3(0))[1] > 0.2
    frequency, ratio = least_damped(law_of_model_3(1))
    assert ratio < -0.03
    assert frequency == pytest.approx(98, abs=1)
    motor, pulley = ([least_damped(law_of_model_1(e, f))[1] for f in (3, 6, 7, 11, 20)] for e in (0, 1))
    assert min(motor) > 0.05
    assert [ratio > 0 for ratio in pulley] == [True, True, False, False, False]
