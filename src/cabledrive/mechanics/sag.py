"""Sag of a span between held ends, and of a taut string under weights that hang on it."""

from collections.abc import Callable
from dataclasses import dataclass
from math import acosh, cosh

import numpy as np

from cabledrive.parameters.arrays import Array
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


def midspan_sag(tension: float, length: float, line_load: float, places: Array, loads: Array) -> float:
    r"""Sag at midspan: a parabola, and a triangle for each weight.

    .. math:: d = \frac{q l^2}{8 T} + \sum_i \frac{P_i \min(x_i, l - x_i)}{2 T}

    ``tension``: tension T [N], the same everywhere; ``length``: distance l of the two held ends [m];
    ``line_load``: weight across the string per length q [N/m]; ``places``, shape (n,): places x_i of the
    weights from one end [m]; ``loads``, shape (n,): weights P_i across the string [N].
    Returns sag [m].
    """
    bend = line_load * length**2 / 8.0 + float(loads @ np.minimum(places, length - places)) / 2.0
    return bend / tension


def squared_shear(length: float, line_load: float, places: Array, loads: Array) -> float:
    r"""Integral of the squared transverse force along the string, exact.

    The transverse force :math:`V = T w'` does not depend on the tension; it falls by q per metre and by P_i
    at each weight. A piece of length h between V_a and V_b adds :math:`h\,(V_a^2 + V_a V_b + V_b^2)/3`.

    ``length``: distance l of the two held ends [m]; ``line_load``: weight across the string per length q
    [N/m]; ``places``, shape (n,): places x_i of the weights from one end, ascending [m]; ``loads``, shape
    (n,): weights P_i across the string [N].
    Returns the integral of V^2 [N^2 m].
    """
    reaction = line_load * length / 2.0 + float(loads @ (1.0 - places / length))
    ends = np.concatenate(([0.0], places, [length]))
    start = reaction - line_load * ends[:-1] - np.concatenate(([0.0], np.cumsum(loads)))
    pieces = np.diff(ends)
    end = start - line_load * pieces
    return float(pieces @ (start**2 + start * end + end**2)) / 3.0


def irvine_parameter(stiffness: float, tension: float, mean_squared_shear: float) -> float:
    r"""Irvine's parameter: how much the sag stiffens the string, for any distribution of weight.

    .. math:: \lambda^2 = \frac{12\,K\,\overline{V^2}}{T_0^3}

    With q alone, :math:`\overline{V^2} = (q l)^2/12`, this is the usual :math:`(q l/T_0)^2\,K/T_0`. A string
    is straight while it is far below 1; at :math:`4\pi^2` the first symmetric mode in the plane of sag has
    risen to the frequency of the first antisymmetric one.

    ``stiffness``: force per strain K of the pretensioned string, EA (1 + eps0) [N]; ``tension``: tension T0
    of the straight string [N]; ``mean_squared_shear``: `squared_shear` over the length [N^2].

    References
    ----------
    .. [1] H. M. Irvine, *Cable Structures*, MIT Press, 1981, chapters 2 and 3.
    """
    return 12.0 * stiffness * mean_squared_shear / tension**3


def tension_with_sag(tension: float, irvine: float) -> float:
    r"""Tension of a string between held ends after its own sag has stretched it.

    The sag lengthens the string by :math:`\tfrac12\int w'^2\,dx`, so that the tension H solves
    :math:`H = T_0 + K\,\overline{V^2}/(2 H^2)`, a cubic with one positive root,

    .. math:: \frac{H}{T_0} =
              \frac13\Big(1 + 2\cosh\big(\tfrac13\,\mathrm{arcosh}(1 + \tfrac{9}{16}\lambda^2)\big)\Big)

    ``tension``: tension T0 of the straight string [N]; ``irvine``: `irvine_parameter`, lambda^2.
    Returns tension H [N].
    """
    return tension * (1.0 + 2.0 * cosh(acosh(1.0 + 0.5625 * irvine) / 3.0)) / 3.0
