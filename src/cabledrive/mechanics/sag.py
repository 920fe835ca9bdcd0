r"""Sag of a span between held ends, in closed form."""

from collections.abc import Callable
from dataclasses import dataclass
from math import asinh, hypot

from cabledrive.parameters.drive import Drive


@dataclass(frozen=True, slots=True, kw_only=True)
class Sag:
    """Shape of a span under its own weight."""

    midpoint: float  # sag of the midpoint [m]
    horizontal_tension: float  # horizontal component of the tension, the same along the span [N]


def parabola_sag(drive: Drive) -> Sag:
    r"""Sag of the shallow span: a parabola, its tension raised by its own stretch.

    .. math:: d = \frac{\rho g L_e^2}{8H}, \qquad
              H = T_0 + K \frac{1}{L_e}\int_0^{L_e} \tfrac12 w'^2\,dx
                = T_0 + \frac{K}{24}\Big(\frac{\rho g L_e}{H}\Big)^2

    This is the static limit of `ConsistentWeakLaw`. On a slope the part of the weight across the span counts,
    and H is the tension along it.

    ``drive``: without carriages on the span.
    """
    cable, length = drive.cable, drive.pulley_distance
    weight = cable.stretched_mass_per_length * drive.layout.gravity_across * length
    stiffness = cable.axial_rigidity + cable.pretension
    if weight == 0.0:
        return Sag(midpoint=0.0, horizontal_tension=cable.pretension)

    def _excess(tension: float) -> float:
        return tension - cable.pretension - stiffness / 24.0 * (weight / tension) ** 2

    highest = cable.pretension + (stiffness * weight**2 / 24.0) ** (1.0 / 3.0)
    tension = _root(_excess, cable.pretension, highest)
    return Sag(midpoint=weight * length / (8.0 * tension), horizontal_tension=tension)


def catenary_sag(drive: Drive) -> Sag:
    r"""Sag of the elastic catenary, exact for a cable of Hooke's law.

    With the weight :math:`P = \rho_0 g L` of the span and unstretched length :math:`L`, the tension H solves

    .. math:: L_e = \frac{H L}{EA} + \frac{2 H L}{P}\,\mathrm{arsinh}\frac{P}{2H}, \qquad
              d = \frac{H L}{P}\Big(\sqrt{1 + \big(\tfrac{P}{2H}\big)^2} - 1\Big) + \frac{P L}{8\,EA}

    ``drive``: level, without carriages on the span.

    References
    ----------
    .. [1] H. M. Irvine, *Cable Structures*, MIT Press, 1981, section 2.3.
    """
    cable, length = drive.cable, drive.span_length
    weight = cable.mass_per_length * drive.layout.gravity * length
    rigidity = cable.axial_rigidity
    if weight == 0.0:
        return Sag(midpoint=0.0, horizontal_tension=cable.pretension)

    def _too_long(tension: float) -> float:
        arc = 2.0 * tension * length / weight * asinh(weight / (2.0 * tension))
        return tension * length / rigidity + arc - drive.pulley_distance

    tension = _root(_too_long, 1e-9 * weight, rigidity + weight)
    half = weight / (2.0 * tension)
    dip = tension * length / weight * half**2 / (hypot(1.0, half) + 1.0)
    return Sag(midpoint=dip + weight * length / (8.0 * rigidity), horizontal_tension=tension)


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Root of a function that is negative below it, by bisection to the last bit."""
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return middle
        if function(middle) < 0.0:
            low = middle
        else:
            high = middle
