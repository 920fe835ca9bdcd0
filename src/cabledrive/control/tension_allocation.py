r"""Tensions of two lines that give a body a force, inside their limits, as near as can be to those preferred.

.. math:: \min_{T_{low} \le T \le T_{high}} \; |M^{-1}(J^T T + F)|^2 + \epsilon\,|T - T_p|^2

Two unknowns in a box: the minimum lies inside, on an edge or at a corner, and every one of the nine is tried.
Where the machine has one coordinate, the second term decides the internal tension; where it has two, it has
no say unless both lines come to lie along each other.
"""

from cabledrive.mechanics.compiled import njit
from cabledrive.parameters.arrays import Array

PREFERENCE = 1e-8
"""Weight of the preferred tensions, over that of the largest acceleration per tension."""


@njit
def allocate(
    force: Array, mass: Array, along: Array, low: Array, high: Array, preferred: Array, tension: Array
) -> None:
    """Write the tensions into ``tension``, shape (2,) [N].

    ``force``, ``mass``, shape (m,): to be given to the body; ``along``, shape (2, m): dL/dq; ``low``,
    ``high``, ``preferred``, shape (2,) [N].
    """
    a, b, c, g, h, top = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(force.size):
        u, v = along[0, j] / mass[j], along[1, j] / mass[j]
        w = force[j] / mass[j] + u * preferred[0] + v * preferred[1]
        a += u * u
        b += u * v
        c += v * v
        g -= u * w
        h -= v * w
        top = max(top, u * u, v * v)
    # Unknown is the distance from the preferred tensions: no digits are lost where they are right.
    a, c = a + PREFERENCE * top, c + PREFERENCE * top
    x0, x1 = low[0] - preferred[0], high[0] - preferred[0]
    y0, y1 = low[1] - preferred[1], high[1] - preferred[1]
    # Minimum of a x^2 / 2 + b x y + c y^2 / 2 - g x - h y over the box.
    scale = a * c - b * b
    best_x, best_y = (g * c - h * b) / scale, (a * h - b * g) / scale
    if not (x0 <= best_x <= x1 and y0 <= best_y <= y1):
        best = 1e300
        for side in range(4):
            if side < 2:
                x = x0 if side == 0 else x1
                y = min(max((h - b * x) / c, y0), y1)
            else:
                y = y0 if side == 2 else y1
                x = min(max((g - b * y) / a, x0), x1)
            cost = 0.5 * a * x * x + b * x * y + 0.5 * c * y * y - g * x - h * y
            if cost < best:
                best, best_x, best_y = cost, x, y
    tension[0], tension[1] = preferred[0] + best_x, preferred[1] + best_y
