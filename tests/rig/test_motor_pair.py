"""Two motors preloaded against the backlash of their gears: against scipy, one motor, draws and take-over."""

from dataclasses import replace

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.rig import Disturbance, Motion, RigOptions
from cabledrive.rig.closed_loop.chain_kernels import LEAST
from cabledrive.rig.closed_loop.chain_plant import doubled
from cabledrive.rig.closed_loop.loop import close_loop, run
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.plant_samples import loop_with_loads, sampled_loops
from cabledrive.rig.tuning import design
from oracles.by_scipy import MotorPair, run_pair

DEGREE, COUNT = np.pi / 180.0, 0.036
BACKLASH, FRICTIONLESS = ["motor.backlash=1 deg"], ["motor.coulomb_friction=0", "motor.offset_torque=0"]
DRIVE = cd.load_drive("dissertation-3", overrides=BACKLASH).listed
SMOOTH = cd.load_drive("dissertation-3", overrides=[*BACKLASH, *FRICTIONLESS]).listed
PAIR = RigOptions(pair=True)
SHORT = Motion(angle=10.0, rise=0.12, dwell=0.05, order=11)


def loop_of(drive, law, hertz, motion, options, seed=0):
    drive = doubled(drive) if options.pair else drive
    choices = {"bandwidth": hertz, "adapt": True, "best": True, "feedforward": "damped"}
    spec = DesignSpec(drive, motion, **choices, options=options, plant=None)
    return close_loop(
        DesignSpec(drive, motion, options=options), design(law, spec), np.random.default_rng(seed)
    )


@pytest.mark.kernel("cabledrive.rig.closed_loop.chain_kernels")
@pytest.mark.kernel("cabledrive.control.observers")
def test_the_pair_moves_as_scipy_integrates_it_also_where_a_flank_opens(measured):
    """Commands of the run replayed; a shock on the load of 0.9 N m opens a flank and closes it again."""
    tight = cd.load_drive(
        "dissertation-3", overrides=[*BACKLASH, *FRICTIONLESS, "cable.pretension=60 N"]
    ).listed
    push = Disturbance(torque=0.9, start=0.1, end=0.13)
    options = RigOptions(pair=True, preload=0.3, disturbances=(push,), encoder_phase="centred")
    loop = loop_of(tight, "lqg", 20.0, SHORT, options)
    done = run(loop)
    gear = MotorPair(
        motor=1.1e-3, viscous=3.1e-3, stiffness=135.0, loss=0.075, gap=DEGREE, shaft=6.42e-4, load=2.35e-3,
        cable=2.0 * 850.0 * 0.04**2, cable_loss=2.0 * 0.18 * 0.04, rate=2.0 * np.pi * 1000.0,
    )  # fmt: skip
    angles, flanks = run_pair(gear, 0.3, done.flanks[:, 2:4], loop.rig.forces[:, 1], 2e-4)
    assert flanks.min() < -0.01, "no flank opened: the case is too mild"
    ours = np.degrees(done.log[:, 2])
    theirs = np.degrees(angles[:, 3])
    off = np.abs(ours - theirs).max() / np.abs(theirs).max()
    apart = np.abs(done.flanks[:, :2] - flanks).max()
    measured(f"load {off:.1e} of the way, flanks {apart:.1e} N m, of which one had {flanks.min():.2f} N m")
    assert off < 2e-3
    assert apart < 0.03


def test_encoders_and_friction_of_a_pair_begin_anywhere_within_their_range():
    """Phases within half a count, friction held at up to all of it, either way."""
    skews = [loop_of(DRIVE, "lqg", 20.0, SHORT, PAIR, seed).pair for seed in range(24)]
    for name, most in (("phase", 0.5), ("held", 1.0)):
        values = np.array([getattr(skew, name) for skew in skews])
        assert np.abs(values).max() <= most
        assert values.min() < -0.5 * most < 0.5 * most < values.max()


@pytest.mark.parametrize(
    "drive, kind, most",
    [
        (SMOOTH, {}, 1e-5),
        (DRIVE, {"smooth_friction": True}, 2e-3),
        (DRIVE, {"load_change": (0.05, 2.0)}, 2e-3),
    ],
    ids=["no friction", "smooth", "load"],
)
def test_with_both_flanks_closed_the_pair_is_a_motor_of_twice_the_size_without_backlash(
    drive, kind, most, measured
):
    """True states: the error of the load to the integrators' order."""
    plain, options = doubled(drive), RigOptions(ideal_sensors=True, **kind)
    plain = replace(plain, motor=replace(plain.motor, backlash=0.0))
    pair, single = (
        run(loop_with_loads(loop_of(one, "lqg", 20.0, SHORT, chosen)))
        for one, chosen in ((drive, replace(options, pair=True)), (plain, options))
    )
    assert pair.state.summary[10] == 0
    off = np.abs(pair.log[:, 2] - single.log[:, 2]).max() / np.abs(single.log[:, 2]).max()
    measured(f"{off:.1e} of the way")
    assert off < most, off


def over_draws(law, hertz, draws, seed, options=PAIR, drive=DRIVE):
    """Peaks [deg], swings at rest [counts] and the least torque of a flank over drawn plants."""
    motion = Motion(dwell=1.0, order=11)
    loop = loop_of(drive, law, hertz, motion, options)
    peaks, swings, least = [], [], []
    for one in sampled_loops(loop, draws, seed):
        done = run(one)
        assert not done.failed
        error = np.degrees(one.load_error(done.log))
        peaks.append(np.abs(error).max())
        swings.append(np.ptp(error[-2500:]) / COUNT)
        first = 2 * one.chain.size + 1 + LEAST
        if options.pair:
            least.append(done.state.x[first : first + 2].min())
    return np.array(peaks), np.array(swings), np.array(least)


@pytest.mark.parametrize("draws", [8, pytest.param(200, marks=pytest.mark.verify)])
def test_the_pair_keeps_its_flanks_closed_and_comes_to_rest_within_a_count(draws, measured):
    """One motor cycles; goal for the error: the backlash over the ratio of 5.2."""
    peaks, swings, least = over_draws("lqg", 15.0, draws, draws)
    _, alone, _ = over_draws("lqg", 15.0, min(draws, 40), draws, RigOptions())
    measured(
        f"median {np.median(peaks):.3f}, 99 % {np.quantile(peaks, 0.99):.3f}, worst {peaks.max():.3f} deg; "
        f"at rest {swings.max():.2f} counts, above one {np.mean(swings > 1.0):.1%} (one motor "
        f"{np.mean(alone > 1.0):.0%}); least flank {least.min():.3f} N m"
    )
    assert least.min() > 0.0
    assert np.mean(swings <= 1.0) >= 0.98
    assert np.mean(peaks < 1.0 / 5.2) >= 0.95
    assert np.mean(alone > 1.0) > 0.5


def test_where_the_torque_exceeds_the_preload_a_flank_opens_and_the_result_says_so():
    """Take-over: a shock of 1.2 N m, the load 20 % heavier than believed; then both flanks close again."""
    tight = cd.load_drive("dissertation-3", overrides=[*BACKLASH, "cable.pretension=60 N"]).listed
    heavy = replace(tight, pulley=(tight.pulley[0], replace(tight.pulley[1], inertia=0.00282)))

    def shocked(preload, torque, **choices):
        push = Disturbance(torque=torque, start=0.7, end=0.75)
        options = RigOptions(pair=True, preload=preload, disturbances=(push,))
        law = {"controller": "lqg", "bandwidth": 20.0, "plant_drive": heavy}
        return cd.track(tight, **law, options=options, **choices)

    found = shocked(0.5, 1.2, motion=Motion(dwell=1.0))
    said = found.summary
    assert said["pair"]["flanks_closed"] is False
    assert "a flank was open" in said["pair"]["reason"]
    assert "a flank of the pair of motors was open" in said["departures"]
    assert found.incomplete is None
    assert np.degrees(np.abs(found.error[-500:])).max() < 0.5
    gentle = shocked(1.0, 0.8).summary
    assert gentle["pair"]["flanks_closed"] is True
    assert "reason" not in gentle["pair"]


def test_the_observer_finds_the_flank_torques_within_rounding_and_friction(measured):
    """Half a count of either encoder across the joint is 0.16 N m, friction holds 0.038 N m."""
    found = cd.track(DRIVE, controller="lqg", bandwidth=20.0, options=PAIR, seed=3, draws=2).summary
    assert found["over_draws"]["flanks_closed"] == 2
    said = found["pair"]
    measured(f"largest error {said['flank_observer_error']:.3f} N m")
    assert said["flank_observer_error"] < 135.0 * np.pi / 2600 + 0.04
    assert said["motor_peak_torque"][0] < said["torque_limit"] == pytest.approx(2.1)
