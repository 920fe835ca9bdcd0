"""The packaged table of belts and ropes: its figures against each other, and a source for each entry."""

import tomllib
from importlib.resources import files

import pytest

from cabledrive.parameters.units import to_si

TABLE = tomllib.loads((files("cabledrive.parameters") / "cable_types.toml").read_text())
UNITS = {
    "axial_rigidity": "N",
    "mass_per_length": "kg/m",
    "strength": "N",
    "bending_stiffness": "N m^2",
    "least_radius": "m",
}


def figures(name):
    return {key: to_si(TABLE[name][key], unit) for key, unit in UNITS.items() if key in TABLE[name]}


@pytest.mark.parametrize("name", TABLE)
def test_rigidity_mass_and_strength_fit_each_other(name, measured):
    """Longitudinal waves of cords in rubber or air run at 0.9 to 12 km/s; cables break at 0.2 to 5 %."""
    own = figures(name)
    wave = (own["axial_rigidity"] / own["mass_per_length"]) ** 0.5
    strain = own["strength"] / own["axial_rigidity"] if "strength" in own else None
    measured(f"{name}: waves {wave:.0f} m/s, strain at its strength {strain}")
    assert 900.0 < wave < 12_000.0
    assert strain is None or 0.002 < strain < 0.05
    if "strain_limit" in TABLE[name] and strain is not None:
        assert strain == pytest.approx(float(TABLE[name]["strain_limit"]), rel=0.05)
    assert own.get("least_radius", 1e-3) > 0.0


@pytest.mark.parametrize("name", TABLE)
def test_every_entry_has_a_source_of_its_own_or_that_of_a_named_entry(name):
    source = TABLE[name]["source"]
    if source.startswith("As "):
        source = TABLE[source.split()[1].rstrip(".,:;")]["source"]
    assert len(source.split()) > 5
