"""Fig. 3.8: a carriage on its way along the span, and the crossing that the text of the figure overlooks."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.modal.counting import modes_below_reference
from cabledrive.parameters import InputRefused, load_drive
from cabledrive.studies import (
    frequency_against_carriage_position,
    midspan_crossing,
    with_carriage,
)

LOOP = load_drive("dissertation-1")


def test_in_phase_mode_falls_below_the_fundamental_at_chi_m_16_59(measured):
    """The exact value is 2 J/(r^2 m_cable): the carriage is then as heavy as both rims together."""
    found = midspan_crossing(LOOP)
    measured(f"crossing at chi_m = {found.mass_ratio:.4f}")
    assert found.mass_ratio == pytest.approx(16.59, abs=5e-3)
    assert found.mass == pytest.approx(2 * LOOP.drive_pulley.rim_mass, rel=1e-9)
    assert found.frequency == pytest.approx(116.32932059, rel=1e-9)


@pytest.mark.parametrize("inertia", [1e-7, 1e-5, 1e-3])
def test_crossing_of_any_symmetric_loop_is_at_twice_the_mass_of_a_rim(inertia):
    """Half of the loop: with t = tan(omega L/(4 c)) the fundamental has omega J/r^2 = 2 Z/t, which puts the
    in-phase mode there when the carriage has omega m = 4 Z/t."""
    drive = replace(LOOP, pulley=tuple(replace(pulley, inertia=inertia) for pulley in LOOP.pulley))
    found = midspan_crossing(drive, span="lower")
    assert found.mass == pytest.approx(2 * drive.drive_pulley.rim_mass, rel=1e-9)
    double = with_carriage(drive, found.mass_ratio, drive.span_length / 2, span="lower")
    chain = longitudinal_chains(double)[0].chain
    count = [modes_below_reference(chain, 2 * np.pi * found.frequency * (1 + e)) for e in (-1e-6, 1e-6)]
    assert count == [1, 3], "the rigid-body mode, then both modes"


def test_mass_at_midspan_lowers_the_fundamental_only_above_the_crossing(measured):
    """The print: midspan equals no mass. So it is at chi_m = 16, and at chi_m = 50 it is 94.5 Hz."""
    data = frequency_against_carriage_position(LOOP, [0.0, 5.0, 16.0, 50.0], [0.5], modes=2)
    fundamental = data.frequency.sel(mode=0, position=0.5).values
    measured(f"fundamental at chi_m = 50, midspan: {fundamental[3]:.2f} Hz")
    np.testing.assert_allclose(fundamental[:3], 116.32932059, rtol=1e-9)
    assert fundamental[3] == pytest.approx(94.5, abs=0.05)
    assert data.frequency.sel(mass_ratio=50.0, position=0.5, mode=1) == pytest.approx(116.32932059, rel=1e-9)


@pytest.mark.parametrize(
    ("drive", "reason"),
    [
        (load_drive("dissertation-2"), "differ: without symmetry"),
        (load_drive("dissertation-transporter"), "without motor and carriage"),
        (load_drive("dissertation-3"), "without motor and carriage"),
        (replace(LOOP, kind="line"), "a loop of two free pulleys"),
    ],
)
def test_crossing_needs_symmetry(drive, reason):
    with pytest.raises(InputRefused, match=reason):
        midspan_crossing(drive)
