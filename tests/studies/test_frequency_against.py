"""Frequencies against any figure of the drive: nothing missed, curves followed by their shapes."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.modal import longitudinal_modes, natural_frequencies
from cabledrive.parameters import Carriage, InputRefused, load_drive
from cabledrive.studies import frequency_against
from cabledrive.studies.following import mass_weighted_shapes
from cabledrive.studies.varied_drive import varied

LOOP = load_drive("dissertation-1")
RIM = LOOP.drive_pulley.rim_mass


def with_mass(position, mass=2 * RIM, drive=LOOP):
    return replace(drive, carriage=[Carriage(mass=mass, position=position)])


def crossing_rows(data):
    names = ("kind", "value", "frequency", "gap", "first", "second")
    return [
        dict(zip(names, row, strict=True))
        for row in zip(*(data[f"crossing_{name}"].values for name in names), strict=True)
    ]


@pytest.mark.parametrize(
    ("name", "key", "values"),
    [
        ("dissertation-1", "pulley.0.inertia", np.geomspace(1e-7, 1e-2, 9)),
        ("dissertation-2", "pulley.1.inertia", np.geomspace(1e-7, 1e-2, 9)),
        ("dissertation-transporter", "carriage.0.position", np.linspace(0.02, 0.98, 11)),
        ("dissertation-transporter", "carriage.0.mass", np.geomspace(1e-5, 1.0, 9)),
        ("dissertation-3", "motor.joint_stiffness", np.geomspace(1.0, 1e5, 9)),
        ("printer-belt", "carriage.0.position", np.linspace(0.02, 0.28, 15)),
        ("camera-line", "carriage.0.position", np.linspace(2.0, 36.0, 9)),
        ("linear-axis", "carriage.0.position", None),
        ("elevator", "carriage.0.mass", None),
    ],
)
def test_curves_hold_the_lowest_modes_at_every_value(name, key, values):
    """Sorted, the followed curves are the certified list, whatever crosses on the way."""
    drive = load_drive(name)
    if values is None:
        here = drive.carriage[0].position if key.endswith("position") else drive.carriage[0].mass
        values = np.linspace(0.3, 0.9, 7) * here
    data = frequency_against(drive, key, values, modes=4)
    for value in values:
        listed = natural_frequencies(varied(drive, key, value), count=4)[:4]
        curves = np.sort(data.frequency.sel(value=value).values)[:4]
        np.testing.assert_allclose(curves, listed, rtol=1e-11)


@pytest.mark.parametrize("points", [2, 3, 40])
def test_modes_of_a_symmetric_loop_cross_whatever_the_values_are(points):
    """A mass at midspan takes the in-phase mode below the fundamental at m = 2 J/r^2; both keep shape."""
    values = np.geomspace(2e-4, 0.2, points)
    data = frequency_against(with_mass(0.5), "carriage.0.mass", values, modes=2)
    (crossing,) = crossing_rows(data)
    assert crossing["kind"] == "crossing"
    assert crossing["value"] == pytest.approx(2 * RIM, rel=1e-7), f"{crossing}"
    assert crossing["frequency"] == pytest.approx(116.32932059, rel=1e-8)
    assert (crossing["first"], crossing["second"]) == (0, 1)
    np.testing.assert_allclose(data.frequency[0], 116.32932059254597, rtol=1e-11)
    assert set(data.family.values[0]) == {"pulleys out of phase"}
    assert np.all(np.diff(data.frequency.values[1]) < 0)


def test_mass_weighted_shapes_of_one_drive_are_orthonormal():
    """Kinetic energy of two different modes does not mix; what is left is the width of the cells."""
    drive = load_drive("dissertation-transporter")
    shapes = mass_weighted_shapes(drive, longitudinal_modes(drive, count=6), 512)
    left = np.abs(shapes.T @ shapes - np.eye(6)).max()
    assert left < 1e-4, f"{left:.1e}"


@pytest.mark.parametrize(
    ("key", "values", "reason"),
    [
        ("pulley.0.inertai", [1e-6], "did you mean"),
        ("pulley.2.inertia", [1e-6], "numbered from 0"),
        ("motor.inertia", [1e-3], r"no \[motor\]"),
        ("kind", [1.0], "not a quantity"),
        ("sensors.drive_encoder", [1000.0], "not a quantity"),
        ("pulley.0.inertia", [1e-6, -1e-6], "must be above 0"),
        ("pulley.0.inertia", [float("nan")], "finite"),
        ("pulley.0.inertia", [], "finite numbers"),
        ("cable", [1.0], "not a quantity"),
    ],
)
def test_what_cannot_be_varied_is_refused(key, values, reason):
    with pytest.raises(InputRefused, match=reason):
        frequency_against(LOOP, key, values)
