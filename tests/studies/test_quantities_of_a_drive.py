"""A quantity is what it is set to in every drive, draw and bound: nothing is cut off in silence."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.identification.filters import difference, zero_phase
from cabledrive.parameters import InputRefused, load_drive
from cabledrive.studies.study.chain_regression import identify_chain
from cabledrive.studies.study.goals import SPREADS
from cabledrive.studies.study.knowledge_stage import ESSENTIAL, know
from cabledrive.studies.study.machine import LOG, Quantity, drive_with, values_of
from cabledrive.studies.study.sampled_plants import sampled_plant
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


@pytest.mark.parametrize("name", ["viscous_friction", "coulomb_friction", "cable_damping", "joint_damping"])
def test_a_negative_friction_or_damping_is_refused(name):
    with pytest.raises(InputRefused, match=name):
        drive_with(RUBBING, {name: -1e-3})


def quantity(name, value, half):
    return Quantity(name=name, value=value, low=value - half, high=value + half, unit="", source=LOG)


def test_bounds_hold_twice_the_interval():
    """An offset may push either way; what cannot be negative ends at a thousandth of its value."""
    assert quantity("offset_torque", 1e-3, 4e-3).outer == pytest.approx((-7e-3, 9e-3))
    assert quantity("coulomb_friction", 0.02, 0.008).outer == pytest.approx((0.004, 0.036))
    assert quantity("coulomb_friction", 0.02, 0.012).outer == pytest.approx((2e-5, 0.044))
    assert quantity("viscous_friction", 0.0, 1e-3).outer == pytest.approx((0.0, 2e-3))


@pytest.mark.parametrize("name", ["offset_torque", "viscous_friction"])
def test_a_plant_within_twice_the_interval_is_within_the_bounds(name):
    known = quantity(name, 1e-3, 0.9e-3)
    low, high = known.outer
    values = np.array([sampled_plant({name: known}, 2, 1, k)[0][name] for k in range(500)])
    near = values[np.abs(values - known.value) <= 2.0 * known.half_width]
    assert len(near) > 490
    assert low <= near.min() < known.value < near.max() <= high, f"{near.min():.3g} of {low:.3g}"


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
