"""Quadratic and adaptive laws: against oracles without a Riccati solver, and on the sampled chain itself."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from cabledrive.control import linear_laws, reference
from cabledrive.control.law_kernels import adapt, feedback_command, reference_model_command
from cabledrive.control.numbers import HIGH, KALMAN, LOW, ObserverNumbers
from cabledrive.control.observers import Sampling, between_samples, gathered_noise, settled_gain
from cabledrive.control.reference_kernels import reference_table
from cabledrive.parameters import NotComputed
from cabledrive.reduction.lumped_chain import LumpedChain, state_space
from cabledrive.trajectories import pulse
from cabledrive.trajectories.limits import rise_coefficients
from control_chains import INTERVAL, carried, flat_rows, model, row_of, state_of

COUNT, TORQUE, TIME = 2.0 * np.pi / 10_000, 0.05, 0.03


@pytest.mark.parametrize("number", [3, 4])
def test_lqi_feedback_is_the_limit_of_the_optimum_over_ever_longer_times(number):
    """The gain over 5,000 samples, by the recursion backwards in time."""
    chain = model(number)
    n = chain.size
    ad, bd = np.eye(2 * n + 1), np.zeros((2 * n + 1, 1))
    ad[: 2 * n, : 2 * n], bd[: 2 * n, 0] = sampled(chain)
    ad[2 * n, n - 1] = INTERVAL
    weight = np.zeros((2 * n + 1, 2 * n + 1))
    weight[n - 1, n - 1], weight[2 * n, 2 * n] = COUNT**-2, (COUNT * TIME) ** -2
    value = weight.copy()
    for _ in range(5000):
        gain = (bd.T @ value @ ad) / (TORQUE**-2 + bd.T @ value @ bd)
        value = weight + ad.T @ value @ ad - (ad.T @ value @ bd) @ gain
        value = 0.5 * (value + value.T)
    row = -linear_laws.lqi_law(chain, COUNT, TORQUE, TIME, INTERVAL).rows[0]
    np.testing.assert_allclose(row, np.roll(gain[0], 1), rtol=1e-5)


STIFF = LumpedChain(  # three inertias that swing several times within a sample
    names=("motor", "drive", "load"),
    inertias=(9.2e-4, 2.1e-3, 3.5e-4),
    viscous=(6.4e-4, 8.9e-8, 4.3e-4),
    coulomb=(0.0, 0.0, 0.0),
    offsets=(0.0, 0.0, 0.0),
    stiffness=(4800.0, 8900.0),
    damping=(1.6e-5, 0.81),
    ratios=((1.0, 1.0), (1.0, 1.0)),
)


def test_the_quadratic_feedback_is_found_whatever_the_units_of_its_weights(measured):
    """Of a drive far stiffer than its sampling; the optimum by doubling the time of the recursion."""
    a, b = linear_laws.sampled_motion(STIFF, 1e-3)
    weight = np.diag([0.0, 0.0, 5.1e-4**-2, 0.0, 0.0, 0.0])
    powers, cost = np.logspace(-3.0, 9.0, 49), 9.6e-3**-2
    gains = [linear_laws.lq_gain(a, b, unit * weight, unit * cost) for unit in powers]
    carried, reach, value = a, b @ b.T / cost, weight
    for _ in range(24):  # 2^24 samples
        inner = np.linalg.inv(np.eye(6) + reach @ value)
        reach, value, carried = (
            reach + carried @ inner @ reach @ carried.T,
            value + carried.T @ value @ inner @ carried,
            carried @ inner @ carried,
        )
    best = (b.T @ value @ a) / (cost + b.T @ value @ b)
    off = max(np.abs(gain - best).max() / np.abs(best).max() for gain in gains)
    measured(f"{off:.1e} of the gain")
    assert off < 1e-6


def test_a_filter_that_no_reading_settles_is_not_computed():
    """An angle that walks and is not read: its error grows without end."""
    with pytest.raises(NotComputed, match="Riccati equation"):
        settled_gain(np.eye(2), np.eye(2), np.array([[1.0, 0.0]]), np.eye(1))


@pytest.mark.parametrize("seed", [1, 2])
def test_worst_case_gain_of_the_h_infinity_feedback_is_within_a_margin_of_the_least(seed, measured):
    """A sweep over frequencies: at most gamma, and no LQ feedback goes below gamma without its margin."""
    chain = row_of(2 + seed % 2, np.random.default_rng(seed))
    a, inputs, weight = linear_laws.with_integral(*state_space(chain), (0.0, 1.0), COUNT, TIME)
    by_torque, by_disturbance = inputs[:, :1], 0.04 * inputs[:, [0, -1]]
    gain, gamma = linear_laws.hinf_gain(a, by_disturbance, by_torque, weight, TORQUE**-2)
    frequencies = np.geomspace(1e-2, 1e4, 3000)

    def swept(row):
        outputs = np.vstack((np.sqrt(weight), row / TORQUE))
        closed = a - by_torque @ row
        assert np.linalg.eigvals(closed).real.max() < 0.0
        answers = (np.linalg.solve(1j * w * np.eye(len(a)) - closed, by_disturbance) for w in frequencies)
        return max(np.linalg.norm(outputs @ answer, 2) for answer in answers)

    found = swept(gain)
    measured(f"{found / gamma:.3f} of gamma")
    assert found <= gamma * 1.001, f"observed {found:.4g}, gamma {gamma:.4g}"
    law = linear_laws.lqi_law(chain, COUNT, TORQUE, TIME, 1e-5)
    assert swept(-law.rows) > gamma / linear_laws.MARGIN * 0.999


LASTING = 0.03
SAMPLES = 10_000


def sampled(chain):
    """Transition and input of the chain with the torque held, shapes (2n, 2n), (2n,)."""
    a, b = state_space(chain)
    size = len(a)
    block = np.zeros((size + 1, size + 1))
    block[:size, :size], block[:size, size] = a, b[:, 0]
    power = expm(block * INTERVAL)
    return power[:size, :size], power[:size, size]


def load_error(law, torque, number=4):
    """Load angle under a torque at the motor, shape (samples,) [rad]."""
    a, b = sampled(model(number))
    x, kept = np.zeros(len(a)), state_of(np.zeros(len(a)), memory=np.zeros(len(law.matrix)))
    still, found = np.zeros((1, len(a) + 1)), np.zeros(len(torque))
    for k, held in enumerate(torque):
        found[k] = x[len(a) // 2 - 1]
        kept.states[:] = x
        u, _ = feedback_command(law, kept, still, 0)
        x = a @ x + b * (u + held)
    return found


@pytest.mark.parametrize("number", [3, 4])
def test_l1_removes_a_torque_that_lasts_and_the_feedback_alone_does_not(number, measured):
    torque = np.full(SAMPLES, LASTING)
    alone = load_error(linear_laws.lq_law(model(number), COUNT, TORQUE, INTERVAL), torque, number)
    removed = load_error(linear_laws.l1_law(model(number), COUNT, TORQUE, 10.0, INTERVAL), torque, number)
    measured(f"{abs(removed[-1] / alone[-1]):.1e} of the error is left")
    assert abs(alone[-1]) > 0.3 * COUNT
    assert abs(removed[-1]) < 1e-6 * abs(alone[-1])


def test_model_reference_adaptation_finds_the_factors_of_a_torque_and_keeps_its_bounds(measured):
    """Two functions with factors 0.03 and -0.02, and a third beyond its bound, which it stops at."""
    a, b = sampled(model(4))
    time = INTERVAL * np.arange(60_000)
    functions = np.column_stack((np.sin(7.0 * time), np.cos(13.0 * time), np.ones(len(time))))
    truth = np.array([0.03, -0.02, 0.05])
    high = np.array([0.04, 0.04, 0.045])
    law = linear_laws.reference_model_law(
        linear_laws.lq_law(model(4), COUNT, TORQUE, INTERVAL), -high, high, np.ones(3), 2.0 * np.pi
    )
    reference = np.column_stack((np.zeros((len(time), len(a) + 1)), functions))
    x, kept = np.zeros(len(a)), state_of(np.zeros(len(a)))
    for k in range(len(time)):
        kept.states[:] = x
        u, sigma = reference_model_command(law, kept, reference, k)
        adapt(law, kept, sigma)
        x = a @ x + b * (u - functions[k] @ truth)
    estimate = kept.parameters
    measured(f"{estimate[:2]} for {truth[:2]}")
    np.testing.assert_allclose(estimate[:2], truth[:2], rtol=0.1)
    assert estimate[2] == high[2]
    assert np.all((law.learning[LOW] <= estimate[:3]) & (estimate[:3] <= law.learning[HIGH]))


# --- The generator of a target makes the rows that the law's reference table holds
@pytest.mark.kernel
@pytest.mark.parametrize("number", [1, 3, 4])
def test_rows_of_a_flat_output_are_those_of_whole_arrays(number, measured):
    """Two pulses of an order at which nothing jumps at an edge, which rounding may put to either side."""
    flat, interval, order = reference.flat_output(model(number)), 1e-3, 15
    numbers = np.array([-20.0, 0.04, 0.01, 2.0])
    motion = reference.MotionNumbers(coefficients=np.array(rise_coefficients(order)), scalars=numbers)
    rows = reference_table(reference.flat_generator(flat, interval), motion, interval, 201)
    wanted = pulse(-20.0, 0.04, 0.01, pulses=2, order=order)(interval * np.arange(201), 2 * flat.size)
    table = flat_rows(flat, wanted, interval)
    gap = float(np.max(np.abs(rows - table) / np.abs(table).max(axis=0)))
    measured(f"{gap:.1e} of the peak")
    assert gap < 1e-9, f"observed {gap:.1e} of each column's peak"


def smoothed_sign(speed, weights):
    """Sign of a speed, smoothed evenly to both sides, with derivatives, (rows, samples)."""
    sign = np.pad(np.tanh(reference.TURN * speed / np.abs(speed).max()), weights.shape[1] // 2, mode="edge")
    return np.array([np.convolve(sign, row[::-1], "valid") for row in weights])


def missed_by(load, torque):
    """States less what the filter takes them for, and innovations, by a torque at the load."""
    mean, missed, seen = 0.5 * (torque + np.append(torque[1:], torque[-1])), [], []
    error = np.zeros(len(load.transition))
    for k, one in enumerate(mean):
        seen.append(load.seen @ error)
        error = error - load.gains[min(k, len(load.gains) - 1)] @ seen[-1]
        missed.append(error[load.chosen])
        error = load.transition[:, :-1] @ error + load.transition[:, -1] * one
    return np.array(missed), np.array(seen)


@pytest.mark.kernel  # cabledrive.control.reference_kernels
@pytest.mark.parametrize("inertias", [2, 3])
def test_columns_of_a_law_that_learns_are_those_of_whole_arrays(inertias, measured):
    """A random chain and a random stable filter; the arrays smooth and filter whole signals."""
    generator = np.random.default_rng(inertias)
    n, states, m, interval, turning = inertias, 2 * inertias + 2, 2, 1e-3, 0.012
    chain = row_of(n, generator)
    model = generator.normal(size=(states, states))
    model *= 0.95 / np.abs(np.linalg.eigvals(model)).max()
    observer = ObserverNumbers(
        kind=KALMAN,
        chosen=np.arange(2 * n)[::-1].copy(),
        places=np.zeros(2, dtype=np.int64),
        model=np.hstack((model, np.zeros((states, 4)))),
        output=generator.normal(size=(m, states)),
        gains=0.1 * generator.normal(size=(40, states, m)),
        scalars=np.zeros(9),
    )
    white = generator.normal(size=(m, m))
    load = reference.load_row_numbers(chain, observer, white, turning, interval)
    numbers = reference.reference_numbers(np.eye(2 * n + 1))._replace(load=load)
    motion = reference.MotionNumbers(
        coefficients=np.array(rise_coefficients(4 * n + 1)), scalars=np.array([-0.3, 0.04, 0.01, 2.0])
    )
    rows = reference_table(numbers, motion, interval, 220)
    y, blocks = rows[:, : 2 * n + 1].T, np.zeros((220, 0))
    for torque in (smoothed_sign(y[1], load.sign), y[1 : 2 * n], y[2:]):
        states_asked, motor = carried(chain, torque, interval)
        missed, seen = missed_by(load, torque[0])
        asked = states_asked[:, observer.chosen] - missed
        blocks = np.hstack((blocks, asked, motor[:, None], seen @ white.T))
    gap = np.abs(rows[:, 2 * n + 1 :] - blocks).max(axis=0) / np.abs(blocks).max(axis=0)
    measured(f"{gap.max():.1e} of the peak")
    assert load.columns == blocks.shape[1] == 3 * (2 * n + 1 + m)
    assert gap.max() < 1e-9


def test_noise_of_a_mode_that_decays_far_within_a_sample_is_gathered_as_of_one_that_does_not():
    """(1 - exp(-2 a h)) / 2a of each, apart and turned into one another, a h to 300."""
    rates, turn = np.array([3.0, 300.0, 3e5]), np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    truth = np.diag((1.0 - np.exp(-2.0 * rates * 1e-3)) / (2.0 * rates))
    assert gathered_noise(np.diag(-rates), np.ones(3), 1e-3) == pytest.approx(truth, rel=1e-12, abs=1e-25)
    turned = gathered_noise(turn @ np.diag(-rates) @ turn.T, np.ones(3), 1e-3)
    np.testing.assert_allclose(turned, turn @ truth @ turn.T, rtol=1e-9)


@pytest.mark.parametrize(("late", "rate"), [(0.0, 0.0), (0.3, 0.0), (0.3, 4000.0), (0.0, 4000.0)])
def test_a_sample_with_a_late_command_is_the_motion_in_two_parts(late, rate):
    """The older command up to the delay, the newer one after it, through the lag of the torque loop."""
    system, inputs = state_space(model(3))
    column, (torque, older, newer, load) = inputs[:, 0], (0.4, -0.7, 0.9, 0.2)
    sampling = Sampling(interval=INTERVAL, delay=late * INTERVAL, current_rate=rate)
    transition, pushes, factors = between_samples(system, column, sampling)
    state = np.concatenate((np.random.default_rng(2).normal(size=len(system)), [torque]))

    def moved(begin, command, time):
        def rates(_, y):
            acting = y[-1] if rate else command
            return np.append(system @ y[:-1] + column * (acting + load), rate * (command - y[-1]))

        return solve_ivp(rates, (0.0, time), begin, rtol=1e-11, atol=1e-13).y[:, -1] if time else begin

    end = moved(moved(state, older, late * INTERVAL), newer, (1.0 - late) * INTERVAL)
    given = np.array([torque, older, newer, load])
    np.testing.assert_allclose(transition @ state[:-1] + pushes @ given, end[:-1], rtol=1e-7, atol=1e-9)
    assert factors @ given[:3] == pytest.approx(end[-1] if rate else newer, rel=1e-8)
