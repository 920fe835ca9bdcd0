r"""Free exchange of energy between the spans through the pulleys, in closed form.

Two plucks a > b in one plane, no damping, tuned: with A, B the amplitudes of the spans, AB stays and half the
logarithm of A/B swings in a well of hyperbolic cosine. The spans swap their amplitudes and swap them back.
"""

import numpy as np

from cabledrive.parameters import InputRefused
from cabledrive.reduction.autoparametric import AutoparametricModel
from cabledrive.reduction.averaging import averaged_coefficients


def exchange_period(model: AutoparametricModel, first: float, second: float) -> float:
    r"""Time in which two unequal plucks swap and swap back, Eq. (A.30).

    .. math:: T = \frac{2K(m)}{\sqrt{\alpha k\,ab}}, \qquad m = -\frac{(a - b)^2}{4ab}

    with the complete elliptic integral K of parameter m.

    ``model``: tuned; its dampings and detunings are left out; ``first``, ``second``: plucks a and b [m].
    Returns [s]; infinite where one span alone was plucked, all its energy ending in the pulleys.
    Raises `InputRefused` if the plucks are equal: nothing is exchanged.
    """
    from scipy.special import ellipk

    a, b = abs(first), abs(second)
    if a == b:
        raise InputRefused(f"plucks of {a:.6g} m on both spans are equal: nothing is exchanged, give two")
    if a * b == 0.0:
        return float("inf")
    c = averaged_coefficients(model)
    rate = float(np.sqrt(c.feedback[0] * c.pump[0] * a * b))
    return float(2.0 * ellipk(-((a - b) ** 2) / (4 * a * b)) / rate)


def largest_exchange(model: AutoparametricModel, first: float, second: float) -> float:
    r"""Largest displacement of the pulley mode while two plucks swap, Eq. (A.31).

    .. math:: q_{\max} = \sqrt{\frac{m_t}{4M}}\,|a - b|

    ``model``: tuned, undamped; ``first``, ``second``: plucks a and b [m].
    Returns [m], twice per period, when both spans swing alike.
    """
    return float(np.sqrt(model.transverse_mass[0] / (4 * model.modal_mass)) * abs(abs(first) - abs(second)))
