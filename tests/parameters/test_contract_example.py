"""The example of the drive file that the reference shows in full loads, and means what it says."""

from math import pi
from pathlib import Path

import pytest

from cabledrive.parameters import Carriage, load_drive

EXAMPLE = Path(__file__).with_name("contract_example.toml")
VALUES = {
    "schema": 1,
    "name": "Dissertation, configuration 3",
    "kind": "loop",
    "title": "",
    "source": "",
    "cable.youngs_modulus": 3.0e9,
    "cable.area": 1.46e-7,
    "cable.mass_per_length": 0.000168,
    "cable.pretension": 7.0,
    "cable.transverse_damping": 1.0,
    "cable.axial_damping": 0.0,
    "cable.strain_limit": None,
    "layout.span_length": 1.0,
    "layout.pulley_distance": None,
    "layout.gravity": 9.81,
    "layout.inclination": 0.0,
    "drive_pulley.radius": 0.04,
    "drive_pulley.inertia": 0.000642,
    "drive_pulley.viscous_friction": 0.0,
    "drive_pulley.coulomb_friction": 0.0,
    "drive_pulley.fixed": False,
    "load_pulley.radius": 0.04,
    "load_pulley.inertia": 0.00235,
    "load_pulley.fixed": False,
    "load_pulley.wrap_angle": None,
    "load_pulley.capstan_friction": None,
    "carriage": (),
    "motor.inertia": 0.0011,
    "motor.viscous_friction": 0.0031,
    "motor.coulomb_friction": 0.0376,
    "motor.offset_torque": -0.0006,
    "motor.joint_stiffness": 135.0,
    "motor.joint_damping": 0.075,
    "motor.torque_limit": 2.1,
    "motor.torque_per_volt": 1.6218,
    "motor.speed_limit": 1092 * 2 * pi / 60,
    "motor.gear_ratio": 5.2,
    "motor.rotor_inertia": None,
    "motor.backlash": 0.0,
    "motor.current_bandwidth": 1000.0,
    "lumped.cable_stiffness": 850.0,
    "lumped.cable_damping": 0.18,
    "sensors.motor_encoder": 2600,
    "sensors.drive_encoder": 10000,
    "sensors.load_encoder": 10000,
    "sensors.load_cell_noise": 0.05,
    "sensors.sample_rate": 5000.0,
    "sensors.delay": 0.0,
    "goal": None,
}


@pytest.mark.parametrize("key", VALUES)
def test_example_means_what_it_says(key):
    """To the bit: decimal units round once; 1092 rpm is 1092 * 2 pi / 60 rad/s."""
    value = load_drive(EXAMPLE)
    for step in key.split("."):
        value = getattr(value, step)
    if key == "motor.speed_limit":
        assert value == pytest.approx(VALUES[key], rel=4e-16), f"{value!r}"
    else:
        assert value == VALUES[key], f"{key} = {value!r}"
        assert type(value) is type(VALUES[key])


def test_commented_lines_of_the_example_load_as_well(tmp_path):
    """The carriage and the fixed pulley, which the example shows as comments."""
    text = EXAMPLE.read_text(encoding="utf-8")
    for line in ("[[carriage]]", "mass =", "span =", "position =", "guided =", "fixed ="):
        assert f"# {line}" in text
        text = text.replace(f"# {line}", line)
    (tmp_path / "drive.toml").write_text(text, encoding="utf-8")
    drive = load_drive(tmp_path / "drive.toml")
    assert drive.load_pulley.fixed
    assert drive.carriage == (Carriage(mass=0.5, span="upper", position=0.25, guided=True),)
