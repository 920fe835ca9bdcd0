"""Learnt from readings: cable and motor in one pulse, a torque of the load from the filter's innovations."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import StateSpace, lsim

from cabledrive.control.bound import IdealLoop
from cabledrive.control.load_schedule import LoadSchedule
from cabledrive.control.observers import QUIET, Sampling, kalman_filter, whitening
from cabledrive.control.reference import flat_output, joint_motion
from cabledrive.control.regression import estimate_load, estimate_motor, filtered, repetition_learning
from cabledrive.reduction.lumped_chain import state_space
from cabledrive.trajectories import pulse
from control_chains import INTERVAL, carried, flat_rows, model, row_of

COUNTS = 2.0 * np.pi / np.array([2600.0, 10000.0, 10000.0])
CHAIN = model(4)
BETA, GAMMA = CHAIN.stiffness[-1] / CHAIN.inertias[-1], CHAIN.damping[-1] / CHAIN.inertias[-1]
WHOLE = np.array([sum(CHAIN.inertias), CHAIN.viscous[0], CHAIN.coulomb[0], CHAIN.offsets[0]])


@cache
def motion():
    """Angles of every shaft in one pulse, and the mean torque over each sample, friction included."""
    flat = flat_output(CHAIN)
    y = pulse(0.785, 0.5, 0.5)(np.arange(0.0, 2.0, INTERVAL), 6)
    rows = flat_rows(flat, y, INTERVAL)
    states, elastic = joint_motion(flat, rows)
    speed, acceleration = rows[:, -2], rows[:, -1]
    torque = CHAIN.inertias[0] * acceleration + elastic
    torque += CHAIN.viscous[0] * speed + CHAIN.coulomb[0] * np.sign(speed) - CHAIN.offsets[0]
    after = np.append(torque[1:], torque[-1])
    return states[:, :3], 0.5 * (torque + after)


def counted(angles, rng):
    """Readings of the last encoders, which start anywhere within a count."""
    counts = COUNTS[-angles.shape[1] :]
    return counts * np.rint(angles / counts + rng.uniform(-0.5, 0.5, angles.shape[1]))


def test_filter_gives_the_derivatives_of_a_slow_sine():
    """Behind 1/(1 + s/w)^3, to the second order of the sample time."""
    time = np.arange(0.0, 3.0, INTERVAL)
    rate, w = 2.0 * np.pi * 2.0, 2.0 * np.pi * 10.0
    found = filtered(np.sin(rate * time), INTERVAL, 10.0)[:, -5000:]
    response = np.exp(1j * rate * time[-5000:]) / (1.0 + 1j * rate / w) ** 3
    for order, row in enumerate(found):
        exact = np.imag((1j * rate) ** order * response)
        assert np.abs(row - exact).max() < 1e-5 * np.abs(exact).max()


def rubbed(coulomb, viscous):
    """Angles before the load and of it in a pulse, with friction of the load; the twist by its own equation.

    gamma twist' + beta twist = y'' + coulomb sgn(y') + viscous y', integrated in exact short steps.
    """
    finer = 20
    time = np.arange(0.0, 2.0, INTERVAL / finer)
    y = pulse(0.785, 0.5, 0.5)(time, 2)
    pull = y[2] + coulomb * np.sign(y[1]) + viscous * y[1]
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
        found = estimate_load(counted(angles, rng), COUNTS[1:], INTERVAL, rng)
        assert found.known(0.02, 0), found
        assert found.believed, found
        worst = max(worst, abs(found.values[0] / BETA - 1.0))
        held += found.intervals[0, 2] <= coulomb <= found.intervals[1, 2]
        allowed = np.minimum((1.0, 0.5), 4.0 * found.errors[2:])
        assert np.all(np.abs(found.values[2:] - (coulomb, viscous)) <= allowed)
    measured(f"beta {100 * worst:.3f} % at most; {held} of 8 intervals hold the Coulomb friction")
    assert worst < 2e-3, f"observed {worst:.1e}"


def test_momentum_sum_gives_inertia_and_friction_from_counts():
    angles, torque = motion()
    rng = np.random.default_rng(3)
    found = estimate_motor(
        counted(angles, rng), torque, COUNTS, np.array([CHAIN.inertias, np.full(3, 0.05)]), INTERVAL, rng
    )
    assert found.known(0.05, 0, 2)
    off = np.abs(found.values[:3] / WHOLE[:3] - 1.0)
    assert np.all(off < [0.01, 0.05, 0.02]), f"observed {off}"
    assert np.all(found.errors > 0.0)
    np.testing.assert_allclose(found.intervals.mean(axis=0), found.values, rtol=1e-14)
    assert np.all(np.ptp(found.intervals, axis=0) > 2.0 * 1.96 * found.errors)


def test_a_repetition_learns_along_as_many_directions_as_keep_the_command_quiet():
    """Five deviations of the command by noise of the errors, summed up directly, stay below the limit."""
    rng = np.random.default_rng(8)
    nominal = np.diag([1.0, 0.6, 0.3, 0.1, 0.03]) @ rng.normal(size=(5, 5))
    command, noise, ripple = rng.normal(size=(5, 5)), 1e-3, 0.02

    def deviations(law):
        return 5.0 * noise * np.sqrt(np.mean((command @ law.directions @ law.correction) ** 2 * 5))

    found = repetition_learning(nominal, (), command, noise, ripple)
    more = repetition_learning(nominal, (), command, noise, np.inf)
    assert 0 < found.directions.shape[1] < more.directions.shape[1] == 5
    assert deviations(found) <= ripple
    assert repetition_learning(nominal, (), command, noise, 1e-9) is None
    next_one = repetition_learning(nominal, (), command, noise, deviations(found) * (1 + 1e-9))
    assert next_one.directions.shape == found.directions.shape


def test_an_ideal_loop_answers_a_torque_by_the_powers_of_its_matrix():
    """One sample later: the output of A^(k-1) b; the schedule of loads is even in one over the load."""
    rng = np.random.default_rng(5)
    loop = IdealLoop(matrix=0.4 * rng.normal(size=(4, 4)), push=rng.normal(size=4), load=2)
    powers = [(np.linalg.matrix_power(loop.matrix, k) @ loop.push)[2] for k in range(6)]
    np.testing.assert_allclose(loop.response(7), [0.0, *powers], rtol=1e-12)
    schedule = LoadSchedule(low=0.5, high=4.0, points=8)
    inverse = 1.0 / np.array(schedule.loads)
    np.testing.assert_allclose(inverse, np.linspace(0.25, 2.0, 8), rtol=1e-14)


def test_nothing_is_learnt_from_nothing():
    """At rest, within one count, or creeping: not excited, and no number is pretended."""
    rng = np.random.default_rng(0)
    rest = np.zeros((4000, 3))
    creep = counted(np.linspace(0.0, 3e-3, 4000)[:, None] * np.ones(3), rng)
    flicker = COUNTS * rng.integers(0, 2, (4000, 3))
    inertias = np.array([CHAIN.inertias, np.zeros(3)])
    for readings in (rest, creep, flicker):
        assert not estimate_load(readings[:, 1:], COUNTS[1:], INTERVAL, rng).known(0.02, 0)
        assert not estimate_motor(readings, np.zeros(4000), COUNTS, inertias, INTERVAL, rng).known(0.05, 0, 2)


TIME = 1e-4 * np.arange(6001)


def bump(derivatives):
    """(sin^2(pi t / T))^6 over the first 0.5 s, with derivatives, from its Fourier series [N m]."""
    inside = TIME < 0.5
    # sin^12 x = sum of cosines, coefficients by sampling exactly
    x = 2.0 * np.pi * np.arange(64) / 64
    series = np.fft.rfft(np.sin(x / 2.0) ** 12)[:7] / 64
    w = 2.0 * np.pi / 0.5
    rows = []
    for k in range(derivatives):
        terms = [
            (2.0 if m else 1.0) * np.real(series[m] * (1j * m * w) ** k * np.exp(1j * m * w * TIME))
            for m in range(7)
        ]
        rows.append(np.where(inside, 0.01 * np.sum(terms, axis=0), 0.0))
    return np.array(rows)


@pytest.mark.parametrize("n", [2, 3, 4])
def test_the_torque_that_is_carried_to_the_motor_leaves_the_load_where_it_is(n, measured):
    """Forward simulation of the chain under both torques: the load moves a millionth of what it would."""
    chain = row_of(n, np.random.default_rng(n))
    torque = bump(2 * n - 1)
    states, motor = carried(chain, torque, 1e-4)
    a, b = state_space(chain)
    system = StateSpace(a, b[:, [0, -1]], np.eye(2 * n), np.zeros((2 * n, 2)))
    _, held, _ = lsim(system, np.column_stack((motor, -torque[0])), TIME)
    _, free, _ = lsim(system, np.column_stack((0.0 * motor, -torque[0])), TIME)
    moved = np.abs(held[:, n - 1]).max() / np.abs(free[:, n - 1]).max()
    measured(f"{moved:.1e}")
    assert moved < 1e-4, f"observed {moved:.1e}"
    scale = np.abs(states[:, : n - 1]).max()
    np.testing.assert_allclose(states[:, : n - 1], held[:, : n - 1], atol=2e-3 * scale)


def test_whitened_innovations_have_variance_one():
    """A settled filter on noise of its own kind: sample covariance of 40,000 samples within 5 %."""
    counts, tuning = np.array([2.4e-3, 6.3e-4, 6.3e-4]), replace(QUIET, load_acceleration=0.03)
    sampling, encoders = Sampling(interval=INTERVAL), list(enumerate(counts))
    observer = kalman_filter(model(4), encoders, sampling, chosen=[0, 1, 2], tuning=tuning)
    gain, output = observer.gains[-1], observer.output
    transition = observer.model[:, :9]
    rng = np.random.default_rng(3)
    # An error whose innovations are white has, by the filter's optimality, covariance S: drive it by them.
    matrix = whitening(observer, counts)
    spread = np.linalg.inv(matrix.T @ matrix)
    reading = np.diag(counts**2 / 12.0)
    np.testing.assert_allclose((np.eye(3) - output @ gain) @ spread, reading, rtol=1e-6, atol=1e-12)
    assert np.linalg.eigvalsh(spread).min() > 0.0
    assert np.abs(np.linalg.eigvals(transition - transition @ gain @ output)).max() < 1.0
    drawn = rng.multivariate_normal(np.zeros(3), spread, 40_000) @ matrix.T
    np.testing.assert_allclose(np.cov(drawn.T), np.eye(3), atol=0.05)
