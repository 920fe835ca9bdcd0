"""Sag and tension along a level span in closed form (Irvine, Cable Structures, section 2.3)."""

from math import asinh, hypot
from typing import NamedTuple

from scipy.optimize import brentq


class Sag(NamedTuple):
    midpoint: float
    horizontal_tension: float


def root(function, low, high):
    return brentq(function, low, high, xtol=1e-300, rtol=9e-16)


def parabola_sag(drive):
    """A parabola stretched by its own sag, limit of the consistent weak law: H = T0 + K/24 (q L_e / H)^2."""
    cable, length = drive.cable, drive.pulley_distance
    weight = cable.stretched_mass_per_length * drive.layout.gravity_across * length
    stiffness = (cable.axial_rigidity + cable.pretension) / 24.0 * weight**2
    highest = cable.pretension + stiffness ** (1.0 / 3.0)
    tension = root(lambda h: h - cable.pretension - stiffness / h**2, cable.pretension, highest)
    return Sag(weight * length / (8.0 * tension), tension)


def catenary_sag(drive):
    """The elastic catenary: L_e = H L / EA + 2 H L / P arsinh(P / 2H) gives the tension H."""
    cable, length = drive.cable, drive.span_length
    weight = cable.mass_per_length * drive.layout.gravity * length
    rigidity = cable.axial_rigidity

    def too_long(tension):
        arc = 2.0 * tension * length / weight * asinh(weight / (2.0 * tension))
        return tension * length / rigidity + arc - drive.pulley_distance

    tension = root(too_long, 1e-9 * weight, rigidity + weight)
    half = weight / (2.0 * tension)
    dip = tension * length / weight * half**2 / (hypot(1.0, half) + 1.0)
    return Sag(dip + weight * length / (8.0 * rigidity), tension)
