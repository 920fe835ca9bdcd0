"""Certified modes of machines with routes: drives with two pulleys, closed forms, reference machines."""

import numpy as np
import pytest
from machines import by_multiplicity

import cabledrive as cd
from cabledrive.mechanics.network import statics_of
from cabledrive.modal.motion import HeldMode
from cabledrive.parameters.route.two_pulleys import as_machine
from network_samples import route, without_gravity
from oracles.route_fem import frequencies_of_route

FIVE = ("dissertation-1", "dissertation-2", "dissertation-3", "printer-belt", "linear-axis")
MOTORS = ("free", "held")
AT_REST = ("camera-line", "elevator", "linear-axis", "printer-belt", "ropeway")


@pytest.mark.parametrize(
    ("drive", "motor"),
    [
        *((without_gravity(cd.load_drive(n)), motor) for n in (*FIVE, AT_REST[0]) for motor in MOTORS),
        *((cd.load_drive(name), "free") for name in AT_REST),
    ],
)
def test_a_drive_as_a_route_has_all_its_modes_with_their_number(drive, motor):
    """Strings in both planes, where they weigh with slopes to 10 %; hanging carriages swing in both."""
    expected, found = (cd.modes(one, count=10, motor=motor) for one in (drive, as_machine(drive)))
    assert found.certified or drive.layout.gravity
    assert found.certificate.count == expected.certificate.count
    assert found.rigid_body_modes == expected.rigid_body_modes
    np.testing.assert_allclose(by_multiplicity(found.modes), by_multiplicity(expected.modes), rtol=1e-12)


def test_strain_energy_is_kinetic_energy():
    """What springs, turning bodies and spans store in a mode is what moves in it, row by row."""
    for name in ("printer", "serpentine", "finger"):
        for mode in cd.modes(route(name), below=3000.0 / (2 * np.pi)).modes:
            if not isinstance(mode, HeldMode):
                own = mode.solved
                strain, kinetic = mode.cut.energies(own.omega, own.placed, own.shapes)
                assert kinetic.sum() == pytest.approx(2.0 * own.omega**2, rel=1e-9)
                assert strain.sum() == pytest.approx(2.0 * own.omega**2, rel=1e-9)


def test_shapes_meet_their_pulleys():
    """At its end on a pulley the belt moves along as the rim does."""
    drive = route("printer")
    mode = cd.modes(drive, below=300.0).longitudinal[0]
    span = drive.free_spans[1]
    ends = mode.shape(span.name, np.array([0.0, span.length]))[0]
    rims = [place.radius * mode.joints[place.name][0] for place in (span.start, span.end)]
    np.testing.assert_allclose(ends, rims, rtol=1e-10)


def test_a_fast_belt_is_warned_of():
    assert "83% of the wave speed" in " ".join(
        cd.modes(route("serpentine", "route.belt.speed=45"), below=100.0).warnings
    )


def test_a_span_that_sags_deep_is_not_certified():
    """A camera of 1 kg lets its lines sag beyond what is taken for shallow."""
    found = cd.modes(cd.load_drive("camera-winches", overrides=["body.camera.mass=1"]), below=2.0)
    assert not found.certified
    assert "sag" in found.certified_reason


# --- The packaged machines: certified modes against finite elements from their files
PACKAGED = cd.packaged_drives("route")
BELOW = {
    "camera-winches": 10.0,
    "capstan-arm": 1800.0,
    "corexy": 320.0,
    "lift-2-to-1": 4.0,
    "printer-idlers": 400.0,
    "ropeway-towers": 0.6,
    "serpentine": 260.0,
    "tendon-finger": 700.0,
}
DEGREE = {"lift-2-to-1": 14}


@pytest.mark.parametrize("name", PACKAGED)
def test_its_modes_are_those_of_finite_elements(name, measured):
    drive, below = cd.load_drive(name), BELOW[name]
    found, statics = cd.modes(drive, below=below), statics_of(drive)
    tensions = list(zip(statics.start, statics.end, strict=True))
    truth = frequencies_of_route(drive, tensions, DEGREE.get(name, 16), below)
    listed = by_multiplicity(found.modes)
    expected = truth[truth < below][found.rigid_body_modes :]
    assert found.certified
    assert listed.size == found.certificate.count == expected.size > 0
    error = np.max(np.abs(listed / expected - 1.0))
    measured(f"{name}: {listed.size} modes below {below:g} Hz, largest relative difference {error:.1e}")
    assert error < (2e-6 if name == "camera-winches" else 1e-6), error  # sag is shallow in the elements
