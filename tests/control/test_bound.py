"""The bound of the theorems: conditions on the robust term, and the tube for the error."""

import numpy as np
import pytest

from cabledrive.control.bound import error_bound, printed_uncertainty, robust_conditions, uncertainty
from cabledrive.control.darc import darc_numbers
from cabledrive.control.darc_gains import darc_gains, printed_bounds
from cabledrive.control.flat_output import flat_output
from control_chains import INTERVAL, model

CHAIN = model(4)
FLAT = flat_output(CHAIN)
GAINS = darc_gains(4)
LAW = darc_numbers(FLAT, GAINS, printed_bounds(CHAIN, flexible_joint=True), np.zeros((1, 9)), INTERVAL)
REST = np.tile([0.0, 0.0, 0.0, 1.0], (20_000, 1))


def test_weighted_sum_bounds_every_uncertainty_within_the_box():
    """|phi^T p~| + |d~| <= h for estimates and truth anywhere in their bounds."""
    rng = np.random.default_rng(0)
    spread = LAW.learning[2] - LAW.learning[1]
    for _ in range(200):
        phi, error = rng.normal(size=(1, 4)), spread * rng.uniform(-1, 1, 4)
        assert abs(phi[0] @ error) + 0.04 <= uncertainty(phi, spread, 0.04)[0] + 1e-12
        assert uncertainty(phi, spread, 0.04)[0] <= printed_uncertainty(phi, spread, 0.04)[0] * 2.0 + 1e-12


def test_tube_settles_on_h_over_the_gains():
    """At rest the tube ends at h / (K_sigma lambda^5), dampers or not: their gain at rest is one."""
    bound = error_bound(LAW, GAINS.bandwidth, REST, 0.04, INTERVAL, FLAT.time_constants)
    assert bound.tube[-1] == pytest.approx(bound.steady, rel=1e-6)
    h = (LAW.learning[2, 3] - LAW.learning[1, 3]) + 0.04
    assert bound.steady == pytest.approx(h / (LAW.k_sigma * GAINS.bandwidth**5), rel=1e-12)
    assert np.degrees(bound.steady) == pytest.approx(0.07, abs=0.01)


def test_printed_norm_is_useless_beside_the_weighted_sum_in_motion():
    """It multiplies the acceleration by the spread of the friction: 0.65 deg and more."""
    moving = REST.copy()
    moving[:, 0], moving[:, 1] = 30.0, 4.0
    bound = error_bound(LAW, GAINS.bandwidth, moving, 0.04, INTERVAL, FLAT.time_constants)
    assert bound.printed > 5.0 * bound.steady


def test_a_constant_gain_meets_condition_1_with_h_squared_over_four_gains():
    sigma = np.linspace(-1e6, 1e6, 2001)
    found = robust_conditions(LAW, sigma, np.tile(REST[0], (2001, 1)), 0.04)
    assert found.dissipative
    assert found.worst <= found.epsilon * (1.0 + 1e-12)
    h = (LAW.learning[2, 3] - LAW.learning[1, 3]) + 0.04
    worst = np.abs(h / LAW.k_sigma)
    touched = robust_conditions(LAW, np.array([worst]), REST[:1], 0.04)
    assert touched.worst == pytest.approx(touched.epsilon, rel=1e-12)
