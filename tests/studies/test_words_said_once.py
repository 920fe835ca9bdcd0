"""What a verdict gives as its reason is not repeated under the notes."""

from dataclasses import replace

import pytest

from cabledrive.parameters import load_drive
from cabledrive.report.study.mechanics import modes_chapter
from cabledrive.studies.study import run_study
from study_drives import drive_of, goals


def text_of(verdict):
    return " | ".join((*verdict.reasons, *verdict.remedies, *verdict.cautions))


@pytest.mark.verify
def test_a_missing_controller_is_stated_once():
    """At 100 Hz no bandwidth is left: the reason stands first, and acceptance points to it."""
    drive = drive_of("wrist")
    slow = replace(drive, sensors=replace(drive.sensors, sample_rate=100.0))
    verdict = run_study(slow, [], goals(60, 0.3, backlash=0.0)).verdict
    assert verdict.answer == "unknown"
    assert "5 Hz, lies above a fortieth of the sample rate, 2.5 Hz" in text_of(verdict)


def test_missing_data_are_stated_once():
    found = run_study(load_drive("camera-line"), [], goals(1, 0.5))
    assert found.verdict.answer == "unknown"
    for reason in found.check.missing:
        assert text_of(found.verdict).count(reason) == 1, found.verdict
    assert any(words.startswith("acceptance was not run: ") for words in found.verdict.cautions)
    page = " ".join(str(getattr(block, "text", "")) for block in modes_chapter(found).blocks)
    assert "see the verdict" in page
    assert not any(reason in page for reason in found.check.missing)


def test_what_stands_nowhere_else_is_stated_in_full():
    """Torque refuses the lift first: why no controller can be designed then stands with the acceptance."""
    found = run_study(load_drive("elevator"), [], goals(45, 0.5))
    assert found.verdict.answer == "unknown", "no error goal, no verdict"
    assert found.verdict.reasons[0].startswith("torque: ")
    for reason in found.check.missing:
        assert text_of(found.verdict).count(reason) == 1, found.verdict
