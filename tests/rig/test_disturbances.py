"""What a rig adds to a plant: backlash, jitter, slow torque, loads, slack spans, blind encoders.

Compiled modules under test: cabledrive.rig.closed_loop.piecewise_kernels,
cabledrive.rig.closed_loop.loop_kernels.
"""

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from cabledrive.identification.logs.reading import read_log
from cabledrive.parameters import InputRefused, load_drive
from cabledrive.rig import Disturbance, Motion, RigOptions
from cabledrive.rig.closed_loop.piecewise_kernels import advance_piecewise
from cabledrive.rig.closed_loop.plant import piecewise_numbers, plant_numbers
from cabledrive.rig.closed_loop.plant_kernels import MOST_TERMS
from cabledrive.rig.log_file import log_text
from cabledrive.rig.parsed_options import parse_disturbance, parse_encoder_dropout
from control_chains import INTERVAL, model
from dissertation_runs import track

DRIVE = load_drive("dissertation-3")
IDEAL = RigOptions(ideal_sensors=True)
CENTRED = RigOptions(encoder_phase="centred")
SHORT = Motion(angle=20.0, rise=0.2, dwell=0.05)
CHAIN = replace(model(4), coulomb=(0.0,) * 3, offsets=(0.0,) * 3)


def with_motor(**values):
    return replace(DRIVE, motor=replace(DRIVE.motor, **values))


def pushed(torque, samples, *, play=0.0, slack=float("inf"), substeps=10, start=None):
    """States of the frictionless row under a torque on its motor."""
    step = INTERVAL / substeps
    piecewise = piecewise_numbers(CHAIN, step, play=play, slack=slack)
    scalars = plant_numbers(CHAIN, INTERVAL, substeps=substeps).scalars
    x = np.zeros(7) if start is None else np.array(start, dtype=float)
    terms, work, states = np.zeros((MOST_TERMS, 7)), np.zeros(7), []
    for _ in range(samples):
        advance_piecewise(piecewise, scalars, x, 1, torque, 0.0, 0.0, INTERVAL, terms, work)
        states.append(x.copy())
    return np.array(states)


@pytest.mark.kernel
def test_motor_turns_alone_through_its_backlash():
    """Inside the play only the motor moves, as tau t^2 / 2 J less its viscous friction."""
    states = pushed(1e-3, 20, play=radians(2.0))
    assert np.all(states[:, 1:3] == 0.0)
    time = INTERVAL * 20
    assert states[-1, 0] == pytest.approx(0.5 * 1e-3 / CHAIN.inertias[0] * time**2, rel=0.01)


def test_beyond_its_play_the_joint_is_the_spring_it_was_shifted_by_half_of_it():
    """At rest under a torque against a held load the joint twists by half the play more."""
    plain, loose = (
        track(
            with_motor(backlash=play, coulomb_friction=0.0, offset_torque=0.0),
            controller="pd",
            options=replace(IDEAL, disturbances=(Disturbance(torque=-0.1, start=0.0, end=9.0),)),
        )
        for play in (0.0, radians(0.5))
    )
    twist = [run.angles[-1, 0] - run.angles[-1, 1] for run in (plain, loose)]
    assert twist[1] - twist[0] == pytest.approx(radians(0.25), rel=0.02)


def test_backlash_costs_energy_never_gives_it():
    """Bouncing in the play: what a frictionless row stores only falls."""
    play = radians(1.0)
    states = pushed(0.0, 1500, play=play, substeps=40, start=[0.02, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    twist = np.stack((states[:, 0] - states[:, 1], states[:, 1] - states[:, 2]))
    twist[0] = np.sign(twist[0]) * np.maximum(np.abs(twist[0]) - play / 2, 0.0)
    stored = np.sum(0.5 * np.array(CHAIN.stiffness)[:, None] * twist**2, axis=0)
    stored += 0.5 * states[:, 3:6] ** 2 @ np.array(CHAIN.inertias)
    rises = np.diff(stored).max() / stored[0]
    assert rises < 1e-3, f"observed {rises:.2e} of the energy at the start"
    assert stored[-1] < 0.5 * stored[0]


def test_backlash_of_the_gearhead_is_reported_and_costs_accuracy(measured):
    """Table A.3's 1 deg, unknown to the law."""
    plain, loose = (
        track(
            DRIVE, controller="darc-4-damped", plant_drive=with_motor(backlash=radians(play)), seed=1
        ).summary
        for play in (0.0, 1.0)
    )
    measured(f"{loose['peak_error_deg']:.3f} deg beside {plain['peak_error_deg']:.3f} deg, phases 1")
    assert loose["backlash"] == pytest.approx(radians(1.0))
    assert loose["free_play_samples"] > 100
    assert "backlash in the gearhead" in loose["broken_assumptions"]
    assert 2.0 * plain["peak_error_deg"] < loose["peak_error_deg"] < 1.0


def test_motion_with_backlash_converges_with_the_internal_step(measured):
    """Contacts are seen at internal steps: 20 us are 1e-3 deg from 2.5 us, the play itself 0.01."""
    loose = with_motor(backlash=radians(1.0))
    plain, *runs = (
        track(DRIVE, controller="lqg", plant_drive=a, motion=SHORT, options=replace(IDEAL, substeps=k))
        for a, k in ((DRIVE, 10), (loose, 10), (loose, 20), (loose, 80))
    )
    coarse, fine = (np.degrees(np.abs(run.load_angle - runs[2].load_angle).max()) for run in runs[:2])
    made = np.degrees(np.abs(plain.load_angle - runs[2].load_angle).max())
    measured(f"from 2.5 us: 20 us {coarse:.1e}, 10 us {fine:.1e} deg; the play itself {made:.3f} deg")
    assert coarse < 1e-3, f"observed {coarse:.5f} deg"
    assert fine < 1e-3, f"observed {fine:.5f} deg"
    assert made > 0.01, f"observed {made:.5f} deg"


def test_a_slack_span_carries_nothing_and_the_other_all(measured):
    """Twist beyond slack: the torque rises half as fast, and the tensions say why."""
    push = Disturbance(torque=0.9, start=0.1, end=0.5)
    options = replace(IDEAL, disturbances=(push,), forbid_slack=False)
    result = track(DRIVE, controller="pd", options=options)
    said = result.summary
    measured(f"tensions {result.tensions.min():.2f} to {result.tensions.max():.1f} N")
    assert said["slack_samples"] > 100
    assert "a span went slack" in said["broken_assumptions"]
    assert result.tensions.min() == 0.0
    assert result.tensions.max() > 14.0


def test_the_torque_across_a_slack_cable_is_continuous_and_half_as_stiff(measured):
    """Before anything moves, twice the twist at which a span goes slack gives 1.5 of its torque."""
    slack = 0.2
    states = pushed(0.0, 1, slack=slack, substeps=10, start=[0.0, 0.0, -2.0 * slack, 0.0, 0.0, 0.0, 0.0])
    torque = states[0, 5] / INTERVAL * CHAIN.inertias[2]
    measured(f"{torque / (slack * CHAIN.stiffness[1]):.3f} times the torque at which it goes slack")
    assert torque == pytest.approx(1.5 * slack * CHAIN.stiffness[1], rel=0.03)


def test_slack_is_refused_before_the_motion_where_it_can_be_foreseen():
    with pytest.raises(InputRefused, match="slack torque"):
        track(DRIVE, controller="pd", motion=Motion(angle=90.0, rise=0.18, order=9))


def test_a_slow_torque_loop_costs_accuracy_and_is_known_to_the_filter(measured):
    slow, quick = (
        track(with_motor(current_bandwidth=hertz), controller="darc-4-damped", options=CENTRED).summary
        for hertz in (60.0, 1000.0)
    )
    measured(f"60 Hz {slow['peak_error_deg']:.4f}, 1 kHz {quick['peak_error_deg']:.4f} deg")
    assert slow["peak_error_deg"] > 1.5 * quick["peak_error_deg"]
    assert slow["peak_error_deg"] < 1.0


def test_jitter_of_the_samples_costs_little_below_a_tenth_of_a_sample(measured):
    plain, jittery = (
        track(DRIVE, controller="darc-4-damped", options=replace(CENTRED, jitter=jitter)).summary
        for jitter in (0.0, 2e-5)
    )
    measured(f"{jittery['peak_error_deg']:.4f} deg beside {plain['peak_error_deg']:.4f} deg")
    assert plain["peak_error_deg"] != jittery["peak_error_deg"]
    assert jittery["peak_error_deg"] < plain["peak_error_deg"] + 0.02


def test_a_load_step_is_held_against_by_the_stiffness_of_the_loop(measured):
    """At rest a torque on the load winds the cable up by tau / k."""
    step = Disturbance(torque=0.05, start=0.1, end=9.0)
    still = Motion(angle=1e-3, rise=0.5, dwell=0.5)
    free = with_motor(coulomb_friction=0.0, offset_torque=0.0)
    result = track(free, controller="pd", options=replace(IDEAL, disturbances=(step,)), motion=still)
    twist = result.angles[-1, 2] - result.angles[-1, 1]
    measured(f"twist {twist:.5f} rad, {twist * 2.72 / 0.05:.4f} of the formula's")
    assert twist == pytest.approx(0.05 / 2.72, rel=0.01)


def test_an_encoder_without_numbers_does_not_move_the_command(measured):
    result = track(
        DRIVE, controller="darc-4", options=replace(CENTRED, blind=("motor", 0.1, 0.12)), motion=SHORT
    )
    gone = (result.time > 0.1001) & (result.time < 0.1199)
    moved = np.ptp(result.torque[gone])
    measured(f"command moves by {moved:g} N m over {result.summary['invalid_samples']} samples, all counted")
    assert moved == 0.0
    assert result.summary["invalid_samples"] == 101
    assert np.isnan(result.readings[gone]).any(axis=1).all()
    assert np.isfinite(result.load_angle).all()


def test_a_plant_that_diverges_keeps_what_was_computed(measured):
    """Without a limit of the torque Model 3 on the drive pulley's encoder runs away."""
    free = with_motor(torque_limit=None)
    options = replace(IDEAL, feedback="drive", forbid_slack=False)
    result = track(free, controller="darc-3", bandwidth=40.0, options=options)
    assert result.incomplete is not None
    measured(f"{len(result.time)} of 10000 samples kept: {result.incomplete}")
    assert "diverged" in result.incomplete
    assert 10 < len(result.time) < 10_000
    assert np.isfinite(result.error).all()


def test_the_log_holds_a_load_cell_that_identification_reads(tmp_path, measured):
    """Both spans together pull with twice the pretension, the noise as stated, and the log is still a log."""
    result = track(DRIVE, controller="darc-4", motion=SHORT)
    path = tmp_path / "run.csv"
    path.write_text(log_text(result, DRIVE))
    log = read_log(path)
    cell = log.channel("load_cell_force")
    measured(f"load cell {cell.mean():.3f} N, noise {cell.std():.3f} N")
    assert cell.mean() == pytest.approx(14.0, abs=0.02)
    assert cell.std() == pytest.approx(0.05, rel=0.1)
    assert {"torque", "angle", "drive_angle", "load_angle"} <= set(log.channels)


@pytest.mark.parametrize(
    "words, refusal",
    [
        ("load:0.05", "SHAFT:TORQUE:START:END"),
        ("drive:0.05:0.1:0.2", "motor or load"),
        ("load:nan:0.1:0.2", "not a quantity"),
        ("load:0.05:0.2:0.1", "no time"),
    ],
)
def test_disturbances_that_cannot_be_are_refused(words, refusal):
    with pytest.raises(InputRefused, match=refusal):
        parse_disturbance(words)


def test_disturbances_and_failures_are_read_with_their_units():
    assert parse_disturbance("motor:20 mN m:0.1 s:200 ms") == Disturbance(
        torque=0.02, start=0.1, end=0.2, on="motor"
    )
    assert parse_encoder_dropout("load:0.1:0.2") == ("load", 0.1, 0.2)
    with pytest.raises(InputRefused, match="swap"):
        parse_encoder_dropout("load:0.2:0.1")
