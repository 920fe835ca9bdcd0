"""A quantity is what it is set to in every drive, draw and bound: nothing is cut off in silence."""

from dataclasses import replace

import pytest

from cabledrive.identification.filters import difference, zero_phase
from cabledrive.parameters import load_drive
from cabledrive.studies.study.chain_regression import identify_chain
from cabledrive.studies.study.goals import SPREADS
from cabledrive.studies.study.knowledge_stage import ESSENTIAL, know
from cabledrive.studies.study.machine import LOG, Quantity, drive_with, values_of
from study_drives import drive_of, log_with

RUBBING = load_drive("dissertation-3")
PULLEYS = tuple(replace(pulley, viscous_friction=0.002, coulomb_friction=0.01) for pulley in RUBBING.pulley)


@pytest.mark.parametrize("motor", [RUBBING.motor, None], ids=["with a motor", "without"])
@pytest.mark.parametrize("share", [0.0, 0.1, 0.9, 1.0, 2.0])
def test_a_drive_has_the_friction_that_it_is_given(motor, share):
    """Also where that is less than the drive file gives the pulleys alone."""
    drive = replace(RUBBING, motor=motor, pulley=PULLEYS)
    before = values_of(drive)
    wanted = {name: share * before[name] for name in ("viscous_friction", "coulomb_friction")}
    moved = drive_with(drive, wanted)
    found = values_of(moved)
    for name, value in wanted.items():
        assert found[name] == pytest.approx(value, rel=1e-12, abs=1e-18), f"{name}: {found[name]:.6g}"
        first, second = (getattr(pulley, name) for pulley in moved.pulley)
        if motor is not None:
            assert first == pytest.approx(second), "the pulleys rub alike, and still do"


def quantity(name, value, half):
    return Quantity(name=name, value=value, low=value - half, high=value + half, unit="", source=LOG)


def with_less_friction(log, taken):
    """The log of a drive whose viscous friction is smaller by so much."""
    speed = difference(zero_phase(log.channel("angle"), log.interval, 100.0), log.interval)
    return replace(log, channels={**log.channels, "torque": log.channel("torque") - taken * speed})


def test_a_friction_that_comes_out_negative_is_reported_and_not_cut_in_silence():
    drive, log = drive_of("turntable"), log_with(("torque", "angle", "load_angle"))
    value, low, high = identify_chain([log], drive).intervals["viscous_friction"]
    slight = know(drive, [with_less_friction(log, value + 0.3 * (high - low))], SPREADS)
    known = slight.quantities["viscous_friction"]
    assert (known.value, known.source) == (0.0, LOG)
    assert known.low < 0.0 < known.high
    assert any("taken as 0" in words for words in slight.undetermined), slight.undetermined
    wrong = know(drive, [with_less_friction(log, 3.0 * value)], SPREADS)
    assert "viscous_friction" in ESSENTIAL
    assert wrong.open_names == ("viscous_friction",)
    assert any(
        words.startswith("viscous friction") and "signs and units" in words for words in wrong.undetermined
    )
