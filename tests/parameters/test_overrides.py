"""Settings replace values of the file for one run, in tables and in arrays."""

from dataclasses import replace
from pathlib import Path

import pytest

from cabledrive.parameters import Carriage, Goal, InputRefused, load_drive

EXAMPLE = Path(__file__).with_name("contract_example.toml")
DRIVE = load_drive(EXAMPLE)


def overridden(*settings):
    return load_drive(EXAMPLE, overrides=settings)


@pytest.mark.parametrize(
    "setting",
    [
        "cable.pretension=6",
        "cable.pretension=6.0",
        "cable.pretension=6 N",
        'cable.pretension="6 N"',
        "cable.pretension='0.006 kN'",
        " cable . pretension = 6 N ",
    ],
)
def test_setting_replaces_a_quantity_however_it_is_quoted(setting):
    assert overridden(setting) == replace(DRIVE, cable=replace(DRIVE.cable, pretension=6.0))


def test_setting_reaches_into_arrays():
    first, second = DRIVE.pulley
    assert overridden("pulley.0.inertia=0.001").pulley == (replace(first, inertia=0.001), second)
    assert overridden("pulley.1.fixed=true").pulley == (first, replace(second, fixed=True))


def test_settings_add_a_table_and_rows_to_an_array():
    drive = overridden("goal.tracking_error=0.1 deg", "carriage.0.mass=1", "carriage.0.position=0.5")
    assert drive.goal == Goal(tracking_error=0.0017453292519943296)
    assert drive.carriage == (Carriage(mass=1.0, position=0.5),)
    two = overridden("carriage=[{mass=1, position=0.5}, {mass=2, position=0.6}]", "carriage.1.mass=3")
    assert [carriage.mass for carriage in two.carriage] == [1.0, 3.0]


def test_setting_can_choose_the_other_length():
    with pytest.raises(InputRefused, match="both are given; give one"):
        overridden("layout.pulley_distance=1 m")
    drive = overridden("layout={pulley_distance=1}")
    assert drive.pulley_distance == 1.0
    assert drive.span_length == 1.0 / (1.0 + DRIVE.cable.prestrain)


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("", "is not KEY=VALUE"),
        ("=", "is not KEY=VALUE"),
        ("cable.pretension", "is not KEY=VALUE"),
        ("=6", "is not KEY=VALUE"),
        (".=6", "does not name a value"),
        ("cable.=6", "does not name a value"),
        ("cable..pretension=6", 'unknown key "cable."'),
        ("cable.capstan_friction=0.2", "that of a wrap is capstan_friction of its \\[\\[pulley\\]\\]"),
        ("cable.pretension.unit=6", "is not a table|does not name a value"),
        ("pulley.0=6", "does not name a value"),
        ("a.b.c.d=6", "does not name a value"),
        ("a." * 100_000 + "b=6", "does not name a value"),
        ("name.x.y=6", "inside a value, not a table"),
        ("pulley.3.radius=1", "pulley has 2 entries, numbered from 0"),
        ("pulley.-1.radius=1", "pulley has 2 entries, numbered from 0"),
        ("pulley.٠.radius=1", "pulley has 2 entries, numbered from 0"),
        ("pulley.².radius=1", "pulley has 2 entries, numbered from 0"),
        ("pulley.0x0.radius=1", "pulley has 2 entries, numbered from 0"),
        ("pulley.99999999999999999999.radius=1", "pulley has 2 entries, numbered from 0"),
        ("pulley.2.radius=1", 'missing key "pulley.2.inertia"'),
        ("cable.tension=6", 'unknown key "cable.tension" \\(did you mean "cable.pretension"\\?\\)'),
        ("cable.pretension=", '"" is not a quantity'),
        ("cable.pretension=6 kg", "is of dimension \\[mass\\], not N: give it in N"),
        ("cable.pretension=[6]", "is an array, not a quantity in N"),
        ("cable.pretension=1979-05-27", "is a date or time, not a number"),
        ("cable.pretension=1\nx = 2", "is not a unit"),
        ("cable.pretension=" + "9" * 10_000, "is not a quantity"),
        ("cable.pretension=" + "[" * 10_000, "is not a quantity"),
        ("cable.pretension=\udcff", "is not a quantity"),
        ("name=\udcff", "holds the character"),
        ("name=\x07", "holds the character"),
        ("motor.speed_limit=50 Hz", "is a frequency \\[Hz\\], not rad/s: give it in rad/s"),
        ("sensors.sample_rate=5000 rad/s", "is an angular speed \\[rad/s\\], not Hz: give it in Hz"),
    ],
    ids=lambda text: ascii(text)[:40],
)
def test_setting_that_makes_no_sense_is_refused_in_one_line(setting, words):
    with pytest.raises(InputRefused, match=words) as refusal:
        overridden(setting)
    message = str(refusal.value)
    assert message.isprintable()
    assert len(message) < 300
