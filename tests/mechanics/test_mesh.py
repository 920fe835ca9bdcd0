"""The divided cable: mass, weight, places of carriages, conservative forces."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cabledrive.mechanics.cable_laws import LAWS, cable_law
from cabledrive.mechanics.mesh import cable_forces, mesh_of, strain_energy, weight_energy
from cabledrive.parameters.drive_file import load_drive
from cabledrive.parameters.drive_parts import Carriage
from cabledrive.parameters.errors import InputRefused

DRIVE = load_drive("dissertation-2")
places = st.lists(st.floats(0.001, 0.999), max_size=6, unique_by=lambda x: round(x, 4))


@given(upper=places, lower=places, segments=st.integers(3, 60))
def test_carriages_sit_on_nodes_and_mass_is_conserved(upper, lower, segments):
    """Whatever the places: each carriage at its place to round-off, and the whole mass of the cable."""
    on = [(p, "upper") for p in upper] + [(p, "lower") for p in lower]
    carriages = tuple(Carriage(mass=1e-3 * (k + 1), position=p, span=s) for k, (p, s) in enumerate(on))
    drive = replace(DRIVE, carriage=carriages)
    mesh = mesh_of(drive, segments)
    stretch = 1.0 + drive.cable.prestrain
    for carriage, node in zip(carriages, mesh.carriage_node, strict=True):
        span = mesh.spans.index(carriage.span)
        assert mesh.position[span, node - span * mesh.segments] == pytest.approx(carriage.position * stretch)
        assert mesh.carriage_mass[node] == carriage.mass
    cable = drive.cable.mass_per_length * drive.span_length * 2
    assert mesh.cable_mass[:-1].sum() == pytest.approx(cable, rel=1e-12)
    assert mesh.spacing.sum() == pytest.approx(2 * drive.pulley_distance, rel=1e-12)
    assert mesh.segments >= max(segments, len(upper) + 1, len(lower) + 1)


def test_gravity_has_the_printed_signs_and_follows_the_slope():
    """(2.26), (2.27): -g on w1, +g on w2; on a slope the rest goes along u, downhill in both spans."""
    level = mesh_of(DRIVE, 10)
    assert (level.weight_w[1:10] < 0.0).all()
    assert (level.weight_w[11:20] > 0.0).all()
    assert not level.weight_u.any()
    steep = mesh_of(replace(DRIVE, layout=replace(DRIVE.layout, inclination=pi / 6)), 10)
    np.testing.assert_allclose(steep.weight_w, level.weight_w * np.cos(pi / 6), rtol=1e-12)
    np.testing.assert_allclose(steep.weight_u[1:10], level.weight_w[1:10] * 0.5, rtol=1e-12)
    assert abs(steep.weight_u[0]) < 1e-12 * abs(steep.weight_u[1]), "the half cells at a rim pull apart"


@pytest.mark.parametrize("name", [name for name, law in LAWS.items() if law.has_potential])
@pytest.mark.parametrize("kind", ["loop", "line"])
def test_forces_are_minus_the_derivative_of_the_energy(name, kind):
    """Complex step through every nodal displacement of a small chain."""
    drive = replace(DRIVE, kind=kind)
    mesh, law = mesh_of(drive, 4), cable_law(drive.cable, name)
    displacement = 1e-3 * np.random.default_rng(2).standard_normal((3, mesh.nodes))
    if mesh.closed:
        displacement[:, -1] = displacement[:, 0]
    force = cable_forces(mesh, law, displacement)
    for axis in range(3):
        for node in range(mesh.nodes - mesh.closed):
            stepped = displacement.astype(complex)
            stepped[axis, node] += 1e-30j
            if mesh.closed:
                stepped[:, -1] = stepped[:, 0]
            slope = np.imag(strain_energy(mesh, law, stepped).sum()) / 1e-30
            assert force[axis, node] == pytest.approx(-slope, rel=1e-11, abs=1e-11 * law.pretension)


def test_weight_energy_falls_as_the_cable_sinks():
    mesh = mesh_of(DRIVE, 10)
    displacement = np.zeros((3, mesh.nodes))
    displacement[2, 1:10] = -1e-3
    lowered = mesh.density * mesh.spacing[0] * 9 * 9.81 * 1e-3
    assert weight_energy(mesh, displacement) == pytest.approx(-lowered, rel=1e-12)


@pytest.mark.parametrize(
    ("segments", "words"),
    [
        (2, "needs at least 3"),
        (10**7, "at most 1000000"),
        (10.5, "not a whole number"),
        (True, "not a whole"),
    ],
)
def test_a_useless_division_is_refused(segments, words):
    with pytest.raises(InputRefused, match=words):
        mesh_of(DRIVE, segments)
