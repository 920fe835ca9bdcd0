"""The content hash names what a result depends on: every number, no word."""

from dataclasses import fields, is_dataclass, replace
from math import inf, nextafter
from pathlib import Path

import pytest

from cabledrive.parameters import content_hash, load_drive

SETTINGS = ["carriage.0.mass=0.5", "carriage.0.position=0.25", "goal.tracking_error=0.001"]
SETTINGS += ["cable.strain_limit=0.05", "pulley.0.wrap_angle=3", "pulley.0.capstan_friction=0.3"]
SETTINGS += ["excitation.torque_ripple=0.02"]
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
        elif field.name in (
            "schema",
            "name",
            "title",
            "source",
            "pulley_distance",
            "fixed",
            "given_rigidity",
            "coupled",
            "type",
            "direction",
            "speed",
        ):
            copies = []
        else:
            copies = [(field.name, replace(table, **{field.name: varied(value, field.name)}))]
        yield from copies


@pytest.mark.parametrize(("key", "other"), [pytest.param(*v, id=v[0]) for v in variants(FULL)])
def test_hash_sees_the_last_bit_of_every_quantity(key, other):
    assert content_hash(other) != content_hash(FULL), f"the hash does not see {key}"


@pytest.mark.parametrize("key", ["name", "title", "source"])
def test_hash_does_not_see_words(key):
    assert content_hash(replace(FULL, **{key: "other words"})) == content_hash(FULL)


def lift(**second):
    drive = load_drive("elevator")
    car, weight = (replace(carriage, coupled="", direction=1) for carriage in drive.carriage)
    return replace(drive, carriage=(car, replace(weight, **second)))


def test_hash_sees_which_carriages_move_together_and_not_what_they_are_called():
    alone, together = lift(), lift(coupled="car")
    assert content_hash(together) != content_hash(alone)
    assert content_hash(lift(coupled="car", direction=-1)) != content_hash(together)
    assert content_hash(lift(coupled="carriage 0")) == content_hash(together)
    cabin = replace(together.carriage[0], name="cabin")
    weight = replace(together.carriage[1], coupled="cabin")
    assert content_hash(replace(together, carriage=(cabin, weight))) == content_hash(together)


def test_hash_sees_the_last_bit_of_a_given_rigidity():
    rope = replace(FULL, cable=replace(FULL.cable, youngs_modulus=None, area=None, given_rigidity=438.0))
    other = replace(rope, cable=rope.cable.with_rigidity(nextafter(438.0, inf)))
    assert len({content_hash(drive) for drive in (FULL, rope, other)}) == 3
