"""Reduced models with the rotor on its holding stiffness, against dense matrices and the full model."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh

import cabledrive as cd
from cabledrive.modal.tuning import pulley_mode
from cabledrive.parameters import InputRefused
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.fast_simulation import FastScheme, simulate_fast
from cabledrive.reduction.friction_integration import integrate_chain
from cabledrive.reduction.lumped_chain import natural_frequencies_of, speed_transfer_function, state_space
from cabledrive.reduction.models import lumped_model
from cabledrive.reduction.quality import distributed_response, model_response
from cabledrive.simulation import Recording, Scheme, Sine, simulate

HOLDING = 25.0
BASE = cd.load_drive("dissertation-3")
SMOOTH = replace(
    BASE,
    cable=replace(BASE.cable, mass_per_length=1e-6),
    layout=replace(BASE.layout, gravity=0.0),
    motor=replace(BASE.motor, holding_stiffness=HOLDING, coulomb_friction=0.0, offset_torque=0.0),
    lumped=None,
)
JOINTS = pytest.mark.parametrize("joint", [135.0, None])


def with_joint(joint):
    return replace(SMOOTH, motor=replace(SMOOTH.motor, joint_stiffness=joint))


def dense(drive):
    """Stiffness and inertia of rotor, drive and load pulley, written out."""
    r1, r2 = drive.drive_pulley.radius, drive.load_pulley.radius
    cable = 2.0 * drive.cable.axial_rigidity / drive.span_length
    joint = drive.motor.joint_stiffness
    stiffness = np.zeros((3, 3))
    stiffness[0, 0] = HOLDING
    stiffness[1:, 1:] = cable * np.array([[r1 * r1, -r1 * r2], [-r1 * r2, r2 * r2]])
    inertia = np.diag([drive.motor.inertia, drive.drive_pulley.inertia, drive.load_pulley.inertia])
    if joint is None:
        together = np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        return together.T @ stiffness @ together, together.T @ inertia @ together
    stiffness[:2, :2] += joint * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return stiffness, inertia


@JOINTS
def test_models_have_the_frequencies_of_the_dense_matrices_and_of_a_cable_without_mass(joint):
    drive = with_joint(joint)
    omega = np.sqrt(eigh(*dense(drive), eigvals_only=True))
    found = natural_frequencies_of(lumped_model(drive))
    assert found == pytest.approx(omega, rel=1e-10)
    exact = 2 * np.pi * cd.natural_frequencies(drive, count=omega.size)
    assert found == pytest.approx(exact, rel=1e-4)


@JOINTS
def test_a_slow_torque_is_answered_by_the_holding_stiffness_alone(joint):
    drive = with_joint(joint)
    slow = np.array([1e-3])
    for found in (distributed_response(drive, slow), model_response(drive, 3, slow)):
        assert abs(found[0]) == pytest.approx(1.0 / HOLDING, rel=1e-4)


@JOINTS
def test_damping_of_the_pulley_mode_is_that_of_the_lumped_eigenvalues(joint):
    """Weak axial damping of a cable almost without mass: real part of the eigenvalue of Model 3 or 4."""
    drive = with_joint(joint)
    still = tuple(replace(p, viscous_friction=0.0) for p in drive.pulley)
    drive = replace(
        drive,
        cable=replace(drive.cable, axial_damping=1e-4 * drive.cable.axial_rigidity),
        pulley=still,
        motor=replace(drive.motor, viscous_friction=0.0, joint_damping=0.0),
    )
    model = autoparametric_model(drive)
    poles = np.linalg.eigvals(state_space(lumped_model(drive))[0])
    nearest = poles[np.argmin(np.abs(np.abs(poles) - pulley_mode(drive).omega))]
    assert model.natural == pytest.approx(abs(nearest), rel=1e-3)
    assert model.modal_damping == pytest.approx(-2.0 * nearest.real, rel=0.02), f"{model.modal_damping}"
    assert model.rigid_arm == 0.0


@JOINTS
def test_fast_model_follows_the_full_model_on_the_holding_stiffness(joint, measured):
    drive = with_joint(joint)
    drive = replace(drive, cable=replace(drive.cable, mass_per_length=BASE.cable.mass_per_length))
    torque = Sine(amplitude=0.05, frequency=9.0)
    full = simulate(drive, 0.5, torque=torque, scheme=Scheme(segments=20), recording=Recording(rate=1000.0))
    fast = simulate_fast(
        drive, 0.5, torque=torque, scheme=FastScheme(sines=4), recording=Recording(rate=1000.0)
    )
    found = np.interp(full.time, fast.time, fast.load_angle)
    error = np.max(np.abs(found - full.load_angle)) / np.max(np.abs(full.load_angle))
    measured(f"largest difference {error:.1e} of the largest angle")
    assert error < 0.02, f"{error:.3e}"


def test_what_has_no_holding_stiffness_refuses_it_in_one_line():
    chain = lumped_model(SMOOTH)
    for refused in (
        lambda: integrate_chain(chain, np.zeros(5), 1e-3),
        lambda: speed_transfer_function(chain),
    ):
        with pytest.raises(InputRefused, match="holding stiffness = 25 N m/rad") as raised:
            refused()
        assert "\n" not in str(raised.value)
