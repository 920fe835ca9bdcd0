r"""What drives the sliding variable along a run, measured from the true states.

On a plant for which the theorem holds, :math:`\mu\dot\sigma + K_\sigma\sigma = g` with
:math:`|g| = |-\varphi^T\tilde p + \tilde d| \le h`. Along a run of which the true states are known, g follows
from the states alone, whatever drives them: with :math:`w = (z - z_d, \dots)` and the companion matrix F of
:math:`(s + \lambda)^{2n-1}(s + K_\sigma/\mu)`,

.. math:: w_{k+1} = e^{F T}w_k + \int_0^T e^{F s}\,ds\,\frac{b}{\mu}\,g_k + \dots

Errors of sensors, delay, hold, friction, disturbance and parameters of the motor all enter g. What is left of
the error of the load after the response to g cannot be made by a torque of the motor: an unmatched part.
"""

from dataclasses import dataclass
from math import comb

import numpy as np

from cabledrive.control.bound import output_tube
from cabledrive.control.flat_output import FlatOutput
from cabledrive.control.numbers import INERTIAL, SURFACE, LawNumbers
from cabledrive.parameters.arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SlidingResidual:
    """Sources of the load's error along a run."""

    torque: Array  # (samples,): g, constant from each sample to the next; the last one repeats [N m]
    unmatched: Array  # (samples,): part of the load's error that g does not make, at the first shaft [rad]
    reach: Array  # (samples,): largest error that torques of the size of g make, at the first shaft [rad]

    @property
    def total(self) -> Array:
        """Bound of the load's error by its sources, whatever their signs, shape (samples,)."""
        return self.reach + np.abs(self.unmatched)


def sliding_residual(
    law: LawNumbers,
    flat: FlatOutput,
    bandwidth: float,
    mu: float,
    states: Array,
    reference: Array,
    error: Array,
    interval: float,
) -> SlidingResidual:
    """What drove the sliding variable along a run.

    ``law``: a law of the chain; ``flat``: of the chain it is made for; ``bandwidth``: lambda [rad/s]; ``mu``:
    of the plant; ``states``, shape (samples, 2n): true angles, then speeds, of the inertias that the law
    takes; ``reference``, shape (samples, 2n + 3); ``error``, shape (samples,): of the load, at the first
    shaft [rad]; ``interval``: sample time [s].
    """
    count = states.shape[1]
    scale = bandwidth ** np.arange(count)
    deviation = (states @ law.matrix.T - reference[:, :count]) / scale
    step, push = _discrete(bandwidth, law.k_sigma / mu, interval, count)
    push = push / (mu * scale[-1])
    torque = (deviation[1:, -1] - deviation[:-1] @ step[-1]) / push[-1]
    output = flat.states[flat.size - 1] * scale
    matched = _response(step, push, output, torque)
    fading = float(np.exp(-law.k_sigma * interval / mu))
    sliding = np.abs(_lagged(torque / law.k_sigma, fading))
    return SlidingResidual(
        torque=np.append(torque, torque[-1:]),
        unmatched=error - matched,
        reach=output_tube(sliding, bandwidth, count - 1, interval, flat.time_constants),
    )


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


def _discrete(bandwidth: float, rate: float, interval: float, count: int) -> tuple[Array, Array]:
    """Transition over a sample of w_i / lambda^i, and the response to a constant unit in its last rate."""
    from scipy.linalg import expm

    surface = np.array([comb(count - 1, i) for i in range(count)], dtype=np.float64)
    both = np.append(0.0, surface) * bandwidth + np.append(surface, 0.0) * rate
    block = np.zeros((count + 1, count + 1))
    block[np.arange(count - 1), np.arange(1, count)] = bandwidth
    block[count - 1, :count] = -both[:count]
    block[count - 1, count] = 1.0
    power = expm(block * interval)
    return power[:count, :count], power[:count, count]


def _response(step: Array, push: Array, output: Array, torque: Array) -> Array:
    """Output under torques held from sample to sample, from rest; the impulse response doubles in length."""
    from scipy.signal import fftconvolve

    samples = len(torque)
    rows, power = output[None], step
    while len(rows) < samples:
        rows = np.concatenate((rows, rows @ power))
        power = power @ power
    impulse = rows[:samples] @ push
    found = fftconvolve(torque, impulse)[:samples] if samples else torque
    return np.append(0.0, found)


def _lagged(signal: Array, fading: float) -> Array:
    """A signal held from sample to sample through a first-order lag, from zero."""
    from scipy.signal import lfilter

    return np.append(0.0, lfilter([1.0 - fading], [1.0, -fading], signal))
