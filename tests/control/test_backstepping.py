"""The backstepping law against its hand-written oracle, against differences, and its matrix D_z.

Compiled modules under test: cabledrive.control.backstepping_kernels,
cabledrive.control.backstepping_recursion.
"""

import numpy as np
import pytest

from cabledrive.control.backstepping import (
    backstepping_gains,
    backstepping_numbers,
    error_matrix,
    scaled_stability,
    unmatched_parameters,
)
from cabledrive.control.backstepping_kernels import backstepping_command
from cabledrive.control.backstepping_recursion import work_shape
from cabledrive.parameters import InputRefused
from control_chains import INTERVAL, model, state_of
from oracles.printed_backstepping import Gains, corrected_backstepping, plant

pytestmark = pytest.mark.kernel

CHAIN = model(3)
GAINS = backstepping_gains()
LAW = backstepping_numbers(CHAIN, GAINS, INTERVAL)


def command(states, y, estimate):
    kept = state_of(states, estimate, table=work_shape(2))
    u, z1 = backstepping_command(LAW, kept, y[None, :], 0)
    return u, z1, kept.regressor[:7]


def test_compiled_law_is_the_corrected_law(measured):
    """u and tau of (6.90) and (6.95), mended, at random states and estimates."""
    rng = np.random.default_rng(0)
    parameters, widths, beta = unmatched_parameters(CHAIN)
    k = Gains(
        GAINS.k1, GAINS.k21, GAINS.k22, 0.0, GAINS.k32, GAINS.k33, 0.0, GAINS.k42, GAINS.k43, GAINS.k44, 0.0
    )
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


def test_errors_obey_their_matrix_along_the_motion():
    """z' = A_z z with true parameters: differences along (6.69) against (6.103), mended."""
    rng = np.random.default_rng(1)
    parameters, _, beta = unmatched_parameters(CHAIN)
    k = Gains(
        GAINS.k1, GAINS.k21, GAINS.k22, 0.0, GAINS.k32, GAINS.k33, 0.0, GAINS.k42, GAINS.k43, GAINS.k44, 0.0
    )
    x, y = rng.normal(size=4) * [1e-2, 0.1, 1.0, 10.0], np.zeros(5)
    S = np.tanh(0.5 * (x[1] + x[3] / beta))
    here = corrected_backstepping(x, y, parameters, k, beta, S)
    rate = np.array(plant(x, here.u, parameters, 0.0, 0.0, beta, S))
    step = 1e-7

    def errors(sign):
        return np.array(corrected_backstepping(x + sign * step * rate, y, parameters, k, beta, S).z)

    found = (errors(1) - errors(-1)) / (2 * step)
    np.testing.assert_allclose(found, error_matrix(GAINS, 1.0) @ np.array(here.z), rtol=1e-5)


def test_parameters_are_those_of_table_6_3():
    parameters, widths, beta = unmatched_parameters(CHAIN)
    assert beta == pytest.approx(1157.4, rel=1e-4)
    np.testing.assert_allclose(parameters[[0, 2, 3, 6]], [1.0, 2718.9, 2059.8, 574.05], rtol=1e-3)
    np.testing.assert_allclose(widths[[0, 2, 3, 6]], [0.05, 81.5, 61.5, 17.5], rtol=0.02)


def test_scaled_condition_holds_without_adaptation():
    """Each error in one unit: the smallest eigenvalue of D_z is positive at 10.5 Hz."""
    assert scaled_stability(GAINS, 1.0) > 0.0


@pytest.mark.parametrize("choices", [{"bandwidth": -1.0}, {"bandwidth": float("nan")}, {"adaptation": -1.0}])
def test_gains_that_cannot_be_are_refused(choices):
    with pytest.raises(InputRefused):
        backstepping_gains(**choices)


def test_model_4_has_too_many_inertias_for_it():
    with pytest.raises(InputRefused, match="Model 3"):
        unmatched_parameters(model(4))
