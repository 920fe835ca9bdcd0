"""Tension at rest on a slope, held against the divided cable and against statics by hand."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.datasheet import lowest_static_tension
from cabledrive.mechanics.mesh import gradients, mesh_of
from cabledrive.mechanics.statics import equilibrium
from cabledrive.parameters import Carriage, load_drive, packaged_drives

DRIVE = load_drive("elevator")
UPPER = Carriage(mass=700.0, position=20.0)
LOWER = Carriage(mass=300.0, position=50.0, span="lower")


def sloped(degrees, *carriages, fixed=False, kind="loop"):
    first, second = DRIVE.pulley
    return replace(
        DRIVE,
        kind=kind,
        pulley=(first, replace(second, fixed=fixed)),
        carriage=carriages,
        layout=replace(DRIVE.layout, inclination=radians(degrees)),
    )


def tension_of_the_divided_cable(drive, segments=90):
    """Lowest tension: segments have the tension of their middles, the ends lie half a segment of cable on."""
    mesh, law = mesh_of(drive, segments), cable_law(drive.cable, "linear")
    tension = (
        law.pretension + law.stiffness * gradients(mesh, equilibrium(mesh, law, hold="drive").displacement)[0]
    )
    slope = abs(np.sin(drive.layout.inclination)) * drive.layout.gravity
    return float(np.min(tension - slope * mesh.density * mesh.spacing / 2.0))


@pytest.mark.parametrize("degrees", [-90, -40, 25, 90])
@pytest.mark.parametrize("fixed", [False, True], ids=["free load pulley", "fixed load pulley"])
@pytest.mark.parametrize("carriages", [(), (UPPER,), (LOWER,), (UPPER, LOWER)], ids=len)
def test_formula_is_the_equilibrium_of_the_divided_cable(degrees, fixed, carriages):
    """Piecewise linear tension: the division is exact but for round-off."""
    drive = sloped(degrees, *carriages, fixed=fixed)
    assert lowest_static_tension(drive) == pytest.approx(tension_of_the_divided_cable(drive), rel=1e-8)


@pytest.mark.parametrize("fixed", [False, True], ids=["free load pulley", "fixed load pulley"])
def test_half_the_cable_hangs_on_a_vertical_loop(fixed):
    """Cable alone: its middle keeps T0, its lower end has T0 - rho0 g L / 2."""
    hanging = DRIVE.cable.mass_per_length * 9.81 * 90.0
    lowest = lowest_static_tension(sloped(-90, fixed=fixed))
    assert lowest == pytest.approx(DRIVE.cable.pretension - hanging / 2.0, rel=1e-13)
    assert lowest_static_tension(sloped(90, fixed=fixed)) == pytest.approx(lowest, rel=1e-13)


def test_weight_on_a_fixed_vertical_line_is_shared_by_the_parts_above_and_below():
    """m g = T_above - T_below and equal and opposite stretch: below loses m g a / L, a from the top."""
    drive = replace(
        sloped(-90, UPPER, kind="line", fixed=True), cable=replace(DRIVE.cable, mass_per_length=1e-9)
    )
    expected = DRIVE.cable.pretension - 700.0 * 9.81 * 20.0 / 90.0
    assert lowest_static_tension(drive) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("name", [name for name in packaged_drives("loop", "line") if name != "elevator"])
def test_level_drive_keeps_its_pretension(name):
    drive = load_drive(name)
    assert lowest_static_tension(drive) == drive.cable.pretension


def test_lift_keeps_what_its_tension_sheave_pulls():
    """The packaged elevator: 2942 N of 17.91 kN are left below, half of what its sheave pulls with."""
    assert lowest_static_tension(DRIVE) == pytest.approx(2942.0, abs=1.0)
