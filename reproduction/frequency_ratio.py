r"""Ratio of the lowest transverse frequency to that of the pulleys against each other, in closed form.

The characteristic equation (5.4) has poles and an unwanted root at zero. Cleared of its fraction it reads
:math:`(\chi_1\chi_2 x^2 - 1)\sin x = (\chi_1 + \chi_2)\,x\cos x` with :math:`x = \omega L_e/c_u`, and this is
the tangent of a sum of two angles:

.. math:: x = (n - 1)\pi + \operatorname{arccot}(\chi_1 x) + \operatorname{arccot}(\chi_2 x), \quad n \ge 1

Each pulley turns the phase of the wave by an angle that falls from :math:`\pi/2` to 0 as its mass grows. The
left side rises, the right side falls: exactly one root for each n, without poles, for any mass from none to
infinite.
"""

from math import pi

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array


def mass_ratios(drive: Drive) -> tuple[float, float]:
    r"""Rim mass of each pulley over the mass of the cable, :math:`\chi_i = J_i/(2\rho r_i^2 L_e)`."""
    cable = 2.0 * drive.cable.mass_per_length * drive.span_length
    return drive.drive_pulley.rim_mass / cable, drive.load_pulley.rim_mass / cable


def pulley_phase(chi1: ArrayLike, chi2: ArrayLike, n: int = 1) -> Array:
    r"""Phase :math:`x = \omega L_e/c_u` of the n-th mode of the pulleys against each other, Eq. (A.1).

    The mass ratios may be anything from zero to infinity. Returns phases in :math:`((n - 1)\pi, n\pi]` [rad].
    """

    def phase(one: float, two: float) -> float:
        def excess(x: float) -> float:
            return x - (n - 1) * pi - float(_angle(one, x) + _angle(two, x))

        return float(brentq(excess, (n - 1) * pi, n * pi, xtol=1e-300, rtol=1e-15))

    one, two = (np.minimum(np.asarray(chi, dtype=float), 1e200) for chi in (chi1, chi2))
    return np.asarray(np.vectorize(phase, otypes=[float])(one, two))


def _angle(chi: ArrayLike, x: ArrayLike) -> Array:
    """Arccot of chi x, from pi/2 (no mass) to 0 (held)."""
    return np.arctan2(1.0, np.multiply(chi, x))


def frequency_ratio(chi1: ArrayLike, chi2: ArrayLike, prestrain: ArrayLike) -> Array:
    r"""Lowest transverse frequency over that of the pulley mode: the surfaces of Fig. 5.2, Eqs. (5.1), (5.4).

    .. math:: \gamma = \frac{\pi c_w}{c_u\,x(\chi_1, \chi_2)}, \qquad
              \frac{c_w}{c_u} = \sqrt{\frac{\varepsilon_0}{1 + \varepsilon_0}}

    with the strain under the pretension, T0 / EA; one half at the 1:2 resonance of chapter 5.
    """
    return np.asarray(pi * _wave_speeds(prestrain) / pulley_phase(chi1, chi2))


def _wave_speeds(prestrain: ArrayLike) -> Array:
    """Transverse over longitudinal wave speed, c_w / c_u."""
    strain = np.asarray(prestrain, dtype=float)
    return np.asarray(np.sqrt(strain / (1.0 + strain)))


def resonant_load_ratio(chi1: ArrayLike, prestrain: ArrayLike) -> Array:
    r"""Contours of Fig. 5.3: the load pulley that makes the frequency ratio one half, Eq. (A.2).

    A given ratio needs no solving: with :math:`x = \pi c_w/(\gamma c_u)`

    .. math:: \chi_2 = \frac{x\cos x\,\chi_1 + \sin x}{x\,(\chi_1 x\sin x - \cos x)}, \qquad
              \chi_1 > \frac{1}{x\tan x}.

    Returns the mass ratio of the load pulley; NaN where none makes this ratio.
    """
    x, chi1 = np.asarray(2 * pi * _wave_speeds(prestrain)), np.asarray(chi1, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        chi2 = 1.0 / (x * np.tan(x - _angle(chi1, x)))
    return np.where((x < pi) & (x - _angle(chi1, x) > 0.0) & (chi2 >= 0.0), chi2, np.nan)
