"""A stepper as an open loop: its spring, its lag, its shaper, and the steps it loses."""

from dataclasses import replace

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.reduction.network_axis import as_axis
from cabledrive.rig import Disturbance, Motion, RigOptions
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.laws.registry import CONTROLLERS, OPEN_LOOPS
from cabledrive.rig.plant_samples import Disturbances
from cabledrive.rig.trial import offered
from command import answer, refusal

QUICK = Motion(angle=8.0, rise=0.03, dwell=0.12)
FREE_OF_FRICTION = ["body.head.coulomb_friction=0"]


def printer(*overrides):
    return cd.load_drive("printer-idlers", overrides=[*FREE_OF_FRICTION, *overrides])


def test_the_load_is_that_of_the_whole_machine_on_its_magnetic_spring(measured):
    """The belt as elements, the rotor on a linear spring to the field: nothing of the rig is in it."""
    run = cd.track(printer(), controller="stepper", motion=QUICK)
    stiffness = printer().motor[0].holding_stiffness
    trajectory = QUICK.trajectory
    end = 0.07

    def field(time):  # the sign of the axis: the head goes one way where the motor turns the other
        return stiffness * trajectory(np.minimum(np.asarray(time, dtype=float), end))[0]

    truth = cd.simulate(printer(), end, torque={"motor": field})
    time, head = np.asarray(truth.to_xarray().time), truth.channel("head.x")
    rigged = run.summary["axis"]["gain"] * np.interp(time, run.time, run.load_angle)
    off, wave = np.abs(head - head[0] - rigged).max(), np.abs(run.error).max() * 6.366e-3
    measured(f"stepper: head within {1e6 * off:.2f} um of elements where it is {1e6 * wave:.1f} um off")
    assert off < 0.05 * wave


@pytest.mark.parametrize("seed", range(3))
def test_an_axis_without_damping_is_shaped_and_one_that_does_not_swing_is_told_so(seed):
    """Of ten axes each; the damping ratio of a mode without any is round-off, of either sign."""
    rng = np.random.default_rng(seed)
    for _ in range(10):
        stiffness, load, joint = 10.0 ** rng.uniform([3.0, -5.0, 1.0], [5.0, -3.0, 2.0])
        drive = replace(
            cd.load_drive("dissertation-3").listed,
            lumped=None,
            cable=cd.Cable(given_rigidity=stiffness, mass_per_length=1e-3, pretension=10.0),
            pulley=(cd.Pulley(radius=0.05, inertia=1e-4), cd.Pulley(radius=0.05, inertia=load)),
            motor=cd.Motor(inertia=3e-4, joint_stiffness=joint, holding_stiffness=2.0 * joint),
        )
        made = CONTROLLERS["stepper-shaped"](DesignSpec(drive, QUICK))
        assert 0.0 <= made.gains["shaper_damping"] < 1e-9
    rigid = replace(drive.motor, joint_stiffness=None, viscous_friction=1e3)
    thick = replace(drive, cable=replace(drive.cable, axial_damping=1e4), motor=rigid)
    with pytest.raises(cd.InputRefused, match="nothing swings"):
        CONTROLLERS["stepper-shaped"](DesignSpec(thick, QUICK))


def test_a_push_beyond_the_field_loses_steps():
    """Beyond a quarter of a period the rotor falls behind, and comes to rest whole periods away."""
    push = Disturbance(torque=-0.3, start=0.1, end=0.107, on="motor")
    options = RigOptions(disturbances=(push,))
    drive = cd.load_drive("printer-idlers", overrides=["cable.pretension=100 N"])
    motion = replace(QUICK, dwell=0.6)
    run = cd.track(drive, controller="stepper", motion=motion, options=options)
    periods = (run.reference[-1] - run.angles[-1, 0]) * 20.0 / 0.235 / (2 * np.pi)
    assert run.incomplete is None
    assert run.summary["saturated_fraction"] > 0.0
    assert periods > 0.9
    assert periods == pytest.approx(round(periods), abs=0.1)


def test_compare_lists_the_open_loops_of_a_stepper_and_draws_the_same_plants(tmp_path):
    assert set(OPEN_LOOPS) < set(offered(as_axis(printer()), Disturbances()))
    motion = ("--rise", "0.1", "--dwell", "0.05", "--pulses", "1", "--draws", "3")
    found = answer(
        "compare", "printer-idlers", "--controllers", ",".join(OPEN_LOOPS), *motion, "-o", tmp_path / "out"
    )["controllers"]
    plain, shaped = sorted(found, key=lambda one: one["name"])
    assert 0.0 < shaped["worst_deg"] < plain["worst_deg"]
    assert plain["disk_margin"] is None
    assert 0.0 < plain["peak_torque"] < 0.235
    drawn = answer("track", "printer-idlers", "--controller", "stepper", "--draws", "4")["over_draws"]
    assert 0.0 < drawn["median_peak_error_deg"] < drawn["worst_peak_error_deg"] < 5.0


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ("track dissertation-3 --controller stepper", "holding_stiffness"),
        ("track printer-idlers --controller stepper --bandwidth 9", "open loop"),
        ("track printer-idlers --controller stepper --smooth-friction", "set-valued friction"),
        ("export printer-idlers --controller stepper-shaped --format c99 -o out", "open loop"),
    ],
)
def test_what_is_no_stepper_is_refused(words, named, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert named in refusal(*words.split())
