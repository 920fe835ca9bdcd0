r"""What the load's own equation tells of the cable, from two encoders and no torque.

.. math:: \ddot\theta_N = \beta(\theta_{N-1} - \theta_N) + \gamma(\dot\theta_{N-1} - \dot\theta_N) + c,
    \qquad \beta = k/J_N, \quad \gamma = b/J_N

with every signal through :math:`1/(1 + s/\omega)^3`; the constant c takes what unknown encoder zeros add.
Samples at which the load moves slower than a quarter of its largest speed are left out: a count then lasts
long, and a loop that follows its encoder well makes the same rounding error in every run, which no averaging
takes away.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.control.regression import filtered, interval_factor, least_squares, rounding_errors

Array = NDArray[np.float64]
FILTER_HZ, THINNING, SLOW_SHARE = 10.0, 10, 0.25
CERTAIN, DAMPING_CERTAIN = 0.02, 0.3


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadEstimate:
    """Stiffness and damping of the last link over the load's inertia.

    Attributes
    ----------
    beta, gamma : float
        [1/s^2], [1/s]; NaN where the motion tells nothing.
    beta_error, gamma_error : float
        Standard errors by the encoders' counts.
    """

    beta: float
    gamma: float
    beta_error: float
    gamma_error: float

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval of beta [1/s^2]."""
        half = interval_factor() * self.beta_error
        return self.beta - half, self.beta + half

    @property
    def damping_interval(self) -> tuple[float, float]:
        """95 % interval of gamma [1/s]."""
        half = interval_factor() * self.gamma_error
        return self.gamma - half, self.gamma + half

    @property
    def excited(self) -> bool:
        """Whether beta is known to 2 %: from less, nothing is learnt."""
        return bool(self.beta > 0.0 and interval_factor() * self.beta_error < CERTAIN * self.beta)

    @property
    def damping_known(self) -> bool:
        """Whether gamma is known to 30 %."""
        return bool(self.gamma > 0.0 and interval_factor() * self.gamma_error < DAMPING_CERTAIN * self.gamma)


def estimate_load(
    readings: Array, counts: Array, interval: float, generator: np.random.Generator
) -> LoadEstimate:
    """Least squares on the filtered load equation.

    Parameters
    ----------
    readings : ndarray, shape (samples, 2)
        Encoder angles of the inertia before the load and of the load, both at the first shaft [rad].
    counts : ndarray, shape (2,)
        One count of each [rad].
    interval : float
        Sample time [s].
    generator : numpy.random.Generator
        For the errors.

    Returns
    -------
    LoadEstimate
    """

    def solve(angles: Array) -> Array:
        return load_coefficients(angles, interval)

    values = solve(readings)
    if not np.all(np.isfinite(values)):
        return LoadEstimate(beta=np.nan, gamma=np.nan, beta_error=np.inf, gamma_error=np.inf)
    errors = rounding_errors(solve, readings, counts, interval, generator)
    return LoadEstimate(
        beta=float(values[0]),
        gamma=float(values[1]),
        beta_error=float(np.nan_to_num(errors[0], nan=np.inf)),
        gamma_error=float(np.nan_to_num(errors[1], nan=np.inf)),
    )


def load_coefficients(readings: Array, interval: float) -> Array:
    """Beta, gamma and the constant by least squares.

    Parameters
    ----------
    readings : ndarray, shape (samples, 2)
        [rad].
    interval : float
        Sample time [s].

    Returns
    -------
    ndarray, shape (3,)
    """
    near, load = np.ascontiguousarray(readings.T)
    twist = filtered(near - load, interval, FILTER_HZ)[:, ::THINNING]
    own = filtered(load, interval, FILTER_HZ)[:, ::THINNING]
    speed = np.abs(own[1])
    regressors = np.column_stack((twist[0], twist[1], np.ones(len(speed))))
    return least_squares(regressors, own[2], speed > SLOW_SHARE * speed.max())
