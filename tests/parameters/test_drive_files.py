"""Drive files: written and read again, damaged at random, packaged with what the pages say of them."""

import re
import tomllib
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given, settings

import cabledrive as cd
from cabledrive.parameters import drive_text, packaged_text
from drive_mutations import mutants
from drive_strategies import drives

EXAMPLE = Path(__file__).with_name("contract_example.toml")
ROUTES = sorted((Path(__file__).parent / "routes").glob("*.toml"))
VALIDATOR = jsonschema.Draft202012Validator(cd.drive_schema())


@pytest.mark.parametrize("source", [*cd.packaged_drives(), EXAMPLE, *ROUTES], ids=str)
def test_packaged_drives_and_examples_are_valid_and_survive_the_round_trip(source, tmp_path):
    """File -> drive -> file -> drive; the second file is the first one written again."""
    drive = cd.load_drive(source)
    path = cd.save_drive(drive, tmp_path / "again.toml")
    again = cd.load_drive(path)
    assert again == drive
    assert cd.content_hash(again) == cd.content_hash(drive)
    assert drive_text(again) == drive_text(drive)
    original = source.read_text() if isinstance(source, Path) else packaged_text(source)
    for text in (original, path.read_text()):
        VALIDATOR.validate(tomllib.loads(text))


@given(drive=drives())
@settings(max_examples=200)
def test_every_drive_survives_the_round_trip(drive, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / "drive.toml"
    assert cd.load_drive(cd.save_drive(drive, path, force=True)) == drive


@pytest.mark.parametrize(
    ("path", "words"),
    [
        (".", "is a folder"),
        ("no/such/folder/drive.toml", "does not exist"),
        ("a\0b.toml", "cannot be written"),
        ("mine.toml", "exists and is not overwritten"),
    ],
)
def test_drive_that_cannot_be_written_leaves_nothing_behind(path, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mine = tmp_path / "mine.toml"
    mine.write_text("mine")
    with pytest.raises(cd.InputRefused, match=words):
        cd.save_drive(cd.load_drive(EXAMPLE), path)
    assert list(tmp_path.iterdir()) == [mine]
    assert mine.read_text() == "mine"


# --- Whatever is done to a valid file, it loads or is refused in one line: nothing else ever happens
def message_of_refusal(path, **options):
    """Load the file: the refusal's message, or nothing if it is a drive."""
    try:
        assert isinstance(cd.load_drive(path, **options), cd.Drive)
    except cd.InputRefused as refusal:
        return str(refusal)
    return None


def check(content, tmp_path_factory, **options):
    """The claim of this file."""
    path = tmp_path_factory.getbasetemp() / "mutant.toml"
    path.write_bytes(content)
    message = message_of_refusal(path, **options)
    if message is not None:
        assert message.isprintable(), f"{message!r}"
        assert len(message) < 300, f"{len(message)} characters: {message}"
        assert message.startswith(f"{path}: ")


@given(content=mutants())
@settings(max_examples=200)
def test_any_change_of_keys_and_values_loads_or_is_refused(content, tmp_path_factory):
    check(content, tmp_path_factory)


# --- The packaged drives are machines that could run, and docs/machines.md says of them what is so
PAGE = Path(__file__).parents[2] / "docs" / "machines.md"


@pytest.mark.parametrize("name", cd.packaged_drives())
def test_documented_frequencies_are_those_of_modes(name):
    """The lowest longitudinal and transverse frequency in the table of docs/machines.md."""
    row = re.search(rf"^\| `{name}` \|.* \| ([\d.]+) \| ([\d.]+) \|$", PAGE.read_text(encoding="utf-8"), re.M)
    found = cd.modes(cd.load_drive(name), count=1)
    lowest = (found.longitudinal[0].frequency, found.transverse[0].frequency)
    assert row.groups() == tuple(f"{frequency:.4g}" for frequency in lowest)
