"""The covariance recursion against plain matrices, and its gains against those of an oracle."""

import numpy as np
import pytest

from cabledrive.control.observer_kernels import gain_schedule


def batch_state(transition, noise, output, reading, start, readings):
    """Mean of the present state, given all readings: one regression on the joint normal law, no recursion."""
    count, n = len(readings), len(transition)
    powers = [np.linalg.matrix_power(transition, k) for k in range(count)]
    covariance = np.zeros((count * n, count * n))
    for i in range(count):
        for j in range(count):
            both = powers[i] @ start @ powers[j].T
            for k in range(1, min(i, j) + 1):
                both = both + powers[i - k] @ noise @ powers[j - k].T
            covariance[i * n : (i + 1) * n, j * n : (j + 1) * n] = both
    seen = np.kron(np.eye(count), output)
    spread = seen @ covariance @ seen.T + np.kron(np.eye(count), reading)
    return covariance[-n:] @ seen.T @ np.linalg.solve(spread, np.concatenate(readings))


@pytest.mark.kernel
@pytest.mark.parametrize(("states", "encoders"), [(2, 1), (5, 2), (7, 3)])
def test_the_recursion_ends_where_a_regression_on_all_readings_does(states, encoders):
    rng = np.random.default_rng(states)
    transition = np.eye(states) + 0.3 * rng.standard_normal((states, states))
    transition /= max(np.abs(np.linalg.eigvals(transition)))
    factor = rng.standard_normal((states, states))
    noise, start, reading = 1e-2 * factor @ factor.T, np.eye(states), np.diag(rng.uniform(0.1, 1.0, encoders))
    output = rng.standard_normal((encoders, states))
    readings = [rng.standard_normal(encoders) for _ in range(12)]
    gains = np.zeros((12, states, encoders))
    assert gain_schedule(transition, noise, output, reading, start, gains, 0.0) == 11
    state = np.zeros(states)
    for k, (gain, row) in enumerate(zip(gains, readings, strict=True)):
        state = transition @ state if k > 0 else state
        state = state + gain @ (row - output @ state)
    expected = batch_state(transition, noise, output, reading, start, readings)
    np.testing.assert_allclose(state, expected, rtol=1e-9, atol=1e-10)


def test_a_settled_gain_ends_the_schedule():
    """A walk read with as much noise as it walks: gain 1/(1/2 + sqrt(5)/2), the golden ratio's inverse."""
    one = np.eye(1)
    gains = np.zeros((400, 1, 1))
    used = gain_schedule(one, one, one, one, 100.0 * one, gains, 1e-7)
    assert 100 < used < 399
    assert gains[used, 0, 0] == pytest.approx((np.sqrt(5.0) - 1.0) / 2.0, rel=1e-12)
