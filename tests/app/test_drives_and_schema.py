"""`cabledrive drives` and `cabledrive schema`: what there is to start from."""

import pytest

import cabledrive as cd
from command import answer, call


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
