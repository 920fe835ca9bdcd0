"""Settings replace values of the file for one run, in tables and in arrays."""

import tomllib
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import pytest

from cabledrive.parameters import Carriage, Goal, InputRefused, load_drive
from cabledrive.parameters.units import to_si

EXAMPLE = Path(__file__).with_name("contract_example.toml")
DRIVE = load_drive(EXAMPLE)


def overridden(*settings):
    return load_drive(EXAMPLE, overrides=settings)


@pytest.mark.parametrize(
    "setting",
    [
        "cable.pretension=6",
        "cable.pretension=6 N",
        'cable.pretension="6 N"',
        " cable . pretension = 6 N ",
    ],
)
def test_setting_replaces_a_quantity_however_it_is_quoted(setting):
    assert overridden(setting) == replace(DRIVE, cable=replace(DRIVE.cable, pretension=6.0))


def test_settings_reach_into_arrays_and_add_a_table_and_rows():
    first, second = DRIVE.pulley
    assert overridden("pulley.1.fixed=true").pulley == (first, replace(second, fixed=True))
    drive = overridden("goal.tracking_error=0.1 deg", "carriage.0.mass=1", "carriage.0.position=0.5")
    assert drive.goal == Goal(tracking_error=0.0017453292519943296)
    assert drive.carriage == (Carriage(mass=1.0, position=0.5),)
    two = overridden("carriage=[{mass=1, position=0.5}, {mass=2, position=0.6}]", "carriage.1.mass=3")
    assert [carriage.mass for carriage in two.carriage] == [1.0, 3.0]


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("", "is not KEY=VALUE"),
        ("cable.pretension", "is not KEY=VALUE"),
        ("cable..pretension=6", 'unknown key "cable."'),
        ("cable.capstan_friction=0.2", "that of a wrap is capstan_friction of its \\[\\[pulley\\]\\]"),
        ("a." * 100_000 + "b=6", "does not name a value"),
        ("name.x.y=6", "inside a value, not a table"),
        ("pulley.3.radius=1", "pulley has 2 entries, numbered from 0"),
        ("pulley.-1.radius=1", "pulley has 2 entries, numbered from 0"),
        ("pulley.٠.radius=1", "pulley has 2 entries, numbered from 0"),
        ("pulley.2.radius=1", 'missing key "pulley.2.inertia"'),
        ("cable.tension=6", 'unknown key "cable.tension" \\(did you mean "cable.pretension"\\?\\)'),
        ("cable.pretension=", '"" is not a quantity'),
        ("cable.pretension=" + "[" * 10_000, "is not a quantity"),
        ("cable.pretension=\udcff", "is not a quantity"),
        ("name=\udcff", "holds the character"),
    ],
    ids=lambda text: ascii(text)[:40],
)
def test_setting_that_makes_no_sense_is_refused_in_one_line(setting, words):
    with pytest.raises(InputRefused, match=words) as refusal:
        overridden(setting)
    message = str(refusal.value)
    assert message.isprintable()
    assert len(message) < 300


# --- The packaged table of belts and ropes: its figures against each other, and a source for each entry
TABLE = tomllib.loads((files("cabledrive.parameters") / "cable_types.toml").read_text())
UNITS = {
    "axial_rigidity": "N",
    "mass_per_length": "kg/m",
    "strength": "N",
    "bending_stiffness": "N m^2",
    "least_radius": "m",
}


def figures(name):
    return {key: to_si(TABLE[name][key], unit) for key, unit in UNITS.items() if key in TABLE[name]}


@pytest.mark.parametrize("name", TABLE)
def test_rigidity_mass_and_strength_fit_each_other(name, measured):
    """Longitudinal waves of cords in rubber or air run at 0.9 to 12 km/s; cables break at 0.2 to 5 %."""
    own = figures(name)
    wave = (own["axial_rigidity"] / own["mass_per_length"]) ** 0.5
    strain = own["strength"] / own["axial_rigidity"] if "strength" in own else None
    measured(f"{name}: waves {wave:.0f} m/s, strain at its strength {strain}")
    assert 900.0 < wave < 12_000.0
    assert strain is None or 0.002 < strain < 0.05
    if "strain_limit" in TABLE[name] and strain is not None:
        assert strain == pytest.approx(float(TABLE[name]["strain_limit"]), rel=0.05)
    assert own.get("least_radius", 1e-3) > 0.0


@pytest.mark.parametrize("name", TABLE)
def test_every_entry_has_a_source_of_its_own_or_that_of_a_named_entry(name):
    source = TABLE[name]["source"]
    if source.startswith("As "):
        source = TABLE[source.split()[1].rstrip(".,:;")]["source"]
    assert len(source.split()) > 5
