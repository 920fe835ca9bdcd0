"""The law of a study without yes leaves only on demand, and the reason goes with it into the firmware."""

import json

import pytest

import cabledrive as cd
from cabledrive.export import export_to
from cabledrive.rig.laws.controller_file import controller_numbers
from command import call
from export.designs import DRIVE, loop_of

REASON = "the log contradicts the assumptions: the angles lag the torque by 2 ms */ of late"


@pytest.fixture
def study(tmp_path):
    """A study's folder whose verdict is unknown, made by hand."""

    def written(verdict):
        folder = tmp_path / "study"
        folder.mkdir()
        data = controller_numbers(loop_of("pd"), DRIVE, "motor")
        data |= {"study": {"verdict": verdict, "reason": REASON}}
        (folder / "controller.json").write_text(json.dumps(data))
        cd.save_drive(DRIVE, str(folder / "drive.toml"))
        return folder

    return written


def test_the_law_of_a_study_without_yes_is_refused_with_the_reason(study, tmp_path):
    asked = call("export", study("unknown"), "--format", "c99", "-o", tmp_path / "firmware")
    assert asked.exit_code == 2
    assert "lag the torque by 2 ms" in asked.output
    assert "--anyway" in asked.output
    assert not (tmp_path / "firmware").exists()


@pytest.mark.parametrize("what", ["controller", "loop"])
def test_the_reason_stands_in_the_header_and_the_readme(what, study, tmp_path):
    arguments = ("--format", "c99", "--what", what, "--anyway", "-o", tmp_path / "firmware")
    asked = call("export", study("unknown"), *arguments)
    assert asked.exit_code == 0, asked.output
    header = next((tmp_path / "firmware").glob("cabledrive_l*.h")).read_text()
    first = header[: header.index("*/")]
    assert "verdict of its study is unknown" in first
    assert "lag the torque by 2 ms * / of late" in first
    assert "lag the torque by 2 ms" in (tmp_path / "firmware" / "README.md").read_text()


def test_a_copy_of_a_doubtful_law_stays_doubtful(study, tmp_path):
    export_to(tmp_path / "firmware", study("no"), "c99", anyway=True)
    with pytest.raises(cd.InputRefused, match="its study is no"):
        export_to(tmp_path / "again", tmp_path / "firmware", "c99")


def test_the_law_of_a_study_that_says_yes_is_written_without_a_caution(study, tmp_path):
    export_to(tmp_path / "firmware", study("yes"), "c99")
    assert "Caution" not in (tmp_path / "firmware" / "cabledrive_law.h").read_text()
