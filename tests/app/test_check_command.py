"""`cabledrive check` and `drives`: what is valid, and what there is to start from."""

import pytest

import cabledrive as cd
from cabledrive.mechanics.warnings import drive_warnings
from cabledrive.modal.lowest import derived_with_lowest
from command import answer, call


@pytest.mark.parametrize("name", cd.packaged_drives("loop", "line"))
def test_packaged_drives_are_valid_and_reported_as_in_python(name):
    drive = cd.load_drive(name)
    found = answer("check", name)
    assert (found["valid"], found["drive_hash"]) == (True, cd.content_hash(drive))
    assert found["derived"] == derived_with_lowest(drive)
    assert found["warnings"] == list(drive_warnings(drive))


def test_warnings_are_shown_to_people():
    text = call("check", "dissertation-3").stdout
    for line in drive_warnings(cd.load_drive("dissertation-3")):
        assert f"Warning: {line}.\n" in text
    assert "Warning" not in call("check", "dissertation-1").stdout


# --- `cabledrive drives`: what there is to start from
def test_drives_lists_every_packaged_drive_with_title_and_source():
    rows = answer("drives")["drives"]
    assert [row["name"] for row in rows] == list(cd.packaged_drives())
    for row in rows:
        drive = cd.load_drive(row["name"])
        assert (row["title"], row["source"]) == (drive.title, drive.source.strip())
        assert row["source"]


@pytest.mark.parametrize("name", cd.packaged_drives())
def test_a_packaged_drive_written_to_a_file_loads_as_the_same_drive(name, tmp_path):
    file = tmp_path / "start.toml"
    call("drives", name, "-o", file)
    assert cd.content_hash(cd.load_drive(file)) == cd.content_hash(cd.load_drive(name))
    assert file.read_text() == answer("drives", name)["file"]
    assert file.read_text().rstrip("\n") == call("drives", name).stdout.rstrip("\n")
