"""The law that learns, the bound, the baselines over many draws; a seeded tenth of some in `make test`."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import binom

from cabledrive.parameters import load_drive
from cabledrive.rig import Motion, RigOptions
from cabledrive.rig.closed_loop.loop import run, with_plant
from cabledrive.rig.laws.load_learning import run_indirect
from cabledrive.rig.margins import expected_bound
from cabledrive.rig.plant_samples import sampled_chain, sampled_loops
from rig_runs import loop_of, track

DRIVE = load_drive("dissertation-3").listed
TWO = Motion(pulses=2)
DRAWS, SEED = 1000, 2027
WHOLE = pytest.param(DRAWS, marks=pytest.mark.verify)
RARE = 1e-3
INTERVALS = ("beta", "gamma", "inertia", "viscous", "coulomb", "offset", "load_coulomb", "load_viscous")


def peaks_of(loop, log):
    """True error in the first pulse and after, and after against the encoder's own zero [deg]."""
    error, pause = loop.load_error(log), loop.rig.first_end
    own = error + loop.rig.counts[-1] * loop.rig.phases[-1] / loop.gear
    return [np.degrees(np.abs(one).max()) for one in (error[:pause], error[pause:], own[pause:])]


def learnt_of(loop, found):
    """Relative error of beta, use, and whether each interval of `INTERVALS` holds the true value."""
    chain, load, (low, high) = loop.chain, found.load.intervals.T, found.motor.intervals
    beta, gamma, coulomb, viscous = (
        one[-1] / chain.inertias[-1] for one in (chain.stiffness, chain.damping, chain.coulomb, chain.viscous)
    )
    true = [sum(chain.inertias), sum(chain.viscous), sum(chain.coulomb), chain.offsets[0]]
    pairs = [(beta, load[0]), (gamma, load[1])]
    pairs += [(value, ends) for value, *ends in zip(true, low, high, strict=True)]
    pairs += [(coulomb, load[2]), (viscous, load[3])]
    return [
        found.load.values[0] / beta - 1.0,
        found.excited,
        *(low <= value <= high for value, (low, high) in pairs),
    ]


def rubbing_loops(loop, draws, seed):
    """Plants as drawn, with up to 0.02 N m of Coulomb friction at the load."""
    for generator in np.random.default_rng(seed).spawn(draws):
        chain = sampled_chain(loop.chain, generator)
        friction = (*chain.coulomb[:-1], chain.coulomb[-1] + 0.02 * generator.random())
        rig = loop.rig._replace(phases=generator.uniform(-0.5, 0.5, len(loop.rig.phases)))
        yield replace(with_plant(loop, replace(chain, coulomb=friction)), rig=rig)


@cache
def learning(draws=DRAWS, rubbing=False, best=True, seed=SEED):
    """Peaks and the twist that friction holds at rest, (draws, 4) [deg]; what was learnt, (draws, 10)."""
    loop = loop_of("darc-indirect", DRIVE, TWO, best=best)
    rows = []
    for one in rubbing_loops(loop, draws, seed) if rubbing else sampled_loops(loop, draws, seed):
        _, done, found = run_indirect(one)
        assert found is not None
        assert not done.failed
        held = float(np.degrees(one.chain.coulomb[-1] / one.chain.stiffness[-1]))
        rows.append(([*peaks_of(one, done.log), held], learnt_of(one, found)))
    return tuple(np.array(part, dtype=float) for part in zip(*rows, strict=True))


def errors_in(peaks) -> str:
    """After the first pulse against the encoder's own zero and true, then in the first pulse [deg]."""
    first, true, own = (
        f"{np.quantile(one, 0.99):.4f} (99 %), median {np.median(one):.4f}, worst {one.max():.4f}"
        for one in peaks[:, :3].T
    )
    return f"own zero {own}; true {true}; first pulse {first} deg"


@pytest.mark.parametrize("draws", [10, WHOLE])
def test_law_that_learns_keeps_within_its_encoders_count(draws, measured):
    """99 of 100 draws within 0.036 deg of the encoder's zero, 0.050 deg true; first pulse 0.10 deg."""
    peaks, _ = learning(draws)
    measured(f"{draws} draws: {errors_in(peaks)}")
    beyond = np.count_nonzero(peaks[:, 1:3] > [0.050, 0.036], axis=0)
    assert max(beyond) <= (0.01 * DRAWS if draws == DRAWS else binom.isf(RARE, draws, 0.01)), beyond
    assert peaks[:, 0].max() <= 0.10


@pytest.mark.verify
def test_friction_of_the_load_stays_in_the_error_and_out_of_beta(measured):
    """Up to 0.02 N m as well, which no law here compensates: its static twist, and what is left without."""
    peaks, learnt = learning(rubbing=True)
    unused = np.count_nonzero(learnt[:, 1] == 0.0)
    beyond = float((peaks[:, 1] - peaks[:, 3]).max())
    measured(f"{len(peaks)} draws, {unused} not used: {errors_in(peaks)}; {beyond:.4f} deg beyond the twist")
    assert unused <= 0.01 * DRAWS
    assert beyond <= 0.05


@pytest.mark.parametrize(
    "rubbing", [False, True], ids=["load without friction", "up to 0.02 N m at the load"]
)
@pytest.mark.parametrize("draws", [10, WHOLE])
def test_beta_after_one_pulse_and_the_coverage_of_its_interval(draws, rubbing, measured):
    """Of ten draws the lower end only: as many hold as 93 % leave but once in 1,000."""
    _, learnt = learning(draws, rubbing)
    covered, worst = learnt[:, 2:].sum(axis=0), np.abs(learnt[:, 0]).max()
    held = dict(zip(INTERVALS, covered / draws, strict=True))
    shares = ", ".join(f"{name} {100 * share:.1f}" for name, share in held.items())
    measured(f"beta {100 * worst:.3f} % at most; intervals hold {shares} %")
    assert worst <= 2e-3
    if draws < DRAWS:
        assert min(covered) >= binom.ppf(RARE, draws, 0.93), covered
        return
    slack = 2.0 * np.sqrt(0.95 * 0.05 / DRAWS)  # two standard errors
    for name, share in held.items():
        highest = 0.99 if name == "beta" and not rubbing else 0.97 + slack
        assert 0.93 - slack <= share <= highest, f"observed {share:.3f} of {name}"


@pytest.mark.verify
@pytest.mark.parametrize("gains", ["printed", "best"])
def test_cable_of_438_under_a_design_for_850(gains, measured):
    soft = load_drive("dissertation-3", overrides=["lumped.cable_stiffness=438"]).listed
    said = [
        track(DRIVE, controller="darc-indirect", plant_drive=soft, motion=TWO, seed=seed, gains=gains).summary
        for seed in range(32)
    ]
    first = max(one["first_pulse_error_deg"] for one in said)
    later = [one["later_pulses_error_deg"] for one in said]
    measured(f"first pulse {first:.3f}, later {np.median(later):.4f} / {max(later):.4f} deg")
    assert first < 1.0
    assert np.median(later) <= 0.04
    assert max(later) <= 0.05


@pytest.mark.parametrize(
    "gains, stiffness, phases",
    [
        ("printed", 800, (0, 4)),
        pytest.param("printed", 800, range(12), marks=pytest.mark.verify),
        pytest.param("best", 850, range(12), marks=pytest.mark.verify),
    ],
)
def test_making_the_law_anew_gives_no_bump_at_any_phase(gains, stiffness, phases, measured):
    """The 0.1 s after the rebuilding beside the 0.1 s before it, under a design for 850 N/m."""
    plant = load_drive("dissertation-3", overrides=[f"lumped.cable_stiffness={stiffness}"]).listed
    law = {"controller": "darc-indirect", "plant_drive": plant, "motion": TWO, "gains": gains}
    errors = np.degrees([np.abs(track(DRIVE, seed=seed, **law).error) for seed in phases])
    before, after = errors[:, 9500:10_500].reshape(-1, 2, 500).max(axis=2).T
    rise = (after - before).max()
    measured(f"after at most {rise:.4f} deg above before, {max(before.max(), after.max()):.4f} deg in all")
    assert rise < 0.02, f"observed {rise:.4f} deg"


@pytest.mark.verify
def test_law_that_learns_at_the_printed_gains(measured):
    """A hundred draws at 23/25 Hz: 0.036 deg of the encoder's zero is missed by a sixtieth, see the docs."""
    peaks, _ = learning(100, best=False, seed=SEED + 3)
    measured(f"{len(peaks)} draws: {errors_in(peaks)}")
    assert np.all(np.quantile(peaks, 0.99, axis=0)[1:3] <= [0.050, 0.038])
    assert peaks[:, 0].max() <= 0.10


@pytest.mark.parametrize("best", [True, False], ids=["best gains", "printed gains"])
@pytest.mark.parametrize("draws", [100, WHOLE])
def test_bound_holds_in_a_thousand_of_a_thousand_and_is_within_three(draws, best, measured):
    """How near the worst comes needs the thousand."""
    loop = loop_of("darc-4-damped", DRIVE, Motion(), best=best)
    bound, worst, outside = expected_bound(loop).total, 0.0, 0
    for one in sampled_loops(loop, draws, SEED + 1):
        error = np.abs(run(one).log[:, 2] - one.target)
        worst, outside = max(worst, float(error.max())), outside + bool(np.any(error > bound))
    words = f"bound {np.degrees(bound.max()):.3f}, worst {np.degrees(worst):.3f} deg"
    measured(f"{words}, {bound.max() / worst:.2f} times; {outside} of {draws} outside")
    assert outside == 0
    assert bound.max() <= (3.0 if draws == DRAWS else 5.0) * worst


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


# --- Peak errors of the laws over many encoder phases and plants: the figures of tests/validation.md
CENTRED, DRIVE_SIDE = RigOptions(encoder_phase="centred"), RigOptions(feedback="drive")


def peaks(law, key="peak_error_deg", phases=32, **choices):
    said = [track(DRIVE, controller=law, seed=seed, **choices).summary for seed in range(phases)]
    assert all(one["estimates_within_bounds"] for one in said)
    assert all(one["peak_torque"] <= 2.1 for one in said)
    return np.array([one[key] for one in said])


@pytest.mark.parametrize(
    "law, choices, median, worst",
    [
        ("darc-3", {}, 0.13, 0.19),
        ("darc-4", {}, 0.085, 0.12),
        ("backstepping", {}, 0.20, 0.30),
        ("darc-4-damped", {}, 0.025, 0.041),
        ("darc-4-damped", {"gains": "best"}, 0.023, 0.041),
        ("backstepping-6", {}, 0.044, 0.08),
    ],
)
@pytest.mark.parametrize("phases", [3, pytest.param(32, marks=pytest.mark.verify)])
def test_peak_errors_over_32_encoder_phases(law, choices, median, worst, phases, measured):
    """Of three phases the worst only; a median of 32 says nothing of three."""
    found = peaks(law, phases=phases, **choices)
    measured(f"median {np.median(found):.4f}, worst {found.max():.4f} deg")
    assert phases < 32 or np.median(found) <= median, f"observed {np.median(found):.4f} deg"
    assert found.max() <= worst, f"observed {found.max():.4f} deg"


@pytest.mark.verify
@pytest.mark.parametrize("law, hertz", [("darc-1", 3.0), ("darc-1", 5.0), ("darc-1", 11.0), ("darc-2", 22.0)])
def test_laws_without_the_cable_leave_two_to_three_degrees(law, hertz, measured):
    options = DRIVE_SIDE if law == "darc-1" else RigOptions()
    found = peaks(law, bandwidth=hertz, options=options)
    measured(f"median {np.median(found):.2f}, worst {found.max():.2f} deg")
    assert 2.0 < np.median(found) <= found.max() < 3.3


@pytest.mark.verify
def test_model_3_on_the_drive_pulleys_encoder_cycles_at_every_phase(measured):
    found = peaks("darc-3", options=DRIVE_SIDE)
    share = peaks("darc-3", "saturated_fraction", options=DRIVE_SIDE)
    words = f"median {np.median(found):.3f}, worst {found.max():.3f} deg"
    measured(f"{words}; {100 * np.median(share):.0f} % of the samples at the limit")
    assert share.min() > 0.4
    assert found.min() > 0.25


@pytest.mark.verify
def test_one_degree_of_backlash_over_16_phases(measured):
    loose = replace(DRIVE, motor=replace(DRIVE.motor, backlash=np.radians(1.0)))
    plain, played = (
        [
            track(DRIVE, controller="darc-4-damped", plant_drive=plant, seed=seed).summary["peak_error_deg"]
            for seed in range(16)
        ]
        for plant in (DRIVE, loose)
    )
    beside = f"beside {np.median(plain):.3f} / {max(plain):.3f} deg"
    measured(f"{np.median(played):.3f} / {max(played):.3f} deg {beside}")
    assert 2.0 * np.median(plain) < np.median(played)
    assert max(played) < 1.0


@pytest.mark.verify
def test_backstepping_over_200_draws(measured):
    worst = track(DRIVE, controller="backstepping", draws=200).summary["over_draws"]["worst_peak_error_deg"]
    measured(f"worst {worst:.4f} deg")
    assert worst <= 0.35, f"observed {worst:.4f} deg"


@pytest.mark.verify
def test_centred_phases(measured):
    """At 26 Hz the printed Model 4 misses 0.055 deg, see the docs; that is noted, not judged."""

    def centred(law, hertz=None):
        return track(DRIVE, controller=law, bandwidth=hertz, options=CENTRED).summary["peak_error_deg"]

    damped, printed = centred("darc-4-damped"), centred("darc-4", 28.0)
    measured(
        f"darc-4-damped {damped:.4f}, darc-4 {printed:.4f} at 28 Hz, {centred('darc-4', 26.0):.4f} at 26 Hz"
    )
    measured(f"backstepping {centred('backstepping'):.4f} deg")
    assert damped <= 0.007, f"observed {damped:.4f} deg"
    assert printed <= 0.055, f"observed {printed:.4f} deg"


# --- The laws on the distributed cable beside its lumped chain
LAWS = [
    ("darc-1", {"bandwidth": 3.0, "options": DRIVE_SIDE}),
    ("darc-1", {"bandwidth": 5.0, "options": DRIVE_SIDE}),
    ("darc-1", {"bandwidth": 11.0, "options": DRIVE_SIDE}),
    ("darc-2", {}),
    ("darc-3", {}),
    ("darc-4", {}),
    ("backstepping", {}),
    ("darc-4-damped", {}),
    ("darc-4-damped", {"gains": "best"}),
]


@pytest.mark.verify
@pytest.mark.parametrize("law, choices", LAWS)
def test_errors_on_the_cable_are_within_20_percent_of_those_on_its_row(law, choices, measured):
    """Median and worst over 16 encoder phases; the cable's own modes stay below 0.002 deg."""
    peaks = {}
    for plant in ("model-4", "cable"):
        said = [track(DRIVE, controller=law, plant=plant, seed=s, **choices) for s in range(16)]
        assert all(one.incomplete is None for one in said)
        peaks[plant] = np.array([one.summary["peak_error_deg"] for one in said])
    spillover = max(one.summary["cable"]["spillover_deg"] for one in said)
    ratios = {
        name: float(score(peaks["cable"]) / score(peaks["model-4"]))
        for name, score in (("median", np.median), ("worst", np.max))
    }
    median, worst = (100.0 * (ratio - 1.0) for ratio in ratios.values())
    words = f"median {median:+.1f} %, worst {worst:+.1f} % of the row's; spillover {spillover:.1e} deg"
    measured(f"{words}, transverse to pulley mode {said[0].summary['cable']['frequency_ratio']:.1f}")
    assert spillover < 2e-3
    assert all(one.summary["cable"]["one_to_two"] == "far from it" for one in said)
    for name, ratio in ratios.items():
        assert abs(ratio - 1.0) <= 0.2, f"observed {name} {ratio:.3f} times that of the row"


@pytest.mark.verify
def test_twenty_draws_of_ten_seconds_on_the_cable(measured):
    over = {
        plant: track(DRIVE, controller="darc-4", plant=plant, motion=Motion(pulses=5), draws=20).summary[
            "over_draws"
        ]
        for plant in ("model-4", "cable")
    }
    ratio = over["cable"]["worst_peak_error_deg"] / over["model-4"]["worst_peak_error_deg"]
    measured(f"worst {100.0 * (ratio - 1.0):+.1f} % of the row's, {over['cable']['failed']} failed")
    assert over["cable"]["failed"] == 0
    assert abs(ratio - 1.0) <= 0.2, f"observed {ratio:.3f}"
