"""Figures of the packaged belts and ropes agree with each other."""

import tomllib
from importlib.resources import files

import pytest

from cabledrive.parameters.units import to_si

TYPES = tomllib.loads((files("cabledrive.parameters") / "cable_types.toml").read_text())
UNITS = {
    "axial_rigidity": "N",
    "mass_per_length": "kg/m",
    "strength": "N",
    "bending_stiffness": "N m^2",
    "least_radius": "m",
}


@pytest.mark.parametrize("name", sorted(TYPES))
def test_an_entry_has_a_source_and_agrees_with_itself(name):
    entry = TYPES[name]
    assert len(entry["source"]) > 5
    value = {key: to_si(entry[key], unit) for key, unit in UNITS.items() if key in entry}
    strain = value["strength"] / value["axial_rigidity"]
    assert 0.002 < strain < 0.03, strain
    if "strain_limit" in entry:
        assert strain == pytest.approx(entry["strain_limit"], rel=0.02)
    wave_speed = (value["axial_rigidity"] / value["mass_per_length"]) ** 0.5
    assert 1000.0 < wave_speed < 12_000.0, wave_speed
    if (
        "bending_stiffness" in value
    ):  # less than that of a solid rod of the same rigidity and the rope's width
        diameter = float(name.rpartition("-")[2].removesuffix("mm")) * 1e-3
        assert value["bending_stiffness"] < value["axial_rigidity"] * diameter**2 / 16.0
        assert value["least_radius"] >= 20.0 * diameter * 0.999
