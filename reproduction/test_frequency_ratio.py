"""Frequency ratio of chapter 5: Eq. (5.4) without poles, its surfaces and contours, the tuned pretension."""

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.modal.tuning import (
    span_frequency,
)
from reproduction.frequency_ratio import (
    frequency_ratio,
    mass_ratios,
    pulley_phase,
    resonant_load_ratio,
    wave_speed_ratio,
)

CONFIGURATION_2 = cd.load_drive("dissertation-2")


def random_loop(rng):
    """A loop with any two pulleys and cable, strain up to 10 %."""
    rigidity = 10 ** rng.uniform(1, 6)
    cable = cd.Cable(
        youngs_modulus=rigidity * 1e6,
        area=1e-6,
        mass_per_length=10 ** rng.uniform(-5, 1),
        pretension=rigidity * 10 ** rng.uniform(-5, -1),
    )
    span = 10 ** rng.uniform(-1, 3)
    pulleys = []
    for _ in range(2):
        radius = 10 ** rng.uniform(-2.5, 0.5)
        mass = 2 * cable.mass_per_length * span * 10 ** rng.uniform(-3, 5)
        pulleys.append(cd.Pulley(radius=radius, inertia=mass * radius**2))
    layout = cd.Layout(span_length=span, gravity=0.0)
    return cd.Drive(name="random", kind="loop", cable=cable, layout=layout, pulley=tuple(pulleys))


def ratio_errors(drives, seed):
    rng = np.random.default_rng(seed)
    for _ in range(drives):
        drive = random_loop(rng)
        closed = frequency_ratio(*mass_ratios(drive), drive.cable.prestrain)
        certified = cd.modes(drive, count=1)
        exact = span_frequency(drive) / certified.longitudinal[0].frequency
        assert certified.certified
        yield abs(closed / exact - 1.0)


def test_closed_ratio_equals_certified_modes_of_random_drives(measured):
    worst = max(ratio_errors(100, 1))
    measured(f"relative error {worst:.1e} in 100 drives")
    assert worst < 1e-12, f"{worst:.2e}"


@pytest.mark.verify
def test_closed_ratio_equals_certified_modes_of_a_thousand_random_drives(measured):
    worst = max(ratio_errors(1000, 0))
    measured(f"relative error {worst:.1e} in 1,000 drives")
    assert worst < 1e-12, f"{worst:.2e}"


def test_phase_solves_eq_5_4_cleared_of_its_fraction():
    """(chi1 chi2 x^2 - 1) sin x = (chi1 + chi2) x cos x, in each interval of length pi."""
    rng = np.random.default_rng(2)
    chi1, chi2 = 10 ** rng.uniform(-3, 3, (2, 500))
    for n in (1, 2, 5):
        x = pulley_phase(chi1, chi2, n)
        assert np.all(((n - 1) * np.pi < x) & (x < n * np.pi))
        left, right = (chi1 * chi2 * x**2 - 1) * np.sin(x), (chi1 + chi2) * x * np.cos(x)
        scale = (1 + chi1 * x) * (1 + chi2 * x)
        assert np.max(np.abs(left - right) / scale) < 1e-13 * n


def test_phase_at_the_limits_of_mass():
    """Massless pulleys: pi. One held, one massless: pi/2. Both heavy: x^2 = 1/chi1 + 1/chi2."""
    np.testing.assert_allclose(
        pulley_phase([0.0, np.inf, 0.0], [0.0, 0.0, np.inf]), [np.pi, np.pi / 2, np.pi / 2]
    )
    assert pulley_phase(1e9, 3e9) == pytest.approx(np.sqrt(1e-9 + 1e-9 / 3), rel=1e-8)


def test_contour_of_fig_5_3_is_where_the_surface_of_fig_5_2_is_one_half():
    """The mass conserved while the tension changes: one contour for each prestrain."""
    strains = np.array([3.0, 5.0, 10.0])[:, None] / CONFIGURATION_2.cable.axial_rigidity
    chi1 = np.linspace(0.5, 60.0, 200)
    chi2 = resonant_load_ratio(chi1, strains)
    there = np.isfinite(chi2)
    assert there.any(axis=1).all()
    assert not there.all()
    ratio = frequency_ratio(np.broadcast_to(chi1, chi2.shape), chi2, strains)
    np.testing.assert_allclose(ratio[there], 0.5, rtol=1e-12)


def test_contour_starts_at_its_asymptote():
    """chi1 > 1 / (x tan x): 8.259 at 3.274 N without stretch, where x = 2 pi sqrt(T0/EA)."""
    strain = 3.274 / CONFIGURATION_2.cable.axial_rigidity
    x = 2 * np.pi * wave_speed_ratio(strain)
    edge = 1 / (x * np.tan(x))
    assert edge == pytest.approx(8.259, abs=0.03), f"{edge:.4f}"
    assert np.isnan(resonant_load_ratio(edge * (1 - 1e-9), strain))
    assert resonant_load_ratio(edge * (1 + 1e-9), strain) > 1e6


def test_printed_form_of_the_contour():
    """chi2 = (x cos x chi1 + sin x) / (x (chi1 x sin x - cos x)), Eq. (5.4) solved for chi2."""
    strain, chi1 = 3e-3, np.linspace(20.0, 500.0, 7)
    x = 2 * np.pi * wave_speed_ratio(strain)
    printed = (x * np.cos(x) * chi1 + np.sin(x)) / (x * (chi1 * x * np.sin(x) - np.cos(x)))
    np.testing.assert_allclose(resonant_load_ratio(chi1, strain), printed, rtol=1e-11)
