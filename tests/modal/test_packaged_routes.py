"""The packaged machines with routes: certified modes against finite elements from their files."""

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.mechanics.network import statics_of
from command import answer
from oracles.route_fem import frequencies_of_route

ROUTES = cd.packaged_drives("route")
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


@pytest.mark.parametrize("name", ROUTES)
def test_check_takes_it_and_its_figures_have_sources(name):
    found = answer("check", name)
    drive = cd.load_drive(name)
    assert found["valid"]
    assert found["drive_hash"] == cd.content_hash(drive)
    assert "estimate" in drive.source
    assert [span["name"] for span in found["spans"]] == [span.name for span in drive.free_spans]
    safety = [span["safety_factor"] for span in found["spans"] if span["safety_factor"] is not None]
    assert all(factor > 3.0 for factor in safety)
    assert all("askew" in line for line in found["warnings"])


@pytest.mark.parametrize("name", ROUTES)
def test_its_modes_are_those_of_finite_elements(name, measured):
    drive, below = cd.load_drive(name), BELOW[name]
    found, statics = cd.modes(drive, below=below), statics_of(drive)
    tensions = list(zip(statics.start, statics.end, strict=True))
    truth = frequencies_of_route(drive, tensions, DEGREE.get(name, 16), below)
    listed = np.repeat([m.frequency for m in found.modes], [m.multiplicity for m in found.modes])
    expected = truth[truth < below][found.rigid_body_modes :]
    assert found.certified
    assert listed.size == found.certificate.count == expected.size > 0
    error = np.max(np.abs(listed / expected - 1.0))
    measured(f"{name}: {listed.size} modes below {below:g} Hz, largest relative difference {error:.1e}")
    assert error < 1e-6, error
