"""L1 and model reference adaptation against a torque at the motor, on the sampled chain itself."""

import numpy as np
import pytest
from scipy.linalg import expm

from cabledrive.control.adaptive_laws import l1_law, reference_model_law
from cabledrive.control.law_kernels import adapt, linear_command, reference_model_command
from cabledrive.control.linear_laws import lq_law
from cabledrive.control.numbers import HIGH, LOW
from cabledrive.reduction.lumped_chain import state_space
from control_chains import INTERVAL, model, state_of

COUNT, TORQUE, HELD = 2.0 * np.pi / 10_000, 0.05, 0.03
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
        u, _ = linear_command(law, kept, still, 0)
        x = a @ x + b * (u + held)
    return found


@pytest.mark.parametrize("number", [3, 4])
def test_l1_removes_a_torque_that_lasts_and_the_feedback_alone_does_not(number, measured):
    torque = np.full(SAMPLES, HELD)
    alone = load_error(lq_law(model(number), COUNT, TORQUE, INTERVAL), torque, number)
    removed = load_error(l1_law(model(number), COUNT, TORQUE, 10.0, INTERVAL), torque, number)
    measured(f"{abs(removed[-1] / alone[-1]):.1e} of the error is left")
    assert abs(alone[-1]) > 0.3 * COUNT
    assert abs(removed[-1]) < 1e-6 * abs(alone[-1])


def test_l1_lets_a_torque_above_its_low_pass_to_the_feedback():
    """At ten times the low-pass the error differs from that of the feedback alone by less than a third."""
    torque = HELD * np.sin(2.0 * np.pi * 60.0 * INTERVAL * np.arange(4000))
    alone, slow = (
        np.ptp(load_error(law, torque)[2000:])
        for law in (
            lq_law(model(4), COUNT, TORQUE, INTERVAL),
            l1_law(model(4), COUNT, TORQUE, 6.0, INTERVAL),
        )
    )
    assert slow == pytest.approx(alone, rel=0.34)


def test_model_reference_adaptation_finds_the_factors_of_a_torque_and_keeps_its_bounds(measured):
    """Two functions with factors 0.03 and -0.02, and a third beyond its bound, which it stops at."""
    a, b = sampled(model(4))
    time = INTERVAL * np.arange(60_000)
    functions = np.column_stack((np.sin(7.0 * time), np.cos(13.0 * time), np.ones(len(time))))
    truth = np.array([0.03, -0.02, 0.05])
    high = np.array([0.04, 0.04, 0.045])
    law = reference_model_law(lq_law(model(4), COUNT, TORQUE, INTERVAL), -high, high, np.ones(3), 2.0 * np.pi)
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
