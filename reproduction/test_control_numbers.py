"""Errata of the numbers in Chapter 6: tables, bounds, frequencies and torques from the printed data."""

import math

import numpy as np
import pytest

# Tables 4.1, 4.2, 6.1 and 6.2
J1, J11, J12, J2 = 0.001742, 0.0011, 0.000642, 0.00235  # kg m^2
RADIUS, STIFFNESS = 0.04, 850.0  # m, N/m per span
CABLE_DAMPING, JOINT_STIFFNESS, JOINT_DAMPING = 0.18, 135.0, 0.075  # N s/rad, N m/rad, N m s/rad
VISCOUS, COULOMB = 0.0031, 0.0376  # N m s/rad, N m

KK = 2 * STIFFNESS * RADIUS**2  # rotational stiffness of both spans, N m/rad
BB = 2 * CABLE_DAMPING * RADIUS  # and their damping, N m s/rad
BETA = KK / J2


def frequency_response(frequency_hz, k_m=JOINT_STIFFNESS, b_m=JOINT_DAMPING, kk=KK, bb=BB):
    """Motor speed over torque of (6.13), (6.14) as it should be, by the impedances of the chain."""
    s = 2j * np.pi * frequency_hz
    cable, joint = kk + bb * s, k_m + b_m * s
    load = J2 * s**2
    drive = J12 * s**2 + cable * load / (cable + load)
    motor = J11 * s**2 + VISCOUS * s + joint * drive / (joint + drive)
    return s / motor


def natural_frequencies(inertias, stiffness, damping):
    """Natural frequencies [Hz] and damping ratios of the oscillatory modes of a chain, ascending."""
    n = len(inertias)
    inverse = np.diag(1 / np.array(inertias))
    matrix = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])
    poles = np.linalg.eigvals(matrix)
    poles = sorted(poles[poles.imag > 1e-3], key=abs)
    return np.abs(poles) / (2 * np.pi), np.array([-p.real / abs(p) for p in poles])


def chain(joint, cable):
    """Stiffness or damping matrix of motor, drive pulley, load pulley."""
    return np.array([[joint, -joint, 0], [-joint, joint + cable, -cable], [0, -cable, cable]])


def test_table_6_2_gives_8_27_and_92_2_hz():
    """`erratum-figure-6-3`: poles and zeros of (6.14), its peaks, and what 7 and 120 Hz would need."""
    stiffness, damping = chain(JOINT_STIFFNESS, KK), chain(JOINT_DAMPING, BB) + np.diag([VISCOUS, 0, 0])
    resonance, ratio = natural_frequencies([J11, J12, J2], stiffness, damping)
    anti_resonance, _ = natural_frequencies([J12, J2], stiffness[1:, 1:], damping[1:, 1:])
    np.testing.assert_allclose(resonance, [8.27, 92.2], rtol=1e-3)
    np.testing.assert_allclose(ratio, [0.147, 0.173], rtol=5e-3)
    np.testing.assert_allclose(anti_resonance, [5.36, 73.7], rtol=1e-3)

    frequency = np.linspace(1, 300, 300_000)
    magnitude = np.abs(frequency_response(frequency))
    turning = frequency[1:-1][np.diff(np.sign(np.diff(magnitude))) != 0]
    np.testing.assert_allclose(turning, [5.31, 8.50, 70.7, 98.0], rtol=1e-3)  # minima and maxima in turn

    softer = natural_frequencies([J11, J12, J2], chain(JOINT_STIFFNESS, KK * 606 / STIFFNESS), 0 * damping)[0]
    stiffer = natural_frequencies([J11, J12, J2], chain(229, KK), 0 * damping)[0]
    assert softer[0] == pytest.approx(7, abs=0.02), f"observed {softer[0]:.3f} Hz with k = 606 N/m"
    assert stiffer[1] == pytest.approx(120, abs=0.2), f"observed {stiffer[1]:.2f} Hz with k_m = 229 N m/rad"


def test_bounds_of_section_6_6_1_cross_unless_the_lower_one_is_0_0009():
    """`erratum-6-6-1-bounds`: 0.009 to 0.0013 is empty; 0.0009 makes J11 its middle."""
    upper, printed, corrected = 0.0013, 0.009, 0.0009
    assert printed > upper, "an empty interval"
    assert corrected < J11 < upper
    assert (corrected + upper) / 2 == pytest.approx(J11, rel=1e-12), "J11 is its middle"

    others = {VISCOUS: (0.0029, 0.0033), COULOMB: (0.035, 0.04), -0.0006: (-0.01, 0.01)}
    assert all(low < value < high for value, (low, high) in others.items())
    assert 0.00165 < J1 < 0.00185, "Section 6.5.1, Model 3"


def test_table_6_3_prints_a_tenth_of_p5():
    """`erratum-table-6-3-p5`: the definitions under (6.69) give the rest, and p5 ten times larger."""
    assert pytest.approx(1157, abs=0.5) == BETA
    assert pytest.approx(2718.9, abs=0.05) == (KK / BETA + J1) * BETA / J1
    assert pytest.approx(2059.8, abs=0.1) == VISCOUS * BETA / J1

    p5 = COULOMB * BETA / J1
    assert p5 == pytest.approx(24982, abs=1), f"observed {p5:.1f}"
    assert p5 / 10 == pytest.approx(2498.3, abs=0.05), "the printed digits, one place to the right"
    np.testing.assert_allclose(np.array([2423, 2573]) / (p5 / 10), [0.97, 1.03], atol=5e-4)


def test_table_6_3_p7_lies_outside_its_own_bounds():
    """`erratum-table-6-3-p7`: 1/J1 = 574.05, printed 547; the printed bounds are 3 % about 574."""
    p7, printed, low, high = 1 / J1, 547, 556, 591
    assert p7 == pytest.approx(574.05, abs=0.005), f"observed {p7:.3f}"
    assert not low <= printed <= high
    assert low <= p7 <= high
    np.testing.assert_allclose(np.array([low, high]) / p7, [0.97, 1.03], atol=2e-3)


def slack_torque(radius, pretension, stiffness=STIFFNESS):
    """Torque carried by two spans when the relative angle has just taken the tension from one of them."""
    relative_angle = pretension / (stiffness * radius)  # T0 - k r (theta_1 - theta_2) = 0
    return 2 * stiffness * radius**2 * relative_angle


def test_a_span_goes_slack_far_below_the_torque_limit():
    """`erratum-slack-torque`: 2 r T0, whatever the stiffness."""
    assert slack_torque(0.04, 7.0) == pytest.approx(0.56, rel=1e-12)
    assert slack_torque(0.03, 5.0) == pytest.approx(0.30, rel=1e-12)
    assert slack_torque(0.04, 7.0, stiffness=438.0) == pytest.approx(0.56, rel=1e-12)
    assert slack_torque(0.04, 7.0) < 2.1 / 3


def test_2_1_newton_metre_is_the_rated_torque_through_the_gear():
    """`erratum-maximum-torque`: Table A.1's continuous 405 mN m times 5.2; stalled it gives 22 times that."""
    rated, stall = 0.405 * 5.2, 8.920 * 5.2
    assert rated == pytest.approx(2.1, abs=0.01)
    assert stall == pytest.approx(46.4, abs=0.05)
    assert stall > 12.0 > rated, "Table A.3 lets the gear carry 12 N m intermittently"


def test_beta_is_the_anti_resonance_not_the_natural_frequency():
    """`erratum-6-47-beta`: sqrt(beta) is the load ringing with the drive held; the mode needs J1 as well."""
    no_damping = np.zeros((2, 2))
    mode = natural_frequencies([J1, J2], KK * np.array([[1, -1], [-1, 1]]), no_damping)[0][-1]
    assert math.sqrt(BETA) / (2 * math.pi) == pytest.approx(5.41, abs=0.005)
    assert mode == pytest.approx(8.30, abs=0.005), f"observed {mode:.3f} Hz"
    assert (2 * math.pi * mode) ** 2 == pytest.approx(BETA * (1 + J2 / J1), rel=1e-9)
