"""Backstepping: against the printed law, against differences of 60 digits, and the matrix of its errors."""

import mpmath
import numpy as np
import pytest

from cabledrive.control import backstepping
from cabledrive.control.backstepping_recursion import work_shape
from cabledrive.control.law_kernels import backstepping_command
from cabledrive.control.reference import MotionNumbers, flat_output, joint_motion
from cabledrive.control.reference_kernels import reference_table
from cabledrive.trajectories import pulse
from cabledrive.trajectories.limits import rise_coefficients
from control_chains import INTERVAL, flat_rows, model, state_of
from oracles.printed_laws import Gains, corrected_backstepping

CHAIN = model(3)
LAW = backstepping.backstepping_numbers(CHAIN, backstepping.PRINTED_HZ, 1e-6, INTERVAL)


def command(states, y, estimate):
    kept = state_of(states, estimate, table=work_shape(2))
    u, z1 = backstepping_command(LAW, kept, y[None, :], 0)
    return u, z1, kept.regressor[:7]


@pytest.mark.kernel
def test_compiled_law_is_the_corrected_law(measured):
    """u and tau of (6.90) and (6.95), mended, at random states and estimates."""
    rng = np.random.default_rng(0)
    parameters, widths, beta = backstepping.unmatched_parameters(CHAIN)
    rate = 2.0 * np.pi * backstepping.PRINTED_HZ
    k = Gains(rate, 1.0, rate, 0.0, 1.0, rate, 0.0, 0.0, 1.0, rate, 0.0)
    off = []
    for _ in range(20):
        states, y = rng.normal(size=4), rng.normal(size=5)
        estimate = parameters + widths * rng.uniform(-1, 1, 7)
        x = (states[1], states[3], beta * (states[0] - states[1]), beta * (states[2] - states[3]))
        true = corrected_backstepping(x, y, estimate, k, beta, np.tanh(0.5 * states[2]))
        u, z1, tau = command(states, y, estimate)
        off.append(float(abs(u / true.u - 1.0)))
        assert z1 == pytest.approx(true.z[0], rel=1e-12)
        expected = sum(
            np.array(phi, float) * z
            for phi, z in zip((true.phi2, true.phi3, true.phi4), true.z[1:], strict=True)
        )
        np.testing.assert_allclose(tau, expected, rtol=1e-10, atol=1e-10 * np.abs(expected).max())
    measured(f"within {max(off):.1e} of the command")
    assert max(off) <= 1e-11, f"observed {max(off):.2e}"


SIX_STATES = model(4)
LAW_OF_SIX = backstepping.backstepping_numbers(SIX_STATES, 25.0, 1e-12, INTERVAL)
NOMINAL, WIDTHS = backstepping.chain_parameters(SIX_STATES)
S1, S2 = backstepping.chain_scales(SIX_STATES)
UNIT = np.array([1.0, 10.0, S1 * 0.01, S1 * 0.3, S2 * 1e-3, S2 * 0.05])


def sample(seed):
    """States, signals and estimates of plausible size."""
    rng = np.random.default_rng(seed)
    x = UNIT * rng.normal(size=6)
    rate = 2 * np.pi * 2.0
    y = rng.normal(size=7) * rate ** np.arange(7)
    w = rng.normal(size=9) * 0.05 * np.array([*rate ** np.arange(2, 7), *rate ** np.arange(4, 7), rate**6])
    return x, np.concatenate((y, w)), NOMINAL + WIDTHS * rng.uniform(-1, 1, 10), float(rng.normal())


def states_of(x):
    """Angles and speeds of scaled states."""
    load, twist, joint = x[0], x[2] / S1, x[4] / S2
    speeds = x[1], x[3] / S1, x[5] / S2
    return np.array([load + twist + joint, load + twist, load, sum(speeds), speeds[0] + speeds[1], speeds[0]])


@pytest.mark.kernel
@pytest.mark.parametrize("seed", range(5))
def test_compiled_law_is_its_readable_twin(seed):
    """Command to 1e-11, adaptation tau equal to the sum of phi_i z_i."""
    x, signals, estimate, friction = sample(seed)
    reference = np.array([[*signals, friction]])
    kept = state_of(states_of(x), estimate, table=work_shape(3))
    u, z1 = backstepping_command(LAW_OF_SIX, kept, reference, 0)
    given = (x, signals, states_of(x)[3], np.tanh(50.0 * friction))
    readable, z, _, phi = backstepping.backstepping_step(LAW_OF_SIX, estimate, *given)
    assert u == pytest.approx(readable, rel=1e-11)
    assert z1 == pytest.approx(z[0], rel=1e-11)
    expected = np.array(phi).T @ z
    np.testing.assert_allclose(kept.regressor[:10], expected, rtol=1e-9, atol=1e-11 * np.abs(expected).max())


def rates(x, u, p, w, speed, friction):
    """Rates of the scaled states under a command, parameters p; w: known accelerations of the rows."""
    return [
        x[1],
        p[0] * x[2] + p[1] + w[0],
        x[3],
        p[2] * x[4] - p[3] * x[2] - S1 * p[1] + w[1],
        x[5],
        S2 * p[9] * u - p[4] * x[4] + p[5] * x[2] - p[6] * speed - p[7] * friction + p[8] + w[2],
    ]


def moved(x, signals, rate, step):
    """States and signals a little later."""
    n = len(x) // 2
    ends = np.cumsum([2 * n + 1, *(2 * (n - j) + 1 for j in range(1, n + 1))])
    assert ends[-1] == len(signals)
    later = []
    for chain in np.split(signals, ends[:-1]):
        later += [a + step * b for a, b in zip(chain, [*chain[1:], mpmath.mpf(0)], strict=True)]
    return x + step * np.array(rate), np.array(later)


def off_their_dynamics(law, rates_of, p, truth, x, signals, speed, friction):
    """Largest difference of z' from A z - Phi^T p~ over the row's largest term; differences of 60 digits."""
    n = len(x) // 2
    with mpmath.workdps(60):
        matrix = backstepping.errors_matrix(law, p, 2 * n)
        exact = [np.array([mpmath.mpf(float(v)) for v in a]) for a in (p, truth, x, signals)]
        gains = [
            np.vectorize(lambda v: mpmath.mpf(float(v)), otypes=[object])(a) for a in (law.matrix, law.rows)
        ]
        exact_law = law._replace(matrix=gains[0], rows=gains[1])
        p, truth, x, signals = exact
        speed, friction = mpmath.mpf(float(speed)), mpmath.mpf(float(friction))

        def step_at(x, signals):
            return backstepping.backstepping_step(exact_law, p, x, signals, speed, friction)

        here = step_at(x, signals)
        starts = np.cumsum([2 * n + 1, *(2 * (n - j) + 1 for j in range(1, n))])
        rate = rates_of(x, here.command, truth, signals[starts], speed, friction)
        size = mpmath.mpf(10) ** -20
        after, before = (step_at(*moved(x, signals, rate, sign * size)).errors for sign in (1, -1))
        off = []
        for i in range(2 * n):
            found = (after[i] - before[i]) / (2 * size)
            row = [mpmath.mpf(matrix[i, j]) * here.errors[j] for j in range(2 * n)]
            row += [-here.regressors[i, m] * (p[m] - truth[m]) for m in range(3 * n + 1)]
            off.append(float(abs(found - sum(row)) / max(abs(term) for term in row)))
        return max(off)


@pytest.mark.parametrize("seed", range(3))
def test_errors_obey_their_dynamics_to_eleven_digits(seed, measured):
    """z' = A z - Phi^T p~ by central differences with 60 digits, true parameters unlike the estimates.

    Every partial derivative of every virtual control enters; one wrong term shows at once.
    """
    x, signals, estimate, friction = sample(seed)
    truth, speed = sample(seed + 100)[2], states_of(x)[3]
    off = off_their_dynamics(LAW_OF_SIX, rates, estimate, truth, x, signals, speed, friction)
    measured(f"within {off:.1e} of the largest term of each row")
    assert off <= 1e-11, f"observed {off}"


def test_condition_holds_without_adaptation_and_fails_with_it():
    """D_z at rest: positive for gamma = 0; at the gamma that helps, negative over the motion."""
    time = np.asarray(INTERVAL * np.arange(2500), dtype=np.float64)
    wanted = pulse(0.8, 0.5, 0.0)(time, 6)
    motion = MotionNumbers(np.array(rise_coefficients(9)), np.array([0.8, 0.5, 0.0, 1.0]))
    reference = reference_table(
        backstepping.chain_generator(SIX_STATES, INTERVAL), motion, INTERVAL, len(time)
    )
    states = joint_motion(flat_output(SIX_STATES), flat_rows(flat_output(SIX_STATES), wanted, INTERVAL))[0]
    still = backstepping.backstepping_numbers(SIX_STATES, 25.0, 0.0, INTERVAL)
    margins = [
        backstepping.stability_margin(law, NOMINAL, states[900], reference[900])
        for law in (still, LAW_OF_SIX)
    ]
    assert margins[0] == pytest.approx(2 * np.pi * 25.0, rel=0.02)
    assert margins[1] < 0.0, f"observed {margins}"
