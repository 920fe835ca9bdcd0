"""Regressors that a rigid axis with Coulomb friction does not need: where they help, the model is wrong."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.axis_equation import AxisEquation, filtered
from cabledrive.identification.filters import difference, zero_phase
from cabledrive.parameters import InputRefused

Array = NDArray[np.float64]


def extra_column(
    name: str,
    position: Array,
    torque: Array,
    speed: Array,
    sign: Array,
    equation: AxisEquation,
    interval: float,
) -> Array:
    """A regressor that a rigid axis with Coulomb friction does not need.

    Parameters
    ----------
    name : str
        "delay", "flexibility", "asymmetry", "stribeck:SPEED", "slope:K", "backlash:ANGLE".
    position, torque, speed, sign : ndarray, shape (samples,)
        The sign is the direction of the friction.
    equation : AxisEquation
    interval : float

    Returns
    -------
    ndarray, shape (samples,)

    Raises
    ------
    InputRefused
        If the name is unknown.
    """
    kind, _, value = name.partition(":")
    if kind == "delay":
        return difference(filtered(torque, equation, interval), interval)
    if kind == "flexibility":
        smooth = filtered(position, equation, interval)
        for _ in range(4):
            smooth = difference(smooth, interval)
        return smooth
    if kind == "asymmetry":
        return filtered(np.abs(speed), equation, interval)
    if kind == "stribeck":
        return filtered(sign * np.exp(-((speed / float(value)) ** 2)), equation, interval)
    if kind == "slope":
        return filtered(np.tanh(float(value) * speed) - sign, equation, interval)
    if kind == "backlash":
        return backlash_column(position, speed, float(value), equation, interval)
    raise InputRefused(f'regressor "{name}" is unknown')


def backlash_column(
    position: Array, speed: Array, gap: float, equation: AxisEquation, interval: float
) -> Array:
    """Acceleration while the load is loose: from where its drive changes sides until the gap is crossed.

    Parameters
    ----------
    position, speed : ndarray, shape (samples,)
    gap : float
        Assumed free play [rad].
    equation : AxisEquation
    interval : float

    Returns
    -------
    ndarray, shape (samples,)
    """
    acceleration = difference(
        difference(zero_phase(position, interval, 3 * equation.bandwidth), interval), interval
    )
    turns = np.flatnonzero(np.diff(np.sign(acceleration)) != 0)
    free = np.zeros(position.size)
    for start, end in pairwise([*turns, position.size - 1]):
        # The load keeps its speed; the motor leaves it by the difference of the two.
        away = (
            position[start : end + 1] - position[start] - speed[start] * interval * np.arange(end + 1 - start)
        )
        free[start : start + int(np.argmax(np.abs(away) > gap) or away.size)] = 1.0
    return filtered(free * acceleration, equation, interval)
