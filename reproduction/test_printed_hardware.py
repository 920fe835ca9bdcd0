"""Tables A.1-A.3, Section 4.1 and configuration 3 of the dissertation: arithmetic on the printed data."""

from math import log10, pi

import numpy as np
import pytest

GEAR, ROTOR, GEARHEAD = 5.2, 536e-7, 109e-7  # Tables A.1, A.3; kg m^2
NOMINAL_TORQUE, NOMINAL_SPEED, TORQUE_CONSTANT = 0.405, 5680.0, 38.5e-3  # N m, rpm, N m/A
ENCODER_STEP = 360.0 / 10_000  # deg, drive and load pulleys


def test_rotor_alone_is_heavier_than_the_printed_motor_inertia():
    """`erratum-table-4-1-reflected-inertia`: through 5.2 the rotor is 1.449e-3, with gearhead 1.744e-3."""
    rotor, both = GEAR**2 * ROTOR, GEAR**2 * (ROTOR + GEARHEAD)
    assert rotor == pytest.approx(1.449e-3, abs=5e-7), f"{rotor:.4e}"
    assert both == pytest.approx(1.744e-3, abs=5e-7), f"{both:.4e}"
    assert rotor > 1.3 * 0.0011, "Table 4.1 prints 0.0011 for the motor at the output shaft"
    assert both == pytest.approx(0.001742, rel=2e-3), "which Table 4.1 prints for motor and drive pulley"


def test_rotor_inertia_agrees_with_the_time_constant_of_the_same_table():
    """`erratum-table-4-1-reflected-inertia`: J R/k_t^2 is 3.72 ms, 3.75 printed."""
    time_constant = ROTOR * 0.103 / TORQUE_CONSTANT**2
    assert time_constant == pytest.approx(3.75e-3, rel=0.01), f"{1e3 * time_constant:.3f} ms"


def test_240_watts_are_nominal_torque_times_nominal_speed():
    """`erratum-4-1-motor-power`: 0.405 N m at 5680 rpm is 240.9 W; Table A.1 names the motor 200 Watt."""
    power = NOMINAL_TORQUE * NOMINAL_SPEED * 2 * pi / 60
    assert int(power) == 240, f"{power:.2f} W"


def test_output_ratings_follow_from_the_gear():
    """`number-motor-ratings`: through 5.2 they become 2.1 N m, 1092 rpm, 2600 counts."""
    assert f"{NOMINAL_TORQUE * GEAR:.1f}" == "2.1"
    assert int(NOMINAL_SPEED / GEAR) == 1092
    assert round(500 * GEAR) == 2600


def test_nominal_torque_is_not_the_largest_achievable_one():
    """`erratum-4-1-achievable-torque`: at stall 46 N m; the gearhead takes 12 N m briefly."""
    stall = 8.92 * GEAR
    assert stall == pytest.approx(46.4, abs=0.05), f"{stall:.2f} N m"
    assert NOMINAL_TORQUE * GEAR < 12.0 < stall


def test_nominal_speed_is_beyond_the_recommended_gearhead_input():
    """`erratum-table-a-3-input-speed`: 3000 rpm at the input is 577 rpm at the output, not 1092."""
    recommended = 3000.0
    assert round(recommended / GEAR) == 577
    assert recommended / GEAR < NOMINAL_SPEED / GEAR


def test_backlash_is_many_times_the_claimed_tracking_error():
    """`erratum-table-a-3-backlash`: 1.0 deg of backlash is 18 times 0.055 deg."""
    backlash, tracking_error = 1.0, 0.055
    assert round(backlash / tracking_error) == 18


def test_amplifier_gain_of_4_2_decibel():
    """`number-amplifier-gain`: 10^(4.2/20) = 1.6218 N m/V and its inverse 0.6166 V/(N m)."""
    gain = 10 ** (4.2 / 20)
    assert (f"{gain:.4f}", f"{1 / gain:.4f}") == ("1.6218", "0.6166")


def test_4_2_decibel_belong_to_the_torque_not_to_the_current():
    """`erratum-4-20-current`: 1.6218 N m/V at the output shaft is 8.1 A/V or 18.2 dB."""
    amperes_per_volt = 1.6218 / (TORQUE_CONSTANT * GEAR)
    assert 20 * log10(amperes_per_volt) == pytest.approx(18.2, abs=0.05), f"{amperes_per_volt:.3f} A/V"
    assert amperes_per_volt < 10.8 < 1.6218 / TORQUE_CONSTANT


def test_encoder_steps_behind_the_tracking_claims():
    """`number-rig-results`: 0.036 deg; 0.17 deg is about five steps, 0.055 deg less than two."""
    assert f"{ENCODER_STEP:.3f}" == "0.036"
    assert 4.5 < 0.17 / ENCODER_STEP < 5.5
    assert 0.055 / ENCODER_STEP < 2


def test_axial_stiffness_is_half_of_the_fitted_spring():
    """`erratum-table-6-1-stiffness`: EA/L = 438 N/m; k = 850 N/m is 1.94 times that."""
    stiffness = 3e9 * 1.46e-7 / 1.0
    assert stiffness == pytest.approx(438.0)
    fitted = 850.0
    assert fitted / stiffness == pytest.approx(1.94, abs=5e-3)
    assert 2 * stiffness / fitted == pytest.approx(1.03, abs=2e-3), "both spans together come within 3 %"


def test_table_6_2_has_no_mode_at_7_or_120_hertz():
    """`erratum-fig-6-3-frequencies`: poles at 8.27, 92.2 Hz; zeros at 5.36, 73.7 Hz."""
    k, b_c, k_m, b_m, r, b1 = 850.0, 0.18, 135.0, 0.075, 0.04, 0.0031
    kk, bb = 2 * k * r**2, 2 * b_c * r
    mass = np.diag([0.0011, 0.000642, 0.00235])
    damping = np.array([[b1 + b_m, -b_m, 0.0], [-b_m, b_m + bb, -bb], [0.0, -bb, bb]])
    stiffness = np.array([[k_m, -k_m, 0.0], [-k_m, k_m + kk, -kk], [0.0, -kk, kk]])

    def oscillating(first):
        m, c, s = (matrix[first:, first:] for matrix in (mass, damping, stiffness))
        size, inverse = m.shape[0], np.linalg.inv(m)
        state = np.block([[np.zeros((size, size)), np.eye(size)], [-inverse @ s, -inverse @ c]])
        values = np.linalg.eigvals(state)
        return np.sort(np.abs(values[values.imag > 1.0])) / (2 * pi)

    np.testing.assert_allclose(oscillating(0), [8.27, 92.2], rtol=6e-4)
    np.testing.assert_allclose(oscillating(1), [5.36, 73.7], rtol=6e-4)  # motor held: zeros at the motor
