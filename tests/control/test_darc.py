"""The laws of the dissertation against the printed ones; bound, projection, errors, and what laws refuse."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cabledrive.control import backstepping, darc
from cabledrive.control.backstepping import backstepping_numbers
from cabledrive.control.backstepping_recursion import work_shape
from cabledrive.control.bound import printed_uncertainty, robust_conditions, uncertainty
from cabledrive.control.law_kernels import adapt, backstepping_command, law_step
from cabledrive.control.numbers import K_SIGMA
from cabledrive.control.reference import MotionNumbers, flat_output, joint_motion
from cabledrive.control.reference_kernels import reference_table
from cabledrive.reduction.lumped_chain import state_space
from cabledrive.trajectories import pulse
from cabledrive.trajectories.limits import rise_coefficients
from command import refused
from control_chains import INTERVAL, flat_rows, model, row_of, state_of
from oracles.printed_laws import LAWS, Gains, Machine, corrected_backstepping, printed_states

FLEXIBLE_JOINT = {1: False, 2: True, 3: False, 4: True}


def law_of(number, *, bandwidth=12.0, **options):
    chain = model(number)
    flat = flat_output(chain, damped=False)
    y = pulse(0.785, 0.5, 0.5)(np.arange(0.0, 2.0, INTERVAL), 2 * chain.size)
    bounds = darc.printed_bounds(chain, flexible_joint=FLEXIBLE_JOINT[number])
    gains = darc.darc_gains(number, bandwidth)
    return darc.darc_numbers(flat, gains, bounds, flat_rows(flat, y, INTERVAL), INTERVAL, **options)


def stepped(law, estimate, states, row):
    """Command, sliding variable and regressor of one sample."""
    kept = state_of(states, estimate)
    command, sigma, valid = law_step(law, kept, row[None, :], 0)
    assert valid
    return command, sigma, kept.regressor[:4]


@pytest.mark.kernel
@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_undamped_law_is_the_printed_law(number, measured):
    """(6.20), (6.43), (6.53), (6.63) at random states, to 1e-11 of the largest term."""
    law, rng = law_of(number), np.random.default_rng(number)
    machine = Machine(*(float(getattr(Machine, f)) for f in ("J11", "J12", "J2", "kk", "k_m")))
    n, off = model(number).size, []
    for _ in range(20):
        states, y = rng.normal(size=2 * n), rng.normal(size=2 * n + 1)
        estimate = law.learning[0] * rng.uniform(0.5, 1.5, 4)
        friction = np.tanh(0.5 * states[n])
        printed = LAWS[number](
            machine, printed_states(states), y, estimate, 2 * np.pi * 12.0, law.k_sigma, friction
        )
        command, own_sigma, regressor = stepped(law, estimate, states, np.append(y, (0.0, 0.0)))
        u, sigma, phi, mu = printed
        assert law.mu == pytest.approx(mu, rel=1e-12)
        assert own_sigma == pytest.approx(sigma, rel=1e-11, abs=1e-11 * abs(law.rows[0]).max())
        np.testing.assert_allclose(regressor, phi.astype(float), rtol=1e-10, atol=1e-11 * np.abs(phi).max())
        off.append(float(abs(command - u) / max(abs(u), law.k_sigma * abs(sigma))))
    measured(f"command within {max(off):.1e} of the largest term")
    assert max(off) < 1e-11, f"observed {max(off):.2e}"


@pytest.mark.kernel
@pytest.mark.parametrize("n", [1, 2, 3, 4, 5])
def test_sigma_obeys_its_dynamics_on_a_damped_row_of_any_length(n):
    """mu sigma' + K_sigma sigma = -phi^T p~ along the true motion of the row, friction of the motor known."""
    rng = np.random.default_rng(n)
    chain = row_of(n, rng)
    flat = flat_output(chain)
    nominal = np.array([chain.inertias[0], chain.viscous[0], chain.coulomb[0], chain.offsets[0]])
    bounds = darc.Bounds(nominal=nominal, low=nominal - 1.0, high=nominal + 1.0)
    gains = darc.DarcGains(bandwidth=80.0, sliding_rate=90.0)
    row = rng.normal(size=2 * n + 3)
    law = darc.darc_numbers(flat, gains, bounds, row[None, :], INTERVAL)
    states, error = 1e-3 * rng.normal(size=2 * n), nominal * rng.uniform(-0.3, 0.3, 4)
    command, sigma, regressor = stepped(law, nominal + error, states, row)
    a, b = state_space(chain)
    speed = states[n]
    net = command - nominal[2] * np.tanh(0.5 * speed) + nominal[3]
    rate = a @ states + b[:, 0] * net
    z_rate = law.matrix @ rate
    sigma_rate = law.rows[0, : 2 * n] @ (z_rate - row[1 : 2 * n + 1])
    residual = law.mu * sigma_rate + law.k_sigma * sigma + regressor @ error
    scale = max(abs(law.mu * sigma_rate), abs(law.k_sigma * sigma), 1e-3)
    assert abs(residual) < 1e-8 * scale, f"observed {abs(residual) / scale:.2e}"


@pytest.mark.kernel
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_estimates_move_at_their_largest_rate_and_stop_at_their_bound(way):
    """Eq. (6.24) with a limit, written out: a regressor of a thousand asks for more than the limit allows."""
    low, high, limit = np.full(4, -1.0), np.full(4, 1.0), np.array([0.5, 1.0, 2.0, 1e9])
    learning = np.array([np.zeros(4), low, high, np.ones(4), limit])
    kept = state_of(np.zeros(6))
    kept.regressor[:4] = 1e3
    law = law_of(4)._replace(learning=learning)
    adapt(law, kept, way)
    expected = way * np.minimum(INTERVAL * np.minimum(limit, 1e3), 1.0)
    np.testing.assert_allclose(kept.parameters[:4], expected, rtol=1e-12)
    for _ in range(20_000):
        adapt(law, kept, way)
    np.testing.assert_array_equal(kept.parameters[:4], way)


@pytest.mark.kernel
def test_a_state_that_is_not_a_number_keeps_the_last_command_and_learns_nothing():
    law = law_of(4)
    estimate = law.learning[0].copy()
    states = np.full(6, np.nan)
    kept = state_of(states, estimate, last=0.123)
    u, _, valid = law_step(law, kept, np.zeros((1, 9)), 0)
    assert (u, valid) == (0.123, False)
    np.testing.assert_array_equal(kept.parameters[:4], law.learning[0])


@pytest.mark.kernel
def test_flat_output_gives_the_response_of_the_row():
    """theta_i / torque = D_1 .. D_(i-1) R_i / (J_1 s^2 R_1 + D_1 a_2), against the state matrix."""
    chain = row_of(4, np.random.default_rng(4))
    flat = flat_output(chain)
    a, b = state_space(chain)
    torque = chain.inertias[0] * flat.inertial + flat.elastic
    torque += chain.viscous[0] * np.concatenate(([0.0], flat.angles[0, :-1]))
    for s in 2j * np.pi * np.array([0.7, 5.0, 40.0]):
        angles = np.linalg.solve(s * np.eye(8) - a, b[:, 0])[:4]
        found = flat.angles @ s ** np.arange(9) / (torque @ s ** np.arange(9))
        np.testing.assert_allclose(found, angles, rtol=1e-9)


@pytest.mark.kernel
def test_reference_through_the_dampers_leads_to_the_wanted_load_angle():
    """theta_N of the filtered reference is y_d, to the order of the straight lines between samples."""
    chain = model(4)
    flat = flat_output(chain)
    y = pulse(0.785, 0.5, 0.5)(np.arange(0.0, 2.0, INTERVAL), 6)
    states, _ = joint_motion(flat, flat_rows(flat, y, INTERVAL))
    worst = np.abs(states[:, 2] - y[0]).max()
    assert worst < 3e-7, f"observed {worst:.2e} rad"


@pytest.mark.kernel
def test_printed_gains_and_bounds_are_those_of_sections_6_5_1_and_6_6_1():
    three = darc.printed_bounds(model(3), flexible_joint=False)
    np.testing.assert_allclose(three.low, [0.00165, 0.0029, 0.035, -0.01], rtol=1e-9)
    np.testing.assert_allclose(three.high, [0.00185, 0.0033, 0.04, 0.01], rtol=1e-9)
    four = darc.printed_bounds(model(4), flexible_joint=True)
    np.testing.assert_allclose([four.low[0], four.high[0]], [0.0009, 0.0013], rtol=1e-9)
    beta = 2 * 850 * 0.04**2 / 0.00235
    law = law_of(4, bandwidth=23.0)
    assert law.scalars[K_SIGMA] == pytest.approx(2 * np.pi * 25 * 0.0011 * 0.000642 / (beta * 135), rel=1e-12)


CHAIN = model(4)
FLAT = flat_output(CHAIN)
GAINS = darc.darc_gains(4)
LAW = darc.darc_numbers(
    FLAT, GAINS, darc.printed_bounds(CHAIN, flexible_joint=True), np.zeros((1, 9)), INTERVAL
)
REST = np.tile([0.0, 0.0, 0.0, 1.0], (20_000, 1))


def test_weighted_sum_bounds_every_uncertainty_within_the_box():
    """|phi^T p~| + |d~| <= h for estimates and truth anywhere in their bounds."""
    rng = np.random.default_rng(0)
    spread = LAW.learning[2] - LAW.learning[1]
    for _ in range(200):
        phi, error = rng.normal(size=(1, 4)), spread * rng.uniform(-1, 1, 4)
        assert abs(phi[0] @ error) + 0.04 <= uncertainty(phi, spread, 0.04)[0] + 1e-12
        assert uncertainty(phi, spread, 0.04)[0] <= printed_uncertainty(phi, spread, 0.04)[0] * 2.0 + 1e-12


def test_a_constant_gain_meets_condition_1_with_h_squared_over_four_gains():
    sigma = np.linspace(-1e6, 1e6, 2001)
    found = robust_conditions(LAW, sigma, np.tile(REST[0], (2001, 1)), 0.04)
    assert found["condition_2"]
    assert found["worst"] <= found["epsilon"] * (1.0 + 1e-12)
    h = (LAW.learning[2, 3] - LAW.learning[1, 3]) + 0.04
    worst = np.abs(h / LAW.k_sigma)
    touched = robust_conditions(LAW, np.array([worst]), REST[:1], 0.04)
    assert touched["worst"] == pytest.approx(touched["epsilon"], rel=1e-12)


LOW, HIGH = np.array([-1.0, 0.0, 2.0, -3.0]), np.array([1.0, 0.5, 2.5, 3.0])
inside = arrays(float, 4, elements=st.sampled_from([0.0, 1.0, 0.25, 0.6])).map(
    lambda s: LOW + s * (HIGH - LOW)
)
vectors = arrays(float, 4, elements=st.floats(-1e3, 1e3))
gains = arrays(float, 4, elements=st.floats(1e-3, 1e3))


@given(estimate=inside, truth=inside, tau=vectors, gain=gains)
def test_projection_never_raises_the_lyapunov_function(estimate, truth, tau, gain):
    """P1 and P2, Eqs. (6.25), (6.26), sampled: p~+^T (Gamma^-1 (p+ - p) - tau) <= 0 for diagonal Gamma."""
    kept = state_of(np.zeros(6), estimate)
    kept.regressor[:4] = tau / INTERVAL
    learning = np.array([np.zeros(4), LOW, HIGH, gain, np.full(4, np.inf)])
    adapt(law_of(4)._replace(learning=learning), kept, 1.0)
    fresh = kept.parameters[:4]
    assert np.all((fresh >= LOW) & (fresh <= HIGH))
    value = (fresh - truth) @ ((fresh - estimate) / gain - tau)
    assert value <= 1e-12 * (100.0 * np.abs(tau).max() + 10.0 / gain.min()), f"observed {value:.3e}"


def test_adaptation_gain_gives_the_second_order_loop_its_damping():
    """Eq. (6.35): the largest phi^T Gamma phi / mu along the reference is k_m^2 / 4, with zeta = 1."""
    bounds = darc.printed_bounds(model(4), flexible_joint=True)
    regressor = np.random.default_rng(0).normal(size=(50, 4))
    chosen = darc.DarcGains(bandwidth=100.0, sliding_rate=150.0)
    gain = darc.adaptation_gain(chosen, bounds, regressor, 1e-6)
    largest = np.max(regressor**2 @ gain) / 1e-6
    assert largest == pytest.approx(150.0**2 / 4.0, rel=1e-12)
    np.testing.assert_allclose(gain / bounds.spread**2, gain[0] / bounds.spread[0] ** 2, rtol=1e-12)


def test_bounds_of_the_offset_do_not_depend_on_its_sign():
    one, other = (
        darc.printed_bounds(replace(model(3), offsets=(sign * 0.05, 0.0)), flexible_joint=False)
        for sign in (1.0, -1.0)
    )
    assert one.high[3] == other.high[3] == 0.1
    assert one.low[3] == other.low[3] == -0.1


ROWS = [
    (lambda: darc.darc_gains(4, -3.0), ["-3", "above 0"]),
    (lambda: darc.darc_gains(4, float("nan")), ["nan", "above 0"]),
    (
        lambda: darc.Bounds(nominal=np.ones(4), low=np.array([2.0, 0, 0, 0]), high=np.full(4, 3.0)),
        ["outside 2 to 3"],
    ),
    (lambda: backstepping_numbers(model(4), -1.0, 0.0, INTERVAL), ["bandwidth", "-1"]),
    (lambda: backstepping_numbers(model(4), float("nan"), 0.0, INTERVAL), ["bandwidth", "nan"]),
]


@pytest.mark.parametrize("call, named", ROWS)
def test_what_no_law_takes_is_refused_by_name_and_number(call, named):
    refused(call, *named)


# --- Backstepping: against the printed law, against differences of 60 digits, and the matrix of its errors
THREE = model(3)
LAW_OF_THREE = backstepping.backstepping_numbers(THREE, backstepping.PRINTED_HZ, 1e-6, INTERVAL)


def command(states, y, estimate):
    kept = state_of(states, estimate, table=work_shape(2))
    u, z1 = backstepping_command(LAW_OF_THREE, kept, y[None, :], 0)
    return u, z1, kept.regressor[:7]


@pytest.mark.kernel
def test_compiled_law_is_the_corrected_law(measured):
    """u and tau of (6.90) and (6.95), mended, at random states and estimates."""
    rng = np.random.default_rng(0)
    parameters, widths, beta = backstepping.unmatched_parameters(THREE)
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

        command, errors, _, regressors = step_at(x, signals)
        starts = np.cumsum([2 * n + 1, *(2 * (n - j) + 1 for j in range(1, n))])
        rate = rates_of(x, command, truth, signals[starts], speed, friction)
        size = mpmath.mpf(10) ** -20
        after, before = (step_at(*moved(x, signals, rate, sign * size))[1] for sign in (1, -1))
        off = []
        for i in range(2 * n):
            found = (after[i] - before[i]) / (2 * size)
            row = [mpmath.mpf(matrix[i, j]) * errors[j] for j in range(2 * n)]
            row += [-regressors[i, m] * (p[m] - truth[m]) for m in range(3 * n + 1)]
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
