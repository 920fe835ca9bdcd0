r"""The equations of motion of the cable written out in u', u'', ..., as the dissertation prints them.

They hold the same mechanics as `CableLaw.components`, differentiated by hand; the node-centred scheme uses
them. Arguments are the gradients ``(u', v', w')`` [-], the second derivatives ``(u'', v'', w'')`` [1/m], and
the squares of the wave speeds, :math:`c_u^2 = EA\,(1 + \epsilon_0)/\rho` and :math:`c_w^2 = T_0/\rho`
[m^2/s^2]; accelerations come without gravity and without damping [m/s^2], taut or not.
"""

from math import pi, sqrt

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw, Components


def longitudinal_acceleration(first: Components, second: Components, c_u2: float, c_w2: float) -> Array:
    r"""Longitudinal acceleration of the exact cable, F of Eq. (2.15).

    With :math:`D = (1 + u')u'' + v'v'' + w'w''`,

    .. math:: \ddot u = \frac{u'' c_w^2 + c_u^2 (1 + u') \frac{D}{\lambda + 1}}{\lambda + 1}
              + \frac{c_u^2 u'' \lambda}{\lambda + 1}
              - \frac{(1 + u') D (c_w^2 + c_u^2 \lambda)}{(\lambda + 1)^3}
    """
    return _exact(0, first, second, c_u2, c_w2)


def transverse_accelerations(
    first: Components, second: Components, c_u2: float, c_w2: float
) -> tuple[Array, Array]:
    r"""Transverse accelerations of the exact cable, G and H of Eqs. (2.16) and (2.17).

    As `longitudinal_acceleration`, with :math:`v', v''` (:math:`w', w''`) in the places of
    :math:`1 + u', u''` outside of :math:`D`.
    """
    return _exact(1, first, second, c_u2, c_w2), _exact(2, first, second, c_u2, c_w2)


def _exact(axis: int, first: Components, second: Components, c_u2: float, c_w2: float) -> Array:
    along = (1.0 + first[0], first[1], first[2])
    slope, curvature = along[axis], second[axis]
    stretch = np.sqrt(along[0] ** 2 + along[1] ** 2 + along[2] ** 2)  # lambda + 1
    d = along[0] * second[0] + along[1] * second[1] + along[2] * second[2]
    total = (curvature * c_w2 + c_u2 * slope * d / stretch) / stretch + c_u2 * curvature * (
        stretch - 1
    ) / stretch
    return total - slope * d * (c_w2 + c_u2 * (stretch - 1)) / stretch**3


def weak_accelerations(first: Components, second: Components, c_u2: float, c_w2: float) -> Components:
    r"""Accelerations of the weakly nonlinear cable as printed, Eqs. (2.23)-(2.25).

    .. math:: \ddot u = c_u^2 \lambda' \frac{1 + u'}{1 + \lambda}
              + (c_w^2 + c_u^2 \lambda)\,\frac{(1 + \lambda) u'' - (1 + u') \lambda'}{(1 + \lambda)^2},
              \qquad \lambda = u' + \tfrac12 (v'^2 + w'^2)

    and the same with :math:`v', v''` and :math:`w', w''` in the places of :math:`1 + u', u''`.
    """
    strain, strain_x = _weak_strain(first, second)
    u, v, w = (
        c_u2 * strain_x * slope / (1.0 + strain)
        + (c_w2 + c_u2 * strain) * ((1.0 + strain) * curvature - slope * strain_x) / (1.0 + strain) ** 2
        for slope, curvature in zip((1.0 + first[0], first[1], first[2]), second, strict=True)
    )
    return u, v, w


def consistent_weak_accelerations(
    first: Components, second: Components, c_u2: float, c_w2: float
) -> Components:
    r"""Accelerations of the weakly nonlinear cable with a potential.

    .. math:: \ddot u = c_u^2 \lambda', \qquad
              \ddot v = c_u^2 \lambda' v' + (c_w^2 + c_u^2 \lambda)\,v'', \qquad
              \ddot w = c_u^2 \lambda' w' + (c_w^2 + c_u^2 \lambda)\,w''
    """
    strain, strain_x = _weak_strain(first, second)
    v, w = (c_u2 * strain_x * first[k] + (c_w2 + c_u2 * strain) * second[k] for k in (1, 2))
    return c_u2 * strain_x, v, w


def _weak_strain(first: Components, second: Components) -> tuple[Array, Array]:
    """Strain (2.19) and its derivative along the cable."""
    (u_x, v_x, w_x), (u_xx, v_xx, w_xx) = first, second
    return u_x + 0.5 * (v_x**2 + w_x**2), u_xx + v_x * v_xx + w_x * w_xx


def linear_accelerations(first: Components, second: Components, c_u2: float, c_w2: float) -> Components:
    """Accelerations of the linear cable, Eqs. (3.7) and (3.8) without gravity; the gradients are not used."""
    return c_u2 * second[0], c_w2 * second[1], c_w2 * second[2]


def lateral_frequency(mass: float, tension: float, before: float, after: float, cable: float = 0.0) -> float:
    r"""Frequency across of a mass [kg] that hangs between two held points, Eqs. (3.33)-(3.35) [Hz].

    ``before``, ``after``: stretched lengths to them [m]; ``cable``: mass between them, a third of which
    moves, Eq. (M.8): :math:`m\omega = c_w\rho(\cot\alpha_1 + \cot\alpha_2)` to first order in the phases.
    """
    return sqrt(tension * (1.0 / before + 1.0 / after) / (mass + cable / 3.0)) / (2.0 * pi)


def accelerations(law: CableLaw, density: float, first: Components, second: Components) -> Components:
    """Accelerations of u, v and w by a cable law, written out; ``density`` per pretensioned metre [kg/m]."""
    speeds = law.stiffness / density, law.pretension / density
    if law.name == "exact":
        v, w = transverse_accelerations(first, second, *speeds)
        return longitudinal_acceleration(first, second, *speeds), v, w
    written_out = {
        "weak": weak_accelerations,
        "weak-consistent": consistent_weak_accelerations,
        "linear": linear_accelerations,
    }
    return written_out[law.name](first, second, *speeds)
