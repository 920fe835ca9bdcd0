"""The distributed cable as plant: near its lumped chain, and named where it is not.

Compiled modules under test: cabledrive.rig.closed_loop.cable_kernels,
cabledrive.rig.closed_loop.sample_kernels.
"""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.parameters import InputRefused, load_drive
from cabledrive.rig import Disturbance, Motion, RigOptions
from cabledrive.rig.closed_loop.cable_plant import drive_like
from cabledrive.rig.closed_loop.loop import close_loop, plant_chain, run
from cabledrive.rig.laws.registry import design
from cabledrive.rig.plant_samples import sampled_chain
from cabledrive.rig.run_facts import why_ended
from cabledrive.rig.trial import spec_for
from dissertation_runs import track

DRIVE = load_drive("dissertation-3")
IDEAL = RigOptions(ideal_sensors=True)
SHORT = Motion(angle=20.0, rise=0.2, dwell=0.05)


def on_cable(controller, options=IDEAL, **choices):
    return track(DRIVE, controller=controller, plant="cable", options=options, **choices)


@pytest.mark.kernel
def test_cable_starts_as_its_row_of_inertias_does():
    """Twenty samples: too short for the cable's own modes to matter."""
    motion = Motion(angle=20.0, rise=0.002, dwell=0.001)
    spec = spec_for(DRIVE, motion)
    options = replace(IDEAL, segments=4)
    found = [
        run(close_loop(DRIVE, DRIVE, design("pd", spec), motion, options, np.random.default_rng(0), cable=c))
        for c in (False, True)
    ]
    row, cable = (done.log[: len(done.log), 0] for done in found)
    assert np.abs(row).max() > 1e-4
    assert np.abs(row - cable).max() < 0.05 * np.abs(row).max(), (
        f"observed {np.abs(row - cable).max():.2e} rad"
    )


@pytest.mark.parametrize("controller", ["darc-3", "darc-4", "darc-4-damped"])
def test_cable_leaves_the_error_of_its_row_of_inertias(controller):
    """True states: within 3 % and no worse than the 20 % that are asked of the rig."""
    row = track(DRIVE, controller=controller, options=IDEAL).summary["peak_error_deg"]
    said = on_cable(controller).summary
    assert said["peak_error_deg"] == pytest.approx(row, rel=0.03)
    assert said["cable"]["one_to_two"] == "far from it"
    assert 0.0 < said["cable"]["spillover_deg"] < 1e-3


def test_cable_comes_nearer_to_itself_with_more_segments(measured):
    row = track(DRIVE, controller="darc-4", options=IDEAL).load_angle
    angles = {n: on_cable("darc-4", replace(IDEAL, segments=n)).load_angle for n in (4, 8, 12, 24, 32)}
    off = {n: np.degrees(np.abs(angle - row).max()) for n, angle in angles.items()}
    coarse, fine = (np.degrees(np.abs(angles[n] - angles[32]).max()) for n in (4, 8))
    apart = ", ".join(f"{n} segments {size:.4f}" for n, size in off.items())
    measured(f"from the row: {apart} deg; 4 and 8 from 32: {coarse:.4f}, {fine:.4f} deg")
    assert fine < 0.6 * coarse
    assert fine < 0.002, f"observed {fine:.5f} deg"


def test_cable_as_printed_is_softer_than_the_design_believes(measured):
    """EA/L is 438 N/m without damping, the design believes 850: as a lumped chain with those numbers."""
    soft = load_drive("dissertation-3", overrides=["lumped.cable_stiffness=438", "lumped.cable_damping=0"])
    row = track(DRIVE, controller="darc-4-damped", plant_drive=soft, options=IDEAL).summary
    said, undamped = (
        on_cable(law, replace(IDEAL, as_printed=True)).summary for law in ("darc-4-damped", "darc-4")
    )
    words = f"darc-4-damped {said['peak_error_deg']:.3f} (row {row['peak_error_deg']:.3f})"
    measured(f"{words}, darc-4 {undamped['peak_error_deg']:.3f} deg")
    assert said["peak_error_deg"] == pytest.approx(row["peak_error_deg"], rel=0.03)
    assert said["peak_error_deg"] > 0.5
    assert said["cable"]["stiffness"] == pytest.approx(438.0)
    assert on_cable("darc-4-damped").summary["cable"]["stiffness"] == pytest.approx(850.0)


def test_damping_of_the_cable_is_the_measured_one():
    """b_c = 0.18 N s/rad at a pulley of 4 cm is 4.5 N s along a cable of 1 m."""
    assert on_cable("pd", motion=SHORT).summary["cable"]["axial_damping"] == pytest.approx(0.18 / 0.04)


def test_encoders_delay_and_torque_loop_act_on_the_cable_too():
    late = replace(DRIVE, sensors=replace(DRIVE.sensors, delay=1.3e-4))
    row, cable = (
        track(late, controller="darc-4", plant=plant, seed=2, motion=SHORT).summary
        for plant in (None, "cable")
    )
    assert cable["encoder_phases"] == row["encoder_phases"]
    assert cable["peak_error_deg"] == pytest.approx(row["peak_error_deg"], rel=0.1)


def test_load_on_the_pulley_turns_it_and_can_make_a_span_slack(measured):
    """Some milliseconds after the lumped chain: a span that hangs keeps some tension for a while."""
    push = Disturbance(torque=0.9, start=0.1, end=0.5)
    result = on_cable("darc-4", replace(IDEAL, disturbances=(push,)))
    assert result.incomplete is not None
    assert "slack" in result.incomplete
    row = track(DRIVE, controller="darc-4", options=replace(IDEAL, disturbances=(push,)))
    later, least = len(result.time) - len(row.time), result.tensions.min() / DRIVE.cable.pretension
    measured(f"ends {1e3 * (result.time[-1] - row.time[-1]):.1f} ms after the row, at {100 * least:.2f} %")
    assert 0 < later < 50


def test_a_span_that_goes_slack_in_the_last_sample_is_reported_too():
    """The same run, of a motion that ends where it did: as many samples as were asked for, and yet failed."""
    push = Disturbance(torque=0.9, start=0.1, end=0.5)
    options, law = replace(IDEAL, disturbances=(push,)), design("darc-4", spec_for(DRIVE, SHORT))
    loop = close_loop(DRIVE, DRIVE, law, SHORT, options, np.random.default_rng(0), cable=True)
    early = run(loop)
    assert early.failed
    assert early.ended < len(loop.target)
    whole = run(replace(loop, target=loop.target[: early.ended]))
    assert whole.ended == early.ended
    assert whole.failed
    assert why_ended(replace(loop, target=loop.target[: early.ended]), whole) == why_ended(loop, early)
    assert not run(replace(loop, target=loop.target[: early.ended - 1])).failed


def test_spans_carry_the_pretension_together():
    result = on_cable("darc-4", motion=SHORT)
    assert result.tensions.sum(axis=1) == pytest.approx(14.0, abs=0.01)
    row = track(DRIVE, controller="darc-4", options=IDEAL, motion=SHORT)
    assert np.abs(row.tensions - result.tensions).max() < 0.1


@pytest.mark.parametrize(
    "law, choices",
    [
        *(("darc-1", {"bandwidth": hertz, "options": RigOptions(feedback="drive")}) for hertz in (3.0, 11.0)),
        *((law, {}) for law in ("darc-2", "darc-3", "darc-4", "backstepping", "darc-4-damped")),
        ("darc-4-damped", {"gains": "best"}),
    ],
)
def test_cable_keeps_its_own_modes_small_at_two_phases(law, choices, measured):
    """Two of 16: each run to its end, the middle of a span within 0.002 deg of the line between its ends."""
    runs = [track(DRIVE, controller=law, plant="cable", seed=seed, **choices) for seed in range(2)]
    spillover = max(one.summary["cable"]["spillover_deg"] for one in runs)
    measured(f"spillover {spillover:.1e} deg")
    assert all(one.incomplete is None for one in runs)
    assert spillover < 2e-3


def test_a_drawn_row_of_inertias_has_a_drive_of_its_own():
    chain = sampled_chain(plant_chain(DRIVE, 4), np.random.default_rng(1))
    again = plant_chain(drive_like(DRIVE, chain), 4)
    for name in ("inertias", "stiffness", "damping", "coulomb", "viscous", "offsets"):
        assert getattr(again, name) == pytest.approx(getattr(chain, name))


def test_draws_run_on_the_cable():
    over = on_cable("darc-4", draws=2, motion=SHORT).summary["over_draws"]
    assert over["failed"] == 0
    assert 0.0 < over["median_peak_error_deg"] < 0.5


@pytest.mark.parametrize(
    "options, drive, words",
    [
        (replace(IDEAL, jitter=1e-5), DRIVE, "jitter"),
        (IDEAL, replace(DRIVE, motor=replace(DRIVE.motor, backlash=0.01)), "backlash"),
    ],
)
def test_what_the_cable_does_not_follow_is_refused(options, drive, words):
    with pytest.raises(InputRefused, match=words):
        track(drive, controller="pd", plant="cable", options=options)
