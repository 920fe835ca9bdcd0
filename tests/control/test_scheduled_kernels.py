"""Kernels whose numbers go by a place or a load, and the start of a controller on a target."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.control import load_schedule
from cabledrive.control.controller_kernels import new_target_state, start_target, target_step
from cabledrive.control.law_kernels import feedback_command, learn_from_innovations, reference_model_command
from cabledrive.control.linear_laws import pd_law
from cabledrive.control.numbers import (
    BY_LOAD,
    GAIN,
    HIGH,
    LEARNING,
    LOW,
    REFERENCE_MODEL,
    SCHEDULED,
    ControllerState,
    LawNumbers,
    ObserverNumbers,
)
from cabledrive.control.observers import KalmanTuning, Sampling, correct, gain_schedule, kalman_filter
from cabledrive.export.translation.source import interpreted
from control_chains import INTERVAL, model

pytestmark = pytest.mark.kernel
RNG = np.random.default_rng(5)


@pytest.mark.parametrize(
    ("position", "place"), [(0.1, 0.0), (0.35, 0.3), (0.85, 1.3), (1.2, 2.0), (9.0, 3.0)]
)
def test_a_position_lies_in_its_cell_of_the_grid_and_is_held_at_its_ends(position, place):
    assert load_schedule.grid_place(0.2, 0.5, 4, position) == pytest.approx(place)


def test_a_scheduled_sample_is_correct_act_predict_with_interpolated_matrices():
    points, size, states = 4, 6, 4
    feedback, drive = RNG.normal(size=(points, states)), RNG.normal(size=(points, size))
    correction, transition = RNG.normal(size=(points, size, 2)), RNG.normal(size=(points, size, size))
    estimate, readings, reference = (
        RNG.normal(size=size),
        RNG.normal(size=2),
        RNG.normal(size=(2, states + 2)),
    )
    estimate[1] = 0.1
    share = (0.2 + 0.7 + 0.1 - 0.2) / 0.5 - 1.0
    gain, correct, go, push = (
        (1.0 - share) * table[1] + share * table[2] for table in (feedback, correction, transition, drive)
    )
    corrected = estimate + correct @ (readings - estimate[[0, 2]])
    wanted = reference[1, states] - gain @ (corrected[:states] - reference[1, :states])
    for limit in (2.0 * abs(wanted), 0.5 * abs(wanted)):
        force, kept = np.clip(wanted, -limit, limit), estimate.copy()
        law = load_schedule.ScheduledLaw(
            np.array([0.2, 0.5, 0.9]), feedback, correction, transition, drive, limit
        )
        found = load_schedule.scheduled_step(law, kept, readings, reference, 1, np.zeros(size))
        assert found == pytest.approx(force, rel=1e-12)
        expected = go @ corrected + push * (force - reference[1, states + 1])
        np.testing.assert_allclose(kept, expected, rtol=1e-11)


def test_a_filter_takes_in_readings_with_the_gain_of_the_announced_load():
    """Interpolated in one over the load, at its ends too; a reading that is missing changes no estimate."""
    first, step, points = 0.4, 0.3, 3
    gains, output = RNG.normal(size=(points, 4, 2)), RNG.normal(size=(2, 4))
    scalars = np.zeros(11)
    scalars[9:] = first, step
    chosen = np.array([2, 0])
    observer = ObserverNumbers(BY_LOAD, chosen, np.zeros(2, int), np.zeros((12, 8)), output, gains, scalars)
    for told in (9.0, 1.0 / 0.55, 1.0 / 0.85, 0.9):
        place = min(max((1.0 / told - first) / step, 0.0), points - 1.0)
        assert load_schedule.grid_place(first, step, points, 1.0 / told) == pytest.approx(place)
        gain = np.array(
            [[np.interp(place, range(points), gains[:, i, j]) for j in range(2)] for i in range(4)]
        )
        assert load_schedule.row_at(gains[:, :, 0].copy(), place, 3) == pytest.approx(gain[3, 0], rel=1e-12)
        begun, readings = RNG.normal(size=4), RNG.normal(size=2)
        estimate, states, scratch = begun.copy(), np.zeros(2), np.zeros(2)
        correct(observer, place, estimate, readings, states, scratch)
        expected = begun + gain @ (readings - output @ begun)
        np.testing.assert_allclose(estimate, expected, rtol=1e-11)
        np.testing.assert_array_equal(states, estimate[chosen])
        correct(observer, place, estimate, np.array([1.0, np.nan]), states, scratch)
        np.testing.assert_allclose(estimate, expected, rtol=1e-11)
        assert np.isnan(states).all()


@pytest.mark.parametrize("told", [0.8, 1.0, 1.7])
def test_a_scheduled_command_stands_about_what_the_announced_load_asks_for(told):
    """Wanted states and torque grow with the load beyond 1; the feedback is that of one over the load."""
    first, step, n2 = 0.5, 0.3, 4
    rows, matrix, kept = RNG.normal(size=(3, 1 + n2)), RNG.normal(size=(1, 1 + n2 + 1)), kept_state()
    kept.parameters[0] = told
    numbers = LawNumbers(SCHEDULED, matrix, rows, np.zeros((5, 1)), np.array([1e-3, first, step, 0.3, 5.0]))
    wanted, torque, more, heavier = RNG.normal(size=n2), 0.3, RNG.normal(size=n2), 0.2
    row = np.concatenate((wanted, [torque], more, [heavier]))[None, :]
    found, error = load_schedule.scheduled_command(numbers, kept, row, 0)
    place = (1.0 / told - first) / step
    gains = [np.interp(place, range(3), rows[:, j]) for j in range(1 + n2)]
    target = wanted + (told - 1.0) * more
    off = kept_state().states - target
    friction = 0.3 * np.tanh(5.0 * target[2])
    expected = 0.5 + torque + (told - 1.0) * heavier + friction + np.dot(gains[1:], off)
    assert (found, error) == pytest.approx((expected, off[1]), rel=1e-12)
    assert kept.memory[0] == pytest.approx(0.5 + gains[0] * matrix[0, 2] * off[1], rel=1e-12)


def test_the_first_finite_reading_of_an_encoder_is_its_zero():
    """One that is missing at the start is read from where it appears; none is moved later."""
    chain = model(3)
    sampling = Sampling(interval=INTERVAL)
    observer = kalman_filter(chain, [(0, 1e-3), (1, 1e-3)], sampling, chosen=[0, 1])
    law = pd_law(chain, 2.0, INTERVAL)
    target = new_target_state(observer, law, 0)
    start_target(np.zeros(0), target, np.array([np.nan, 0.2]))
    reference, step = np.zeros((1, 5)), interpreted(target_step)
    step(observer, law, 1.0, target, np.array([np.nan, 0.2]), reference)
    assert np.isnan(target.readings[0])
    assert target.missed[0] == 1
    for moved in (0.0, 0.05):
        readings = np.array([0.1, 0.2]) + moved
        step(observer, law, 1.0, target, readings, reference)
        np.testing.assert_allclose(target.readings, moved, atol=1e-15)
        np.testing.assert_array_equal(target.datum, [0.1, 0.2])


# --- The covariance recursion against a regression on all readings
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


@pytest.mark.parametrize(("states", "encoders"), [(2, 1), (5, 2), (7, 3)])
def test_the_recursion_ends_where_a_regression_on_all_readings_does(states, encoders):
    rng = np.random.default_rng(states)
    transition = np.eye(states) + 0.3 * rng.standard_normal((states, states))
    transition /= max(np.abs(np.linalg.eigvals(transition)))
    factor = rng.standard_normal((states, states))
    noise, start, reading = 1e-2 * factor @ factor.T, np.eye(states), np.diag(rng.uniform(0.1, 1.0, encoders))
    output = rng.standard_normal((encoders, states))
    readings = [rng.standard_normal(encoders) for _ in range(12)]
    gains = gain_schedule(transition, noise, output, reading, start)[:12]
    state = np.zeros(states)
    for k, (gain, row) in enumerate(zip(gains, readings, strict=True)):
        state = transition @ state if k > 0 else state
        state = state + gain @ (row - output @ state)
    expected = batch_state(transition, noise, output, reading, start, readings)
    np.testing.assert_allclose(state, expected, rtol=1e-9, atol=1e-10)


def test_a_settled_gain_ends_the_schedule():
    """A walk read with as much noise as it walks: gain 1/(1/2 + sqrt(5)/2), the golden ratio's inverse."""
    one = np.eye(1)
    gains = gain_schedule(one, one, one, one, 100.0 * one)
    assert 100 < len(gains) < 400
    assert gains[-1, 0, 0] == pytest.approx((np.sqrt(5.0) - 1.0) / 2.0, rel=1e-12)


@pytest.mark.parametrize("mass", [1e-6, 1e6])
def test_the_gains_of_a_filter_do_not_depend_on_the_unit_of_mass(mass):
    """That of the disturbance is N m per rad: it counted for nothing in mN m, and alone in MN m."""
    chain = replace(model(3), coulomb=(0.0, 0.0), offsets=(0.0, 0.0))
    names = ("inertias", "viscous", "stiffness", "damping")
    heavy = replace(chain, **{name: tuple(mass * one for one in getattr(chain, name)) for name in names})
    tuning = KalmanTuning(torque=1e-6, disturbance=1e-4)
    heavier = replace(tuning, torque=mass**2 * tuning.torque, disturbance=mass**2 * tuning.disturbance)
    own, other = (
        kalman_filter(
            one, [(0, 1e-3), (1, 1e-3)], Sampling(interval=INTERVAL), chosen=[0, 1], tuning=noise
        ).gains
        for one, noise in ((chain, tuning), (heavy, heavier))
    )
    assert other.shape == own.shape
    other[:, 2 * chain.size] /= mass
    np.testing.assert_allclose(other, own, rtol=1e-6, atol=1e-9 * np.abs(own).max())


# --- Commands of the laws that learn against their formulas in matrices
DRAWN = np.random.default_rng(11)
STATES, MEMORY, ENCODERS, PARAMETERS = 4, 2, 2, 3
WHITE = np.array([[2.0, 0.0], [-0.7, 1.5]])
WANTED, TORQUE = DRAWN.normal(size=STATES), 0.3
CARRIED = DRAWN.normal(size=(PARAMETERS, STATES))  # states that go with a unit of each parameter
TORQUES, SLOPES = DRAWN.normal(size=PARAMETERS), DRAWN.normal(size=(PARAMETERS, ENCODERS))
BEGUN, COVARIANCE = np.array([0.2, -0.1, 0.4]), np.diag([0.5, 0.3, 0.8]) + 0.1
INNOVATIONS = np.array([0.4, -0.9])


def law(kept=1.0, gate=1000000000.0, renewed=0.0):
    learning = np.zeros((5, PARAMETERS))
    learning[LOW], learning[HIGH], learning[GAIN] = -9.0, 9.0, 2.0
    rows = np.zeros((1 + ENCODERS, MEMORY + STATES))
    rows[0] = np.arange(1.0, 1.0 + MEMORY + STATES)
    rows[1:, :ENCODERS] = WHITE
    matrix = np.random.default_rng(3).normal(size=(MEMORY, MEMORY + STATES + 1))
    return LawNumbers(LEARNING, matrix, rows, learning, np.array([1e-3, kept, gate, renewed, 0.0, 0.0, 0.0]))


def kept_state():
    return ControllerState(
        sample=np.zeros(1, dtype=np.int64),
        estimate=np.zeros(2 * STATES),
        held=np.array([0.0, 0.7]),
        parameters=np.concatenate((BEGUN, COVARIANCE.ravel())),
        memory=np.array([0.5, -0.2]),
        commands=np.zeros(2),
        states=np.array([0.1, 0.4, -0.3, 0.8]),
        regressor=np.zeros(12),
        work=np.concatenate((INNOVATIONS, np.zeros(10))),
        table=np.zeros((0, 0)),
    )


def reference():
    parts = [WANTED, [TORQUE]]
    for carried, torque, slopes in zip(CARRIED, TORQUES, SLOPES, strict=True):
        parts += [carried, [torque], slopes]
    return np.concatenate(parts)[None, :]


def test_learning_without_forgetting_is_least_squares_with_a_prior():
    """One sample of all encoders: information adds up, however they follow one another."""
    kept = kept_state()
    learn_from_innovations(law(), kept, reference(), 0)
    information = np.linalg.inv(COVARIANCE) + SLOPES @ SLOPES.T
    posterior = np.linalg.inv(information)
    expected = BEGUN + posterior @ SLOPES @ (WHITE @ INNOVATIONS - SLOPES.T @ BEGUN)
    np.testing.assert_allclose(kept.parameters[:3], expected, rtol=1e-12)
    np.testing.assert_allclose(kept.parameters[3:].reshape(3, 3), posterior, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(("share", "learnt"), [(0.99, True), (1.01, False)])
def test_an_innovation_is_passed_over_beyond_the_gate_in_its_own_spread(share, learnt):
    """The spread is 1 + s^T P s of what noise and parameters explain; the covariance then goes back."""
    slope = SLOPES[:, 0]
    error = WHITE[0] @ INNOVATIONS - slope @ BEGUN
    spread = np.sqrt(1.0 + slope @ COVARIANCE @ slope)
    kept = kept_state()
    blind = reference()
    blind[0, -1 - np.arange(PARAMETERS) * (STATES + 1 + ENCODERS)] = 0.0  # the other encoder tells nothing
    one = law(gate=abs(error) / spread / share, renewed=0.25)
    one.rows[2] = 0.0
    learn_from_innovations(one, kept, blind, 0)
    assert (kept.parameters[:3].tolist() != BEGUN.tolist()) == learnt
    if not learnt:
        back = 0.75 * COVARIANCE + 0.25 * 2.0 * np.eye(3)
        np.testing.assert_allclose(kept.parameters[3:].reshape(3, 3), back, rtol=1e-13)


def test_the_command_follows_a_reference_that_carries_the_estimates():
    kept, numbers = kept_state(), law()
    before = kept.memory.copy()
    learn_from_innovations(numbers, kept, reference(), 0)
    command, load = feedback_command(numbers, kept, reference(), 0)
    estimate = kept.parameters[:3]
    error = kept.states - WANTED - estimate @ CARRIED
    both = np.concatenate((before, error))
    assert command == pytest.approx(TORQUE + estimate @ TORQUES + numbers.rows[0] @ both, rel=1e-12)
    assert load == pytest.approx(error[STATES // 2 - 1], rel=1e-12)
    np.testing.assert_allclose(kept.memory, numbers.matrix @ np.concatenate((both, [0.7])), rtol=1e-12)


def test_a_model_reference_law_adds_what_its_estimates_carry():
    kept = kept_state()
    numbers = law()._replace(kind=REFERENCE_MODEL)
    row = np.concatenate((WANTED, [TORQUE], TORQUES))
    command, feedback = reference_model_command(numbers, kept, row[None, :], 0)
    expected = numbers.rows[0, :STATES] @ (kept.states - WANTED)
    assert feedback == pytest.approx(expected, rel=1e-13)
    assert command == pytest.approx(TORQUE + expected + BEGUN @ TORQUES, rel=1e-13)
    np.testing.assert_array_equal(kept.regressor[:3], TORQUES)
