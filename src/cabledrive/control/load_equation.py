r"""What the load's own equation tells of the cable, from two encoders and no torque.

.. math:: \ddot\theta_2 = \beta(\theta_1 - \theta_2) + \gamma(\dot\theta_1 - \dot\theta_2) + c, \qquad
    \beta = k_k/J_2, \quad \gamma = b_b/J_2

with every signal through :math:`1/(1 + s/\omega)^3`; the constant c takes what unknown encoder zeros add.
"""

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy.signal import cont2discrete, lfilter

Array = NDArray[np.float64]
FILTER_HZ, MEMORY = 10.0, 0.1
CERTAIN = 0.02


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadEstimate:
    """Stiffness and damping over load inertia.

    Attributes
    ----------
    beta, gamma : float
        [1/s^2], [1/s].
    beta_error, gamma_error : float
        Standard errors, residuals correlated over 0.1 s.
    excited : bool
        Whether beta is known to 2 %: from less, nothing is learnt.
    """

    beta: float
    gamma: float
    beta_error: float
    gamma_error: float
    excited: bool

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval of beta [1/s^2]."""
        return self.beta - 1.96 * self.beta_error, self.beta + 1.96 * self.beta_error


def filtered(signal: Array, interval: float, hertz: float = FILTER_HZ) -> Array:
    """A signal and its first two derivatives through 1/(1 + s/w)^3, from rest at its first value.

    Parameters
    ----------
    signal : ndarray, shape (samples,)
    interval : float
        Sample time [s].
    hertz : float, default 10.0
        w/(2 pi).

    Returns
    -------
    ndarray, shape (3, samples)
    """
    w = 2.0 * pi * hertz
    a = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-(w**3), -3.0 * w**2, -3.0 * w]])
    b = np.array([[0.0], [0.0], [w**3]])
    rows = []
    for k in range(3):
        c = np.eye(3)[k : k + 1]
        ad, bd, cd, dd, _ = cont2discrete((a, b, c, np.zeros((1, 1))), interval, "foh")
        denominator = np.real(np.poly(ad))
        numerator = np.real(np.poly(ad - bd @ cd)) - denominator + float(dd[0, 0]) * denominator
        rows.append(lfilter(numerator, denominator, signal - signal[0]))
    rows[0] = rows[0] + signal[0]
    return np.array(rows)


def estimate_load(drive_angle: Array, load_angle: Array, interval: float) -> LoadEstimate:
    """Least squares on the filtered load equation.

    Parameters
    ----------
    drive_angle, load_angle : ndarray, shape (samples,)
        Encoder angles of the pulleys, both at the first shaft [rad].
    interval : float
        Sample time [s].

    Returns
    -------
    LoadEstimate
    """
    twist = filtered(drive_angle - load_angle, interval)
    acceleration = filtered(load_angle, interval)[2]
    regressors = np.column_stack((twist[0], twist[1], np.ones(len(load_angle))))
    scale = np.abs(regressors).max(axis=0)
    if np.any(scale == 0.0):
        return LoadEstimate(beta=0.0, gamma=0.0, beta_error=np.inf, gamma_error=np.inf, excited=False)
    scaled = regressors / scale
    solution = np.linalg.lstsq(scaled, acceleration, rcond=None)[0]
    residual = acceleration - scaled @ solution
    spread = _covariance(scaled, residual, round(MEMORY / interval))
    values, errors = solution / scale, np.sqrt(np.diag(spread)) / scale
    known = bool(values[0] > 0.0 and errors[0] < CERTAIN * values[0])
    return LoadEstimate(
        beta=float(values[0]),
        gamma=float(values[1]),
        beta_error=float(errors[0]),
        gamma_error=float(errors[1]),
        excited=known,
    )


def _covariance(regressors: Array, residual: Array, lags: int) -> Array:
    """Of the least squares, residuals correlated over some samples, weights falling on a straight line."""
    moments = regressors * residual[:, None]
    steps = max(1, lags // 25)
    total = moments.T @ moments
    for lag in range(steps, lags, steps):
        part = moments[lag:].T @ moments[:-lag]
        total += steps * (1.0 - lag / lags) * (part + part.T)
    inverse = np.linalg.inv(regressors.T @ regressors)
    return np.abs(inverse @ total @ inverse)
