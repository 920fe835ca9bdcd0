"""The projection keeps estimates in their bounds and never raises the Lyapunov function."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cabledrive.control.darc_gains import DarcGains, adaptation_gain, printed_bounds
from cabledrive.control.projection import adapted, limited_rate, projected_rate
from control_chains import INTERVAL, model

LOW, HIGH = np.array([-1.0, 0.0, 2.0, -3.0]), np.array([1.0, 0.5, 2.5, 3.0])
inside = arrays(float, 4, elements=st.sampled_from([0.0, 1.0, 0.25, 0.6])).map(
    lambda s: LOW + s * (HIGH - LOW)
)
vectors = arrays(float, 4, elements=st.floats(-1e3, 1e3))
gains = arrays(float, 4, elements=st.floats(1e-3, 1e3))


@given(estimate=inside, truth=inside, tau=vectors, gain=gains)
def test_projection_never_raises_the_lyapunov_function(estimate, truth, tau, gain):
    """P2, Eq. (6.26), for diagonal Gamma: p~^T (Gamma^-1 Proj(Gamma tau) - tau) <= 0."""
    projected = projected_rate(gain * tau, estimate, LOW, HIGH)
    value = (estimate - truth) @ (projected / gain - tau)
    assert value <= 1e-12 * np.abs(tau).max() * 10, f"observed {value:.3e}"


@given(estimate=inside, rate=vectors, limit=arrays(float, 4, elements=st.floats(0.0, 10.0)))
def test_estimates_stay_in_their_bounds_and_below_their_rates(estimate, rate, limit):
    """P1, Eq. (6.25), sampled, with and without a rate limit."""
    for allowed in (None, limit):
        fresh = adapted(estimate, rate, LOW, HIGH, INTERVAL, allowed)
        assert np.all((fresh >= LOW) & (fresh <= HIGH))
    moved = np.abs(adapted(estimate, rate, LOW, HIGH, INTERVAL, limit) - estimate)
    assert np.all(moved <= limit * INTERVAL * (1.0 + 1e-9) + 1e-15)


def test_a_rate_limit_that_acts_spoils_p2():
    """The limit as defined here keeps P1 and breaks P2, as any limit does."""
    estimate, truth, tau = np.array([0.5]), np.array([0.9]), np.array([10.0])
    rate = limited_rate(projected_rate(tau, estimate, np.zeros(1), np.ones(1)), np.ones(1))
    assert (estimate - truth) @ (rate - tau) == pytest.approx(3.6)


def test_adaptation_gain_gives_the_second_order_loop_its_damping():
    """Eq. (6.35): the largest phi^T Gamma phi / mu along the reference is k_m^2 / (4 zeta^2)."""
    bounds = printed_bounds(model(4), flexible_joint=True)
    regressor = np.random.default_rng(0).normal(size=(50, 4))
    chosen = DarcGains(bandwidth=100.0, sliding_rate=150.0, damping_ratio=0.8)
    gain = adaptation_gain(chosen, bounds, regressor, 1e-6)
    largest = np.max(regressor**2 @ gain) / 1e-6
    assert largest == pytest.approx(150.0**2 / (4 * 0.8**2), rel=1e-12)
    np.testing.assert_allclose(gain / bounds.spread**2, gain[0] / bounds.spread[0] ** 2, rtol=1e-12)
