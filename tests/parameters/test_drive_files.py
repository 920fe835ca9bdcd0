"""Drive files: written and read again, damaged at random, packaged; what the JSON Schema says of them."""

import copy
import re
import tomllib
from dataclasses import fields, is_dataclass, replace
from math import inf, nextafter
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given, settings

import cabledrive as cd
from cabledrive.parameters import (
    InputRefused,
    content_hash,
    drive_schema,
    drive_text,
    load_drive,
    packaged_text,
)
from cabledrive.parameters.tables import drive_from_tables, tables_from_drive
from drive_strategies import drives, mutants

VALIDATOR = jsonschema.Draft202012Validator(drive_schema())
EXAMPLE = Path(__file__).with_name("contract_example.toml")
ROUTES = sorted((Path(__file__).parent / "routes").glob("*.toml"))


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
    assert cd.load_drive(cd.save_drive(drive, path, force=True)).listed == drive


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
        assert isinstance(cd.load_drive(path, **options), cd.Machine)
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


# --- The JSON Schema for editors says of a drive file what the loader says
VALIDATOR = jsonschema.Draft202012Validator(drive_schema())
EXAMPLE = Path(__file__).with_name("contract_example.toml")
FULL = tomllib.loads(EXAMPLE.read_text(encoding="utf-8"))
FULL |= {"title": "t", "source": "s", "goal": {"tracking_error": 0.001}}
FULL |= {"carriage": [{"mass": 1, "position": 0.5}]}
PLACES = [(), *[(key,) for key in FULL if isinstance(FULL[key], dict)], ("pulley", 1), ("carriage", 0)]
TABLE_SCHEMAS = {place: VALIDATOR.schema["else"]["properties"][place[0]] for place in PLACES[1:]}
QUANTITIES = {
    (*place, key): field
    for place, table in TABLE_SCHEMAS.items()
    for key, field in table.get("items", table)["properties"].items()
    if "anyOf" in field
}


def table_at(data, place):
    for step in place:
        data = data[step]
    return data


def loads(data):
    try:
        drive_from_tables(data)
    except InputRefused:
        return False
    return True


@given(drive=drives())
def test_every_drive_as_it_is_written_is_valid(drive):
    VALIDATOR.validate(tables_from_drive(drive))


@pytest.mark.parametrize("place", PLACES, ids=str)
def test_unknown_key_is_refused_by_schema_and_loader(place):
    data = copy.deepcopy(FULL)
    assert VALIDATOR.is_valid(data)
    assert loads(data)
    table_at(data, place)["frobnicate"] = 1
    assert not VALIDATOR.is_valid(data)
    assert not loads(data)


@pytest.mark.parametrize(
    ("place", "key"), [(place, key) for place in PLACES for key in table_at(FULL, place)], ids=str
)
def test_schema_and_loader_require_the_same_keys(place, key):
    data = copy.deepcopy(FULL)
    del table_at(data, place)[key]
    assert VALIDATOR.is_valid(data) == loads(data), f"the loader says {loads(data)}"


@pytest.mark.parametrize("place", QUANTITIES, ids=lambda place: ".".join(map(str, place)))
def test_schema_bounds_a_number_as_the_loader_does(place):
    """What ties two quantities together, like a place and its span, only the loader knows."""
    for value in (-1e31, -1, -1e-31, 0, 1e-31, 0.5, 1, 2e30, True, None, [], {}, ""):
        data = copy.deepcopy(FULL)
        table_at(data, place[:-1])[place[-1]] = value
        if place == ("layout", "pulley_distance"):
            del data["layout"]["span_length"]
        if loads(data) or place[-1] not in ("position", "span_length", "pulley_distance"):
            assert VALIDATOR.is_valid(data) == loads(data), f"{value!r}: the loader says {loads(data)}"


# --- The content hash names what a result depends on: every number, no word
SETTINGS = ["carriage.0.mass=0.5", "carriage.0.position=0.25", "goal.tracking_error=0.001"]
SETTINGS += ["cable.strain_limit=0.05", "pulley.0.wrap_angle=3", "pulley.0.capstan_friction=0.3"]
SETTINGS += ["excitation.torque_ripple=0.02"]
EVERY_NUMBER = load_drive(EXAMPLE, overrides=SETTINGS).listed
OTHER = {"kind": "line", "span": "lower"}
ELSEWHERE = {"schema", "name", "title", "source", "pulley_distance", "fixed", "given_rigidity"}
ELSEWHERE |= {"coupled", "type", "direction", "speed", "chain_of"}


def varied(value, name):
    """The nearest different value of the same kind."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return value + 1
    if isinstance(value, str):
        return OTHER[name]
    return 1.0 if value is None else nextafter(value, inf)


def variants(table):
    """Every copy of a table in which one number, choice or setting differs."""
    for field in fields(table):
        value = getattr(table, field.name)
        if is_dataclass(value):
            copies = [
                (f"{field.name}.{key}", replace(table, **{field.name: new})) for key, new in variants(value)
            ]
        elif isinstance(value, tuple):
            changed = [(n, *one) for n, row in enumerate(value) for one in variants(row)]
            rows = [(f"{n}.{key}", (*value[:n], new, *value[n + 1 :])) for n, key, new in changed]
            copies = [(f"{field.name}.{key}", replace(table, **{field.name: new})) for key, new in rows]
        elif field.name in ELSEWHERE:
            copies = []
        else:
            copies = [(field.name, replace(table, **{field.name: varied(value, field.name)}))]
        yield from copies


@pytest.mark.parametrize(("key", "other"), [pytest.param(*v, id=v[0]) for v in variants(EVERY_NUMBER)])
def test_hash_sees_the_last_bit_of_every_quantity(key, other):
    assert content_hash(other) != content_hash(EVERY_NUMBER), f"the hash does not see {key}"


@pytest.mark.parametrize("key", ["name", "title", "source"])
def test_hash_does_not_see_words(key):
    assert content_hash(replace(EVERY_NUMBER, **{key: "other words"})) == content_hash(EVERY_NUMBER)


def test_hash_sees_the_last_bit_of_a_given_rigidity():
    cable = replace(EVERY_NUMBER.cable, youngs_modulus=None, area=None, given_rigidity=438.0)
    rope = replace(EVERY_NUMBER, cable=cable)
    other = replace(rope, cable=rope.cable.with_rigidity(nextafter(438.0, inf)))
    assert len({content_hash(drive) for drive in (EVERY_NUMBER, rope, other)}) == 3
