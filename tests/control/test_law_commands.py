"""Commands of cabledrive.control.law_kernels against their formulas in matrices."""

import numpy as np
import pytest

from cabledrive.control.law_kernels import learn_from_innovations, learning_command, reference_model_command
from cabledrive.control.numbers import GAIN, HIGH, LEARNING, LOW, REFERENCE_MODEL, ControllerState, LawNumbers

pytestmark = pytest.mark.kernel
RNG = np.random.default_rng(11)
STATES, MEMORY, ENCODERS, PARAMETERS = 4, 2, 2, 3
WHITE = np.array([[2.0, 0.0], [-0.7, 1.5]])
WANTED, TORQUE = RNG.normal(size=STATES), 0.3
CARRIED = RNG.normal(size=(PARAMETERS, STATES))  # states that go with a unit of each parameter
TORQUES, SLOPES = RNG.normal(size=PARAMETERS), RNG.normal(size=(PARAMETERS, ENCODERS))
BEGUN, COVARIANCE = np.array([0.2, -0.1, 0.4]), np.diag([0.5, 0.3, 0.8]) + 0.1
INNOVATIONS = np.array([0.4, -0.9])


def law(kept=1.0, gate=1e9, renewed=0.0) -> LawNumbers:
    learning = np.zeros((5, PARAMETERS))
    learning[LOW], learning[HIGH], learning[GAIN] = -9.0, 9.0, 2.0
    rows = np.zeros((1 + ENCODERS, MEMORY + STATES))
    rows[0] = np.arange(1.0, 1.0 + MEMORY + STATES)
    rows[1:, :ENCODERS] = WHITE
    matrix = np.random.default_rng(3).normal(size=(MEMORY, MEMORY + STATES + 1))
    return LawNumbers(LEARNING, matrix, rows, learning, np.array([1e-3, kept, gate, renewed, 0.0, 0.0, 0.0]))


def kept_state() -> ControllerState:
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


def reference() -> np.ndarray:
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
    command, load = learning_command(numbers, kept, reference(), 0)
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
