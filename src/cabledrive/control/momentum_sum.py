r"""Whole inertia and friction from the sum of all momenta, in which every joint's torque cancels.

.. math::
    \frac{\sum_i J_i\ddot\theta_i}{\sum_i J_i}\,J
    = \tau - b\,\dot\theta_1 - c\,\mathrm{sgn}\,\dot\theta_1 + d

with every signal through the same filter. How the whole inertia J divides among the shafts is taken as
believed: the motor's part and the load's are not separated by pulses of half a second. Samples slower than
a fifth of the largest speed, and 0.08 s after, are left out: near standstill the motor sticks, or the noise
of its law turns it to and fro, and its friction is not that of the filtered speed's sign.
"""

from dataclasses import dataclass
from math import exp

import numpy as np

from cabledrive.control.regression import (
    filtered,
    interval_factor,
    least_squares,
    rounding_replicates,
    rounding_spread,
    with_bounded_errors,
)
from cabledrive.parameters.arrays import Array

FILTER_HZ, THINNING = 20.0, 5
SLOW_SHARE, AFTER = 0.2, 0.08
CERTAIN = 0.05


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MotorEstimate:
    """Whole inertia, viscous and Coulomb friction and offset torque at the motor."""

    values: Array  # (4,) [kg m^2], [N m s/rad], [N m], [N m]
    errors: Array  # (4,): standard errors; `interval_factor` gives the 95 % interval

    @property
    def intervals(self) -> Array:
        """95 % intervals, shape (2, 4)."""
        half = interval_factor() * self.errors
        return np.array([self.values - half, self.values + half])

    @property
    def excited(self) -> bool:
        """Whether inertia and friction are known to 5 %."""
        half = interval_factor() * self.errors
        known = half[[0, 2]] < CERTAIN * self.values[[0, 2]]
        return bool(np.all(self.values[:3] > 0.0) and np.all(known))


def estimate_motor(
    readings: Array,
    torque: Array,
    counts: Array,
    inertias: Array,
    interval: float,
    generator: np.random.Generator,
    *,
    spread: Array | None = None,
) -> MotorEstimate:
    """Least squares on the filtered sum of momenta; ``generator``: for the errors.

    ``readings``, (samples, n): encoder angle of every inertia [rad]; ``torque``, (samples,): from each sample
    to the next, see `acting_torque` [N m]; ``inertias``, (n,): as believed; they divide the whole among the
    shafts [kg m^2]; ``spread``, (n,): relative half widths within which they are believed; default: none.
    """
    widths = np.zeros(len(inertias)) if spread is None else spread

    def solve(angles: Array, shares: Array) -> Array:
        return motor_coefficients(angles, torque, shares, interval)

    values = solve(readings, inertias)
    if not np.all(np.isfinite(values)):
        return MotorEstimate(values=np.full(4, np.nan), errors=np.full(4, np.inf))

    replicates = rounding_replicates(readings, counts, interval, generator)
    errors = rounding_spread(np.array([solve(one, inertias) for one in replicates]))
    bounds = inertias * (1.0 + np.diag(widths))
    effects = np.array([solve(readings, one) - values for one in bounds])
    errors = with_bounded_errors(errors, effects, generator)
    return MotorEstimate(values=values, errors=np.nan_to_num(errors, nan=np.inf))


def motor_coefficients(readings: Array, torque: Array, inertias: Array, interval: float) -> Array:
    """Whole inertia, viscous and Coulomb friction, offset torque by least squares, signs as above."""
    mean = filtered(readings @ (inertias / inertias.sum()), interval, FILTER_HZ)
    speed = filtered(np.ascontiguousarray(readings[:, 0]), interval, FILTER_HZ)[1]
    acting = filtered(torque_at_samples(torque), interval, FILTER_HZ)[0]
    slow = np.abs(speed) < SLOW_SHARE * np.abs(speed).max()
    lately = round(AFTER / interval)
    so_far = np.concatenate((np.zeros(lately + 1), np.cumsum(slow)))
    after = so_far[lately + 1 :] > so_far[: len(slow)]
    ones = np.ones(len(speed))
    regressors = np.column_stack((mean[2], speed, np.sign(speed), -ones))
    thin = slice(None, None, THINNING)
    return least_squares(regressors[thin], acting[thin], ~after[thin])


def acting_torque(command: Array, interval: float, *, delay: float = 0.0, current_rate: float = 0.0) -> Array:
    """Mean torque [N m] from each sample to the next that the torque loop makes of commands [N m].

    ``delay``: from sampling to torque [s]; ``current_rate``: bandwidth of the torque loop [rad/s]; 0: none.
    """
    whole, part = int(delay // interval), delay % interval / interval
    padded = np.concatenate((np.zeros(whole + 1), command))
    wanted = part * padded[: len(command)] + (1.0 - part) * padded[1 : len(command) + 1]
    if current_rate == 0.0:
        return wanted
    from scipy.signal import lfilter

    fading = exp(-current_rate * interval)
    after = lfilter([1.0 - fading], [1.0, -fading], wanted)
    before = np.concatenate(([0.0], after[:-1]))
    return np.asarray(wanted + (before - wanted) * (1.0 - fading) / (current_rate * interval))


def torque_at_samples(torque: Array) -> Array:
    """Torque at the samples [N m] as the mean of what acts before and after each."""
    before = np.concatenate((torque[:1], torque[:-1]))
    return 0.5 * (before + torque)
