"""Frequencies against any figure of the drive: nothing missed, curves followed by their shapes."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.modal import longitudinal_modes, natural_frequencies
from cabledrive.parameters import Carriage, InputRefused, load_drive
from cabledrive.studies import frequency_against
from cabledrive.studies.following import mass_weighted_shapes
from cabledrive.studies.varied_drive import quantity_of, varied

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


@pytest.mark.parametrize("off_centre", [0.02, 0.001])
def test_curves_veer_where_symmetry_is_broken_with_a_gap_in_proportion(off_centre):
    """A mass off midspan couples the two modes: they keep their order and exchange shapes.

    Of unit modal mass, the out-of-phase mode moves the mass by its slope times the shift, the in-phase mode
    by its displacement: the coupling m u_a' u_b of the kinetic energy is the relative gap per shift.
    """
    out, within = longitudinal_modes(with_mass(0.5, 2.02 * RIM), count=2)[::-1]
    coupling = 2 * RIM * out.slopes_at("carriage 0")[0][0] * within.joints["carriage 0"][0]
    values = np.geomspace(2e-4, 0.2, 12)
    data = frequency_against(with_mass(0.5 + off_centre), "carriage.0.mass", values, modes=2)
    (veering,) = crossing_rows(data)
    assert veering["kind"] == "veering"
    assert veering["value"] == pytest.approx(2 * RIM, rel=0.02)
    assert np.all(data.frequency.values[0] < data.frequency.values[1])
    assert data.family.values[0, 0] == data.family.values[1, -1] == "pulleys out of phase"
    expected = abs(coupling) * out.frequency * off_centre
    assert veering["gap"] == pytest.approx(expected, rel=0.02), f"gap {veering['gap']:.6g} Hz"


def test_gap_of_a_veering_is_the_least_distance_of_the_curves():
    values = np.geomspace(2e-4, 0.2, 12)
    drive = with_mass(0.51)
    (veering,) = crossing_rows(frequency_against(drive, "carriage.0.mass", values, modes=2))
    near = veering["value"] * (1 + np.linspace(-0.02, 0.02, 81))
    pairs = np.array([natural_frequencies(varied(drive, "carriage.0.mass", m), count=2) for m in near])
    gap = 2 * (pairs[:, 1] - pairs[:, 0]) / pairs.sum(axis=1)
    least = gap.min() * veering["frequency"]
    assert veering["gap"] == pytest.approx(least, rel=1e-4)


def test_joint_mode_rises_through_the_modes_of_the_cable():
    """A stiffer motor joint in configuration 3: it veers from one cable mode, crosses the one at rest."""
    drive = load_drive("dissertation-3")
    data = frequency_against(drive, "motor.joint_stiffness", np.geomspace(10.0, 3e4, 12), modes=4)
    kinds = [(row["kind"], round(row["frequency"])) for row in crossing_rows(data)]
    assert ("veering", 807) in kinds, kinds
    assert ("crossing", 807) in kinds, kinds
    assert data.family.values[1, 3] == "motor joint"


def test_curves_of_equal_frequency_stay_together():
    """Both pulleys held: the two spans are alike, every mode is double at every value."""
    held = replace(LOOP, pulley=tuple(replace(pulley, fixed=True) for pulley in LOOP.pulley))
    data = frequency_against(held, "layout.span_length", np.linspace(0.5, 2.0, 5), modes=4)
    np.testing.assert_allclose(data.frequency[0], data.frequency[1], rtol=1e-12)
    np.testing.assert_allclose(data.frequency[2], 2 * data.frequency[0], rtol=1e-9)
    assert data.crossing.size == 0


def test_mode_that_comes_down_from_above_has_its_own_curve():
    """The carriage's mode starts as the third and ends among the lowest two."""
    data = frequency_against(with_mass(0.5), "carriage.0.mass", np.geomspace(2e-5, 0.05, 10), modes=1)
    assert data.mode.size == 2
    assert data.frequency.values[1, -1] < data.frequency.values[0, -1]


def test_pretension_moves_the_transverse_modes_alone():
    """c_w/(2 Le) = sqrt(T0/(1 + eps0)/rho0)/(2 L); longitudinal modes of a loop of given length stay."""
    tensions = np.array([1.0, 5.0, 25.0])
    drive = replace(LOOP, layout=replace(LOOP.layout, gravity=0.0))  # no sag that would raise the tension
    data = frequency_against(drive, "cable.pretension", tensions)
    np.testing.assert_allclose(data.frequency, np.tile(data.frequency[:, :1], 3), rtol=1e-12)
    stretch = 1 + tensions / LOOP.cable.axial_rigidity
    expected = np.sqrt(tensions / stretch / LOOP.cable.mass_per_length) / 2
    np.testing.assert_allclose(data.lowest_transverse, expected, rtol=1e-12)


def test_more_inertia_never_raises_a_frequency():
    data = frequency_against(LOOP, "pulley.1.inertia", np.geomspace(1e-7, 1e-2, 25), modes=5)
    steps = np.diff(np.sort(data.frequency, axis=0), axis=1)
    assert np.all(steps < 1e-9), f"largest step {steps.max():.3g} Hz"


def test_values_come_back_in_the_order_given():
    values = [5e-6, 1e-6, 3e-6, 1e-6]
    data = frequency_against(LOOP, "pulley.0.inertia", values, modes=2)
    assert list(data.value.values) == values
    up = frequency_against(LOOP, "pulley.0.inertia", sorted(set(values)), modes=2)
    np.testing.assert_array_equal(data.frequency[:, [1, 2, 0]], up.frequency)


def test_result_says_its_units_and_what_it_was_computed_from():
    data = frequency_against(LOOP, "pulley.0.inertia", [1e-6, 2e-6], modes=2)
    assert data.frequency.attrs["units"] == data.lowest_transverse.attrs["units"] == "Hz"
    assert data.value.attrs["units"] == "kg m^2"
    assert len(data.attrs["drive_hash"]) == 64


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


def test_quantity_is_named_as_in_the_schema():
    assert quantity_of(LOOP, "cable.pretension")[0] == "N"
    assert quantity_of(LOOP, "pulley.1.radius") == ("m", "radius at the cable's centre line")


def test_too_many_modes_are_refused():
    with pytest.raises(InputRefused, match="between 1 and 200"):
        frequency_against(LOOP, "cable.pretension", [1.0], modes=0)
