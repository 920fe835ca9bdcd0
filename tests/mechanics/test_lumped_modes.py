"""First estimates of the cable's and the joint's mode, held against the measured ones."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

from cabledrive.mechanics.holding import lumped_cable_mode, lumped_joint_mode, span_stiffness
from cabledrive.parameters import load_drive

DRIVE = load_drive("dissertation-3")


def test_modes_of_the_rig_are_those_of_table_6_2():
    """8.27 Hz and 92.2 Hz, fitted to the response; the parameters have two to three digits."""
    assert lumped_cable_mode(DRIVE) / (2 * pi) == pytest.approx(8.27, rel=0.005)
    assert lumped_joint_mode(DRIVE) / (2 * pi) == pytest.approx(92.2, rel=0.005)


def test_estimates_bracket_the_coupled_modes():
    """Motor, drive pulley and load pulley on two springs: rigid joint and free cable shift both modes up."""
    k = 2.0 * span_stiffness(DRIVE) * DRIVE.drive_pulley.radius**2
    km = DRIVE.motor.joint_stiffness
    stiffness = np.array([[km, -km, 0.0], [-km, km + k, -k], [0.0, -k, k]])
    inertia = np.array([DRIVE.motor.inertia, DRIVE.drive_pulley.inertia, DRIVE.load_pulley.inertia])
    omega = np.sqrt(np.abs(np.linalg.eigvalsh(stiffness / np.sqrt(np.outer(inertia, inertia)))))
    assert omega[1] < lumped_cable_mode(DRIVE) < 1.01 * omega[1], f"{omega}"
    assert lumped_joint_mode(DRIVE) < omega[2] < 1.02 * lumped_joint_mode(DRIVE), f"{omega}"


def test_fixed_load_pulley_leaves_the_drive_side_on_both_spans():
    drive = replace(DRIVE, pulley=(DRIVE.drive_pulley, replace(DRIVE.load_pulley, fixed=True)))
    inertia = DRIVE.motor.inertia + DRIVE.drive_pulley.inertia
    assert lumped_cable_mode(drive) == pytest.approx(sqrt(2 * 850.0 * 0.04**2 / inertia), rel=1e-14)


def test_line_has_one_span():
    assert lumped_cable_mode(DRIVE) == pytest.approx(
        sqrt(2.0) * lumped_cable_mode(replace(DRIVE, kind="line")), rel=1e-14
    )


def test_measured_stiffness_stands_before_that_of_the_cable():
    assert span_stiffness(DRIVE) == 850.0
    assert span_stiffness(replace(DRIVE, lumped=None)) == pytest.approx(438.0, rel=1e-14)


def test_what_does_not_exist_has_no_frequency():
    pulleys = tuple(replace(pulley, fixed=True) for pulley in DRIVE.pulley)
    assert lumped_cable_mode(replace(DRIVE, motor=None, pulley=pulleys)) is None
    assert lumped_joint_mode(replace(DRIVE, motor=None)) is None
    assert lumped_joint_mode(load_drive("finger-tendon")) is None
