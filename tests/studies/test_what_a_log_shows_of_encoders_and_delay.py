"""Encoders coarser than the file's and a delay that it does not name: found in a log, used, and said first.

The logs are of the plants of `true_plants`, which share no code with the study's.
"""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from cabledrive.identification.logs.reading import read_log
from cabledrive.parameters import load_drive
from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study import Goals, run_study
from cabledrive.studies.study.controller_stage import law_of
from cabledrive.studies.study.knowledge_stage import know, known_drive
from cabledrive.studies.study.results_file import results_of
from cabledrive.studies.study.sampled_plants import joined_loop
from true_plants import errors, log_text, truth_of

COARSE = 2000
LATE = 3
"""Samples of 1 ms by which the angles of a log are later than its torque."""


def sheet():
    """A geared drive with 10,000 counts a turn at its load."""
    drive = load_drive("dissertation-3")
    return replace(drive, sensors=replace(drive.sensors, load_encoder=10000, sample_rate=2000.0))


def coarse_machine():
    """The same machine whose load encoder has 2,000."""
    truth = truth_of(sheet())
    return replace(truth, counts=(*truth.counts[:2], 2 * pi / COARSE * truth["gear"]))


def written(path, text):
    path.write_text(text)
    return path


def later(text, rows):
    """A log with its angles so many rows later."""
    head, *lines = text.splitlines()
    cells = [line.split(",") for line in lines]
    moved = [[*now[:2], *before[2:]] for now, before in zip(cells[rows:], cells, strict=False)]
    return "\n".join([head, *(",".join(row) for row in moved)]) + "\n"


def test_a_load_encoder_of_a_fifth_of_the_counts_is_a_finding_and_is_used(tmp_path):
    log = read_log(written(tmp_path / "log.csv", log_text(coarse_machine(), 12.0, 0.8, seed=3)))
    found = know(sheet(), [log], Goals().spreads)
    [finding] = found.findings
    assert (finding.id, finding.decides) == ("load_encoder", True)
    assert finding.value == pytest.approx(2 * pi / COARSE, rel=1e-3)
    assert finding.limit == pytest.approx(1.2 * 2 * pi / 10000)
    assert known_drive(sheet(), found).sensors.load_encoder == COARSE


@pytest.mark.verify
def test_a_load_encoder_of_a_fifth_of_the_counts_ends_no_study_in_yes(tmp_path, measured):
    """Before, the study said yes to what the machine does not do."""
    log = written(tmp_path / "log.csv", log_text(coarse_machine(), 12.0, 0.8, seed=3))
    goals = Goals(angle=30 * DEGREE, duration=0.4, dwell=0.15, draws=500, cable_draws=0)
    found = run_study(sheet(), [log], goals)
    said = results_of(found)
    assert found.verdict.answer == "unknown"
    assert "load encoder of the log has 2000 counts" in said["headline"]
    assert [one["id"] for one in said["findings"] if one["decides"]] == ["load_encoder"]
    assert found.known.sensors.load_encoder == COARSE
    law = law_of(found.laws.chosen, found.known, goals.motion, found.knowledge)
    worst = errors(
        coarse_machine(), joined_loop(found.known, found.known, law, goals.motion, None), 40, seed=5
    )
    reached = found.verdict.reached.error
    measured(f"reached {reached / DEGREE:.3f} deg as said; machine {worst.max() / DEGREE:.3f} deg")
    assert np.mean(worst <= reached) >= 0.95


def test_encoders_as_the_file_has_them_are_no_finding(tmp_path):
    log = read_log(written(tmp_path / "log.csv", log_text(truth_of(sheet()), 12.0, 0.8, seed=3)))
    found = know(sheet(), [log], Goals().spreads)
    assert [one.id for one in found.findings] == []
    assert known_drive(sheet(), found).sensors == sheet().sensors


def test_a_delay_that_a_log_shows_is_a_finding_and_is_designed_for(tmp_path, measured):
    log = read_log(written(tmp_path / "log.csv", later(log_text(truth_of(sheet()), 12.0, 0.8, seed=3), LATE)))
    found = know(sheet(), [log], Goals().spreads)
    [finding] = [one for one in found.findings if one.id == "delay"]
    delay = known_drive(sheet(), found).sensors.delay
    measured(f"{1e3 * delay:.3f} ms designed for, {LATE} ms there")
    assert finding.value > finding.limit
    assert delay == pytest.approx(1e-3 * LATE, abs=2.5e-4)
