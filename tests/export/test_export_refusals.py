"""What `export` refuses: source and options, and the name or number in the one line; nothing is written."""

import json

import pytest

import cabledrive as cd
from cabledrive.export import export_to
from export.designs import DRIVE, OWN

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
]


@pytest.mark.parametrize("source, options, named", ROWS)
def test_refused_in_one_line_with_nothing_written(source, options, named, tmp_path):
    with pytest.raises(cd.InputRefused) as refusal:
        export_to(tmp_path / "out", source, **options)
    assert named in str(refusal.value)
    assert "\n" not in str(refusal.value)
    assert list(tmp_path.iterdir()) == []


def test_a_full_folder_an_empty_study_and_another_layout_are_refused(tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("mine")
    with pytest.raises(cd.InputRefused, match="not empty"):
        export_to(tmp_path / "full", "dissertation-3", "c99")
    (tmp_path / "study").mkdir()
    with pytest.raises(cd.InputRefused, match=r"controller\.json"):
        export_to(tmp_path / "out", tmp_path / "study", "c99")
    (tmp_path / "controller.json").write_text(json.dumps({"drive_hash": "0"}))
    with pytest.raises(cd.InputRefused, match=r"controller\.json"):
        export_to(tmp_path / "out", tmp_path / "controller.json", "c99")
    assert not (tmp_path / "out").exists()
