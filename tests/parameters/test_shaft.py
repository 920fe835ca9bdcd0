"""One key stretches a lift: places relative to `shaft`."""

import pytest

import cabledrive as cd
from cabledrive.parameters import InputRefused
from cabledrive.parameters.drive_file import drive_from_text, packaged_text

LIFT = packaged_text("lift-2-to-1")


def test_a_shaft_of_60_m_is_the_lift_with_every_place_written_anew():
    stretched = cd.load_drive("lift-2-to-1", overrides=["shaft=60 m"])
    text = LIFT.replace('shaft = "42 m"', "").replace('"0.5 shaft - 1 m"', '"29 m"')
    text = text.replace('"0.5 shaft + 0.5 m"', '"30.5 m"').replace('"0.5 shaft - 2.5 m"', '"27.5 m"')
    text = text.replace('"2 m : shaft - 4 m"', '"2 m : 56 m"').replace('"shaft"', '"60 m"')
    assert "shaft" not in text.split("[cable]")[1].replace("--set shaft", "")
    assert stretched == drive_from_text(text)


@pytest.mark.parametrize(
    ("old", "new", "name"),
    [
        ('shaft = "42 m"', "", "shaft"),
        ('shaft = "42 m"', 'shaft = "-1 m"', "shaft"),
        ('shaft = "42 m"', 'shaft = "3 kg"', "kg"),
        ('"0.5 shaft + 0.5 m"', '"shaft of 3 m"', "place"),
        ('"0.5 shaft + 0.5 m"', '"0.5 shaft + 1 kg"', "kg"),
    ],
)
def test_what_is_no_relative_place_is_refused(old, new, name):
    with pytest.raises(InputRefused, match=name):
        drive_from_text(LIFT.replace(old, new, 1))
