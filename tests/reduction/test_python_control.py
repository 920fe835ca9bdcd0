"""Exchange with python-control: the same response, poles and zeros; a refusal with the remedy without it."""

import sys

import numpy as np
import pytest

from cabledrive.parameters import InputRefused, load_drive
from cabledrive.reduction.lumped_chain import natural_frequencies_of
from cabledrive.reduction.models import lumped_model
from cabledrive.reduction.python_control import speed_to_control, to_control
from cabledrive.reduction.quality import model_response

DRIVE = load_drive("dissertation-3")
OMEGA = 2.0 * np.pi * np.array([0.3, 3.0, 8.0, 90.0, 300.0])


def test_without_python_control_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(InputRefused, match=r"\[control\]"):
        to_control(lumped_model(DRIVE, 4))


@pytest.mark.parametrize("model", [1, 2, 3, 4])
def test_state_space_answers_as_the_model_does(model, measured):
    control = pytest.importorskip("control")
    chain = lumped_model(DRIVE, model)
    system = to_control(chain)
    assert system.output_labels == [f"{name}_angle" for name in chain.names]
    found = np.atleast_2d(np.squeeze(control.frequency_response(system, OMEGA).frdata))[-1]
    expected = np.abs(model_response(DRIVE, model, OMEGA))
    measured(f"Model {model}: response within {np.max(np.abs(np.abs(found) / expected - 1.0)):.1e}")
    np.testing.assert_allclose(np.abs(found), expected, rtol=1e-8)


def test_transfer_function_has_the_modes_as_poles_and_the_held_drive_as_zeros(measured):
    """From motor torque to motor speed: zeros at the frequencies of the row with its motor held."""
    control = pytest.importorskip("control")
    chain = lumped_model(DRIVE, 4)
    system = speed_to_control(chain)
    poles = np.sort(np.abs(control.poles(system)))[1::2]
    modes = natural_frequencies_of(chain)
    held = np.linalg.eigvals(np.linalg.solve(np.diag(chain.inertias[1:]), chain.stiffness_matrix[1:, 1:]))
    zeros = np.sort(np.abs(control.zeros(system)))[::2]
    away = [np.max(np.abs(a / b - 1.0)) for a, b in ((poles, modes), (zeros, np.sort(np.sqrt(held))))]
    measured(f"poles within {100 * away[0]:.2g} %, zeros within {100 * away[1]:.2g} % of the undamped modes")
    np.testing.assert_allclose(poles, modes, rtol=2e-2)
    np.testing.assert_allclose(zeros, np.sort(np.sqrt(held)), rtol=2e-2)
