"""What Models 3 and 4 leave over the angle and the rise of the pulse, with true states."""

import pytest

from cabledrive.parameters import load_drive
from cabledrive.rig import Motion, RigOptions
from dissertation_runs import track

DRIVE = load_drive("dissertation-3")
IDEAL = RigOptions(ideal_sensors=True)


@pytest.mark.parametrize("angle, rise", [(90.0, 0.3), (90.0, 0.5), (45.0, 0.3), (45.0, 0.7), (45.0, 1.0)])
def test_a_flexible_joint_in_the_model_leaves_less_at_every_angle_and_rise(angle, rise, measured):
    three, four = (
        track(DRIVE, controller=law, motion=Motion(angle=angle, rise=rise), options=IDEAL).summary
        for law in ("darc-3", "darc-4")
    )
    measured(f"Model 3 {three['peak_error_deg']:.4f}, Model 4 {four['peak_error_deg']:.4f} deg")
    assert four["peak_error_deg"] < three["peak_error_deg"]
