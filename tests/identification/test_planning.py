"""The intervals that a test will give are computed before it is run."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.identification.planned_response import resonance_warnings
from cabledrive.identification.planning import largest_amplitude, plan_test
from cabledrive.identification.predicted_errors import AxisGuess, Instruments
from cabledrive.identification.rigid_axis import AxisOptions, identify_rigid_axis
from cabledrive.parameters import InputRefused, load_drive
from cabledrive.rig.bench.chapter_4 import BENCH_TESTS, TORQUE_PER_VOLT, bench_command, bench_rig, rig_of
from cabledrive.rig.bench.experiment import Excitation, command_of, experiment, load_excitation
from cabledrive.rig.bench.planned_experiment import plan_experiment
from cabledrive.rig.bench.virtual_rig import Imperfections, run_rig

TEST = replace(BENCH_TESTS[1], duration=12.0)
GUESS = AxisGuess(inertia=TEST.inertia, viscous=TEST.viscous, coulomb=TEST.coulomb, offset=TEST.offset)
TORQUE = TORQUE_PER_VOLT * bench_command(TEST, np.random.default_rng(1))


def spread(test, noise, repeats):
    """Standard deviation of the estimates over repeats of one test, and the prediction."""
    command = bench_command(test, np.random.default_rng(1))
    found = []
    for seed in range(repeats):
        rig = bench_rig(test, Imperfections(torque_noise=noise))
        log = run_rig(rig, command, np.random.default_rng(seed))
        one = identify_rigid_axis([log], AxisOptions(bandwidth=20.0, lag=False))
        found.append([one[name] for name in one.parameters])
    guess = AxisGuess(inertia=test.inertia, viscous=test.viscous, coulomb=test.coulomb, offset=test.offset)
    plan = plan_test(TORQUE_PER_VOLT * command, 1e-3, guess, Instruments(torque_noise=noise, bandwidth=20.0))
    return np.std(found, axis=0, ddof=1) / np.array(list(plan.standard_errors.values()))


@pytest.mark.parametrize("test", BENCH_TESTS, ids=lambda test: test.name)
def test_predicted_standard_errors_are_the_spread_of_repeated_tests(test):
    """16 repeats give a standard deviation to 18 %: three of that."""
    ratios = spread(replace(test, duration=12.0), 0.05, 16)
    assert (np.abs(ratios - 1.0) < 0.54).all(), ratios


@pytest.mark.verify
@pytest.mark.parametrize("test", BENCH_TESTS, ids=lambda test: test.name)
def test_predicted_standard_errors_of_every_bench_test(test, measured):
    """100 repeats of 30 s, torque noise 50 mN m: within a quarter."""
    ratios = spread(replace(test, duration=30.0), 0.05, 100)
    measured("spread over prediction, J, b, c, d: " + ", ".join(f"{ratio:.2f}" for ratio in ratios))
    assert (np.abs(ratios - 1.0) < 0.25).all(), ratios


def test_limits_are_kept_by_the_largest_amplitude_and_named_when_passed():
    limits = {"torque": 0.6, "speed": 25.0, "stroke": 6.0}
    scale = largest_amplitude(TORQUE, 1e-3, GUESS, limits)
    peaks = plan_test(scale * TORQUE, 1e-3, GUESS, limits=limits).peaks
    shares = [peaks[name] / limit for name, limit in limits.items()]
    assert max(shares) == pytest.approx(1.0, rel=1e-3), shares
    passed = plan_test(1.2 * scale * TORQUE, 1e-3, GUESS, limits=limits).findings
    assert any("above its limit" in finding for finding in passed), passed


def test_a_line_on_the_pulley_mode_of_a_tuned_drive_is_warned_of_above_its_threshold_only(measured):
    """Configuration 2 near its tuned pretension: 0.9 mN m at 81.74 Hz is the threshold."""
    settings = ("cable.pretension=3.3", "cable.transverse_damping=1.0", "pulley.1.viscous_friction=1e-5")
    drive, time = load_drive("dissertation-2", overrides=settings), np.arange(8000) / 1000.0

    def warned(frequency, amplitude):
        return resonance_warnings(drive, amplitude * np.sin(2 * np.pi * frequency * time), 1000.0)

    measured("; ".join(warned(81.74, 2e-3)) + f"; {len(warned(81.74, 4e-4))} warnings of 0.4 mN m")
    assert "would drive the 1:2 resonance" in warned(81.74, 2e-3)[0]
    assert warned(81.74, 4e-4) == ()
    assert warned(40.0, 0.05) == ()


def test_the_door_plans_an_experiment_without_running_it(tmp_path, capsys):
    """Model 4 under a multisine: stiffness of the joint to a few per cent; nothing is written."""
    import json

    from cabledrive.app.main import main

    toml = 'kind = "multisine"\nduration = "8 s"\namplitude = "1 V"\nband = ["1 Hz", "250 Hz"]\nlines = 120\n'
    (tmp_path / "e.toml").write_text(toml + 'period = "1 s"\nodd = false\n')
    with pytest.raises(SystemExit) as end:
        main(["experiment", "dissertation-3", "--excitation", str(tmp_path / "e.toml"), "--plan", "--json"])
    answer = json.loads(capsys.readouterr().out)
    assert not end.value.code
    assert 0.0 < answer["relative_standard_error"]["joint_stiffness"] < 0.05
    assert set(answer["peaks"]) == {"torque", "speed", "stroke"}
    assert [path.name for path in tmp_path.iterdir()] == ["e.toml"]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("frequencies = 3", "is no list"),
        ('band = ["1 Hz"]', "band holds 1 frequencies"),
        ('lines = "all"', "must be a whole number"),
        ("trials = 0", "at least 1"),
        ("odd = 3", "neither true nor false"),
        ("kind = 3", 'excitation "3" is unknown'),
        ("period = 0", "must be above 0"),
        ("amplitude = true", "is no quantity"),
        ("frequencies = []\namplitudes = []", "frequencies holds none"),
    ],
)
def test_an_excitation_with_a_value_of_another_kind_is_refused(tmp_path, line, words):
    (tmp_path / "e.toml").write_text(line + "\n")
    with pytest.raises(InputRefused, match=words):
        load_excitation(tmp_path / "e.toml")


def without(**sensors):
    drive = load_drive("dissertation-3")
    return replace(drive, sensors=replace(drive.sensors, **sensors))


SHORT = Excitation(duration=2.0)
BLIND = {"motor_encoder": None, "drive_encoder": None, "load_encoder": None}


@pytest.mark.parametrize(
    ("planned", "words"),
    [
        (lambda: plan_test(0.05 * TORQUE, 1e-3, GUESS), "does not move the axis"),
        (lambda: plan_experiment(without(motor_encoder=None), SHORT), r"sensors\.motor_encoder is missing"),
        (lambda: experiment(without(), SHORT, seed=-1), "seed = -1 must not be negative"),
        (lambda: rig_of(without(**BLIND), 1), "no encoder on motor"),
        (lambda: rig_of(without(sample_rate=None), 1), r"sensors\.sample_rate is missing"),
        (
            lambda: command_of(replace(SHORT, kind="multisine", period=1e-6), 1e3, np.random.default_rng(0)),
            "holds 0 samples",
        ),
        (lambda: plan_experiment(without(), SHORT, model=1, stroke=0.0), "stroke = 0"),
    ],
)
def test_what_cannot_be_planned_is_refused(planned, words):
    with pytest.raises(InputRefused, match=words):
        planned()
