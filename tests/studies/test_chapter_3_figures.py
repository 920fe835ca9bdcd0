"""The data of Figs. 3.1-3.4 and 3.9 show what the text says they show, and what it does not."""

import numpy as np
import pytest

from cabledrive.modal.printed import loop_matrix
from cabledrive.parameters import load_drive
from cabledrive.studies import modal_determinant, mode_shapes


@pytest.mark.parametrize("name", ["dissertation-1", "dissertation-2"])
def test_determinant_changes_sign_at_every_mode_the_in_phase_ones_included(name):
    """Figs. 3.1 and 3.2: its zero crossings are the natural frequencies, 751.73 Hz among them."""
    data = modal_determinant(load_drive(name))
    sign = np.sign(data.determinant.values[1:])
    frequency = data.frequency.values[1:]
    crossings = frequency[:-1][sign[:-1] != sign[1:]]
    inside = data.natural_frequency.values
    assert crossings.size == inside.size
    assert np.all((crossings <= inside) & (inside <= crossings + 1.0)), f"{crossings} and {inside} Hz"
    assert np.any(np.abs(inside - 751.7327) < 1e-3)


@pytest.mark.parametrize("name", ["dissertation-1", "dissertation-2"])
def test_fundamental_shapes_come_from_the_null_space_of_3_13(name):
    """Figs. 3.3 and 3.4: U_i = a_i cos + b_i sin with the null vector, largest value 1."""
    drive = load_drive(name)
    data = mode_shapes(drive)
    omega = 2 * np.pi * data.frequency.values[0]
    a1, a2, b1, b2 = np.linalg.svd(loop_matrix(drive, omega))[2][-1]
    phase = omega * data.position.values / np.sqrt(drive.cable.axial_rigidity / drive.cable.mass_per_length)
    expected = np.array([a * np.cos(phase) + b * np.sin(phase) for a, b in ((a1, b1), (a2, b2))])
    expected *= data.displacement.values[0].ravel() @ expected.ravel() / np.sum(expected**2)
    np.testing.assert_allclose(data.displacement[0], expected, atol=1e-10)
    assert np.abs(data.displacement.values).max() == pytest.approx(1.0, abs=1e-14)
