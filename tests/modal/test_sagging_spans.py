"""Straight ropes of routes against spans that sag: a hanging cable divided about its exact rest."""

from dataclasses import replace

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.mechanics.network import statics_of
from cabledrive.mechanics.network.span_table import span_rows
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.route.parts import Anchor, RoutedMotor, RoutedPulley, RouteLayout
from cabledrive.parameters.route.rope import Rope, Route
from oracles.sagging_fem import extrapolated

RIGIDITY, DENSITY, LENGTH, RADIUS = 2e6, 1.0, 100.0, 0.01


def one_span(pull):
    """A rope from an anchor to a fixed drum of 1 cm."""
    return RoutedDrive(
        name="span",
        cable=Rope(given_rigidity=RIGIDITY, mass_per_length=DENSITY, pretension=pull),
        layout=RouteLayout(gravity=9.81),
        anchor=(Anchor(name="left", at=(0.0, RADIUS)),),
        pulley=(RoutedPulley(name="drum", at=(LENGTH, 0.0), radius=RADIUS, inertia=0.02),),
        route=(Route(name="rope", path=("left", "-drum")),),
    )


@pytest.mark.parametrize("pull", [1e5, 4e4, 2e4, 1e4])
def test_what_sag_shifts_lies_within_the_bound_and_is_flagged(pull, measured):
    """The first mode in the plane, which stretches the rope, against the bound 4 lambda^2/pi^4."""
    drive = one_span(pull)
    below = 2.3 * np.sqrt(pull / DENSITY) / (2 * LENGTH)
    found = cd.modes(drive, below=below, hold=["drum"])
    straight = next(mode.frequency for mode in found.transverse if mode.plane == "w")
    truth = extrapolated(
        RIGIDITY, DENSITY, np.array([0.0, -9.81]), np.array([LENGTH, 0.0]), pull, elements=60, count=1
    )[0]
    irvine = span_rows(drive, statics_of(drive))[0]["irvine_parameter"]
    shift, bound = truth / straight - 1.0, 4.0 * irvine / np.pi**4
    measured(
        f"lambda^2 = {irvine:.3g}: the sagging span's first mode is {shift:.2e} higher, bound {bound:.2e}"
    )
    assert 0.9 * bound < shift < 1.02 * bound  # of first order in lambda^2
    assert found.certified == (bound < 1e-3)
    assert found.certified or "sag" in found.certified_reason
    assert bound < 1e-4 or any("sag" in line for line in found.warnings)


@pytest.mark.parametrize("ratio", [0.6, 0.9, 1.0, 1.2])
def test_where_motion_along_meets_motion_across_sag_leaves_the_list_uncertified(ratio, measured):
    """A wheel whose mode along is near the first across, lambda^2 = 0.005: the shift is of first order."""
    pull = ((9.81 * LENGTH * DENSITY) ** 2 * RIGIDITY / 0.005) ** (1 / 3)
    first = np.sqrt(pull / DENSITY) / (2 * LENGTH)
    rim = RIGIDITY / LENGTH / (2 * np.pi * first * ratio) ** 2 - DENSITY * LENGTH / 3
    drive = replace(
        one_span(pull),
        pulley=(RoutedPulley(name="drum", at=(LENGTH, 0.0), radius=RADIUS, inertia=rim * RADIUS**2 / 2),),
        motor=(RoutedMotor(inertia=rim * RADIUS**2 / 2),),
    )
    found = cd.modes(drive, below=1.6 * first, motor="free")
    listed = np.array([mode.frequency for mode in found.modes if mode.plane != "v"])
    chord = np.array([LENGTH, 0.0])
    truth = extrapolated(
        RIGIDITY, DENSITY, np.array([0.0, -9.81]), chord, pull, elements=60, count=listed.size, wheel=rim
    )
    error = float(np.max(np.abs(listed / truth - 1.0)))
    measured(
        f"along over across {ratio:g}, lambda^2 = 0.005: off by {error:.1e}, certified {found.certified}"
    )
    assert found.certified == (error < 1e-3)
    assert found.certified or "couples motion along and across" in found.certified_reason
