"""A holding stiffness is used by a command, or the command says that it is left out."""

import pytest

import cabledrive as cd
from cabledrive.studies.study.check_stage import check
from command import answer, refusal

HOLDING = ("--set", "motor.holding_stiffness=5 N m/rad")


@pytest.mark.verify
def test_tracking_takes_the_motor_as_free_and_says_so():
    plain = answer("track", "dissertation-3", "--controller", "pd", "--ideal-sensors")
    sprung = answer("track", "dissertation-3", "--controller", "pd", "--ideal-sensors", *HOLDING)
    assert (plain["motor"], sprung["motor"]) == ("free", "free")
    assert "motor_reason" not in plain
    assert "motor.holding_stiffness = 5 N m/rad is left out" in sprung["motor_reason"]
    assert sprung["peak_error_deg"] == plain["peak_error_deg"]


def test_a_study_says_that_the_holding_stiffness_is_left_out():
    drive = cd.load_drive("printer-belt")
    assert any(
        "motor.holding_stiffness = 20 N m/rad is left out" in line for line in check(drive, [], []).warnings
    )


def test_resonance_is_that_of_the_motor_on_its_holding_stiffness():
    found = answer("resonance", "dissertation-3", *HOLDING)
    drive = cd.load_drive("dissertation-3", overrides=[HOLDING[1]])
    assert found["motor"] == "holding"
    assert found["pulley_frequency_hz"] == pytest.approx(cd.natural_frequencies(drive, count=1)[0], rel=1e-9)
    assert answer("resonance", "dissertation-3")["motor"] == "free"


def test_check_and_modes_give_both_lowest_frequencies():
    derived = answer("check", "linear-axis")["derived"]
    found = answer("modes", "linear-axis", "--motor", "held", "--count", "1")
    assert derived["lowest_frequency_free_hz"] == pytest.approx(99.28, abs=0.005)
    assert derived["lowest_frequency_held_hz"] == pytest.approx(34.00, abs=0.005)
    assert found["motor"] == "held"
    assert found["lowest_frequency_free_hz"] == derived["lowest_frequency_free_hz"]
    assert min(m["frequency_hz"] for m in found["modes"] if m["kind"] == "longitudinal") == pytest.approx(
        derived["lowest_frequency_held_hz"], rel=1e-12
    )


def test_a_part_that_cannot_be_held_is_refused():
    assert 'did you mean "drive pulley"' in refusal("modes", "linear-axis", "--hold", "drive pully")
    assert "motor.holding_stiffness" in refusal("modes", "linear-axis", "--motor", "holding")
