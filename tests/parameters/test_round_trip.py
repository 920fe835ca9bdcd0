"""A drive written to a file and read again is the same drive, to the last bit."""

from pathlib import Path

import pytest
from hypothesis import given, settings

from cabledrive.parameters import InputRefused, drive_text, load_drive, packaged_drives, save_drive
from drive_strategies import drives

EXAMPLE = Path(__file__).with_name("contract_example.toml")


@pytest.mark.parametrize("source", [*packaged_drives(), EXAMPLE], ids=str)
def test_packaged_drives_survive_the_round_trip(source, tmp_path):
    """File -> drive -> file -> drive; the second file is the first one written again."""
    drive = load_drive(source)
    again = load_drive(save_drive(drive, tmp_path / "again.toml"))
    assert again == drive
    assert drive_text(again) == drive_text(drive)


@given(drive=drives())
@settings(max_examples=200)
def test_every_drive_survives_the_round_trip(drive, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / "drive.toml"
    assert load_drive(save_drive(drive, path, force=True)) == drive


def test_only_what_differs_from_the_defaults_is_written(tmp_path):
    """A short file stays short; each quantity carries its unit."""
    text = drive_text(load_drive(EXAMPLE))
    assert 'pretension = "7.0 N"' in text
    assert 'joint_stiffness = "135.0 N m/rad"' in text
    assert "axial_damping" not in text
    assert "gravity" not in text
    assert "fixed" not in text


def test_existing_file_is_not_overwritten_unasked(tmp_path):
    path = tmp_path / "drive.toml"
    path.write_text("mine")
    drive = load_drive(EXAMPLE)
    with pytest.raises(InputRefused, match="exists and is not overwritten"):
        save_drive(drive, path)
    assert path.read_text() == "mine"
    assert load_drive(save_drive(drive, path, force=True)) == drive


@pytest.mark.parametrize(
    ("path", "words"),
    [
        (".", "is a folder"),
        ("no/such/folder/drive.toml", "does not exist"),
        ("a\0b.toml", "cannot be written"),
    ],
)
def test_drive_that_cannot_be_written_leaves_nothing_behind(path, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputRefused, match=words):
        save_drive(load_drive(EXAMPLE), path)
    assert list(tmp_path.iterdir()) == []
