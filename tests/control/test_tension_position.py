"""The law of two motors: allocation, limits and rest, and the bound of a body's place."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import lsq_linear

from cabledrive.control import tension_position
from cabledrive.reduction.two_motors import TwoMotors

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
GAINS = tension_position.TensionGains(
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


def torque_of(state, measurement, reference):
    """Torques of a sample; the state goes on."""
    torque = np.zeros(2)
    space = np.zeros((2, 1)), np.zeros(25)
    tension_position.step_in_place(GAINS, state, measurement, reference, torque, space)
    return torque


@pytest.mark.kernel("cabledrive.control.tension_position")
def test_at_rest_each_motor_holds_its_line():
    state = tension_position.first_state(GAINS, REST)
    torque = torque_of(state, np.array([0.0, 0.0, *REST]), np.zeros(5))
    np.testing.assert_allclose(torque, PAIR.drum * REST, rtol=1e-12)
    np.testing.assert_allclose(state, tension_position.first_state(GAINS, REST), atol=1e-9)


@pytest.mark.kernel("cabledrive.control.tension_position")
def test_no_measurement_and_no_reference_takes_the_wanted_tension_outside_its_limits():
    """Two equal lags of a bounded signal stay within its bounds."""
    rng, state = np.random.default_rng(3), tension_position.first_state(GAINS, REST)
    reshaped = 0.0
    for _ in range(300):
        wild = np.concatenate([rng.normal(0.0, 0.5, 2), rng.normal(100.0, 300.0, 2)])
        torque = torque_of(state, wild, rng.normal(0.0, [0.1, 1.0, 50.0, 100.0, 100.0]))
        lags, asked = state[3:7], state[10:12]
        inside = np.concatenate([lags, asked])
        assert np.abs(inside - 165.0).max() <= 135.0 + 1e-9, inside
        assert (np.abs(torque) <= 40.0).all()
        reshaped += state[9]
    assert reshaped > 100.0, "the limits were hardly reached"


@pytest.mark.kernel("cabledrive.control.tension_position")
@pytest.mark.parametrize("m", [1, 2])
def test_allocation_is_the_bounded_least_squares_solution(m):
    rng = np.random.default_rng(m)
    edges = 0
    for _ in range(60):
        along, mass = rng.normal(size=(2, m)), rng.uniform(1.0, 5.0, m)
        low = rng.uniform(10.0, 100.0, 2)
        high, preferred = low + rng.uniform(50.0, 500.0, 2), rng.uniform(50.0, 400.0, 2)
        force, found = rng.normal(0.0, 300.0, m), np.zeros(2)
        tension_position.allocate(force, mass, along, (low, high), preferred, found)
        weight = np.sqrt(tension_position.PREFERENCE * np.max((along / mass) ** 2))
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


POSITION, LAG, OBSERVER = 6.3, 76.0, 11.4


def error_of(time, *, unexpected=None, tension=None, noise=None, measured=None):
    """Error of the place by observer, law and lags as differential equations, from rest."""

    def none(_):
        return 0.0

    a, t, n, g = (given or none for given in (unexpected, tension, noise, measured))

    def rate(now, x):
        e, v, seen, speed, disturbance, first, second = x
        innovation = e + n(now) - seen
        believed = second + disturbance
        feedback = -(POSITION**2) * seen - 2.0 * POSITION * speed - disturbance
        return [
            v,
            second + a(now) + t(now),
            speed + 3.0 * OBSERVER * innovation,
            believed + t(now) + g(now) + 3.0 * OBSERVER**2 * innovation,
            OBSERVER**3 * innovation,
            LAG * (feedback - first),
            LAG * (first - second),
        ]

    return solve_ivp(rate, (0.0, time[-1]), np.zeros(7), t_eval=time, rtol=1e-9, atol=1e-12, max_step=2e-3).y[
        0
    ]


def pulse_answer(kind):
    """Instants and the error under a narrow pulse of unit area."""
    time = np.linspace(0.0, 3.0, 3001)
    width = time[1]
    return time, error_of(time, **{kind: lambda s: 1.0 / width if s < width else 0.0})


@pytest.mark.parametrize(
    ("kind", "name"), [("unexpected", "unexpected"), ("tension", "tension"), ("noise", "place")]
)
def test_the_worst_disturbance_reaches_the_bound_and_none_exceeds_it(kind, name):
    """The signs of the answer, backwards in time."""
    bound = getattr(tension_position.place_answers(POSITION, LAG, OBSERVER), name)
    time, answer = pulse_answer(kind)
    signs = np.sign(answer)[::-1]
    worst = np.abs(error_of(time, **{kind: lambda s: signs[min(int(s / time[1]), len(signs) - 1)]})).max()
    assert np.trapezoid(np.abs(answer), time) == pytest.approx(bound, rel=0.01)
    assert 0.97 * bound < worst < 1.01 * bound


@pytest.mark.parametrize(("kind", "name"), [("noise", "noisy_place"), ("measured", "noisy_acceleration")])
def test_white_noise_goes_through_the_square_of_the_answer(kind, name):
    time, answer = pulse_answer(kind)
    expected = np.sqrt(np.trapezoid(answer**2, time))
    assert getattr(tension_position.place_answers(POSITION, LAG, OBSERVER), name) == pytest.approx(
        expected, rel=0.01
    )
