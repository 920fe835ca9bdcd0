"""A mode that lies on the very end of a bisection interval is not taken for its neighbour."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.modal import modes
from cabledrive.parameters import load_drive


@pytest.mark.parametrize("stiffness", [10500.0, 11500.0, 13045.0, 16000.0, 20000.0, 21000.0])
def test_motor_joint_mode_close_to_an_in_phase_mode_is_found_beside_it(stiffness):
    """In-phase modes of a loop are at half turns of its travel time, where halved intervals end exactly."""
    drive = load_drive("dissertation-3", overrides=["layout.gravity=0"])
    drive = replace(drive, motor=replace(drive.motor, joint_stiffness=stiffness))
    found = modes(drive, count=6)
    frequency = np.array([mode.frequency for mode in found.longitudinal])
    assert found.certified
    assert np.all(np.diff(frequency) > 1e-6 * frequency[1:]), f"{frequency} Hz"
    assert np.min(np.abs(frequency - 807.33246825)) < 1e-8
