"""What a study learns from a log without the load's angle: the axis as one, where it moves as one."""

from dataclasses import replace

import pytest

from cabledrive.parameters import load_drive
from cabledrive.rig.bench.experiment import experiment
from cabledrive.studies.study.goals import SPREADS
from cabledrive.studies.study.knowledge_stage import know
from cabledrive.studies.study.machine import values_of
from study_drives import FOLDER, LIVELY, datasheet_of, drive_of, log_with


def test_with_a_stiff_cable_the_axis_is_identified_and_not_the_cable():
    """Motor and load reflected through the radii come out together, not the data sheet's."""
    stiff = load_drive(FOLDER / "turntable.toml", overrides=["cable.youngs_modulus=20 TPa"])
    log, truth = experiment(stiff, LIVELY, seed=1), values_of(stiff)
    one = replace(log, channels={name: log.channels[name] for name in ("torque", "angle")})
    found = know(datasheet_of(stiff), [one], SPREADS)
    whole = found.values["near_inertia"] + found.values["load_inertia"] / 9.0
    assert whole == pytest.approx(truth["near_inertia"] + truth["load_inertia"] / 9.0, rel=0.003)
    friction = found.quantities["coulomb_friction"]
    assert friction.low < truth["coulomb_friction"] < friction.high
    assert friction.source == "log"
    assert found.quantities["cable_stiffness"].source == "datasheet"
    assert any("no load angle" in words for words in found.undetermined)


def test_an_axis_that_is_not_rigid_gives_nothing_and_the_datasheet_stays():
    found = know(drive_of("turntable"), [log_with(("torque", "angle"))], SPREADS)
    assert any("not one rigid axis" in words for words in found.undetermined)
    assert {quantity.source for quantity in found.quantities.values()} == {"datasheet"}
