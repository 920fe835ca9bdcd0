r"""What the theorems bound: the sliding variable by the uncertainty, and the error of the load by both.

All uncertainty acts as a torque of at most :math:`h = \sum_i (p_{max} - p_{min})_i|\varphi_i| + \delta`, so
that
:math:`\mu|\sigma|' \le -K_\sigma|\sigma| + h`.
"""

from dataclasses import dataclass

import numpy as np

from cabledrive.control.numbers import HIGH, LOW, NOMINAL, LawNumbers
from cabledrive.parameters.arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ErrorBound:
    """Bounds of the load's error, at the first shaft."""

    tube: Array  # (samples,): bound at every sample, with weighted uncertainty, run along the motion [rad]
    steady: float  # h / (K_sigma lambda^(2n-1)) with the largest weighted uncertainty [rad]
    printed: float  # the same with the printed product of norms, which adds kg m^2 to N m [rad]


def uncertainty(regressor: Array, spread: Array, delta: Array | float) -> Array:
    """Largest torque h [N m] of all uncertainty, (samples,), each parameter weighted by its own regressor.

    ``regressor``, (samples, 4); ``spread``, (4,): widths of the bounds of p2 to p5; ``delta``, (samples,):
    bound of the disturbance [N m]; with friction that sticks at least its Coulomb torque.
    """
    return np.abs(regressor) @ spread + delta


def printed_uncertainty(regressor: Array, spread: Array, delta: Array | float) -> Array:
    r"""The same by :math:`\|p_{max} - p_{min}\|\,\|\varphi\| + \delta`, as (6.22) takes it."""
    return np.linalg.norm(regressor, axis=1) * np.linalg.norm(spread) + delta


def error_bound(
    law: LawNumbers,
    bandwidth: float,
    regressor: Array,
    delta: Array | float,
    interval: float,
    times: Array,
    deviation: Array | None = None,
) -> ErrorBound:
    r"""Bounds of the load's error along a motion, the consequence of Eq. (6.27) for the output.

    :math:`\sigma` passes :math:`1/(s + \lambda)` as often as the surface has roots, which keeps a bound a
    bound because the impulse response is positive; each damper's :math:`1 + T_i s` goes with one of them.
    :math:`\mu` may lie anywhere between the bounds of the motor's inertia: the tube grows with the smallest
    one and shrinks with the largest.

    ``law``: a law of the chain; ``bandwidth``: lambda [rad/s]; ``regressor``, shape (samples, 4): phi along
    the motion; ``delta``, shape (samples,): bound of the disturbance [N m]; ``interval``: sample time [s];
    ``times``, shape (n - 1,): b_i / k_i of the links [s]; ``deviation``, shape (samples, 4): by how much the
    regressor of the true states differs from ``regressor``, where the law compensates with the nominal
    parameters for it (desired compensation).
    """
    nominal, low, high = law.learning[NOMINAL], law.learning[LOW], law.learning[HIGH]
    spread, order = high - low, law.matrix.shape[0] - 1
    h = uncertainty(regressor, spread, delta)
    if deviation is not None:
        h = h + np.abs(deviation) @ np.maximum(high - nominal, nominal - low)
    shares = (low[0] / nominal[0], high[0] / nominal[0]) if nominal[0] > 0.0 else (1.0, 1.0)
    held = np.maximum(h[:-1], h[1:])
    sliding = sliding_tube(held, law.k_sigma, law.mu * np.array(shares), interval)
    scale = 1.0 / (law.k_sigma * bandwidth**order)
    return ErrorBound(
        tube=output_tube(sliding, bandwidth, order, interval, times),
        steady=float(h.max() * scale),
        printed=float(printed_uncertainty(regressor, spread, delta).max() * scale),
    )


def sliding_tube(h: Array, k_sigma: float, mu: Array, interval: float) -> Array:
    r"""Largest :math:`|\sigma|`, (samples,), under :math:`\mu|\sigma|' \le h - K_\sigma|\sigma|`, from zero.

    ``h``, (samples - 1,): from each sample to the next, not negative [N m]; ``mu``: values between which it
    lies.
    """
    fast, slow = (float(np.exp(-k_sigma * interval / one)) for one in (np.min(mu), np.max(mu)))
    found, bound = [0.0], 0.0
    for level in (h / k_sigma).tolist():
        gap = bound - level
        bound = level + gap * (slow if gap > 0.0 else fast)
        found.append(bound)
    return np.array(found)


def output_tube(sliding: Array, bandwidth: float, order: int, interval: float, times: Array) -> Array:
    """Bound of the load's angle [rad] by one of the sliding variable, through 1/(s + lambda) order times.

    ``bandwidth``: lambda [rad/s]; ``times``, (n - 1,): b_i / k_i of the links [s].
    """
    bound = sliding
    for i in range(order):
        slow = _lag(bound / bandwidth, bandwidth, interval)
        time = times[i] if i < len(times) else 0.0
        bound = time * bound + abs(1.0 - time * bandwidth) * slow
    return bound


def _lag(signal: Array, rate: float, interval: float) -> Array:
    """Signal through rate / (s + rate), held at the larger of the two samples beside each interval."""
    from scipy.signal import lfilter

    fading = np.exp(-rate * interval)
    upper = np.maximum(signal[:-1], signal[1:]) if len(signal) > 1 else signal
    return lfilter([0.0, 1.0 - fading], [1.0, -fading], np.append(upper, upper[-1]))


@dataclass(frozen=True, slots=True, kw_only=True)
class RobustConditions:
    """Whether a constant gain meets the conditions (6.21) on the robust term along a motion."""

    epsilon: float  # smallest for which Condition 1 holds, max h^2 / (4 k_sigma_s) [N m rad/s^(2n-1)]
    worst: float  # largest value met of |sigma| h - k_sigma_s sigma^2
    dissipative: bool  # Condition 2


def robust_conditions(
    law: LawNumbers, sigma: Array, regressor: Array, delta: Array | float
) -> RobustConditions:
    r"""Hold the robust term against its two conditions along a motion, Eqs. (6.21), (6.44), (6.54), (6.64).

    The corrected example of (6.22) is :math:`u_{s2} = -\sigma h^2/(4\epsilon)`; with a constant gain
    :math:`k_{\sigma s}` the condition holds for every :math:`\epsilon \ge h^2/(4k_{\sigma s})`.

    ``sigma``, shape (samples,); ``regressor``, shape (samples, 4); ``delta``, shape (samples,) [N m].
    k_sigma_s is half of K_sigma, which gives the best bound.
    """
    gain = 0.5 * law.k_sigma
    h = uncertainty(regressor, law.learning[HIGH] - law.learning[LOW], delta)
    met = np.abs(sigma) * h - gain * sigma**2
    return RobustConditions(
        epsilon=float(np.max(h**2) / (4.0 * gain)),
        worst=float(np.max(met)),
        dissipative=gain >= 0.0,
    )
