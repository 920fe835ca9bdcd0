"""The JSON Schema for editors says of a drive file what the loader says."""

import copy
import tomllib
from dataclasses import fields, is_dataclass, replace
from math import inf, nextafter
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given

from cabledrive.parameters import InputRefused, content_hash, drive_schema, load_drive
from cabledrive.parameters.tables import drive_from_tables, tables_from_drive
from drive_strategies import drives

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
EVERY_NUMBER = load_drive(EXAMPLE, overrides=SETTINGS)
OTHER = {"kind": "line", "span": "lower"}
ELSEWHERE = {"schema", "name", "title", "source", "pulley_distance", "fixed", "given_rigidity"}
ELSEWHERE |= {"coupled", "type", "direction", "speed"}


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
