"""What `export` refuses: source and options, and the name or number in the one line; nothing is written."""

import json
from dataclasses import replace

import pytest

import cabledrive as cd
from cabledrive.rig.laws.controller_file import controller_numbers
from command import call
from export.designs import DRIVE, OWN, loop_of


def with_vectors(gains, state, measurement, reference):
    error = reference[:4] - measurement
    return state, error[0]


def with_a_longer_state(gains, state, measurement, reference):
    return measurement, reference[0]


def by_name(gains, state, measurement, reference):
    return state, gains["p"] * (reference[0] - measurement[0])


OUTSIDE = [
    ({"step": with_vectors}, "test_export_refusals.py:"),
    ({"step": with_a_longer_state}, "state of shape"),
    ({"step": by_name, "gains": {"p": 1.0}}, "its gains cannot be exported"),
    ({"step": eval("lambda g, s, m, r: (s, 0.0)")}, "cannot be exported"),
]
CABLE = {"format": "fmu2", "what": "cable"}
ROWS = [
    ("dissertation-3", {"format": "c99", "controller": "no-law"}, "no-law"),
    ("elevator", {"format": "c99"}, "3000 N m"),
    ("no-such-drive", {"format": "c99"}, "no-such-drive"),
    ("dissertation-3", {"format": "hdl"}, "hdl"),
    ("dissertation-3", {"format": "mjcf", "what": "loop"}, "loop"),
    ("dissertation-3", {"format": "fmu2", "float32": True}, "float32"),
    ("dissertation-3", {"format": "mjcf", "float32": True}, "float32"),
    ("dissertation-3", CABLE, "coulomb_friction"),
    ("dissertation-1", CABLE | {"format": "c99"}, "fmu2 or fmu3"),
    ("dissertation-1", CABLE | {"controller": "pd"}, "holds no controller"),
    ("ropeway", CABLE, "carriage"),
    (DRIVE, {"format": "c99", "controller": OWN, "float32": True}, "your own"),
    (DRIVE, {"format": "c99", "controller": OWN, "what": "loop"}, "your own"),
    *((DRIVE, {"format": "c99", "controller": replace(OWN, **one)}, named) for one, named in OUTSIDE),
]


@pytest.mark.parametrize("source, options, named", ROWS)
def test_refused_in_one_line_with_nothing_written(source, options, named, tmp_path):
    with pytest.raises(cd.InputRefused) as refusal:
        cd.export_to(tmp_path / "out", source, **options)
    assert named in str(refusal.value)
    assert "\n" not in str(refusal.value)
    assert list(tmp_path.iterdir()) == []


def test_a_full_folder_an_empty_study_and_another_layout_are_refused(tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("mine")
    with pytest.raises(cd.InputRefused, match="not empty"):
        cd.export_to(tmp_path / "full", "dissertation-3", "c99")
    (tmp_path / "study").mkdir()
    with pytest.raises(cd.InputRefused, match=r"controller\.json"):
        cd.export_to(tmp_path / "out", tmp_path / "study", "c99")
    (tmp_path / "controller.json").write_text(json.dumps({"drive_hash": "0"}))
    with pytest.raises(cd.InputRefused, match=r"controller\.json"):
        cd.export_to(tmp_path / "out", tmp_path / "controller.json", "c99")
    assert not (tmp_path / "out").exists()


# --- The law of a study without yes leaves only on demand, with its reason in the firmware
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
    cd.export_to(tmp_path / "firmware", study("no"), "c99", anyway=True)
    with pytest.raises(cd.InputRefused, match="its study is no"):
        cd.export_to(tmp_path / "again", tmp_path / "firmware", "c99")
