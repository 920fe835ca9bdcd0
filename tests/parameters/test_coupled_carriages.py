"""Carriages that move together: by name or number, in one direction or against each other."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.parameters import InputRefused, load_drive
from cabledrive.studies.planned_motion import PlannedMotion, drive_along


def with_coupling(**second):
    drive = load_drive("elevator")
    car, weight = drive.carriage
    return replace(drive, carriage=(car, replace(weight, **second)))


@pytest.mark.parametrize("direction", [1, -1])
def test_a_coupled_carriage_moves_as_far_as_the_first(direction):
    drive = with_coupling(direction=direction)
    motion = PlannedMotion(time=np.array([0.0, 10.0]), torque=np.zeros(2), carriage=np.array([30.0, 40.0]))
    places = [carriage.position for carriage in drive_along(drive, motion, 5.0).carriage]
    assert places == pytest.approx([35.0, 30.0 + 5.0 * direction])


@pytest.mark.parametrize(
    ("second", "word"),
    [
        ({"coupled": "cabin"}, "no carriage of this drive"),
        ({"coupled": "counterweight"}, "the carriage itself"),
        ({"coupled": "", "direction": -1}, "needs carriage.1.coupled"),
        ({"direction": 2}, "direction = 2 is not one of its values"),
    ],
)
def test_couplings_that_make_no_sense_are_refused(second, word):
    with pytest.raises(InputRefused, match=word):
        with_coupling(**second)


def test_couplings_that_contradict_each_other_are_refused():
    drive = load_drive("elevator")
    car, weight = drive.carriage
    with pytest.raises(InputRefused, match="contradicts"):
        replace(drive, carriage=(replace(car, coupled="counterweight", direction=-1), weight))
