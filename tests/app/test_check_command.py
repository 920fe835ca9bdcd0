"""`cabledrive check`: valid or refused, whatever the file holds; never a defect."""

import pytest

import cabledrive as cd
from cabledrive.mechanics.warnings import drive_warnings
from cabledrive.modal.lowest import derived_with_lowest
from command import answer, call, object_of, the_line


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


def checked(content, folder):
    """The claim: status 0 with one JSON object, or 2 with one line; never anything else."""
    path = folder / "mutant.toml"
    path.write_bytes(content)
    result = call("check", str(path), "--json")
    assert result.exit_code in (0, 2), result.stderr
    if result.exit_code == 0:
        assert object_of(result.stdout)["valid"] is True
    else:
        assert result.stdout == ""
        assert the_line(result.stderr).startswith(f"{path}: ")
    return result.exit_code
