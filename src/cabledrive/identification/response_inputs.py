"""From a log to the input and output of a response: friction and offset taken off, speed from an angle."""

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.filters import difference, zero_phase
from cabledrive.identification.logs.log import Log
from cabledrive.parameters import InputRefused

Array = NDArray[np.float64]


def compensated_torque(
    torque: Array, speed: Array, coulomb: float, offset: float, slope: float = 0.0
) -> Array:
    r"""Torque without Coulomb friction and offset, the input of the transfer functions.

    .. math:: \tau_c = \tau - c_1 S(\dot\theta) + d_1

    Parameters
    ----------
    torque, speed : ndarray, shape (samples,)
        [N m], [rad/s].
    coulomb, offset : float
        [N m].
    slope : float, default 0.0
        K of a smooth friction tanh(K w) [s/rad]; 0: its sign.

    Returns
    -------
    ndarray, shape (samples,)
    """
    level = np.tanh(slope * speed) if slope > 0.0 else np.sign(speed)
    return torque - coulomb * level + offset


def speed_of(log: Log, channel: str, bandwidth: float | None = None) -> Array:
    """Speed from a channel: as it is, or from the difference of an angle or position.

    Parameters
    ----------
    log : Log
    channel : str
    bandwidth : float, optional
        Of a filter without phase [Hz]; default: none.

    Returns
    -------
    ndarray, shape (samples,)

    Raises
    ------
    InputRefused
        If the channel is neither a speed nor an angle or position.
    """
    values, quantity = log.channel(channel), channel.rpartition("_")[2]
    if quantity not in ("angle", "position", "velocity"):
        raise InputRefused(
            f'{log.source}: "{channel}" is no angle, position or velocity: choose another channel'
        )
    if bandwidth is not None:
        values = zero_phase(values, log.interval, bandwidth)
    return values if quantity == "velocity" else difference(values, log.interval)
