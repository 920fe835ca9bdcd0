"""A torque at the load: carried to the motor, seen by the filter, learnt from its innovations.

Compiled modules under test: cabledrive.control.innovations_of_load, cabledrive.control.law_kernels.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import StateSpace, lsim

from cabledrive.control.innovations_of_load import missed_by_filter, whitening
from cabledrive.control.kalman import QUIET, Sampling, kalman_filter
from cabledrive.control.law_kernels import learn_from_innovations
from cabledrive.control.load_torque import carried, smoothed_sign
from cabledrive.control.numbers import LEARNING, LawNumbers
from cabledrive.control.observer_kernels import correct, predict
from cabledrive.reduction.lumped_chain import state_space
from control_chains import INTERVAL, model, row_of, state_of

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


def test_derivatives_of_the_smoothed_sign_are_those_of_its_values():
    t = 1e-4 * np.arange(10_001)
    rows = smoothed_sign(np.sin(2.0 * np.pi * t), 5, 0.06, 1e-4)
    assert rows[0].max() == pytest.approx(1.0, abs=1e-6)
    assert rows[0].min() == pytest.approx(-1.0, abs=1e-6)
    for low, high in pairwise(rows):
        found = np.gradient(low, 1e-4)[600:-600]
        np.testing.assert_allclose(found, high[600:-600], atol=0.02 * np.abs(high).max())


def filter_of(chain):
    counts = (2.4e-3, 6.3e-4, 6.3e-4)
    tuning = replace(QUIET, load_acceleration=0.03)
    sampling = Sampling(interval=INTERVAL)
    return kalman_filter(chain, [0, 1, 2], counts, sampling, chosen=[0, 1, 2], tuning=tuning), np.array(
        counts
    )


@pytest.mark.kernel
def test_what_the_filter_misses_is_what_it_misses_on_a_plant_with_that_torque():
    """The plant by its matrices, the filter by the kernels of the loop, no torque of the motor."""
    chain = replace(model(4), coulomb=(0.0, 0.0, 0.0), offsets=(0.0, 0.0, 0.0))
    observer, _ = filter_of(chain)
    torque = 0.01 * np.sin(40.0 * INTERVAL * np.arange(500))
    missed, innovations = missed_by_filter(observer, chain, torque, INTERVAL)
    a, b = state_space(chain)
    fine = 10
    time = INTERVAL / fine * np.arange(500 * fine + 1)
    load = np.interp(time, INTERVAL * np.arange(500), torque)
    _, true, _ = lsim(StateSpace(a, -b[:, -1:], np.eye(6), np.zeros((6, 1))), load, time)
    estimate, states, scratch, held = np.zeros(9), np.zeros(6), np.zeros(12), np.zeros(2)
    found, seen = np.zeros((500, 6)), np.zeros((500, 3))
    for k in range(500):
        x = true[k * fine]
        correct(
            2,
            observer.chosen,
            observer.output,
            observer.gains,
            observer.scalars,
            k,
            estimate,
            x[:3],
            states,
            scratch,
        )
        found[k], seen[k] = x - states, scratch[:3]
        predict(observer.model, observer.scalars, 3, estimate, held, 0.0, 0.0, scratch)
    for ours, theirs in ((missed, found), (innovations, seen)):
        gap = np.abs(ours - theirs).max(axis=0) / np.abs(theirs).max(axis=0)
        assert gap.max() < 2e-3, f"observed {gap}"


def test_whitened_innovations_have_variance_one():
    """A settled filter on noise of its own kind: sample covariance of 40,000 samples within 5 %."""
    chain = model(4)
    observer, counts = filter_of(chain)
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


def learnt(slopes, innovations, forgetting, start, gate=1e9, high=1e9, renewed=0.0):
    """Parameters and covariance after the kernel has seen every row, one encoder."""
    p = slopes.shape[1]
    kept = state_of((), (*np.zeros(p), *start.ravel()))
    rows = np.array([[0.0], [1.0]])
    learning = np.array([np.zeros(p), np.full(p, -1e9), np.full(p, high), np.ones(p), np.full(p, np.inf)])
    law = LawNumbers(LEARNING, np.zeros((0, 1)), rows, learning, np.array([0.0, forgetting, gate, renewed]))
    reference = np.zeros((len(slopes), 1 + 2 * p))
    reference[:, 2::2] = slopes
    for k, value in enumerate(innovations):
        kept.work[0] = value
        learn_from_innovations(law, kept, reference, k)
    estimate = kept.parameters
    return estimate[:p], estimate[p : p + p * p].reshape(p, p)


@pytest.mark.kernel
def test_without_forgetting_it_is_least_squares_with_a_prior():
    rng = np.random.default_rng(5)
    slopes, truth, prior = rng.normal(size=(60, 3)), np.array([0.3, -1.0, 2.0]), np.diag([4.0, 1.0, 9.0])
    data = slopes @ truth + rng.normal(size=60)
    found, spread = learnt(slopes, data, 1.0, prior)
    information = np.linalg.inv(prior) + slopes.T @ slopes
    np.testing.assert_allclose(found, np.linalg.solve(information, slopes.T @ data), rtol=1e-9)
    np.testing.assert_allclose(spread, np.linalg.inv(information), rtol=1e-9)


def test_a_direction_that_is_not_excited_is_not_forgotten_and_covariance_stays_bounded():
    """Only the first parameter moves the innovation: the others keep their covariance over 20,000 samples."""
    prior = np.diag([4.0, 1.0, 9.0])
    slopes = np.zeros((20_000, 3))
    slopes[:, 0] = 0.1
    _, spread = learnt(slopes, np.zeros(20_000), 0.999, prior)
    np.testing.assert_allclose(spread[1:, 1:], prior[1:, 1:], rtol=1e-12)
    assert 0.05 < spread[0, 0] < 0.2, f"observed {spread[0, 0]:.3g}"  # 0.1 = (1 - 0.999) / 0.1^2


@pytest.mark.kernel
def test_an_innovation_that_the_covariance_does_not_explain_is_passed_over():
    prior = np.diag([1e-4, 1e-4, 1e-4])
    found, kept = learnt(np.ones((1, 3)), np.array([50.0]), 1.0, prior, gate=6.0)
    np.testing.assert_array_equal(found, 0.0)
    np.testing.assert_array_equal(kept, prior)
    _, renewed = learnt(np.ones((1, 3)), np.array([50.0]), 1.0, prior, gate=6.0, renewed=0.25)
    np.testing.assert_allclose(renewed, 0.75 * prior + 0.25 * np.eye(3), rtol=1e-15)
    spread = 3.0  # of three parameters of variance 1, besides the innovation's own 1: the gate is at 12
    for size, learns in ((0.99, True), (1.01, False)):
        value = size * 6.0 * np.sqrt(1.0 + spread)
        found, _ = learnt(np.ones((1, 3)), np.array([value]), 1.0, np.eye(3), gate=6.0)
        np.testing.assert_allclose(found, value / (1.0 + spread) if learns else 0.0, rtol=1e-14)
    held, _ = learnt(np.ones((1, 3)), np.array([5.0]), 1.0, np.eye(3), gate=6.0, high=0.5)
    np.testing.assert_array_equal(held, 0.5)
