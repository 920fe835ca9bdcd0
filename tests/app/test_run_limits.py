"""A run that would not end or not fit into memory is refused at once, with its bound and a remedy."""

from time import monotonic

import pytest

from cabledrive.app.run_limits import MOST_DRAWS, check_run
from cabledrive.parameters import load_drive
from cabledrive.rig import Motion, RigOptions
from command import refusal

DRIVE = "dissertation-3"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--rise", "1e9"], "at most 4 GB are used, 1333 s: shorten rise"),
        (["--pulses", "10000"], "a motion of 2e+04 s has 1e+08 samples, whose record takes 60 GB"),
        (["--set", "sensors.sample_rate=10 MHz"], "has 2e+07 samples"),
        (["--draws", "1000000000"], "draws = 1000000000 are more than the 100000 that this motion allows"),
        (["--plant", "cable", "--segments", "1000000"], "segments = 1000000 are more than the 39"),
        (["--set", "sensors.delay=1e20"], "sensors.delay = 1e+20 s is not below the 2 s of the motion"),
        (["--jitter", "1 ms"], "jitter = 0.001 s is above 0.4 of the sample time"),
        (["--blind", "load:1e300:1e301"], "blind load encoder: starts at 1e+300 s, the motion ends at 2 s"),
        (["--disturbance", "load:0.1:3:4"], "disturbance on the load: starts at 3 s, the motion ends at 2 s"),
        (["--angle", "nan"], "angle = nan deg must be finite"),
    ],
)
def test_a_run_without_end_is_refused_before_it_begins(arguments, words):
    began = monotonic()
    assert words in refusal("track", DRIVE, *arguments)
    assert monotonic() - began < 5.0, "refused after the work"


def test_long_work_stays_possible():
    """Twenty minutes of motion, or as many draws as a day allows, or 1,000 segments."""
    drive, plain = load_drive(DRIVE), RigOptions()
    check_run(drive, Motion(rise=0.5, dwell=0.5, pulses=600), plain)
    check_run(drive, Motion(), plain, draws=MOST_DRAWS)
    check_run(drive, Motion(), RigOptions(segments=1000), cable=True)


def test_a_study_of_hours_at_5_khz_is_refused(tmp_path):
    (tmp_path / "goals.toml").write_text("[motion]\npulses = 3000\n")
    arguments = ("--goals", tmp_path / "goals.toml", "-o", tmp_path / "out", "--quiet")
    assert "has 3e+07 samples, whose record takes 18 GB" in refusal("study", DRIVE, *arguments)
    assert not (tmp_path / "out").exists()
