"""The data of Figs. 3.1-3.4 and 3.9 show what the text says they show, and what it does not."""

import numpy as np
import pytest

from cabledrive.modal import longitudinal_modes
from cabledrive.modal.printed import loop_matrix
from cabledrive.parameters import load_drive
from cabledrive.studies import modal_determinant, mode_shapes, with_carriage

LOOP = load_drive("dissertation-1")


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


def test_mass_at_midspan_rests_in_the_fundamental_and_leads_the_in_phase_mode():
    """Fig. 3.9: a node at the mass; in the mode above it the whole of the upper span goes with the mass."""
    data = mode_shapes(with_carriage(LOOP, 5.0, 0.5), modes=2)
    bare = mode_shapes(LOOP)
    np.testing.assert_allclose(data.displacement[0], bare.displacement[0], atol=1e-9)
    assert abs(data.carriage_displacement[0, 0]) < 1e-9
    assert data.carriage_displacement[1, 0] == pytest.approx(1.0, abs=1e-9)
    assert list(data.carriage_position.values) == [0.5]


def test_shapes_of_a_double_mode_are_both_given():
    held = load_drive("dissertation-1")
    ring = with_carriage(held, held.drive_pulley.rim_mass / 9.8e-4, 0.5)
    ring = with_carriage(ring, held.drive_pulley.rim_mass / 9.8e-4, 0.5, span="lower")
    data = mode_shapes(ring, modes=3)
    assert longitudinal_modes(ring, count=1)[0].multiplicity == 2
    assert data.frequency[0] == data.frequency[1] != data.frequency[2]
    first, second = (data.displacement.values[i].ravel() for i in (0, 1))
    cosine = abs(first @ second) / np.linalg.norm(first) / np.linalg.norm(second)
    assert cosine < 0.9, f"cosine {cosine:.3f}"
