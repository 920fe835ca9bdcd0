"""Sag of the elastic catenary, exact for a cable of Hooke's law (Irvine, Cable Structures, section 2.3)."""

from math import asinh, hypot

from scipy.optimize import brentq

from cabledrive.mechanics.sag import Sag


def catenary_sag(drive):
    """Of a level span without carriages: L_e = H L / EA + 2 H L / P arsinh(P / 2H) gives the tension H."""
    cable, length = drive.cable, drive.span_length
    weight = cable.mass_per_length * drive.layout.gravity * length
    rigidity = cable.axial_rigidity
    if weight == 0.0:
        return Sag(midpoint=0.0, horizontal_tension=cable.pretension)

    def too_long(tension):
        arc = 2.0 * tension * length / weight * asinh(weight / (2.0 * tension))
        return tension * length / rigidity + arc - drive.pulley_distance

    tension = brentq(too_long, 1e-9 * weight, rigidity + weight, xtol=1e-300, rtol=9e-16)
    half = weight / (2.0 * tension)
    dip = tension * length / weight * half**2 / (hypot(1.0, half) + 1.0)
    return Sag(midpoint=dip + weight * length / (8.0 * rigidity), horizontal_tension=tension)
