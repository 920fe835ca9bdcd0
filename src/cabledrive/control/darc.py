r"""Direct adaptive robust control of a lumped chain, from one derivation for any length and with damping.

With z the flat output and :math:`\sigma = (s + \lambda)^{2n-1}(z - z_d)`, :math:`z_{eq}` is what
:math:`z^{(2n)}` must be for :math:`\dot\sigma = 0`, and

.. math::
    u = [D_1 a_2]z + \hat p_2 [s^2 R_1]_{z^{(2n)} \to z_{eq}} + \hat p_3\omega_1 + \hat p_4 S - \hat p_5 -
    K_\sigma\sigma

gives :math:`\mu\dot\sigma + K_\sigma\sigma = -\varphi^T\tilde p + \tilde d`. Without dampers these are the
printed laws.
"""

from dataclasses import dataclass
from math import comb

import numpy as np

from cabledrive.control.darc_gains import Bounds, DarcGains, adaptation_gain, mu_of
from cabledrive.control.flat_output import FlatOutput
from cabledrive.control.numbers import (
    BY_REFERENCE,
    DARC,
    DESIRED,
    ELASTIC,
    GAIN,
    HIGH,
    INERTIAL,
    INTERVAL,
    LIMIT,
    LOW,
    NOMINAL,
    SLOPE,
    SURFACE,
    LawNumbers,
    learning_table,
)
from cabledrive.control.projection import adapted
from cabledrive.parameters.arrays import Array

PRINTED_SLOPE, REFERENCE_SLOPE = 0.5, 50.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DarcStep:
    """What one step of the law gives."""

    command: float  # u [N m]
    sigma: float  # sliding variable [rad/s^(2n-1)]
    regressor: Array  # (4,): phi, by which the estimates adapt
    estimate: Array  # (4,): p2 to p5 for the next sample


def surface(order: int, bandwidth: float) -> Array:
    r"""Coefficients of :math:`(s + \lambda)^n`, rising powers, Eqs. (6.18), (6.41), (6.50) and (6.60)."""
    return np.array([comb(order, i) * bandwidth ** (order - i) for i in range(order + 1)])


def darc_numbers(
    flat: FlatOutput,
    gains: DarcGains,
    bounds: Bounds,
    reference: Array,
    interval: float,
    *,
    friction_by_reference: bool = False,
    desired: bool = False,
    rate_limit: Array | None = None,
) -> LawNumbers:
    """Freeze a law of the chain.

    ``flat``: of the chain it is made for; without dampers for the published laws; ``reference``, shape
    (samples, 2n + 3): from `cabledrive.control.reference.flat_reference`; sets the adaptation gain;
    ``interval``: sample time [s]; ``friction_by_reference``: S = tanh(50 w_d) of the reference instead of
    tanh(0.5 w) of the motor; ``desired``: adaptation by the regressor of the reference (desired
    compensation); ``rate_limit``, shape (4,): largest rates of the estimates; default: none.
    """
    n2 = 2 * flat.size
    mu = mu_of(flat, bounds.nominal[0])
    slope = REFERENCE_SLOPE if friction_by_reference else PRINTED_SLOPE
    along = reference_regressor(reference, slope)
    rows = np.zeros((3, n2 + 1))
    rows[SURFACE, :n2] = surface(n2 - 1, gains.bandwidth)
    rows[ELASTIC, :n2], rows[INERTIAL] = flat.elastic[:n2], flat.inertial
    gain = adaptation_gain(gains, bounds, along, mu)
    return LawNumbers(
        kind=DARC,
        matrix=flat.from_states,
        rows=rows,
        learning=learning_table(bounds.nominal, bounds.low, bounds.high, gain, rate_limit),
        scalars=np.array([interval, mu * gains.sliding_rate, slope, friction_by_reference, desired, mu, 0.0]),
    )


def reference_regressor(reference: Array, slope: float) -> Array:
    """Phi along the reference, (samples, 4); ``slope``: K of tanh(K w) [s/rad]."""
    speed, acceleration = reference[:, -2], reference[:, -1]
    return np.column_stack((-acceleration, -speed, -np.tanh(slope * speed), np.ones(len(speed))))


def darc_step(law: LawNumbers, estimate: Array, states: Array, reference: Array) -> DarcStep:
    """One sample of the law of the chain, Eqs. (6.20), (6.43), (6.53) and (6.63).

    ``estimate``, (4,): p2 to p5; ``states``, (2n,): angles, then speeds, from the motor to the load;
    ``reference``, (2n + 3,): one row.
    """
    n2, rows, learning = len(states), law.rows, law.learning
    z = law.matrix @ states
    error = z - reference[:n2]
    sigma = rows[SURFACE, :n2] @ error
    z_eq = reference[n2] - rows[SURFACE, : n2 - 1] @ error[1:]
    acceleration = rows[INERTIAL] @ np.append(z, z_eq)
    speed, speed_d = states[n2 // 2], reference[n2 + 1]
    friction = np.tanh(law.scalars[SLOPE] * (speed_d if law.scalars[BY_REFERENCE] else speed))
    regressor = np.array([-acceleration, -speed, -friction, 1.0])
    compensation = -regressor @ estimate
    if law.scalars[DESIRED]:
        actual, regressor = regressor, np.array([-reference[n2 + 2], -speed_d, -friction, 1.0])
        compensation = -learning[NOMINAL] @ (actual - regressor) - regressor @ estimate
    command = rows[ELASTIC, :n2] @ z + compensation - law.k_sigma * sigma
    rate = learning[GAIN] * regressor * sigma
    fresh = adapted(estimate, rate, learning[LOW], learning[HIGH], law.scalars[INTERVAL], learning[LIMIT])
    return DarcStep(command=float(command), sigma=float(sigma), regressor=regressor, estimate=fresh)
