"""The law that learns, the bound, the baselines over many draws; a seeded tenth of some in `make test`."""

from functools import cache

import numpy as np
import pytest
from scipy.stats import binom

from cabledrive.parameters import load_drive
from cabledrive.rig import Motion, RigOptions
from cabledrive.rig.closed_loop.loop import Loop, close_loop, run
from cabledrive.rig.expected_bound import expected_bound
from cabledrive.rig.laws.indirect import RUBBING_LOAD, LearningSamples, run_learning_samples
from cabledrive.rig.plant_samples import sampled_loops
from cabledrive.rig.trial import spec_for
from cabledrive.rig.tuning import design
from dissertation_runs import track

DRIVE = load_drive("dissertation-3")
TWO = Motion(pulses=2)
DRAWS, SEED = 1000, 2027
WHOLE = pytest.param(DRAWS, marks=pytest.mark.verify)
RARE = 1e-3


def loop_of(name: str, motion: Motion, **choices) -> Loop:
    spec = spec_for(DRIVE, motion, **choices)
    return close_loop(DRIVE, DRIVE, design(name, spec), motion, RigOptions(), np.random.default_rng(0))


@cache
def learning(draws: int = DRAWS, rubbing: bool = False) -> LearningSamples:
    spec = spec_for(DRIVE, TWO, best=True)
    loop = loop_of("darc-indirect", TWO, best=True)
    spreads = RUBBING_LOAD if rubbing else None
    return run_learning_samples(loop, spec, RigOptions(), draws, SEED, spreads=spreads)


def errors_in(said: dict) -> str:
    """After the first pulse against the encoder's own zero and true, then in the first pulse [deg]."""
    own, true = (
        f"{said[f'{kind}_99_deg']:.4f} (99 %), median {said[f'median_{kind}_deg']:.4f}, "
        f"worst {said[f'worst_{kind}_deg']:.4f}"
        for kind in ("encoder_error", "peak_error")
    )
    return f"own zero {own}; true {true}; first pulse {said['worst_first_pulse_error_deg']:.4f} deg"


@pytest.mark.parametrize("draws", [20, WHOLE])
def test_law_that_learns_keeps_within_its_encoders_count(draws, measured):
    """99 of 100 draws within 0.036 deg of the encoder's zero, 0.050 deg true; first pulse 0.10 deg."""
    found = learning(draws)
    measured(f"{draws} draws: {errors_in(found.words)}")
    beyond = [
        np.count_nonzero(np.degrees(angles) > limit)
        for angles, limit in ((found.own_later, 0.036), (found.later, 0.050))
    ]
    assert found.words["failed"] == 0
    assert max(beyond) <= (0.01 * DRAWS if draws == DRAWS else binom.isf(RARE, draws, 0.01)), beyond
    assert found.words["worst_first_pulse_error_deg"] <= 0.10


@pytest.mark.verify
def test_friction_of_the_load_stays_in_the_error_and_out_of_beta(measured):
    """Up to 0.02 N m drawn as well: no torque of the motor cancels it, and no law here compensates it."""
    said = learning(rubbing=True).words
    measured(f"{said['draws']} draws, {said['unused']} not used: {errors_in(said)}")
    assert said["failed"] == 0
    assert said["unused"] <= 0.01 * DRAWS
    assert said["worst_peak_error_deg"] <= 0.20


@pytest.mark.parametrize(
    "rubbing", [False, True], ids=["load without friction", "up to 0.02 N m at the load"]
)
@pytest.mark.parametrize("draws", [20, WHOLE])
def test_beta_after_one_pulse_and_the_coverage_of_its_interval(draws, rubbing, measured):
    """Of twenty draws the lower end only: as many hold as 93 % leave but once in 1,000."""
    found = learning(draws, rubbing)
    said, covered = found.words, found.covered.sum(axis=0)
    shares = ", ".join(f"{name} {100 * share:.1f}" for name, share in said["interval_coverage"].items())
    measured(f"beta {100 * said['worst_relative_error_of_beta']:.3f} % at most; intervals hold {shares} %")
    assert said["worst_relative_error_of_beta"] <= 2e-3
    if draws < DRAWS:
        assert min(covered) >= binom.ppf(RARE, draws, 0.93), covered
        return
    slack = 2.0 * np.sqrt(0.95 * 0.05 / DRAWS)  # two standard errors
    for name, share in said["interval_coverage"].items():
        highest = 0.99 if name == "beta" and not rubbing else 0.97 + slack
        assert 0.93 - slack <= share <= highest, f"observed {share:.3f} of {name}"


@pytest.mark.verify
@pytest.mark.parametrize("gains", ["printed", "best"])
def test_cable_of_438_under_a_design_for_850(gains, measured):
    soft = load_drive("dissertation-3", overrides=["lumped.cable_stiffness=438"])
    said = [
        track(DRIVE, controller="darc-indirect", plant_drive=soft, motion=TWO, seed=seed, gains=gains).summary
        for seed in range(32)
    ]
    first = max(one["first_pulse_error_deg"] for one in said)
    later = [one["later_pulses_error_deg"] for one in said]
    measured(f"first pulse {first:.3f}, later {np.median(later):.4f} / {max(later):.4f} deg")
    assert first < 1.0
    assert max(later) <= 0.04


@pytest.mark.verify
@pytest.mark.parametrize("gains, stiffness", [("best", 850), ("printed", 800)])
def test_making_the_law_anew_gives_no_bump_at_any_of_12_phases(gains, stiffness, measured):
    """The 0.1 s after the rebuilding beside the 0.1 s before it, under a design for 850 N/m."""
    plant = load_drive("dissertation-3", overrides=[f"lumped.cable_stiffness={stiffness}"])
    found = [
        np.degrees(np.abs(one.error[9500:10_500].reshape(2, 500))).max(axis=1)
        for seed in range(12)
        for one in [
            track(DRIVE, controller="darc-indirect", plant_drive=plant, motion=TWO, seed=seed, gains=gains)
        ]
    ]
    before, after = np.transpose(found)
    rise = (after - before).max()
    measured(f"after at most {rise:.4f} deg above before, {np.max(found):.4f} deg in all")
    assert rise < 0.02, f"observed {rise:.4f} deg"


@pytest.mark.verify
def test_law_that_learns_at_the_printed_gains(measured):
    """A hundred draws at 23/25 Hz: 0.036 deg of the encoder's zero is missed by a sixtieth, see the docs."""
    spec = spec_for(DRIVE, TWO)
    said = run_learning_samples(loop_of("darc-indirect", TWO), spec, RigOptions(), 100, SEED + 3).words
    measured(f"{said['draws']} draws: {errors_in(said)}")
    assert said["encoder_error_99_deg"] <= 0.038
    assert said["peak_error_99_deg"] <= 0.050
    assert said["worst_first_pulse_error_deg"] <= 0.10


@pytest.mark.parametrize("best", [True, False], ids=["best gains", "printed gains"])
@pytest.mark.parametrize("draws", [100, WHOLE])
def test_bound_holds_in_a_thousand_of_a_thousand_and_is_within_three(draws, best, measured):
    """How near the worst comes needs the thousand."""
    loop = loop_of("darc-4-damped", Motion(), best=best)
    bound, worst, outside = expected_bound(loop).total, 0.0, 0
    for one in sampled_loops(loop, RigOptions(), draws, SEED + 1):
        error = np.abs(run(one).log[:, 2] - one.target)
        worst, outside = max(worst, float(error.max())), outside + bool(np.any(error > bound))
    words = f"bound {np.degrees(bound.max()):.3f}, worst {np.degrees(worst):.3f} deg"
    measured(f"{words}, {bound.max() / worst:.2f} times; {outside} of {draws} outside")
    assert outside == 0
    assert draws < DRAWS or bound.max() <= 3.0 * worst


@pytest.mark.parametrize("draws", [2, pytest.param(20, marks=pytest.mark.verify)])
def test_law_that_learns_on_the_nonlinear_cable(draws, measured):
    """Twenty draws of the distributed cable: at most 0.05 deg after the first pulse."""
    said = track(
        DRIVE, controller="darc-indirect", gains="best", plant="cable", motion=TWO, draws=draws
    ).summary["over_draws"]
    measured(
        f"after the first pulse {said['median_peak_error_deg']:.4f} / {said['worst_peak_error_deg']:.4f} deg"
    )
    assert said["failed"] == 0
    assert said["worst_peak_error_deg"] <= 0.05
