"""A run that would not end or not fit into memory is refused at once, with its bound and a remedy."""

from time import monotonic

import pytest

from cabledrive.app.run_limits import MOST_DRAWS, check_run
from cabledrive.parameters import load_drive
from cabledrive.rig import Motion, RigOptions
from command import call, object_of, refusal

DRIVE = "dissertation-3"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--rise", "1e9"], "at most 4 GB are used, 1333 s: shorten rise"),
        (["--pulses", "10000"], "a motion of 2e+04 s takes 1e+08 samples and 60 GB"),
        (["--set", "sensors.sample_rate=10 MHz"], "takes 2e+07 samples"),
        (["--draws", "1000000000"], "draws = 1000000000 are more than the 100000 that this motion allows"),
        (["--plant", "cable", "--segments", "1000000"], "segments = 1000000 are more than the 39"),
        (["--set", "sensors.delay=1e20"], "sensors.delay = 1e+20 s is not below the 2 s of the motion"),
        (["--jitter", "1 ms"], "jitter = 0.001 s is above 0.4 of the sample time"),
        (["--blind", "load:1e300:1e301"], "starts at 1e+300 s, the motion ends at 2 s"),
        (["--disturbance", "load:0.1:3:4"], "disturbance on the load: starts at 3 s, the motion ends at 2 s"),
        (["--angle", "nan"], '"nan" is not a quantity: write a number and a unit'),
    ],
)
def test_a_run_without_end_is_refused_before_it_begins(arguments, words):
    began = monotonic()
    assert words in refusal("track", DRIVE, *arguments)
    assert monotonic() - began < 5.0, "refused after the work"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--duration", "1e9"], "steps of"),
        (["--duration", "1", "--segments", "1000000"], "at most 5e+07 are taken"),
        (["--duration", "5e5", "--rate", "1 MHz", "-o", "run.nc"], "are free in ."),
        (
            ["--duration", "1", "--torque-amplitude", "1", "--torque-frequency", "1e300"],
            "less than two steps",
        ),
        (["--duration", "1", "--torque-amplitude", "1", "--torque-frequency", "-5"], "must not be negative"),
        (
            ["--duration", "1", "--model", "fast", "--torque-amplitude", "1", "--torque-frequency", "1e9"],
            "two",
        ),
        (["--duration", "1 ms", "--rate", "1", "--plot", "run.png"], "16 records that a spectrum needs"),
        (["--duration", "10 ms", "--fields", "1000", "--animate", "run.gif"], "are no two pictures"),
    ],
)
def test_a_run_that_cannot_be_kept_drawn_or_followed_is_refused(arguments, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert words in refusal("simulate", "dissertation-2", *arguments, "--quiet")
    assert list(tmp_path.iterdir()) == []


def test_a_torque_of_no_machine_is_refused():
    assert "is above 1e+24 N m" in refusal("resonance", "dissertation-2", "--torque", "1e300")


def test_a_picture_that_cannot_be_drawn_leaves_the_run_and_says_so(tmp_path, monkeypatch):
    """A slack span ends the run before there are records enough: status 3, the result written and printed."""
    monkeypatch.chdir(tmp_path)
    start = ("simulate", "dissertation-2", "--duration", "0.01", "--torque-amplitude", "1e3")
    done = call(*start, "--torque-frequency", "0", "-o", "run.nc", "--plot", "run.png", "--json")
    assert done.exit_code == 3
    assert (tmp_path / "run.nc").exists()
    assert not (tmp_path / "run.png").exists()
    assert object_of(done.stdout)["slack_events"]
    assert "not drawn: spectrum of" in done.stderr


def test_long_work_stays_possible():
    """Twenty minutes of motion, or as many draws as a day allows, or 1,000 segments."""
    drive, plain = load_drive(DRIVE), RigOptions()
    check_run(drive, Motion(rise=0.5, dwell=0.5, pulses=600), plain)
    check_run(drive, Motion(), plain, draws=MOST_DRAWS)
    check_run(drive, Motion(), RigOptions(segments=1000), cable=True)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('kind = "idinput"\ntrials = 1000000000', "trials = 1000000000 are more than the 1000000"),
        ('kind = "multisine"\nperiod = 1e300', "period = 1e+300 s is above 4571 s at 5000 Hz"),
        ('kind = "steps"\nperiod = 1e-300', "lengthen it to 2 or more"),
        ('kind = "chirp"\nband = [0, 0]', "band: 0 Hz must lie above 0 and below 2500 Hz"),
        ('kind = "chirp"\nband = [3, 3]', "band: both ends are 3 Hz"),
        ("frequencies = [1e300]\namplitudes = [0.1]", "frequencies: 1e+300 Hz must lie above 0 and below"),
    ],
)
def test_an_excitation_that_no_samples_carry_is_refused(line, words, tmp_path):
    (tmp_path / "e.toml").write_text(line + "\n")
    arguments = ("--excitation", tmp_path / "e.toml", "-o", tmp_path / "log.csv")
    assert words in refusal("experiment", DRIVE, *arguments)
    assert [path.name for path in tmp_path.iterdir()] == ["e.toml"]


def test_a_log_beyond_memory_is_refused(tmp_path):
    sampled = ("--set", "sensors.sample_rate=1e20", "-o", tmp_path / "log.csv")
    assert "duration = 70 s at 1e+20 Hz takes 2.45e+15 GB" in refusal("experiment", DRIVE, *sampled)


@pytest.mark.parametrize(
    "arguments", ["experiment x --excitation", "identify log.csv --config", "study x --goals"]
)
def test_an_empty_name_of_a_file_is_no_missing_option(arguments, tmp_path):
    command, first, *option = arguments.split()
    output = [] if command == "identify" else ["-o", tmp_path / "o.csv"]
    first = DRIVE if first == "x" else first
    assert refusal(command, first, *option, "", *output).startswith(".: ")


def test_a_study_of_hours_at_5_khz_is_refused(tmp_path):
    (tmp_path / "goals.toml").write_text("[motion]\npulses = 3000\n")
    arguments = ("--goals", tmp_path / "goals.toml", "-o", tmp_path / "out", "--quiet")
    assert "takes 3e+07 samples and 18 GB" in refusal("study", DRIVE, *arguments)
    assert not (tmp_path / "out").exists()
