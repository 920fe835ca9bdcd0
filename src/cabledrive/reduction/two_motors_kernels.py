r"""A body between two motors, each pulling through its own line: elongations and forces, compiled.

With the body's coordinates q and the drums' angles :math:`\theta_i` (positive: winding in) the tension is

.. math:: T_i = c_i\,e_i, \qquad e_i = L_i(q) + r_i\theta_i - s_i, \qquad c_i = \frac{EA_i}{\ell_i(q)},

:math:`L_i` the length of line i from its drum to the body, arcs included, :math:`\ell_i` its free part.
"""

from math import atan2, sqrt
from typing import NamedTuple

from cabledrive.mechanics.compiled import njit
from cabledrive.parameters.arrays import Array


class TwoMotors(NamedTuple):
    """Numbers of a machine with m coordinates and two motors, in SI; rows by motor."""

    mass: Array  # (m,): of each coordinate [kg]
    force: Array  # (m,): weight and loads [N]
    viscous: Array  # (m,)
    coulomb: Array  # (m,)
    frame: Array  # (2, m): motion of the anchors in x and y
    centre: Array  # (2, 2): of the last pulley before the body [m]
    radius: Array  # (2,): of that pulley, with the sense of the cable as its sign [m]
    anchor: Array  # (2, 2): where each line ends at q = 0 [m]
    bearing: Array  # (2, 2): unit vector along each line at q = 0
    fixed: Array  # (2,): free length before the last pulley [m]
    unwound: Array  # (2,): s at theta = 0 [m]
    rigidity: Array  # (2,): EA [N]
    loss: Array  # (2,): axial damping [N s]
    drum: Array  # (2,): radius [m]
    inertia: Array  # (2,): of the drum and all that turns with it [kg m^2]
    turning_viscous: Array  # (2,)
    turning_coulomb: Array  # (2,)
    limit: Array  # (2,): of the torque [N m]


@njit
def line_at(m: TwoMotors, i: int, q: Array, along: Array) -> tuple[float, float, float]:
    """Length of line i less that at q = 0, its free length, that of its last span [m]; along takes dL/dq."""
    x, y = m.anchor[i, 0] - m.centre[i, 0], m.anchor[i, 1] - m.centre[i, 1]
    before = sqrt(x * x + y * y - m.radius[i] ** 2)
    for j in range(q.size):
        x += m.frame[0, j] * q[j]
        y += m.frame[1, j] * q[j]
    squared = x * x + y * y
    span = sqrt(squared - m.radius[i] ** 2)
    # Unit vector of the tangent: turned from the line of centres by the angle whose sine is radius/distance.
    tx = (span * x - m.radius[i] * y) / squared
    ty = (span * y + m.radius[i] * x) / squared
    ax, ay = m.bearing[i, 0], m.bearing[i, 1]
    turned = atan2(ax * ty - ay * tx, ax * tx + ay * ty)  # both ways up to half a turn
    for j in range(q.size):
        along[j] = tx * m.frame[0, j] + ty * m.frame[1, j]
    return span - before + m.radius[i] * turned, m.fixed[i] + span, span


@njit
def pulled(stretch: float, speed: float, stiffness: float, loss: float) -> float:
    """Tension of a line that only pulls [N]; ``speed``: at which it is stretched [m/s]."""
    return max(stiffness * stretch + loss * speed, 0.0) if stretch > 0.0 else 0.0
