"""The laws on the distributed cable beside its lumped chain: figures of tests/validation.md."""

import numpy as np
import pytest

from cabledrive.parameters import load_drive
from cabledrive.rig import Motion, RigOptions
from dissertation_runs import track

pytestmark = pytest.mark.verify

DRIVE = load_drive("dissertation-3")
DRIVE_SIDE = RigOptions(feedback="drive")
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
