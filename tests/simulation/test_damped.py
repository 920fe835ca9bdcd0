"""Axial dampers with the matrix of a straight rope, `cabledrive.simulation.damped`, beside the bent one's."""

from dataclasses import replace

import numpy as np
import pytest
from kernel_cases import setting, taken

import cabledrive as cd
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, dampers
from cabledrive.simulation.plan import PRETENSION, RIGIDITY, SLACK

DRIVE = cd.load_drive("dissertation-2", overrides=["cable.pretension=3.26", "cable.transverse_damping=2"])
SHAPES = {
    "half-sine": (Pluck(height=5e-3, shape="half-sine"), Pluck(height=5e-3, shape="half-sine", plane="v")),
    "kink": (Pluck(height=5e-3, shape="triangle", place=0.15),),
}


@pytest.mark.parametrize(("shape", "most"), [("half-sine", 5e-6), ("kink", 2e-4)])
@pytest.mark.parametrize("damping", [0.003, 0.3])
def test_slopes_of_a_hundredth_hardly_change_the_dampers(shape, most, damping, monkeypatch, measured):
    """20 ms of 5 mm on half a metre; what the dampers take differs as little, and the budgets close alike."""
    drive = replace(DRIVE, cable=replace(DRIVE.cable, axial_damping=damping))
    runs = []
    for stiffest in (dampers.STIFFEST, 0.0):
        monkeypatch.setattr(dampers, "STIFFEST", stiffest)
        run = cd.simulate(
            drive,
            0.02,
            torque=Sine(amplitude=0.02, frequency=60.0),
            start=Start(plucks=SHAPES[shape]),
            scheme=Scheme(segments=40),
            recording=Recording(rate=5000.0),
        )
        runs.append(run)
    ours, theirs = runs
    pairs = [(one.midpoint(), one.load_angle, one.channel("axial_loss")) for one in (ours, theirs)]
    errors = [np.abs(a - b).max() / np.abs(b).max() for a, b in zip(*pairs, strict=True)]
    measured(f"midpoint, load, axial loss differ by {errors[0]:.0e}, {errors[1]:.0e}, {errors[2]:.0e}")
    assert max(errors) < most, errors
    assert max(errors) > 0.0, "one and the same was computed twice"
    assert ours.energy_budget_error == pytest.approx(theirs.energy_budget_error, rel=1e-3)


@pytest.mark.kernel
def test_a_run_goes_on_from_its_state_alone():
    """To the bit, with a work space of its own for each part: nothing is remembered from step to step."""
    plan, start, torque, forces = setting("everything")
    whole = taken("verlet", plan, start, torque, forces, 6)[1]
    half = len(torque) // 2
    first = taken("verlet", plan, start, torque[:half], forces[:half], 6)[1]
    parts = taken("verlet", plan, first, torque[half:], forces[half:], 6)[1]
    for name in ("x", "x_t", "q", "q_t", "tallies"):
        np.testing.assert_array_equal(getattr(parts, name), getattr(whole, name), err_msg=name)


@pytest.mark.kernel
def test_one_slack_segment_among_all_ends_the_steps():
    plan, start, torque, forces = setting("axial damping")
    start.x[:] = 0.0
    start.x[0, 1] = -1.1 * plan.piece[0, PRETENSION] / plan.piece[0, RIGIDITY] * plan.segment[0, 0]
    code, state = taken("verlet", plan._replace(stop_when_slack=True), start, torque, forces)[:2]
    assert (code, state.counts[0]) == (SLACK, 0)
