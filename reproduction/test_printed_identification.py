"""Chapter 4 of the dissertation: the friction regressor of (4.8), the response (4.19), its tables."""

import numpy as np
import pytest
import sympy as sp
from scipy.signal import bilinear, lfilter

INERTIA, VISCOUS, COULOMB, OFFSET = 0.001742, 0.0035, 0.041, -0.0006  # near Table 4.1, motor and drive pulley
SAMPLE_RATE, SUBSTEPS, DURATION, DROPPED = 1000, 10, 20.0, 0.5  # Hz, per sample, s, s of filter transient
CORNER, VOLT = 2 * np.pi * 20.0, 1.6218  # filter of (4.1) with damping 1 [rad/s]; N m per volt, (4.20)
NARROW = 50.0


def log(hertz, smoothing=None):
    """Torque and angle of an axis with stick-slip Coulomb friction, or with c tanh(K w) where K is given.

    The implicit step solves J (w - w_old)/h + b w + c S(w) = torque + offset exactly for the set-valued sign.
    """
    h = 1 / (SAMPLE_RATE * SUBSTEPS)
    time = np.arange(int(DURATION / h)) * h
    torque = sum(0.1 * VOLT * np.sin(2 * np.pi * f * time) for f in hertz)
    speed, speeds = 0.0, []
    for applied in (torque + OFFSET).tolist():
        free = INERTIA * speed + h * applied
        if smoothing is None:
            sliding = np.sign(free) * max(abs(free) - h * COULOMB, 0.0)
        else:
            sliding = free - h * COULOMB * np.tanh(smoothing * speed)
        speed = sliding / (INERTIA + h * VISCOUS)
        speeds.append(speed)
    angle = np.cumsum(speeds) * h
    return torque[::SUBSTEPS], angle[::SUBSTEPS]


def filtered(signal, numerator):
    """Signal through (4.1), whose numerator s^2 or s differentiates besides."""
    b, a = bilinear(numerator, [1.0, 2 * CORNER, CORNER**2], SAMPLE_RATE)
    return lfilter(b, a, signal)


def regress(torque, angle, smoothing):
    """Least-square J, b, c, d of (4.10) with the regressor tanh(K w)."""
    unit = [CORNER**2]
    friction = np.tanh(smoothing * np.gradient(angle, 1 / SAMPLE_RATE))
    columns = [
        filtered(angle, [CORNER**2, 0.0, 0.0]),
        filtered(angle, [CORNER**2, 0.0]),
        filtered(friction, unit),
        filtered(-np.ones_like(angle), unit),
    ]
    first = int(DROPPED * SAMPLE_RATE)
    regressors, right = np.column_stack(columns)[first:], filtered(torque, unit)[first:]
    return np.linalg.lstsq(regressors, right, rcond=None)[0]


def noisy(angle, torque):
    """Angle and torque with the quantisation of the 2600-count encoder and 2 mN m of seeded noise."""
    rng = np.random.default_rng(48)
    count = 2 * np.pi / 2600
    return torque + rng.normal(0.0, 2e-3, torque.size), np.round(angle / count + rng.uniform()) * count


def test_wide_smoothing_turns_coulomb_friction_into_negative_viscosity():
    """`erratum-4-8-smoothing`: of b 0.0035, c 0.041, tanh(0.5 w) makes b < 0, c = 0.065 to 0.067."""
    torque, angle = log((3.0, 4.0))
    for pair in ((torque, angle), noisy(angle, torque)):
        _, viscous, coulomb, _ = regress(*pair, smoothing=0.5)
        assert -0.001 < viscous < 0.0, f"b = {viscous:.5f} N m s"
        assert 0.063 < coulomb < 0.069, f"c = {coulomb:.4f} N m"


def test_narrow_smoothing_reads_coulomb_friction_as_it_is():
    """`erratum-4-8-smoothing`: the same log and a nearly signum regressor: b, c within 5 %."""
    _, viscous, coulomb, _ = regress(*log((3.0, 4.0)), smoothing=NARROW)
    assert viscous == pytest.approx(VISCOUS, rel=0.05), f"b = {viscous:.5f} N m s"
    assert coulomb == pytest.approx(COULOMB, rel=0.05), f"c = {coulomb:.4f} N m"


def test_wide_smoothing_is_right_only_for_friction_of_its_own_shape():
    """`erratum-4-8-smoothing`: b, c return, to the sampling error, from a log of c tanh(0.5 w)."""
    inertia, viscous, coulomb, _ = regress(*log((3.0, 4.0), smoothing=0.5), smoothing=0.5)
    np.testing.assert_allclose((inertia, viscous, coulomb), (INERTIA, VISCOUS, COULOMB), rtol=0.03)


def test_bias_of_the_wide_smoothing_depends_on_the_excitation():
    """`erratum-4-8-smoothing`: 1 + 3 + 5 Hz at 0.1 V reaches 22 rad/s; c is a tenth too large."""
    _, viscous, coulomb, _ = regress(*log((1.0, 3.0, 5.0)), smoothing=0.5)
    assert coulomb == pytest.approx(1.09 * COULOMB, rel=0.02), f"c = {coulomb:.4f} N m"
    assert viscous == pytest.approx(0.93 * VISCOUS, rel=0.02), f"b = {viscous:.5f} N m s"


def transfer_function_4_19():
    """Motor speed over torque from (4.18); (4.19): first line, numerator, denominator, missing term."""
    s, j11, j12, b1, bm, km = sp.symbols("s J_11 J_12 b_1 b_m k_m", positive=True)
    speed, twist_speed = sp.symbols("w_11 w_12")
    link = (km / s + bm) * (speed - twist_speed)
    balance = [j11 * s * speed - 1 + b1 * speed + link, j12 * s * twist_speed - link]
    exact = sp.solve(balance, (speed, twist_speed))[speed]
    drive, pulley = j11 * s**2 + (b1 + bm) * s + km, j12 * s**2 + bm * s + km
    first = pulley * s / (drive * pulley - (km + bm * s) ** 2)
    numerator = s**2 / j11 + bm / (j11 * j12) * s + km / (j11 * j12)
    linear = km / j11 + km / j12 + b1 * bm / (j11 * j12)
    denominator = s**3 + bm * (1 / j11 + 1 / j12) * s**2 + linear * s + b1 * km / (j11 * j12)
    return exact, first, numerator, denominator, b1 / j11 * s**2


def test_first_line_of_4_19_is_the_response_of_4_18():
    """`confirmed-4-19-first-line`: it follows from the two equations of motion."""
    exact, first, *_ = transfer_function_4_19()
    assert sp.simplify(exact - first) == 0


def test_second_line_of_4_19_lacks_the_motor_friction():
    """`erratum-4-19-second-line`: with b1/J11 added to the s^2 coefficient the lines agree."""
    _, first, numerator, denominator, missing = transfer_function_4_19()
    assert sp.simplify(first - numerator / (denominator + missing)) == 0
    assert sp.simplify(first - numerator / denominator) != 0


def test_inertias_of_table_4_2_are_the_differences_of_table_4_1():
    """`number-inertias`: J12 = 0.001742 - 0.0011, J2 = 0.00345 - 0.0011, J1 = J11 + J12."""
    motor, with_drive, with_load = 0.0011, 0.001742, 0.00345
    assert with_drive - motor == pytest.approx(0.000642, abs=1e-9)
    assert with_load - motor == pytest.approx(0.00235, abs=1e-9)


def test_joint_of_4_19_rings_at_73_and_92_hertz():
    """`number-joint-pair`: k_m = 135 gives 73.0 Hz (anti-resonance) and 91.8 Hz, "near 100 Hz"."""
    anti = np.sqrt(135 / 0.000642) / (2 * np.pi)
    resonance = np.sqrt(135 * (1 / 0.0011 + 1 / 0.000642)) / (2 * np.pi)
    assert (f"{anti:.1f}", f"{resonance:.1f}") == ("73.0", "91.8"), f"{anti:.3f}, {resonance:.3f} Hz"


def test_friction_estimates_of_table_4_1_double_between_rigs():
    """`erratum-table-4-1-consistency`: b1 grows 2.3 and c1 1.9 times from motor to load-pulley rig."""
    motor_only, with_load_pulley = np.array([0.00216, 0.024]), np.array([0.005, 0.045])
    np.testing.assert_allclose(with_load_pulley / motor_only, [2.3, 1.9], atol=0.05)


def test_lines_of_4_14_are_closer_than_the_window_resolves():
    """`erratum-4-14-line-spacing`: 1000 sines from 1 to 500 Hz are 0.5 Hz apart; a 1 s window sees 1 Hz."""
    spacing = (500.0 - 1.0) / (1000 - 1)
    time = np.arange(5000) / 5000.0
    hann = np.hanning(5000)
    leak = abs(np.sum(hann * np.exp(2j * np.pi * spacing * time))) / np.sum(hann)
    assert spacing == pytest.approx(0.4995, abs=1e-4)
    assert leak > 0.8, f"the neighbouring line is seen with {leak:.2f} of its amplitude"
