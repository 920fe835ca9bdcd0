"""Closed loops of a campaign at once, under one law: the rows of the single command."""

import tomllib

import numpy as np
import pytest

from cabledrive.campaign.rows import compute_rows
from cabledrive.campaign.spec import spec_of

SPEC = """
drive = "dissertation-3"
[vary]
"plant.pulley.1.inertia" = { normal = ["23.5 kg cm^2", "1 kg cm^2"] }
"plant.motor.joint_stiffness" = { from = "100 N m/rad", to = "160 N m/rad" }
"plant.motor.coulomb_friction" = { from = 0.0, to = "0.05 N m" }
"plant.cable.pretension" = { from = "3 N", to = "9 N" }
[motion]
angle = "20 deg"
rise = "0.2 s"
dwell = "0.05 s"
pulses = 2
[design]
kind = "random"
rows = 5
seed = 3
[compute]
what = "track"
controller = "darc-4"
gains = "dissertation"
ideal_sensors = true
smooth_friction = true
outputs = ["peak_error_deg", "first_pulse_error_deg", "later_pulses_error_deg", "rms_error_deg",
           "peak_torque", "saturated_fraction", "slack_samples", "controller"]
"""
ANGLE = 20.0


def spec(text, folder):
    return spec_of(tomllib.loads(text), folder)


@pytest.mark.parametrize(
    "law, plant", [("darc-4", "model-4"), ("darc-4-damped", "model-4"), ("darc-3", "model-3")]
)
def test_rows_under_one_law_equal_those_of_the_single_command(law, plant, tmp_path, measured):
    """Within 1e-12 deg of an angle of 20 deg: errors are differences of angles."""
    text = SPEC.replace('controller = "darc-4"', f'controller = "{law}"\nplant = "{plant}"')
    campaign = spec(text, tmp_path)
    done, _ = campaign.computation.many(campaign, campaign.values(0, 5))
    assert done.all()
    at_once = compute_rows(campaign, 0, 5).variables
    singly = compute_rows(campaign, 0, 5, at_once=False).variables
    largest = 0.0
    for output in campaign.computation.outputs:
        one, other = at_once[output.name], singly[output.name]
        if output.kind == "text":
            assert one.tolist() == other.tolist() == [law] * 5
            continue
        largest = max(largest, float(np.abs(one - other).max()))
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-12, err_msg=output.name)
    assert at_once["peak_error_deg"].std() > 1e-4, "the plants do not differ"
    measured(f"closed loops under one law, {law}: within {largest:.1e} deg of {ANGLE:g} deg")


def test_a_row_has_the_same_bits_in_any_company(tmp_path):
    campaign = spec(SPEC, tmp_path)
    whole = compute_rows(campaign, 0, 5).variables
    for first, last in ((0, 2), (2, 3), (3, 5)):
        part = compute_rows(campaign, first, last).variables
        for name in ("peak_error_deg", "rms_error_deg", "peak_torque"):
            assert part[name].tolist() == whole[name][first:last].tolist()
