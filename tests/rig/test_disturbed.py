"""What a rig adds to a plant: backlash, jitter, slow torque, loads, slack spans, blind encoders, wear."""

from dataclasses import fields, replace
from math import radians

import numpy as np
import pytest

from cabledrive.app.results import log_text
from cabledrive.identification.logs.reading import read_log
from cabledrive.parameters import load_drive
from cabledrive.rig import Disturbance, Motion, RigOptions
from cabledrive.rig.closed_loop.chain_plant import chain_numbers
from cabledrive.rig.closed_loop.loop import close_loop, loop_at_rest, run
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.laws.registry import CONTROLLERS
from cabledrive.rig.plant_samples import Disturbances, disturbed_loop, load_disturbances, with_disturbances
from control_chains import INTERVAL, model, states_of
from rig_runs import track
from true_plants import followed, truth_of

DRIVE = load_drive("dissertation-3").listed
IDEAL = RigOptions(ideal_sensors=True)
CENTRED = RigOptions(encoder_phase="centred")
SHORT = Motion(angle=20.0, rise=0.2, dwell=0.05)
CHAIN = replace(model(4), coulomb=(0.0,) * 3, offsets=(0.0,) * 3)


def with_motor(**values):
    return replace(DRIVE, motor=replace(DRIVE.motor, **values))


@pytest.mark.parametrize("delay, whole, rest", [(1e-3, 5, 0.0), (1.2e-3, 6, 0.0), (0.3e-3, 1, 1e-4)])
def test_a_delay_of_whole_samples_leaves_no_rest(delay, whole, rest):
    """By its digits 1 ms of 0.2 ms is 4 samples and nearly one, to which nothing could be added."""
    drive = replace(DRIVE, sensors=replace(DRIVE.sensors, delay=delay))
    spec = DesignSpec(drive, SHORT, options=IDEAL)
    loop = close_loop(spec, CONTROLLERS["pd"](replace(spec, bandwidth=10.0)), np.random.default_rng(0))
    assert (loop.rig.late_samples, loop.rig.late_part) == (whole, pytest.approx(rest, rel=1e-9, abs=0.0))
    later = disturbed_loop(loop, Disturbances(added_delay=(5e-5, 5e-5)), np.random.default_rng(0))
    assert later.rig.late_part == pytest.approx(rest + 5e-5)


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
    plant = chain_numbers(CHAIN, INTERVAL, RigOptions(substeps=10, forbid_slack=False), links=(0.0, slack))
    states = states_of(plant, np.zeros(1), [0.0, 0.0, -2.0 * slack, 0.0, 0.0, 0.0, 0.0])
    torque = states[0, 5] / INTERVAL * CHAIN.inertias[2]
    measured(f"{torque / (slack * CHAIN.stiffness[1]):.3f} times the torque at which it goes slack")
    assert torque == pytest.approx(1.5 * slack * CHAIN.stiffness[1], rel=0.03)


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


MOTION, OPTIONS = Motion(angle=20.0, rise=0.3, dwell=0.15, order=11), RigOptions(forbid_slack=False)


@pytest.fixture(scope="module")
def loop():
    made = CONTROLLERS["lqi"](DesignSpec(DRIVE, MOTION, bandwidth=20.0))
    found = close_loop(DesignSpec(DRIVE, MOTION, options=OPTIONS), made, np.random.default_rng(4))
    # Without counts: a loop that rounds makes other counts out of the last digit of an integrator.
    return replace(found, rig=found.rig._replace(counts=np.zeros(3)))


def disturbed(loop, phases=(0.0, 0.0, 0.0), **values):
    drawn = {one.name: one.default[0] for one in fields(Disturbances)} | values
    chain = replace(
        loop.chain, coulomb=(*loop.chain.coulomb[:-1], loop.chain.coulomb[-1] + drawn["load_coulomb"])
    )
    return with_disturbances(loop, chain, drawn, np.array(phases))


@pytest.mark.parametrize(
    "ours, theirs",
    [
        ({"load_coulomb": 0.02}, {"c3": 0.02}),
        ({"stribeck_excess": 0.5}, {"stribeck": 0.5 * 0.0376}),
        ({"cogging": 0.02, "cogging_periods": 24.0}, {"cogging": 0.02, "cogging_lines": 24.0}),
        ({"torque_ripple": 0.3, "ripple_periods": 12.0}, {"ripple": 0.3, "ripple_lines": 12.0}),
        ({"encoder_eccentricity": 2e-3}, {"eccentric": 2e-3}),
        ({"backlash": 0.004}, {"gap": 0.004}),
    ],
    ids=lambda value: next(iter(value)),
)
def test_each_disturbance_is_that_of_another_integrator(loop, ours, theirs, measured):
    """Peak error of the same law on plants of `true_plants.py`, whose steps are semi-implicit."""
    found = run(disturbed(loop, (0.7, 0.0, 0.4), **ours), log=False).state.summary[0]
    true = truth_of(DRIVE).but(**theirs).values
    other = followed(true, loop.control, loop_at_rest(loop), np.array([0, 1, 2]), 5e-6)
    plain = run(disturbed(loop), log=False).state.summary[0]
    measured(f"{np.degrees(found):.4f} deg, the other {np.degrees(other):.4f}")
    assert abs(found - other) < 0.02 * other, f"observed {found:.3e}, {other:.3e} rad"
    assert abs(found - plain) > abs(found - other), "the disturbance changes nothing"


def test_a_file_of_ranges_is_read_with_its_units(tmp_path):
    path = tmp_path / "disturbances.toml"
    path.write_text('load_coulomb = ["0 N m", "20 mN m"]\nbacklash = "1 deg"\nload_factor = [0.5, 3]\n')
    found = load_disturbances(path)
    assert found.load_coulomb == (0.0, pytest.approx(0.02))
    assert found.backlash == (pytest.approx(np.radians(1.0)),) * 2
    assert found.load_factor == (0.5, 3.0)
    assert found.cogging == (0.0, 0.0)
