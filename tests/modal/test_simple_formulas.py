"""Rigid supports and springs without mass: where the simple formulas hold, and how they fail."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.modal.rigid_supports import (
    against_lumped_springs,
    against_rigid_supports,
    rigid_support_transverse,
)
from cabledrive.parameters import load_drive

LOOP = load_drive("dissertation-1")


def with_rims(drive, first, second):
    """The drive with J = m r^2 for the two rim masses [kg]."""
    pulleys = (
        replace(p, inertia=m * p.radius**2) for p, m in zip(drive.pulley, (first, second), strict=True)
    )
    return replace(drive, pulley=tuple(pulleys))


def test_rigid_supports_miss_the_pulley_mode_of_both_configurations_by_a_factor():
    """Section 3.2.1: 751.73 Hz against 116.33 and 81.74 Hz; transverse modes do not see the pulleys."""
    for number, factor in ((1, 751.7327 / 116.3293), (2, 751.7327 / 81.7421)):
        drive = load_drive(f"dissertation-{number}", overrides=["layout.gravity=0"])
        along, across = against_rigid_supports(drive)
        assert along.deviation == pytest.approx(factor - 1, rel=1e-5)
        assert abs(across.deviation) < 1e-12, f"{across.deviation:.1e}"


def test_transverse_supports_are_at_the_stretched_length():
    """(3.14b) with Le and rho per pretensioned metre: 50.394 Hz, not the printed 50.5."""
    cable = LOOP.cable
    stretch = 1 + cable.prestrain
    expected = np.sqrt(cable.pretension * stretch / cable.mass_per_length) / (2 * LOOP.span_length * stretch)
    assert rigid_support_transverse(LOOP) == pytest.approx(expected, rel=1e-14)
    assert rigid_support_transverse(LOOP) == pytest.approx(50.394, abs=5e-4)


@pytest.mark.parametrize(("kind", "springs"), [("loop", 2), ("line", 1)])
@pytest.mark.parametrize("rims", [(1.0, 1.0), (0.2, 3.0), (1e-2, 1e2)])
def test_lumped_springs_are_right_to_first_order_in_the_mass_of_the_cable(kind, springs, rims):
    """The excess tends to Eq. (M.7) as the cable gets lighter, and what is left is of second order."""
    first, second = rims
    reduced = first * second / (first + second)
    shares, excess = np.array([1e-2, 1e-3]), []
    for share in shares:
        mass_per_length = share * reduced / (springs * LOOP.span_length)
        cable = replace(LOOP.cable, mass_per_length=mass_per_length)
        drive = with_rims(replace(LOOP, kind=kind, cable=cable), first, second)
        excess.append(against_lumped_springs(drive).deviation)
    predicted = shares / 6 * (1 - 3 * reduced / (first + second))
    left = np.abs(np.array(excess) - predicted)
    assert np.all(left < 0.1 * shares**2), f"excess {excess}, predicted {predicted}"


def test_lumped_springs_of_the_dissertation():
    """sqrt(2 k (r1^2/J1 + r2^2/J2))/(2 pi): 117.50 and 83.36 Hz, one and two per cent high."""
    for number, simple, deviation in ((1, 117.497, 0.01004), (2, 83.359, 0.01978)):
        found = against_lumped_springs(load_drive(f"dissertation-{number}"))
        assert found.simple == pytest.approx(simple, abs=1e-3)
        assert found.deviation == pytest.approx(deviation, abs=1e-5)


def test_measured_lumped_stiffness_does_not_enter():
    """`modes` uses the cable's own EA, and so does what it is compared with."""
    drive = load_drive("dissertation-3")
    assert against_lumped_springs(drive) == against_lumped_springs(replace(drive, lumped=None))
