"""Backstepping of six states on the rig: gains, dampers, adaptation, a few draws of the plant."""

from dataclasses import fields, replace

import numpy as np
import pytest

from cabledrive.parameters import InputRefused, load_drive
from cabledrive.rig import Motion, RigOptions
from cabledrive.rig.closed_loop.loop import close_loop, run
from cabledrive.rig.closed_loop.other_plants import with_plant
from cabledrive.rig.laws.backstepping_laws import backstepping_6
from cabledrive.rig.laws.eigenvalues import closed_loop_poles
from cabledrive.rig.plant_samples import Spreads, sampled_chain
from cabledrive.rig.trial import spec_for
from dissertation_runs import track

DRIVE = load_drive("dissertation-3")
SPEC = spec_for(DRIVE, Motion())
SIZES = {"median": "median_peak_error", "99 %": "peak_error_99", "worst": "worst_peak_error"}


def test_nominal_drive_and_a_few_drawn_ones_are_followed_at_25_hz():
    """Encoders with random phases: 0.08 deg on the nominal drive, 0.15 deg over draws."""
    said = track(DRIVE, controller="backstepping-6", seed=0, draws=10).summary
    assert said["gains"]["bandwidth_hz"] == 25.0
    assert said["peak_error_deg"] < 0.08, f"observed {said['peak_error_deg']:.4f} deg"
    worst = said["over_draws"]["worst_peak_error_deg"]
    assert worst < 0.15, f"observed {worst:.4f} deg"
    assert said["estimates_within_bounds"] is True
    assert said["peak_torque"] < 0.3


def test_dampers_along_the_reference_are_worth_a_factor_of_three():
    """Ideal states: 0.077 deg with the dampers left out, as in the printed laws; below 0.02 with them."""
    made = backstepping_6(replace(SPEC, adapt=False))
    plain = made.reference.copy()
    plain[:, 7:16] = 0.0
    peaks = []
    for reference in (made.reference, plain):
        loop = close_loop(
            DRIVE,
            DRIVE,
            replace(made, reference=reference),
            Motion(),
            RigOptions(ideal_sensors=True),
            np.random.default_rng(0),
        )
        peaks.append(np.degrees(run(loop, log=False).state.summary[0]))
    assert peaks[0] < 0.02, f"observed {peaks}"
    assert peaks[1] == pytest.approx(0.077, abs=0.004), f"observed {peaks}"


def test_estimates_move_smoothly_at_the_chosen_gain():
    """No estimate crosses its own range more than 40 times; a million times the gain does 500 times."""
    estimates = track(DRIVE, controller="backstepping-6", seed=0).estimates
    moved = np.abs(np.diff(estimates, axis=0)).sum(axis=0)
    spread = np.ptp(estimates, axis=0)
    assert np.all(spread > 0.0)
    assert np.all(moved < 40.0 * spread), f"observed {moved / spread}"


@pytest.mark.parametrize("law, hertz", [("backstepping", 10.5), ("backstepping-6", 25.0)])
def test_sufficient_condition_is_reported_over_the_run_and_not_met(law, hertz, measured):
    """D_z of (6.100): the bandwidth without adaptation; negative all along the pulse with it."""
    options = RigOptions(check_conditions=True)
    still, adapting = (
        track(DRIVE, controller=law, options=options, adapt=adapt).summary["d_z"] for adapt in (False, True)
    )
    words = f"smallest eigenvalue {still['smallest']:.1f} 1/s without adaptation"
    measured(f"{words}, below {adapting['largest']:.1e} 1/s all along the pulse with it")
    assert still["positive_share"] == 1.0
    assert still["smallest"] == pytest.approx(2 * np.pi * hertz, rel=0.01), f"observed {still}"
    assert adapting["positive_share"] == 0.0
    assert adapting["largest"] < -1e4, f"observed {adapting}"


def test_poles_on_the_true_plant_give_the_least_bandwidth(measured):
    """Dampers left out of the feedback: 30.8 Hz (0.34), 7.2 Hz (0.81) at 25 Hz; unstable below 11.3 Hz."""
    poles = closed_loop_poles(DRIVE, backstepping_6(SPEC))
    found = sorted((p.frequency, p.damping_ratio) for p in poles if p.damping_ratio < 0.99)
    assert found[0] == (pytest.approx(7.2, abs=0.1), pytest.approx(0.81, abs=0.01))
    assert found[-1] == (pytest.approx(30.8, abs=0.1), pytest.approx(0.34, abs=0.01))
    with pytest.raises(InputRefused) as refused:
        track(DRIVE, controller="backstepping-6", bandwidth=10.5)
    measured(str(refused.value))
    refused.match(r"below 11\.3 Hz")
    assert track(DRIVE, controller="backstepping-6", bandwidth=15.0).summary["peak_error_deg"] < 0.12


@pytest.mark.verify
def test_a_thousand_draws(measured):
    """p2 to p5 in the printed bounds, k and J2 5 %, b_c 20 %, k_m 10 %, phases random: worst 0.134 deg."""
    said, still = (
        track(DRIVE, controller="backstepping-6", draws=1000, seed=2026, adapt=adapt).summary["over_draws"]
        for adapt in (True, False)
    )
    words = ", ".join(f"{size} {said[f'{key}_deg']:.3f}" for size, key in SIZES.items())
    measured(f"{words} deg; without adaptation worst {still['worst_peak_error_deg']:.3f} deg")
    assert said["failed"] == 0
    assert said["worst_peak_error_deg"] <= 0.15, f"observed {said['worst_peak_error_deg']:.4f} deg"
    assert said["median_peak_error_deg"] == pytest.approx(0.049, abs=0.004)


@pytest.mark.verify
def test_nominal_over_32_phases(measured):
    """Median 0.038, worst 0.061 deg."""
    peaks = [track(DRIVE, controller="backstepping-6", seed=s).summary["peak_error_deg"] for s in range(32)]
    measured(f"median {np.median(peaks):.4f}, worst {max(peaks):.4f} deg")
    assert max(peaks) <= 0.08, f"observed {max(peaks):.4f} deg"
    assert np.median(peaks) == pytest.approx(0.038, abs=0.006)


NONE = dict.fromkeys((one.name for one in fields(Spreads)), 0.0)
SPREADS = {
    "all": Spreads(),
    "all but cable and load": Spreads(cable_stiffness=0.0, load_inertia=0.0),
    "all but the cable's damping": Spreads(cable_damping=0.0),
    "cable and load alone": Spreads(**NONE | {"cable_stiffness": 0.05, "load_inertia": 0.05}),
}


def worst_errors(draws):
    """Of each of the spreads [deg]; the motor is drawn in its printed bounds, but for the last."""
    options, worst = RigOptions(), {}
    loop = close_loop(DRIVE, DRIVE, backstepping_6(SPEC), Motion(), options, np.random.default_rng(0))
    for name, spreads in SPREADS.items():
        peaks = []
        for generator in np.random.default_rng(3).spawn(draws):
            chain, sure = sampled_chain(loop.chain, generator, spreads), loop.chain
            if "alone" in name:
                motor = {part: getattr(sure, part) for part in ("viscous", "coulomb", "offsets")}
                chain = replace(chain, inertias=(sure.inertias[0], *chain.inertias[1:]), **motor)
            phases = generator.uniform(-0.5, 0.5, len(loop.rig.phases))
            one = replace(with_plant(loop, chain, options), rig=loop.rig._replace(phases=phases))
            peaks.append(np.degrees(run(one, log=False).state.summary[0]))
        worst[name] = max(peaks)
    return worst


@pytest.mark.verify
def test_cable_and_load_are_what_limits(measured):
    """200 draws, k and J2 alone as designed: worst 0.067 instead of 0.133 deg."""
    worst = worst_errors(200)
    measured("worst " + ", ".join(f"{name} {peak:.4f}" for name, peak in worst.items()) + " deg")
    assert worst["all"] == pytest.approx(0.133, abs=0.01), f"observed {worst}"
    assert worst["all but cable and load"] == pytest.approx(0.067, abs=0.01), f"observed {worst}"


def test_no_cause_leaves_more_over_twenty_draws_than_over_two_hundred(measured):
    """The first tenth of them: 0.133 and 0.067 deg, with the hundredth that is allowed there."""
    worst = worst_errors(20)
    measured("worst " + ", ".join(f"{name} {peak:.4f}" for name, peak in worst.items()) + " deg")
    assert worst["all"] <= 0.143, f"observed {worst}"
    assert worst["all but cable and load"] <= 0.077, f"observed {worst}"
