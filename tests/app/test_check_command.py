"""`cabledrive check`: valid or refused, whatever the file holds; never a defect."""

import pytest
from hypothesis import given, settings

import cabledrive as cd
from cabledrive.mechanics.warnings import drive_warnings
from cabledrive.modal.lowest import derived_with_lowest
from command import answer, call, object_of, the_line
from drive_mutations import mutants
from drive_strategies import drives


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


@given(content=mutants())
@settings(max_examples=100)
def test_any_mutation_of_a_valid_file_ends_in_0_or_2(content, tmp_path_factory):
    checked(content, tmp_path_factory.getbasetemp())


@given(drive=drives())
@settings(max_examples=100)
def test_any_drive_of_any_size_is_valid(drive, tmp_path_factory):
    """Twenty-four powers of ten each way, as far as the file format goes: numbers or null with a reason."""
    assert checked(cd.parameters.drive_text(drive).encode(), tmp_path_factory.getbasetemp()) == 0
