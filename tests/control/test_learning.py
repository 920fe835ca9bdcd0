"""Cable and motor identified from one pulse of readings, and the errors."""

from functools import cache

import numpy as np
import pytest

from cabledrive.control.flat_output import flat_output
from cabledrive.control.load_equation import estimate_load, load_coefficients
from cabledrive.control.momentum_sum import acting_torque, estimate_motor, motor_coefficients
from cabledrive.control.reference import flat_reference, joint_motion
from cabledrive.control.regression import filtered, least_squares
from cabledrive.trajectories import pulse
from control_chains import INTERVAL, model

COUNTS = 2.0 * np.pi / np.array([2600.0, 10000.0, 10000.0])
CHAIN = model(4)
BETA, GAMMA = CHAIN.stiffness[-1] / CHAIN.inertias[-1], CHAIN.damping[-1] / CHAIN.inertias[-1]
WHOLE = np.array([sum(CHAIN.inertias), CHAIN.viscous[0], CHAIN.coulomb[0], CHAIN.offsets[0]])


@cache
def motion() -> tuple[np.ndarray, np.ndarray]:
    """Angles of every shaft in one pulse, and the mean torque over each sample, friction included."""
    flat = flat_output(CHAIN)
    y = pulse(0.785, 0.5, 0.5)(np.arange(0.0, 2.0, INTERVAL), 6)
    rows = flat_reference(flat, y, INTERVAL)
    states, elastic = joint_motion(flat, rows)
    speed, acceleration = rows[:, -2], rows[:, -1]
    torque = CHAIN.inertias[0] * acceleration + elastic
    torque += CHAIN.viscous[0] * speed + CHAIN.coulomb[0] * np.sign(speed) - CHAIN.offsets[0]
    after = np.append(torque[1:], torque[-1])
    return states[:, :3], 0.5 * (torque + after)


def counted(angles: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Readings of encoders that start anywhere within a count."""
    phases = rng.uniform(-0.5, 0.5, angles.shape[1])
    return COUNTS * np.rint(angles / COUNTS + phases)


def test_filter_gives_the_derivatives_of_a_slow_sine():
    """Behind 1/(1 + s/w)^3, to the second order of the sample time."""
    time = np.arange(0.0, 3.0, INTERVAL)
    rate, w = 2.0 * np.pi * 2.0, 2.0 * np.pi * 10.0
    found = filtered(np.sin(rate * time), INTERVAL, 10.0)[:, -5000:]
    response = np.exp(1j * rate * time[-5000:]) / (1.0 + 1j * rate / w) ** 3
    for order, row in enumerate(found):
        exact = np.imag((1j * rate) ** order * response)
        assert np.abs(row - exact).max() < 1e-5 * np.abs(exact).max()


def test_load_equation_is_exact_without_counts():
    angles, _ = motion()
    beta, gamma, constant, coulomb, viscous = load_coefficients(angles[:, 1:], INTERVAL)
    assert beta == pytest.approx(BETA, rel=1e-5)
    assert gamma == pytest.approx(GAMMA, rel=1e-3)
    assert abs(constant) < 1e-3
    assert abs(coulomb) < 1e-3
    assert abs(viscous) < 1e-3


def test_one_pulse_of_counts_gives_beta_within_a_fifth_of_a_per_cent():
    angles, _ = motion()
    for seed in range(6):
        rng = np.random.default_rng(seed)
        found = estimate_load(counted(angles, rng)[:, 1:], COUNTS[1:], INTERVAL, rng)
        assert found.excited
        assert found.beta == pytest.approx(BETA, rel=2e-3)
        assert found.gamma == pytest.approx(GAMMA, rel=0.1)
        assert found.misfit < 1.3, f"observed {found.misfit:.2f}"
        assert 2e-5 < found.beta_error / BETA < 1e-3, f"observed {found.beta_error / BETA:.1e}"


def rubbed(coulomb: float, viscous: float, extra: np.ndarray | float = 0.0) -> np.ndarray:
    """Angles before the load and of it in a pulse, with friction of the load; the twist by its own equation.

    gamma twist' + beta twist = y'' + coulomb sgn(y') + viscous y' + extra, integrated in exact short steps.
    """
    finer = 20
    time = np.arange(0.0, 2.0, INTERVAL / finer)
    y = pulse(0.785, 0.5, 0.5)(time, 2)
    pull = y[2] + coulomb * np.sign(y[1]) + viscous * y[1] + extra
    fading = np.exp(-BETA / GAMMA * INTERVAL / finer)
    twist = np.zeros(len(time))
    for i in range(1, len(time)):
        twist[i] = fading * twist[i - 1] + (1.0 - fading) * pull[i] / BETA
    return np.column_stack((y[0] + twist, y[0]))[::finer]


@pytest.mark.parametrize("coulomb, viscous", [(2.0, 0.0), (8.5, 0.0), (0.0, 0.8), (8.5, 0.4)])
def test_friction_of_the_load_is_not_taken_for_a_softer_cable(coulomb, viscous, measured):
    """8.5 rad/s^2 are 0.02 N m; beta within 0.2 %, and both frictions, from counts."""
    angles = rubbed(coulomb, viscous)
    worst, held = 0.0, 0
    for seed in range(8):
        rng = np.random.default_rng(seed)
        found = estimate_load(counted_pair(angles, rng), COUNTS[1:], INTERVAL, rng)
        assert found.excited, found
        worst = max(worst, abs(found.beta / BETA - 1.0))
        held += found.coulomb_interval[0] <= coulomb <= found.coulomb_interval[1]
        assert found.coulomb == pytest.approx(coulomb, abs=min(1.0, 4.0 * found.coulomb_error))
        assert found.viscous == pytest.approx(viscous, abs=min(0.5, 4.0 * found.viscous_error))
    measured(f"beta {100 * worst:.3f} % at most; {held} of 8 intervals hold the Coulomb friction")
    assert worst < 2e-3, f"observed {worst:.1e}"


def test_a_load_that_does_not_obey_the_equation_teaches_nothing(measured):
    """A torque of the load's position, 12 per radian, as a bent shaft or a gear makes it."""
    time = np.arange(0.0, 2.0, INTERVAL / 20)
    cogging = 3.0 * np.sin(12.0 * pulse(0.785, 0.5, 0.5)(time, 0)[0] * 2.0 * np.pi)
    rng = np.random.default_rng(1)
    found = estimate_load(counted_pair(rubbed(0.0, 0.0, cogging), rng), COUNTS[1:], INTERVAL, rng)
    measured(f"residual {found.misfit:.1f} times that of rounding")
    assert not found.believed
    assert not found.excited


def counted_pair(angles: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Readings of the last two encoders that start anywhere within a count."""
    return COUNTS[1:] * np.rint(angles / COUNTS[1:] + rng.uniform(-0.5, 0.5, 2))


def test_an_encoder_zero_off_by_a_count_is_taken_by_the_constant():
    angles, _ = motion()
    plain = load_coefficients(angles[:, 1:], INTERVAL)
    shifted = load_coefficients(angles[:, 1:] + np.array([0.6e-3, 0.0]), INTERVAL)
    np.testing.assert_allclose(shifted[:2], plain[:2], rtol=1e-9)
    assert shifted[2] == pytest.approx(plain[2] - plain[0] * 0.6e-3, rel=1e-9)


def test_momentum_sum_is_exact_without_counts():
    angles, torque = motion()
    found = motor_coefficients(angles, torque, np.array(CHAIN.inertias), INTERVAL)
    assert np.all(np.abs(found[:3] / WHOLE[:3] - 1.0) < [1e-4, 2e-3, 1e-3]), found / WHOLE
    assert found[3] == pytest.approx(WHOLE[3], abs=1e-6)


def test_momentum_sum_gives_inertia_and_friction_from_counts():
    angles, torque = motion()
    rng = np.random.default_rng(3)
    found = estimate_motor(
        counted(angles, rng), torque, COUNTS, np.array(CHAIN.inertias), INTERVAL, rng, spread=np.full(3, 0.05)
    )
    assert found.excited
    off = np.abs(found.values[:3] / WHOLE[:3] - 1.0)
    assert np.all(off < [0.01, 0.05, 0.02]), f"observed {off}"
    assert np.all(found.errors > 0.0)


def test_nothing_is_learnt_from_nothing():
    """At rest, within one count, or creeping: not excited, and no number is pretended."""
    rng = np.random.default_rng(0)
    rest = np.zeros((4000, 3))
    creep = counted(np.linspace(0.0, 3e-3, 4000)[:, None] * np.ones(3), rng)
    flicker = COUNTS * rng.integers(0, 2, (4000, 3))
    inertias = np.array(CHAIN.inertias)
    for readings in (rest, creep, flicker):
        assert not estimate_load(readings[:, 1:], COUNTS[1:], INTERVAL, rng).excited
        assert not estimate_motor(readings, np.zeros(4000), COUNTS, inertias, INTERVAL, rng).excited


def test_regressors_that_say_the_same_leave_everything_unknown():
    line = np.linspace(0.0, 1.0, 50)
    assert np.all(np.isnan(least_squares(np.column_stack((line, 2.0 * line)), line, line > 0.1)))
    assert np.all(np.isnan(least_squares(np.column_stack((line, line**2)), line, line > 2.0)))


def test_acting_torque_is_the_mean_of_what_the_torque_loop_passes():
    """A step: late by the delay, then 1 - exp(-w t); means over each sample."""
    rate, delay, h = 2000.0, 1.5 * INTERVAL, INTERVAL
    command = np.ones(12)
    found = acting_torque(command, h, delay=delay, current_rate=rate)
    fine = np.arange(0.0, 12 * h, h / 2000) + h / 4000
    exact = np.where(fine > delay, 1.0 - np.exp(-rate * (fine - delay)), 0.0).reshape(12, 2000).mean(axis=1)
    assert found[0] == 0.0
    np.testing.assert_allclose(np.cumsum(found)[-1], np.cumsum(exact)[-1], atol=2e-3)
    np.testing.assert_allclose(acting_torque(command, h), command)
