r"""What the theorems bound, what drives the sliding variable along a run, and the bound of a learning law.

All uncertainty acts as a torque of at most :math:`h = \sum_i (p_{max} - p_{min})_i|\varphi_i| + \delta`, so
that
:math:`\mu|\sigma|' \le -K_\sigma|\sigma| + h`.

On a plant for which the theorem holds, :math:`\mu\dot\sigma + K_\sigma\sigma = g` with
:math:`|g| = |-\varphi^T\tilde p + \tilde d| \le h`. Along a run of which the true states are known, g follows
from the states alone, whatever drives them: with :math:`w = (z - z_d, \dots)` and the companion matrix F of
:math:`(s + \lambda)^{2n-1}(s + K_\sigma/\mu)`,

.. math:: w_{k+1} = e^{F T}w_k + \int_0^T e^{F s}\,ds\,\frac{b}{\mu}\,g_k + \dots

Errors of sensors, delay, hold, friction, disturbance and parameters of the motor all enter g. What is left of
the error of the load after the response to g cannot be made by a torque of the motor: an unmatched part.

With p the load's true parameters, :math:`\delta_j` and :math:`\tau_j` what a unit of each asks of states
and motor (`cabledrive.control.reference`) and K the feedback, :math:`\zeta = x - x_d - \sum_j p_j\delta_j`
obeys

.. math:: \zeta_{k+1} = (A + BK)\zeta_k + Bm_k + r_k, \qquad
    m = \sum_j(\hat p_j - p_j)(\tau_j - K\delta_j) + d

and :math:`\delta` leaves the load where it is: the load's error is that of :math:`\zeta`. d is a torque of
the motor of at most :math:`\Delta`. An estimate lies within its bounds, and as long as it lies within five of
its standard deviations, :math:`|m| \le h = \sum_j R_j|\tau_j - K\delta_j| + \Delta` with R the smaller of the
two. Without r the error lies within :math:`|g| * h`, g the response of the load to a torque of one sample.
"""

from dataclasses import dataclass

import numpy as np

from cabledrive.control.darc import surface
from cabledrive.control.linear_laws import sampled_motion
from cabledrive.control.numbers import HIGH, INERTIAL, INTERVAL, LOW, NOMINAL, SURFACE, LawNumbers
from cabledrive.control.reference import FlatOutput
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain, held


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ErrorBound:
    """Bounds of the load's error, at the first shaft."""

    tube: Array  # (samples,): bound at every sample, with weighted uncertainty, run along the motion [rad]
    # h / (K_sigma lambda^(2n-1)) with the printed product of norms, which adds kg m^2 to N m [rad]
    printed: float


def uncertainty(regressor: Array, spread: Array, delta: Array | float) -> Array:
    """Largest torque h (samples,) [N m]: p2 to p5 by their regressors (samples, 4), and ``delta`` [N m]."""
    return np.abs(regressor) @ spread + delta


def printed_uncertainty(regressor: Array, spread: Array, delta: Array | float) -> Array:
    r"""The same by :math:`\|p_{max} - p_{min}\|\,\|\varphi\| + \delta`, as (6.22) takes it."""
    return np.linalg.norm(regressor, axis=1) * np.linalg.norm(spread) + delta


def error_bound(
    law: LawNumbers,
    bandwidth: float,
    regressor: Array,
    delta: Array | float,
    times: Array,
    deviation: Array | None = None,
) -> ErrorBound:
    """Bounds of the load's error along a motion, Eq. (6.27) for the output, whichever the motor's inertia.

    ``bandwidth``: lambda [rad/s]; ``regressor``, (samples, 4); ``delta``, (samples,) [N m]; ``times`` as of
    `output_tube`; ``deviation``, (samples, 4): of the true states' regressor where nominal parameters act.
    """
    nominal, low, high = law.learning[NOMINAL], law.learning[LOW], law.learning[HIGH]
    spread, order, interval = high - low, law.matrix.shape[0] - 1, float(law.scalars[INTERVAL])
    h = uncertainty(regressor, spread, delta)
    if deviation is not None:
        h = h + np.abs(deviation) @ np.maximum(high - nominal, nominal - low)
    shares = (low[0] / nominal[0], high[0] / nominal[0]) if nominal[0] > 0.0 else (1.0, 1.0)
    held = np.maximum(h[:-1], h[1:])
    sliding = sliding_tube(held, law.k_sigma, law.mu * np.array(shares), interval)
    scale = 1.0 / (law.k_sigma * bandwidth**order)
    return ErrorBound(
        tube=output_tube(sliding, bandwidth, order, interval, times),
        printed=float(printed_uncertainty(regressor, spread, delta).max() * scale),
    )


def sliding_tube(h: Array, k_sigma: float, mu: Array, interval: float) -> Array:
    r"""Largest :math:`|\sigma|` under :math:`\mu|\sigma|' \le h - K_\sigma|\sigma|`, from zero, (n,)."""
    fast, slow = (float(np.exp(-k_sigma * interval / one)) for one in (np.min(mu), np.max(mu)))
    found, bound = [0.0], 0.0
    for level in (h / k_sigma).tolist():
        gap = bound - level
        bound = level + gap * (slow if gap > 0.0 else fast)
        found.append(bound)
    return np.array(found)


def output_tube(sliding: Array, bandwidth: float, order: int, interval: float, times: Array) -> Array:
    """Bound of the load's angle [rad] by one of the sliding variable, through 1/(s + lambda) order times.

    ``bandwidth``: lambda [rad/s]; ``times``, (n - 1,): b_i / k_i [s], whose 1 + T s goes with one each.
    """
    bound = sliding
    for i in range(order):
        # held at the larger of the two samples beside each interval
        held = np.maximum(bound, np.append(bound[1:], bound[-1])) / bandwidth
        slow = lag_of_held(held[:-1], float(np.exp(-bandwidth * interval)))
        time = times[i] if i < len(times) else 0.0
        bound = time * bound + abs(1.0 - time * bandwidth) * slow
    return bound


def robust_conditions(
    law: LawNumbers, sigma: Array, regressor: Array, delta: Array | float
) -> dict[str, float | bool]:
    r"""Hold the robust term against its two conditions along a motion, Eqs. (6.21), (6.44), (6.54), (6.64).

    A constant gain, here half of K_sigma, meets both for :math:`\epsilon \ge h^2/(4k_{\sigma s})`.
    """
    gain = 0.5 * law.k_sigma
    h = uncertainty(regressor, law.learning[HIGH] - law.learning[LOW], delta)
    epsilon, worst = float(np.max(h**2) / (4.0 * gain)), float(np.max(np.abs(sigma) * h - gain * sigma**2))
    return {"epsilon": epsilon, "worst": worst, "condition_1": worst <= epsilon, "condition_2": gain >= 0.0}


def sliding_residual(
    law: LawNumbers, flat: FlatOutput, bandwidth: float, mu: float, off: Array, error: Array
) -> tuple[Array, Array]:
    """Bound of the load's error by its sources, whatever their signs, and what no torque makes, (samples,).

    ``flat``: of the chain the law is made for; ``bandwidth``: lambda [rad/s]; ``mu``: of the plant; ``off``,
    (samples, 2n): of the flat output and its derivatives, by true states; ``error``, (samples,): of the load;
    all errors at the first shaft [rad].
    """
    from scipy.signal import fftconvolve

    count, interval = off.shape[1], float(law.scalars[INTERVAL])
    scale = bandwidth ** np.arange(count)
    deviation = off / scale
    powers = surface(count - 1, 1.0)
    both = np.append(0.0, powers) * bandwidth + np.append(powers, 0.0) * (law.k_sigma / mu)
    system = np.diag(np.full(count - 1, bandwidth), 1)  # of w_i / lambda^i
    system[-1] = -both[:count]
    step, push = held(system, np.eye(count)[-1], interval)
    push = push / (mu * scale[-1])
    torque = (deviation[1:, -1] - deviation[:-1] @ step[-1]) / push[-1]
    output = flat.states[flat.size - 1] * scale
    impulse = impulse_response(step, push, output, len(torque))
    matched = np.append(0.0, fftconvolve(torque, impulse)[: len(torque)] if len(torque) else torque)
    fading = float(np.exp(-law.k_sigma * interval / mu))
    sliding = np.abs(lag_of_held(torque / law.k_sigma, fading))
    unmatched = error - matched
    reach = output_tube(sliding, bandwidth, count - 1, interval, flat.time_constants)
    return reach + np.abs(unmatched), unmatched


def regressor_deviation(law: LawNumbers, states: Array, reference: Array) -> Array:
    """Regressor of the true states less that of the reference, (samples, 4)."""
    count = states.shape[1]
    z = states @ law.matrix.T
    error = z - reference[:, :count]
    z_eq = reference[:, count] - error[:, 1:] @ law.rows[SURFACE, : count - 1]
    inertial = z @ law.rows[INERTIAL, :count] + law.rows[INERTIAL, count] * z_eq
    found = np.zeros((len(states), 4))
    found[:, 0] = reference[:, count + 2] - inertial
    found[:, 1] = reference[:, count + 1] - states[:, count // 2]
    return found


def impulse_response(step: Array, push: Array, output: Array, samples: int) -> Array:
    """Output of :math:`x_{k+1} = Ax_k` from ``push`` on, shape (samples,); its rows double in number.

    ``push``, (n,) or (n, inputs), ``output``, (n,) or (outputs, n), put their own axes behind the samples.
    """
    rows, power = output[None], step
    while len(rows) < samples:
        rows = np.concatenate((rows, rows @ power))
        power = power @ power
    return np.asarray(rows[:samples] @ push)


def lag_of_held(signal: Array, fading: float) -> Array:
    """A signal held from sample to sample through a first-order lag, from zero."""
    from scipy.signal import lfilter

    return np.append(0.0, lfilter([1.0 - fading], [1.0, -fading], signal))


DEVIATIONS = 5.0
"""Within which an estimate is taken to lie."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class IdealLoop:
    """The law on the chain it is made for, with true states: memory first, then angles and speeds."""

    matrix: Array  # (k + 2n, k + 2n)
    push: Array  # (k + 2n,): from the motor's torque
    load: int  # place of the load's angle

    def response(self, samples: int) -> Array:
        """Load's angle after a torque of one sample, shape (samples,) [rad/(N m)]."""
        row = np.eye(len(self.matrix))[self.load]
        return np.append(0.0, impulse_response(self.matrix, self.push, row, max(samples - 1, 0)))[:samples]


def ideal_loop(law: LawNumbers, chain: LumpedChain, interval: float) -> IdealLoop:
    """The loop of a law that learns, or of a linear one; ``chain``: that it is made for."""
    k, n = law.matrix.shape[0], chain.size
    a, b = sampled_motion(chain, interval)
    row = law.rows[:1, : k + 2 * n]
    matrix = np.zeros((k + 2 * n, k + 2 * n))
    matrix[:k] = law.matrix[:, : k + 2 * n]
    matrix[k:, k:] = a
    matrix[k:] += b @ row
    return IdealLoop(matrix=matrix, push=np.concatenate((np.zeros(k), b[:, 0])), load=k + n - 1)
