"""Section 6.2: the encoder that the laws of Models 1 and 3 mean by theta_1, from the poles of the drive."""

from itertools import pairwise

import numpy as np
import pytest

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
