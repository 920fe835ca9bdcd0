"""Sag of a span between held ends, and of a taut string under weights that hang on it."""

from math import acosh, cosh

import numpy as np

from cabledrive.parameters.arrays import Array


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
