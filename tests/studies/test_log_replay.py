"""The identified model replayed over its own log: quiet where it is right, else a finding."""

from dataclasses import replace
from math import pi
from types import SimpleNamespace

import numpy as np
import pytest

from cabledrive.control.observers import Sampling, kalman_filter
from cabledrive.identification.logs.log import ColumnMap
from cabledrive.identification.logs.reading import read_log
from cabledrive.parameters import load_drive
from cabledrive.report.figures.study_runs import intervals_picture
from cabledrive.report.study.results import FOUND_IN_LOG, results_of
from cabledrive.report.study.verdict import _quantities, _sheet
from cabledrive.rig.laws.controllers import plant_chain
from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study import Goals, run_study
from cabledrive.studies.study.goals import SPREADS
from cabledrive.studies.study.knowledge_stage import know, known_drive, usable_log
from cabledrive.studies.study.log_replay import TUNING, innovations
from cabledrive.studies.study.plants import load_case
from study_drives import drive_of, log_with
from true_plants import errors, log_text, truth_of

DRIVE = load_drive("dissertation-3").listed
SHEET = truth_of(DRIVE)
FRICTION = SHEET["c1"]


def logged(folder, truth, seed=1, amplitude=0.8, late=0):
    """A log of twelve seconds of a machine, its angles so many rows later than its torque."""
    head, *lines = log_text(truth, 12.0, amplitude, seed).splitlines()
    cells = [line.split(",") for line in lines]
    rows = [[*now[:2], *before[2:]] for now, before in zip(cells[late:], cells, strict=False)]
    (folder / "log.csv").write_text("\n".join([head, *(",".join(row) for row in rows)]) + "\n")
    return folder / "log.csv"


def known(truth, folder, drive=DRIVE, **options):
    """What a study knows of a machine by its data sheet and a log."""
    log = usable_log(read_log(logged(folder, truth, **options), ColumnMap()))
    return know(drive, [log], SPREADS)


@pytest.mark.kernel
def test_innovations_are_readings_less_their_predictions():
    """The compiled `cabledrive.studies.study.log_replay` against the filter's own equations."""
    chain, h, generator = plant_chain(DRIVE, 4), 1e-3, np.random.default_rng(3)
    probe = kalman_filter(
        chain,
        [(0, 2e-3), (1, 6e-4), (2, 6e-4)],
        Sampling(interval=h),
        chosen=range(3),
        tuning=TUNING,
        settled=True,
    )
    torque, readings = generator.normal(size=60), 1e-3 * generator.normal(size=(60, 3)).cumsum(axis=0)
    size = probe.model.shape[0]
    mean = np.append(0.5 * (torque[1:] + torque[:-1]), torque[-1])
    state, held, expected = np.zeros(size), 0.0, []
    for u, y in zip(mean, readings, strict=True):
        expected.append(y - probe.output @ state)
        state = state + probe.gains[-1] @ expected[-1]
        rub = probe.scalars[7] - probe.scalars[5] * np.tanh(probe.scalars[6] * state[probe.places[0]])
        state = probe.model @ [*state, held, u, u, rub]
        held = probe.scalars[2] * held + (probe.scalars[3] + probe.scalars[4]) * u
    np.testing.assert_allclose(innovations(probe, torque, readings), np.array(expected)[6:], rtol=1e-9)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_machine_as_the_sheet_has_it_gives_no_finding(seed, tmp_path, measured):
    found = known(SHEET, tmp_path, seed=seed)
    measured(f"power {found.replays[0].ratio:.2f} times the model's, {found.replays[0].limit:.2f} allowed")
    assert found.findings == ()
    for name, key in (("near_inertia", None), ("load_inertia", "j3"), ("joint_stiffness", "km")):
        true = SHEET["j1"] + SHEET["j2"] if key is None else SHEET[key]
        assert found.quantities[name].low <= true <= found.quantities[name].high, name


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"eccentric": 2e-3}, "load angle"),
        ({"ripple": 0.3, "ripple_lines": 24.0}, "times the power"),
        ({"hardening": 30.0}, "times the power"),
        ({"km": 48.0}, "joint: 4"),
        ({"c1": 1.6 * FRICTION}, "Coulomb friction: 0.06"),
        ({"c3": 0.5 * FRICTION}, "load pulley: 0.018"),
    ],
)
def test_what_the_sheet_lacks_is_a_finding(changes, words, tmp_path, measured):
    found = known(SHEET.but(**changes), tmp_path)
    measured(f"{changes}: {found.findings}")
    assert any(words in finding.words for finding in found.findings), found.findings


@pytest.mark.parametrize(("name", "lines", "share"), [("dissertation-3", 9, 0.2), ("turntable", 12, 0.4)])
def test_cogging_is_identified_and_spoils_no_other_number(name, lines, share, tmp_path, measured):
    """Left in, it made four times the motor's inertia on the turntable, and the verdict unknown."""
    drive = drive_of(name) if name == "turntable" else DRIVE
    truth = truth_of(drive)
    truth = truth.but(cogging=share * truth["c1"], cogging_lines=float(lines))
    found = known(truth, tmp_path, drive, seed=5, amplitude=0.6)
    size, near = found.quantities["ripple_torque"], found.quantities["near_inertia"]
    measured(
        f"{size.value:.5f} N m for {truth['cogging']:.5f}, {found.quantities['ripple_order'].value:g} lines"
    )
    assert found.findings == ()
    assert found.quantities["ripple_order"].value == lines
    assert size.value == pytest.approx(truth["cogging"], rel=0.1)
    assert size.low <= truth["cogging"] <= size.high
    study = SimpleNamespace(drive=drive, goals=Goals(), knowledge=found, carried=False)
    assert "Periods of the ripple" in str(_quantities(study))  # which no data sheet has
    assert intervals_picture("intervals", found.quantities, _sheet(study))
    assert near.low <= truth["j1"] + truth["j2"] <= near.high


def test_friction_of_the_load_and_backlash_are_identified(tmp_path, measured):
    """A load that rubs with 5 mN m; a tenth of a degree of backlash, within a quarter of it."""
    truth = SHEET.but(c3=0.005, gap=np.radians(0.2))
    found = known(truth, tmp_path).quantities
    load, play = found["load_coulomb_friction"], found["backlash"]
    measured(f"load {load.value:.5f} N m, backlash {np.degrees(play.value):.3f} deg")
    assert load.source == play.source == "log"
    assert load.low <= 0.005 <= load.high, load
    assert load.high - load.low < 0.001
    assert play.low <= np.radians(0.2) <= play.high, play


def test_the_angle_of_a_load_behind_a_gear_is_compared_at_the_motor():
    """A turntable of 1 to 3: its own log is replayed without a finding."""
    drive = drive_of("turntable")
    found = know(drive, [log_with(("torque", "angle", "load_angle"))], SPREADS)
    assert found.replays[0].ratio < found.replays[0].limit


# --- Encoders and delay that a log shows
COARSE = 2000
LATE = 3
"""Samples of 1 ms by which the angles of a log are later than its torque."""


def sheet():
    """A geared drive with 10,000 counts a turn at its load."""
    drive = load_drive("dissertation-3").listed
    return replace(drive, sensors=replace(drive.sensors, load_encoder=10000, sample_rate=2000.0))


def coarse_machine():
    """The same machine whose load encoder has 2,000."""
    truth = truth_of(sheet())
    return replace(truth, counts=(*truth.counts[:2], 2 * pi / COARSE * truth["gear"]))


def known_of(folder, truth, late=0):
    """What the data sheet and a log of the machine say together, and the sensors that this gives."""
    found = known(truth, folder, sheet(), seed=3, late=late)
    return found, known_drive(sheet(), found).sensors


def test_a_load_encoder_of_a_fifth_of_the_counts_is_a_finding_and_is_used(tmp_path):
    found, sensors = known_of(tmp_path, coarse_machine())
    [finding] = found.findings
    assert (finding.id, finding.decides) == ("load_encoder", True)
    assert finding.value == pytest.approx(2 * pi / COARSE, rel=1e-3)
    assert finding.limit == pytest.approx(1.2 * 2 * pi / 10000)
    assert sensors.load_encoder == COARSE
    assert FOUND_IN_LOG(finding)["message"] == finding.words  # as `results.json` has it


@pytest.mark.verify
def test_a_load_encoder_of_a_fifth_of_the_counts_ends_no_study_in_yes(tmp_path, measured):
    """Before, the study said yes to what the machine does not do."""
    log = logged(tmp_path, coarse_machine(), seed=3)
    goals = Goals(angle=30 * DEGREE, duration=0.4, dwell=0.15, draws=500, cable_draws=0)
    found = run_study(sheet(), [log], goals)
    said = results_of(found)
    assert found.verdict.answer == "unknown"
    assert "load encoder of the log has 2000 counts" in said["headline"]
    assert [one["id"] for one in said["findings"] if one["decides"]] == ["load_encoder"]
    assert found.known.sensors.load_encoder == COARSE
    case = load_case(found.known, goals, found.knowledge)
    worst = errors(coarse_machine(), case.loop(case.law(found.laws.chosen)), 40, seed=5)
    reached = found.verdict.reached.error
    measured(f"reached {reached / DEGREE:.3f} deg as said; machine {worst.max() / DEGREE:.3f} deg")
    assert np.mean(worst <= reached) >= 0.95


def test_a_delay_that_a_log_shows_is_a_finding_and_is_designed_for(tmp_path, measured):
    found, sensors = known_of(tmp_path, truth_of(sheet()), LATE)
    [finding] = [one for one in found.findings if one.id == "delay"]
    measured(f"{1e3 * sensors.delay:.3f} ms designed for, {LATE} ms there")
    assert finding.value > finding.limit
    assert sensors.delay == pytest.approx(1e-3 * LATE, abs=2.5e-4)
