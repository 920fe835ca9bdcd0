r"""What a speed sensor makes of a speed: its absolute value, a lag, a threshold; with exact derivatives.

.. math:: z = \max(0, y - z_0), \qquad T\dot y + y = |\omega|

A counter of pulses does not see the direction, its converter to a voltage lags, and shows nothing below a
threshold.
"""

from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Array = NDArray[np.float64]

SENSOR_QUANTITIES = ("lag", "threshold")


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """A speed sensor.

    Attributes
    ----------
    rectified : bool
        Whether it shows the absolute value.
    lag : float
        Time constant T [s]; 0: none.
    threshold : float
        Speed :math:`z_0` that is taken off; 0: none.
    """

    rectified: bool = False
    lag: float = 0.0
    threshold: float = 0.0


def shown(
    sensor: Sensor, speeds: Array, sensitivities: Array, interval: float, quantities: tuple[str, ...]
) -> tuple[Array, Array]:
    """What the sensor shows, and its derivatives.

    ``speeds``, shape (samples, channels); ``sensitivities``, shape (samples, channels, p): of the speeds;
    ``interval`` [s]; ``quantities``: what each of the p parameters is; those of `SENSOR_QUANTITIES` act here.
    Returns ``output``, shape (samples, channels); ``derivatives``, shape (samples, channels, p).
    """
    output, slopes = speeds, sensitivities.copy()
    if sensor.rectified:
        slopes = slopes * np.sign(output)[:, :, None]
        output = np.abs(output)
    if sensor.lag > 0.0:
        output, slopes = lagged(output, sensor.lag, interval), lagged(slopes, sensor.lag, interval)
        by_lag = (lagged(output, sensor.lag, interval) - output) / sensor.lag
        for k in (k for k, name in enumerate(quantities) if name == "lag"):
            slopes[:, :, k] += by_lag
    if sensor.threshold > 0.0:
        for k in (k for k, name in enumerate(quantities) if name == "threshold"):
            slopes[:, :, k] -= 1.0
        above = output > sensor.threshold
        output, slopes = np.where(above, output - sensor.threshold, 0.0), slopes * above[:, :, None]
    return output, slopes


def lagged(values: Array, lag: float, interval: float) -> Array:
    """Values behind a lag of order 1, from rest at the first value; on straight lines between samples exact.

    ``values``, shape (samples, ...); ``lag`` [s]; ``interval`` [s].
    """
    ratio = interval / lag
    pole = exp(-ratio)
    late = 1.0 - (1.0 - pole) / ratio  # weight of the newer corner of each straight line
    early = 1.0 - pole - late
    base = values[:1]
    return np.asarray(base + signal.lfilter([late, early], [1.0, -pole], values - base, axis=0))
