"""What laws without the cable leave behind: the lines of Figs. 6.6, 6.8 and 6.10."""

import numpy as np
import pytest

from cabledrive.parameters import load_drive
from cabledrive.rig import Motion, RigOptions
from dissertation_runs import track

DRIVE = load_drive("dissertation-3")
DRIVE_SIDE = RigOptions(feedback="drive", forbid_slack=False)


def lines(law, hertz, options, inertia):
    """Strongest line below 20 Hz and above 60 Hz in two seconds of rest [Hz, deg], and the run's summary."""
    run = track(DRIVE, controller=law, bandwidth=hertz, options=options, motion=Motion(dwell=2.0))
    off = np.degrees(run.angles[-10_000:, inertia] - run.reference[-10_000:])
    window = np.hanning(off.size)
    size = 2.0 * np.abs(np.fft.rfft((off - off.mean()) * window, 80_000)) / window.sum()
    frequency = np.fft.rfftfreq(80_000, 1.0 / 5000.0)
    low, high = (np.flatnonzero(part) for part in ((frequency > 2.0) & (frequency < 20.0), frequency > 60.0))
    places = [part[np.argmax(size[part])] for part in (low, high)]
    return *((frequency[i], size[i]) for i in places), run.summary


@pytest.mark.parametrize(
    "law, hertz, options",
    [
        ("darc-1", 3.0, DRIVE_SIDE),
        ("darc-1", 5.0, DRIVE_SIDE),
        ("darc-2", None, RigOptions(forbid_slack=False)),
    ],
)
def test_load_rings_against_the_held_pulley(law, hertz, options, measured):
    """At the zero of the drive, 5.36 Hz, not at its natural frequency of 8.27 Hz; the joint is quiet."""
    ringing, joint, said = lines(law, hertz, options, 2)
    measured(f"{ringing[0]:.2f} Hz of {ringing[1]:.2f} deg; peak error {said['peak_error_deg']:.2f} deg")
    assert 5.0 <= ringing[0] <= 5.5, f"observed {ringing[0]:.2f} Hz"
    assert ringing[1] > 1e4 * joint[1]


@pytest.mark.parametrize(
    "law, hertz, line", [("darc-1", 7.5, 94.6), ("darc-1", 11.0, 94.2), ("darc-3", 11.0, 91.8)]
)
def test_drive_pulleys_encoder_excites_the_joint(law, hertz, line, measured):
    """From about 7 Hz of bandwidth: a cycle of half a degree and more near 92 to 95 Hz."""
    _, joint, said = lines(law, hertz, DRIVE_SIDE, 1)
    words = f"{joint[0]:.1f} Hz of {joint[1]:.2f} deg, {100 * said['saturated_fraction']:.0f} % at the limit"
    measured(f"{words}; peak error of the load {said['peak_error_deg']:.3f} deg")
    assert joint[0] == pytest.approx(line, abs=1.0)
    assert joint[1] > 0.5
