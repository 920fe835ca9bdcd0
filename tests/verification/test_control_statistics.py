"""Peak errors of the laws over many encoder phases and plants: the figures of docs/validation.md."""

import numpy as np
import pytest

from cabledrive.parameters import load_drive
from cabledrive.rig import Motion, RigOptions, track

pytestmark = pytest.mark.verify

DRIVE = load_drive("dissertation-3")
CENTRED = RigOptions(encoder_phase="centred")


def peaks(law, key="peak_error_deg", **choices):
    said = [track(DRIVE, controller=law, seed=seed, **choices).summary for seed in range(32)]
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
    ],
)
def test_peak_errors_over_32_encoder_phases(law, choices, median, worst, measured):
    found = peaks(law, **choices)
    measured(f"median {np.median(found):.4f}, worst {found.max():.4f} deg")
    assert np.median(found) <= median, f"observed {np.median(found):.4f} deg"
    assert found.max() <= worst, f"observed {found.max():.4f} deg"


def test_later_pulses_of_the_law_that_learns(measured):
    found = peaks("darc-indirect", "later_pulses_error_deg", motion=Motion(pulses=3))
    measured(f"median {np.median(found):.4f}, worst {found.max():.4f} deg")
    assert np.median(found) <= 0.03, f"observed {np.median(found):.4f} deg"
    assert found.max() <= 0.045, f"observed {found.max():.4f} deg"


def test_backstepping_over_200_draws(measured):
    worst = track(DRIVE, controller="backstepping", draws=200).summary["over_draws"]["worst_peak_error_deg"]
    measured(f"worst {worst:.4f} deg")
    assert worst <= 0.35, f"observed {worst:.4f} deg"


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
