"""Sag of a taut string, held against statics, the parabola of a span and the elastic catenary."""

from dataclasses import replace
from math import cosh, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cabledrive.mechanics.sag import (
    catenary_sag,
    irvine_parameter,
    midspan_sag,
    parabola_sag,
    squared_shear,
    tension_with_sag,
)
from cabledrive.parameters import load_drive

NONE = np.array([])


def solved_string(tension, length, line_load, places, loads, n=200_001):
    """Midspan sag and integral of V^2 from T w'' = -q - sum P delta, integrated on a fine grid."""
    x = np.linspace(0.0, length, n)
    load_left_of = line_load * x + np.sum(np.where(x[:, None] > places, loads, 0.0), axis=1)
    moment = np.concatenate(([0.0], np.cumsum((load_left_of[1:] + load_left_of[:-1]) / 2.0 * np.diff(x))))
    reaction = moment[-1] / length
    shear = reaction - load_left_of
    return (reaction * length / 2.0 - np.interp(length / 2.0, x, moment)) / tension, np.trapezoid(shear**2, x)


def test_parabola_of_the_textbook():
    """A clothesline: 0.1 kg/m over 10 m at 100 N sags by q l^2 / 8 T = 12.3 cm."""
    assert midspan_sag(100.0, 10.0, 0.981, NONE, NONE) == pytest.approx(0.1226, abs=5e-5)


def test_weight_at_midspan_sags_by_a_quarter_of_load_times_length_over_tension():
    assert midspan_sag(100.0, 10.0, 0.0, np.array([5.0]), np.array([20.0])) == 20.0 * 10.0 / (4.0 * 100.0)


def test_weights_may_stand_anywhere():
    """Against the integrated equation of the string; the grid resolves a point load to 1/n."""
    places, loads = np.array([1.0, 2.5, 7.7]), np.array([3.0, 11.0, 5.0])
    sag, squared = solved_string(100.0, 10.0, 2.0, places, loads)
    assert midspan_sag(100.0, 10.0, 2.0, places, loads) == pytest.approx(sag, rel=1e-4)
    assert squared_shear(10.0, 2.0, places, loads) == pytest.approx(squared, rel=1e-4)


def test_squared_shear_of_a_uniform_load_is_a_twelfth():
    assert squared_shear(10.0, 2.0, NONE, NONE) == pytest.approx((2.0 * 10.0) ** 2 / 12.0 * 10.0, rel=1e-15)


@given(irvine=st.floats(0.0, 1e12))
def test_raised_tension_solves_its_cubic(irvine):
    """H = T0 + K V^2 / (2 H^2), that is h^3 - h^2 = lambda^2 / 24."""
    h = tension_with_sag(1.0, irvine)
    assert h**3 - h**2 == pytest.approx(irvine / 24.0, rel=1e-9, abs=1e-7 * max(irvine, 1e-8))


def test_straight_string_keeps_its_tension():
    assert tension_with_sag(7.0, 0.0) == pytest.approx(7.0, rel=1e-15)


def loose_span(slackness):
    """Configuration 1 of the dissertation under the gravity that makes its Irvine parameter `slackness`."""
    drive = load_drive("dissertation-1")
    cable = drive.cable
    weight = np.sqrt(slackness * cable.pretension**3 / (cable.axial_rigidity * (1.0 + cable.prestrain)))
    gravity = weight / (cable.mass_per_length * drive.span_length)
    return replace(drive, layout=replace(drive.layout, gravity=gravity))


def string_of(drive):
    cable, length = drive.cable, drive.pulley_distance
    load = length, cable.stretched_mass_per_length * drive.layout.gravity, NONE, NONE
    stiffness = cable.axial_rigidity * (1.0 + cable.prestrain)
    irvine = irvine_parameter(stiffness, cable.pretension, squared_shear(*load) / length)
    tension = tension_with_sag(cable.pretension, irvine)
    return irvine, tension, midspan_sag(tension, *load)


@pytest.mark.parametrize("slackness", [1e-6, 1.0, 40.0, 1e4])
def test_closed_form_is_the_parabola_of_the_span(slackness):
    """The same equation as in `parabola_sag`, there solved by iteration."""
    drive = loose_span(slackness)
    irvine, tension, sag = string_of(drive)
    assert irvine == pytest.approx(slackness, rel=1e-12)
    assert tension == pytest.approx(parabola_sag(drive).horizontal_tension, rel=1e-12)
    assert sag == pytest.approx(parabola_sag(drive).midpoint, rel=1e-12)


def test_shallow_sag_is_the_limit_of_the_elastic_catenary():
    """Halving the weight divides the difference by four: the parabola neglects the square of the slope."""
    drives = [loose_span(slackness) for slackness in (4e-2, 1e-2, 2.5e-3)]  # the weight halved each time
    errors = np.array([string_of(drive)[2] / catenary_sag(drive).midpoint - 1.0 for drive in drives])
    assert errors[:-1] / errors[1:] == pytest.approx([4.0, 4.0], rel=0.02), f"errors {errors}"


def test_inextensible_chain_is_the_catenary_of_the_textbook():
    """T >> weight: d = H/q (cosh(q l / 2 H) - 1) differs from q l^2 / 8 H by (q l / 2 H)^2 / 12."""
    q, length, tension = 2.0, 10.0, 100.0
    a = q * length / (2.0 * tension)
    catenary = tension / q * (cosh(a) - 1.0)
    assert catenary / midspan_sag(tension, length, q, NONE, NONE) - 1.0 == pytest.approx(
        a**2 / 12.0, rel=1e-3
    )


def test_crossover_of_irvine_is_at_four_pi_squared():
    """tan(x) = x - 4 x^3 / lambda^2 with x = omega / 2 omega_1 * pi: at lambda^2 = 4 pi^2 the root is pi."""
    irvine, x = 4.0 * pi**2, pi
    assert np.tan(x) == pytest.approx(x - 4.0 * x**3 / irvine, abs=1e-12)
