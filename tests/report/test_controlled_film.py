"""The film of a controlled run: every picture shows the run at its time."""

import re

import numpy as np
import pytest

from cabledrive.parameters import load_drive
from cabledrive.report.controlled_film import controlled_film
from cabledrive.rig import Motion, track

DRIVE = load_drive("dissertation-3")


def run(plant):
    motion = Motion(angle=15.0, rise=0.2, dwell=0.05)
    return track(DRIVE, controller="pd", bandwidth=20.0, plant=plant, motion=motion)


def test_every_picture_says_the_error_at_its_time():
    found = run("model-3")
    page = controlled_film(DRIVE, found)
    said = re.findall(r">(\d+\.\d+) s, error (-?[\d.]+) deg<", page)
    assert len(said) == 2 * 64  # wide and narrow
    for time, error in said:
        at = np.abs(found.time - float(time)) <= 0.0005 + 1e-9
        errors = np.degrees(found.error[at])
        assert errors.min() - 1e-4 <= float(error) <= errors.max() + 1e-4
    assert float(said[-1][0]) == pytest.approx(found.time[-1], abs=5e-4)
