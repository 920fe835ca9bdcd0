"""A rotor on its holding stiffness in the simulation: at rest, under a torque, and its energy."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from cabledrive.parameters import Carriage, load_drive
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, simulate
from cabledrive.simulation.channels import COLUMN

HOLDING = 2.0
MOTORED = load_drive("dissertation-3")
SPRUNG = replace(
    MOTORED,
    motor=replace(MOTORED.motor, holding_stiffness=HOLDING, offset_torque=0.0, coulomb_friction=0.0),
    layout=replace(MOTORED.layout, inclination=pi / 6),
    carriage=(Carriage(mass=1e-2, position=0.3),),
)
JOINTS = pytest.mark.parametrize("joint", [135.0, 1.0, None])


def with_joint(joint, drive=SPRUNG):
    return replace(drive, motor=replace(drive.motor, joint_stiffness=joint, joint_damping=0.0))


@JOINTS
@pytest.mark.parametrize("method", ["verlet", "node-centred", "energy-conserving"])
def test_a_run_from_equilibrium_stays_there(joint, method):
    drive = with_joint(joint)
    if method == "node-centred":
        drive = replace(drive, carriage=(), layout=replace(drive.layout, inclination=0.0))
    result = simulate(
        drive, 0.02, start=Start(from_equilibrium=True), scheme=Scheme(segments=20, method=method)
    )
    assert np.ptp(result.load_angle) < 1e-9, f"{np.ptp(result.load_angle)} rad"


@JOINTS
def test_a_slow_torque_turns_the_motor_by_torque_over_stiffness(joint):
    """A sine far below the first mode: the motor follows it on its spring."""
    drive = with_joint(joint, replace(SPRUNG, carriage=(), layout=replace(SPRUNG.layout, gravity=0.0)))
    slow = Sine(amplitude=0.01, frequency=0.05)
    result = simulate(drive, 5.0, torque=slow, scheme=Scheme(segments=4, model="linear"))
    quarter = np.argmax(result.rows[:, COLUMN["torque"]])
    assert result.rows[:, COLUMN["motor_angle"]][quarter] == pytest.approx(0.01 / HOLDING, rel=0.02)


@JOINTS
@pytest.mark.parametrize("method", ["verlet", "energy-conserving"])
def test_the_energy_budget_closes_with_a_holding_stiffness(joint, method, measured):
    """With plucks, a torque and a start beside the commanded angle; Verlet on the linear cable."""
    result = simulate(
        with_joint(joint),
        0.2,
        torque=Sine(amplitude=0.02, frequency=30.0),
        start=Start(plucks=(Pluck(height=1e-3, shape="half-sine"),), drive_angle=1e-3, load_angle=1e-3),
        scheme=Scheme(segments=20, method=method, model="linear" if method == "verlet" else "exact"),
        recording=Recording(rate=2000.0),
    )
    measured(f"{result.energy_budget_error:.1e} of the energy handled")
    assert result.rows[:, COLUMN["joint_energy"]].max() > 1e-7
    assert result.energy_budget_error < 1e-11, f"{result.energy_budget_error:.1e}"
