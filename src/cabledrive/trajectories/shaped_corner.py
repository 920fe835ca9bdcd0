r"""How far a shaper rounds the corners of a path: its smoothing, and the acceleration that keeps it small.

After Klipper's documentation [1]_: the motion about its mean delay :math:`\bar t` deviates from the path, at
a reversal under the acceleration a by :math:`\tfrac a2\sum A_i(t_i - \bar t)^2`, at a right angle passed at
the square-corner speed v by
:math:`\sqrt2\sum_{t_i>\bar t} A_i\,(v + \tfrac a2 (t_i - \bar t))(t_i - \bar t)`.

.. [1] Klipper documentation, "Measuring resonances", https://www.klipper3d.org/Measuring_Resonances.html
"""

from math import sqrt

import numpy as np

from cabledrive.trajectories.input_shaping import InputShaper

ACCELERATION = 5.0
"""At which smoothing is stated [m/s^2]."""
CORNER_SPEED = 0.005
"""Square-corner speed, where none is given [m/s]."""
LARGEST_SMOOTHING = 0.12e-3
"""Smoothing up to which the highest acceleration is recommended [m]."""


def smoothing(
    shaper: InputShaper, acceleration: float = ACCELERATION, corner_speed: float = CORNER_SPEED
) -> float:
    """Largest deviation from the path that a shaper causes at a corner.

    Parameters
    ----------
    shaper : InputShaper
    acceleration : float, default 5.0
        Of the motion [m/s^2].
    corner_speed : float, default 0.005
        At which a right angle is passed [m/s].

    Returns
    -------
    float
        Deviation [m].
    """
    first, later, second = _moments(shaper)
    square = sqrt(2.0) * (corner_speed * first + 0.5 * acceleration * later)
    return max(square, 0.5 * acceleration * second)


def highest_acceleration(
    shaper: InputShaper, corner_speed: float = CORNER_SPEED, largest: float = LARGEST_SMOOTHING
) -> float:
    """Largest acceleration whose smoothing stays within a bound; both deviations are linear in it.

    Parameters
    ----------
    shaper : InputShaper
    corner_speed : float, default 0.005
        At which a right angle is passed [m/s].
    largest : float, default 0.12e-3
        Largest smoothing [m].

    Returns
    -------
    float
        Acceleration [m/s^2]; 0 where the corner speed alone takes more than the bound.
    """
    first, later, second = _moments(shaper)
    square = 2.0 * (largest / sqrt(2.0) - corner_speed * first) / later
    return max(0.0, min(square, 2.0 * largest / second))


def _moments(shaper: InputShaper) -> tuple[float, float, float]:
    """About the mean delay: first [s] and second [s^2] of the later impulses, second of all."""
    distance = shaper.times - shaper.delay
    later = distance > 0.0
    weighted = shaper.amplitudes * distance
    return (
        float(np.sum(weighted[later])),
        float(np.sum((weighted * distance)[later])),
        float(weighted @ distance),
    )
