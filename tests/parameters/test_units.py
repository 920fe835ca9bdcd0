"""Text with a unit becomes one SI number, rounded once; settings that replace values for one run."""

import re
import tomllib
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from importlib.resources import files
from math import inf, pi
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cabledrive.parameters import Carriage, Goal, load_drive
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.units import USUAL, _by_pint, _Unit, to_si

DECIMAL_UNITS = {
    ("g/m", "kg/m"): -3,
    ("cm", "m"): -2,
    ("mm^2", "m^2"): -6,
    ("GPa", "Pa"): 9,
    ("MPa", "Pa"): 6,
    ("kN", "N"): 3,
    ("kHz", "Hz"): 3,
    ("ms", "s"): -3,
    ("g cm^2", "kg m^2"): -7,
    ("kN/mm", "N/m"): 6,
    ("mN m/rad", "N m/rad"): -3,
    ("%", "1"): -2,
    ("t", "kg"): 3,
}


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("0.49 g/m", "kg/m", 0.00049),
        ("50 mm²", "m^2", 5e-05),
        ("2.1 N·m", "N m", 2.1),
        ("2.1 Nm", "N m", 2.1),
        ("21 mNm/rad", "N m/rad", 0.021),
        ("135 N m", "N m/rad", 135.0),
        ("5", "N", 5.0),
        ("5N", "N", 5.0),
        ("+.5e1 N", "N", 5.0),
        ("12 %", "1", 0.12),
        ("2 mm/m", "1", 0.002),
        ("3 kgf", "N", 29.41995),
        ("3 lbf", "N", 13.3446648457815),
        ("1 psi", "Pa", 6894.757293168362),
        ("1e15 lbf", "N", 4.4482216152605e15),  # a factor of 28 digits, not of a double
        ("1e999 N", "N", inf),  # the bounds of the quantity then refuse it
        ("-1e999999999999999999999 MN", "N", -inf),
        ("1e-999999999999999999999 MN", "N", 0.0),
    ],
)
def test_quantity_is_read_to_the_bit(text, unit, value):
    assert to_si(text, unit) == value, f"{to_si(text, unit)!r}"


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("1092 rpm", "rad/s", 1092 * 2 * pi / 60),
        ("90 deg", "rad", pi / 2),
        ("0.5 turn", "rad", pi),
        ("1 N m/deg", "N m/rad", 180 / pi),
    ],
)
def test_angles_are_read_to_round_off(text, unit, value):
    assert to_si(text, unit) == pytest.approx(value, rel=4e-16), f"{to_si(text, unit)!r}"


@given(
    number=st.decimals(allow_nan=False, allow_infinity=False, places=12, min_value=-(10**6), max_value=10**6),
    units=st.sampled_from(sorted(DECIMAL_UNITS)),
)
def test_decimal_units_are_rounded_once(number, units):
    """The nearest double to the exact product of what is written and the power of ten."""
    exact = Fraction(number) * Fraction(10) ** DECIMAL_UNITS[units]
    assert to_si(f"{number:f} {units[0]}", units[1]) == float(exact)


@given(
    value=st.floats(allow_nan=False, allow_infinity=False), unit=st.sampled_from(["N m s/rad", "Pa", "Hz"])
)
def test_what_is_written_with_its_unit_is_read_back(value, unit):
    assert to_si(f"{value!r} {unit}", unit) == value


RATES = {"Hz": ["50 Hz", "1 kHz"], "rad/s": ["50 rad/s", "1092 rpm", "3 deg/s"], "1/s": ["50 1/s", "2 s^-1"]}


@pytest.mark.parametrize(
    ("text", "unit"),
    [(text, unit) for own, texts in RATES.items() for text in texts for unit in RATES if unit != own],
)
def test_frequency_angular_speed_and_decay_rate_are_never_converted_into_each_other(text, unit):
    with pytest.raises(InputRefused, match=f'^"{re.escape(text)}" is an? .*, not {unit}: give it in {unit}$'):
        to_si(text, unit)


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("3 N m/Hz", "N m s/rad"),
        ("50 rad Hz", "Hz"),
        ("5 N m/rad", "N m"),
        ("3 deg N", "N"),
        ("3 rad", "1"),
        ("3 sr", "rad"),
        ("3 dB", "1"),
        ("5 kg", "N"),
        ("20 degC", "N"),
        ("5 mil", "m"),
    ],
)
def test_unit_of_another_kind_is_refused(text, unit):
    with pytest.raises(InputRefused, match=r"give it in|leave the unit out"):
        to_si(text, unit)


GARBAGE = ["", " ", "N", "nan", "inf N", "-", "++5 N", "1,5 N", "1_000 N", "0x10 N", "1.5.5 N", "5 N;"]
GARBAGE += ["٧ N", "７ N", "² N", "5 ٧", "5 N/0", "5 N^99", "5 __class__", "5 kilokiloN", "5 N\x00"]
GARBAGE += ["5 \udcff", "5 " + "m " * 50, "9" * 5000, "5\nN m", "5 N^", "5 *N", "5 N/", "5 ()"]
GARBAGE += ["5 N'", "5 %s", "{} N"]


@pytest.mark.parametrize("text", GARBAGE)
def test_garbage_is_refused(text):
    with pytest.raises(InputRefused):
        to_si(text, "N")


def test_units_known_without_pint_are_those_of_pint():
    assert len(USUAL) > 40
    for text, (factor, dimension, meaning) in USUAL.items():
        assert _Unit(Decimal(factor), dimension, meaning) == _by_pint(text), text


# --- Settings replace values of the file for one run, in tables and in arrays
EXAMPLE = Path(__file__).with_name("contract_example.toml")
DRIVE = load_drive(EXAMPLE).listed


def overridden(*settings):
    return load_drive(EXAMPLE, overrides=settings).listed


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
