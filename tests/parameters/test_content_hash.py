"""The content hash names what a result depends on: every number, no word."""

from dataclasses import fields, is_dataclass, replace
from math import inf, nextafter
from pathlib import Path

import pytest
from hypothesis import given

from cabledrive.parameters import Drive, content_hash, drive_text, load_drive, packaged_drives, save_drive
from drive_strategies import drives

SETTINGS = ["carriage.0.mass=0.5", "carriage.0.position=0.25", "goal.tracking_error=0.001"]
SETTINGS += ["cable.strain_limit=0.05", "pulley.0.wrap_angle=3", "pulley.0.capstan_friction=0.3"]
FULL = load_drive(Path(__file__).with_name("contract_example.toml"), overrides=SETTINGS)
OTHER = {"kind": "line", "span": "lower"}


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
            copies = [
                (
                    f"{field.name}.{n}.{key}",
                    replace(table, **{field.name: (*value[:n], new, *value[n + 1 :])}),
                )
                for n, row in enumerate(value)
                for key, new in variants(row)
            ]
        elif field.name in ("schema", "name", "title", "source", "pulley_distance", "fixed"):
            copies = []
        else:
            copies = [(field.name, replace(table, **{field.name: varied(value, field.name)}))]
        yield from copies


@pytest.mark.parametrize(("key", "other"), [pytest.param(*v, id=v[0]) for v in variants(FULL)])
def test_hash_sees_the_last_bit_of_every_quantity(key, other):
    assert content_hash(other) != content_hash(FULL), f"the hash does not see {key}"


def test_hash_sees_a_fixed_pulley():
    first, second = FULL.pulley
    assert content_hash(replace(FULL, pulley=(first, replace(second, fixed=True)))) != content_hash(FULL)


@pytest.mark.parametrize("key", ["name", "title", "source"])
def test_hash_does_not_see_words(key):
    assert content_hash(replace(FULL, **{key: "other words"})) == content_hash(FULL)


def test_hash_does_not_see_how_a_number_is_written(tmp_path):
    path = tmp_path / "drive.toml"
    path.write_text(drive_text(FULL).replace('"7.0 N"', '"0.007 kN"').replace('"0.04 m"', "4e-2"))
    assert path.read_text().count("0.007 kN") == 1
    assert content_hash(load_drive(path)) == content_hash(FULL)


def test_hash_does_not_see_a_default_that_is_stated():
    stated = load_drive(
        Path(__file__).with_name("contract_example.toml"), overrides=[*SETTINGS, "cable.axial_damping=-0.0"]
    )
    assert content_hash(stated) == content_hash(FULL)


def test_packaged_drives_have_different_hashes():
    hashes = {content_hash(load_drive(name)) for name in packaged_drives()}
    assert len(hashes) == len(packaged_drives())
    assert all(len(name) == 64 and set(name) <= set("0123456789abcdef") for name in hashes)


@given(drive=drives())
def test_hash_survives_the_round_trip(drive: Drive, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / "hashed.toml"
    assert content_hash(load_drive(save_drive(drive, path, force=True))) == content_hash(drive)
