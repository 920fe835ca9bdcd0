"""Models 1-4 of Section 6.2 and their sliding surfaces: what the print derives rightly, derived again."""

from itertools import pairwise
from math import comb

import numpy as np
import pytest
import sympy as sp

U, D, S, LAMBDA, K_SIGMA = sp.symbols("u d S lambda K_sigma")
J11, J12, J1, J2, K, R, KM, B1 = sp.symbols("J_11 J_12 J_1 J_2 k r k_m b_1", positive=True)
P2, P3, P4, P5 = P = sp.symbols("p_2:6")  # inertia at the motor, b1, c1, d0
HATS = sp.symbols("phat_2:6")
KK = 2 * K * R**2


def surface(x, rates, order):
    """Derivatives of y = x1 along the flow; sigma = (s + lambda)^(order-1) z1; z_eq of the print; sigma'."""
    references = sp.symbols(f"yd0:{order + 1}")
    outputs = [x[0]]
    for _ in range(order):
        slopes = [sp.diff(outputs[-1], xi) * rate for xi, rate in zip(x, rates, strict=True)]
        outputs.append(sp.expand(sum(slopes)))
    z = [y - yd for y, yd in zip(outputs, references, strict=True)]
    weights = [comb(order - 1, i) * LAMBDA ** (order - 1 - i) for i in range(order)]
    sigma = sum(w * zi for w, zi in zip(weights, z[:-1], strict=True))
    rate = sum(w * zi for w, zi in zip(weights, z[1:], strict=True))
    z_eq = references[-1] - sum(w * zi for w, zi in zip(weights[:-1], z[1:-1], strict=True))
    return outputs, sigma, z_eq, rate


def check_law(mu, rate, sigma, known, regressor):
    """Mu sigma' is u + known + phi p + d, and the printed law leaves mu sigma' + K sigma = -phi p~ + d."""
    surface_dynamics = U + known + sum(f * p for f, p in zip(regressor, P, strict=True)) + D
    assert sp.simplify(mu * rate - surface_dynamics) == 0
    law = -known - sum(f * p for f, p in zip(regressor, HATS, strict=True)) - K_SIGMA * sigma
    errors = sum(f * (h - p) for f, h, p in zip(regressor, HATS, P, strict=True))
    assert sp.simplify(surface_dynamics.subs(U, law) + K_SIGMA * sigma + errors - D) == 0


def test_model_2_surface_and_law_follow_from_6_10_without_joint_damping():
    """`confirmed-6-39-model-2`: (6.39)-(6.45) with b_m = 0."""
    x = _, x2, x3, x4 = sp.symbols("x1:5")
    beta = KM / (J2 + J12)
    drive = U - P3 * (x2 + x4) - P4 * S + P5 + D
    rates = (x2, beta * x3, x4, (drive - KM * x3) / P2 - beta * x3)
    assert sp.simplify(P2 * rates[3] - (drive - (P2 + KM / beta) * beta * x3)) == 0  # (6.39d)
    _, sigma, z_eq, rate = surface(x, rates, 4)
    regressor = (-beta * x3 - z_eq / beta, -(x2 + x4), -S, 1)
    check_law(P2 / beta, rate, sigma, -KM * x3, regressor)


def test_model_3_surface_and_law_follow_from_6_11_without_cable_damping():
    """`confirmed-6-46-model-3`: (6.46)-(6.56) with b_c = 0; x4bar' in (6.47d), fourth derivative in z_eq."""
    x = _, x2, x3, x4 = sp.symbols("x1:5")
    beta = KK / J2
    drive = U - P3 * (x2 + x4) - P4 * S + P5 + D
    rates = (x2, beta * x3, x4, (drive - KK * x3) / P2 - beta * x3)
    assert sp.simplify(P2 * rates[3] - (drive - (J2 + P2) * beta * x3)) == 0  # (6.47d) with x4bar'/beta
    _, sigma, z_eq, rate = surface(x, rates, 4)
    regressor = (-beta * x3 - z_eq / beta, -(x2 + x4), -S, 1)
    check_law(P2 / beta, rate, sigma, -J2 * beta * x3, regressor)


def test_model_4_surface_and_law_follow_from_6_13_without_damping():
    """`confirmed-6-57-model-4`: (6.57)-(6.65) with b_m = b_c = 0."""
    x = _, x2, x3, x4, x5, x6 = sp.symbols("x1:7")
    beta = KK / J2
    speed = x2 + x4 + x6
    drive = U - P3 * speed - P4 * S + P5 + D
    pulley = (KM * x5 - KK * x3) / J12
    rates = (x2, beta * x3, x4, pulley - beta * x3, x6, (drive - KM * x5) / P2 - pulley)
    printed = drive + P2 * KK / J12 * x3 - KM * (1 + P2 / J12) * x5
    assert sp.simplify(P2 * rates[5] - printed) == 0  # (6.58f)
    outputs, sigma, z_eq, rate = surface(x, rates, 6)
    x3_bar, x4_bar_rate, x5_bar = beta * x3, beta * rates[3], beta * x5
    assert sp.simplify(outputs[4] - (-KK * (1 / J12 + 1 / J2) * x3_bar + KM / J12 * x5_bar)) == 0  # (6.59e)
    phi2 = J12 / KM * ((1 + J2 / J12) * x4_bar_rate + z_eq / beta)
    phi2 -= J2 / J12 * x3_bar - KM / (beta * J12) * x5_bar
    check_law(P2 * J12 / (beta * KM), rate, sigma, -KM * x5, (-phi2, -speed, -S, 1))


def test_transfer_function_6_12_is_the_response_of_6_11():
    """`confirmed-6-12-model-3-response`: motor speed over torque of two inertias, dampings included."""
    s, bc = sp.symbols("s b_c", positive=True)
    drive, load = sp.symbols("w_1 w_2")
    link = (KK / s + 2 * bc * R) * (drive - load)
    speed = sp.solve([J1 * s * drive - 1 + B1 * drive + link, J2 * s * load - link], (drive, load))[drive]
    numerator = (s**2 + 2 * bc * R / J2 * s + KK / J2) / J1
    quadratic = (B1 + 2 * bc * R) / J1 + 2 * bc * R / J2
    linear = KK / J1 + KK / J2 + 2 * B1 * bc * R / (J1 * J2)
    denominator = s**3 + quadratic * s**2 + linear * s + KK * B1 / (J1 * J2)
    assert sp.simplify(speed - numerator / denominator) == 0


INERTIAS = np.diag([0.0011, 0.000642, 0.00235])  # Table 4.2
SPRING, DAMPER, JOINT, JOINT_DAMPER = 2 * 850 * 0.04**2, 2 * 0.18 * 0.04, 135.0, 0.075  # Table 6.2
VISCOUS = 0.0031


def drive_model_4():
    """State matrix and input of (6.13) without Coulomb friction: angles, then speeds, from motor to load."""
    kinds = []
    for joint, cable in ((JOINT, SPRING), (JOINT_DAMPER, DAMPER)):
        kinds.append(np.array([[joint, -joint, 0], [-joint, joint + cable, -cable], [0, -cable, cable]]))
    stiffness, damping = kinds
    damping[0, 0] += VISCOUS
    inverse = np.linalg.inv(INERTIAS)
    state = np.block([[np.zeros((3, 3)), np.eye(3)], [-inverse @ stiffness, -inverse @ damping]])
    return state, np.r_[0, 0, 0, inverse[0, 0], 0, 0]


def law_of_model_3(encoder, bandwidth=11.0, gain=13.0):
    """Row of u = L x of (6.53), nominal parameters; theta_1 read at the motor (0) or the drive pulley (1)."""
    drive, load, lam = np.trace(INERTIAS[:2, :2]), INERTIAS[2, 2], 2 * np.pi * bandwidth
    beta = SPRING / load
    unit = np.eye(6)
    twist, twist_rate = unit[encoder] - unit[2], unit[encoder + 3] - unit[5]
    z = unit[2], unit[5], beta * twist, beta * twist_rate
    sigma = z[3] + 3 * lam * z[2] + 3 * lam**2 * z[1] + lam**3 * z[0]
    z_eq = -3 * lam * z[3] - 3 * lam**2 * z[2] - lam**3 * z[1]
    feedforward = load * z[2] + drive * (z[2] + z_eq / beta) + VISCOUS * (twist_rate + unit[5])
    return feedforward - 2 * np.pi * gain * drive / beta * sigma


def law_of_model_1(encoder, bandwidth):
    """Row of u = L x of (6.20); K_sigma = 13/11 lambda mu as in Model 3, for none is printed."""
    unit, lam, inertia = np.eye(6), 2 * np.pi * bandwidth, np.trace(INERTIAS)
    angle, rate = unit[encoder], unit[encoder + 3]
    return -lam * inertia * rate + VISCOUS * rate - 13 / 11 * lam * inertia * (rate + lam * angle)


def least_damped(row):
    """Frequency [Hz] and damping ratio of the least damped mode in the loop."""
    state, torque = drive_model_4()
    values = np.linalg.eigvals(state + np.outer(torque, row))
    worst = max(values[np.abs(values) > 1e-6], key=lambda value: value.real / abs(value))
    return abs(worst) / (2 * np.pi), -worst.real / abs(worst)


def test_model_3_needs_the_motor_encoder():
    """`convention-theta-1`: at the printed gains the drive-pulley encoder destabilises the joint mode."""
    _, collocated = least_damped(law_of_model_3(encoder=0))
    frequency, other = least_damped(law_of_model_3(encoder=1))
    assert collocated > 0.2, f"motor encoder: damping ratio {collocated:.3f}"
    assert other < -0.03, f"drive-pulley encoder: damping ratio {other:.3f}"
    assert frequency == pytest.approx(98, abs=1), f"{frequency:.2f} Hz"


def test_model_1_on_the_drive_pulley_encoder_loses_the_joint_mode_as_bandwidth_grows():
    """`convention-theta-1`: unstable from 7 Hz on; on the motor encoder it stays stable."""
    hertz = (3.0, 6.0, 7.0, 11.0, 20.0)
    motor, pulley = ([least_damped(law_of_model_1(e, f))[1] for f in hertz] for e in (0, 1))
    assert min(motor) > 0.05, f"motor encoder: damping ratios {motor}"
    assert [ratio > 0 for ratio in pulley] == [True, True, False, False, False], f"drive pulley: {pulley}"
    assert all(later < earlier for earlier, later in pairwise(pulley))
