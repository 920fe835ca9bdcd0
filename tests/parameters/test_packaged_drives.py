"""The packaged drives are machines that could run, and docs/machines.md says of them what is so."""

import re
from pathlib import Path

import pytest

import cabledrive as cd

PAGE = Path(__file__).parents[2] / "docs" / "machines.md"
DISSERTATION = [name for name in cd.packaged_drives("loop", "line") if name.startswith("dissertation")]


@pytest.mark.parametrize("name", cd.packaged_drives())
def test_documented_frequencies_are_those_of_modes(name):
    """The lowest longitudinal and transverse frequency in the table of docs/machines.md."""
    row = re.search(rf"^\| `{name}` \|.* \| ([\d.]+) \| ([\d.]+) \|$", PAGE.read_text(encoding="utf-8"), re.M)
    found = cd.modes(cd.load_drive(name), count=1)
    lowest = (found.longitudinal[0].frequency, found.transverse[0].frequency)
    assert row.groups() == tuple(f"{frequency:.4g}" for frequency in lowest)


@pytest.mark.parametrize(
    ("name", "drive_inertia", "load_inertia", "radius", "modulus", "area", "density", "pretension"),
    [  # Tables 3.1 and 6.1; configuration 3 with the motor's J11 of Table 4.2 added to the drive pulley's J12
        ("dissertation-1", 7.316e-6, 7.316e-6, 0.03, 2.6e9, 4.26e-7, 4.9e-4, 5.0),
        ("dissertation-2", 0.0011, 7.316e-6, 0.03, 2.6e9, 4.26e-7, 4.9e-4, 5.0),
        ("dissertation-3", 0.001742, 0.00235, 0.04, 3.0e9, 1.46e-7, 1.68e-4, 7.0),
    ],
)
def test_dissertation_drives_hold_the_printed_tables(
    name, drive_inertia, load_inertia, radius, modulus, area, density, pretension
):
    drive = cd.load_drive(name)
    first, second, cable = *drive.pulley, drive.cable
    rotor = drive.motor.inertia if drive.motor else 0.0
    assert first.inertia + rotor == pytest.approx(drive_inertia, rel=1e-15)
    assert (second.inertia, first.radius, second.radius) == (load_inertia, radius, radius)
    assert (cable.youngs_modulus, cable.area, cable.mass_per_length) == (modulus, area, density)
    assert (cable.pretension, drive.span_length) == (pretension, 1.0)


@pytest.mark.parametrize("name", cd.packaged_drives())
def test_every_packaged_drive_says_what_it_is_and_where_its_figures_come_from(name):
    drive = cd.load_drive(name)
    assert drive.title
    origin = "Bhardhwaj" if name in DISSERTATION else "estimate"
    assert origin in drive.source, f"{name}: source names no {origin}"
