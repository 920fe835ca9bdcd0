"""The law of two motors: allocation, limits and rest, without any simulation."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from cabledrive.control.tension_allocation import PREFERENCE, allocate
from cabledrive.control.tension_position import TensionGains, first_state, step
from cabledrive.reduction.two_motors_kernels import TwoMotors

PAIR = TwoMotors(  # a mass on a rail between two winches 8 m apart
    mass=np.array([3.0]),
    force=np.zeros(1),
    viscous=np.zeros(1),
    coulomb=np.zeros(1),
    frame=np.array([[1.0], [0.0]]),
    centre=np.array([[-4.0, 0.0], [4.0, 0.0]]),
    radius=np.zeros(2),
    anchor=np.zeros((2, 2)),
    bearing=np.array([[1.0, 0.0], [-1.0, 0.0]]),
    fixed=np.zeros(2),
    unwound=np.array([-0.02, -0.02]),
    rigidity=np.array([2e4, 2e4]),
    loss=np.zeros(2),
    drum=np.array([0.1, 0.1]),
    inertia=np.array([0.01, 0.01]),
    turning_viscous=np.zeros(2),
    turning_coulomb=np.zeros(2),
    limit=np.array([40.0, 40.0]),
)
REST = np.array([100.0, 100.0])
GAINS = TensionGains(
    machine=PAIR,
    low=np.array([30.0, 30.0]),
    high=np.array([300.0, 300.0]),
    preferred=REST,
    position=8.0,
    filter=90.0,
    tension=90.0,
    observer=15.0,
    sliding=0.1,
    interval=1e-3,
)


@pytest.mark.kernel("cabledrive.control.tension_position")
def test_at_rest_each_motor_holds_its_line():
    state = first_state(GAINS, REST)
    following, torque = step(GAINS, state, np.array([0.0, 0.0, *REST]), np.zeros(5))
    np.testing.assert_allclose(torque, PAIR.drum * REST, rtol=1e-12)
    np.testing.assert_allclose(following, state, atol=1e-9)


@pytest.mark.kernel("cabledrive.control.tension_position")
def test_no_measurement_and_no_reference_takes_the_wanted_tension_outside_its_limits():
    """Two equal lags of a bounded signal stay within its bounds."""
    rng, state = np.random.default_rng(3), first_state(GAINS, REST)
    reshaped = 0.0
    for _ in range(300):
        wild = np.concatenate([rng.normal(0.0, 0.5, 2), rng.normal(100.0, 300.0, 2)])
        state, torque = step(GAINS, state, wild, rng.normal(0.0, [0.1, 1.0, 50.0, 100.0, 100.0]))
        lags, asked = state[3:7], state[10:12]
        inside = np.concatenate([lags, asked])
        assert np.abs(inside - 165.0).max() <= 135.0 + 1e-9, inside
        assert (np.abs(torque) <= 40.0).all()
        reshaped += state[9]
    assert reshaped > 100.0, "the limits were hardly reached"


@pytest.mark.kernel("cabledrive.control.tension_allocation")
@pytest.mark.parametrize("m", [1, 2])
def test_allocation_is_the_bounded_least_squares_solution(m):
    rng = np.random.default_rng(m)
    edges = 0
    for _ in range(60):
        along, mass = rng.normal(size=(2, m)), rng.uniform(1.0, 5.0, m)
        low = rng.uniform(10.0, 100.0, 2)
        high, preferred = low + rng.uniform(50.0, 500.0, 2), rng.uniform(50.0, 400.0, 2)
        force, found = rng.normal(0.0, 300.0, m), np.zeros(2)
        allocate(force, mass, along, low, high, preferred, found)
        weight = np.sqrt(PREFERENCE * np.max((along / mass) ** 2))
        matrix = np.vstack([(along / mass).T, weight * np.eye(2)])
        wanted = np.concatenate([-force / mass, weight * preferred])
        best = lsq_linear(matrix, wanted, (low, high), method="bvls", tol=1e-14)

        def cost(tension, matrix=matrix, wanted=wanted):
            return np.sum((matrix @ tension - wanted) ** 2)

        assert (found >= low - 1e-9).all()
        assert (found <= high + 1e-9).all()
        assert cost(found) <= cost(best.x) * (1.0 + 1e-9) + 1e-9, (found, best.x)
        edges += bool(np.any((found <= low) | (found >= high)))
    assert edges > 10, "the limits were hardly reached"
