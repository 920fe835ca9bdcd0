"""Peak errors of the laws over many encoder phases and plants: the figures of tests/validation.md."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.parameters import load_drive
from cabledrive.rig import Motion, RigOptions
from rig_runs import track

DRIVE = load_drive("dissertation-3")
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
