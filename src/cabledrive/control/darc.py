r"""Direct adaptive robust control of a lumped chain: the law, its gains, its projection.

With z the flat output and :math:`\sigma = (s + \lambda)^{2n-1}(z - z_d)`, :math:`z_{eq}` is what
:math:`z^{(2n)}` must be for :math:`\dot\sigma = 0`, and

.. math::
    u = [D_1 a_2]z + \hat p_2 [s^2 R_1]_{z^{(2n)} \to z_{eq}} + \hat p_3\omega_1 + \hat p_4 S - \hat p_5 -
    K_\sigma\sigma

gives :math:`\mu\dot\sigma + K_\sigma\sigma = -\varphi^T\tilde p + \tilde d`. Without dampers these are the
printed laws.
"""

from dataclasses import dataclass
from math import comb, isfinite, pi

import numpy as np

from cabledrive.control import numbers
from cabledrive.control.numbers import LawNumbers
from cabledrive.control.reference import FlatOutput
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain

PRINTED_HZ = {1: (5.0, 5.0 * 13.0 / 11.0), 2: (22.0, 26.0), 3: (11.0, 13.0), 4: (23.0, 25.0)}
"""Lambda/(2 pi) and K_sigma/(2 pi mu); printed for Models 3 and 4, for Model 2 lambda alone, not for 1."""
RATIO = {1: 13.0 / 11.0, 2: 13.0 / 11.0, 3: 13.0 / 11.0, 4: 25.0 / 23.0}

# Bounds of sections 6.5.1 and 6.6.1 over the values of Table 4.1: p2 with a rigid and with a flexible joint,
# p3, p4; p5 over the Coulomb friction.
_INERTIA = {False: (0.00165 / 0.001742, 0.00185 / 0.001742), True: (0.0009 / 0.0011, 0.0013 / 0.0011)}
_VISCOUS, _COULOMB, _OFFSET = (
    (0.0029 / 0.0031, 0.0033 / 0.0031),
    (0.035 / 0.0376, 0.04 / 0.0376),
    0.01 / 0.0376,
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Bounds:
    """What is known of p2 to p5: motor-side inertia, viscous and Coulomb friction, offset torque."""

    nominal: Array  # (4,) [kg m^2], [N m s/rad], [N m], [N m], as the next two
    low: Array
    high: Array

    def __post_init__(self) -> None:
        names = ("p2 [kg m^2]", "p3 [N m s/rad]", "p4 [N m]", "p5 [N m]")
        for name, value, low, high in zip(names, self.nominal, self.low, self.high, strict=True):
            if not low <= value <= high:
                raise InputRefused(f"{name} = {value:.6g} lies outside {low:.6g} to {high:.6g}: widen them")

    @property
    def spread(self) -> Array:
        """Widths of the bounds."""
        return self.high - self.low


def printed_bounds(chain: LumpedChain, *, flexible_joint: bool) -> Bounds:
    """Bounds about the first inertia in the proportions of sections 6.5.1 and 6.6.1, 0.009 read as 0.0009."""
    nominal = np.array([chain.inertias[0], chain.viscous[0], chain.coulomb[0], chain.offsets[0]])
    pairs = (_INERTIA[flexible_joint], _VISCOUS, _COULOMB)
    low = np.array([pair[0] * value for pair, value in zip(pairs, nominal, strict=False)])
    high = np.array([pair[1] * value for pair, value in zip(pairs, nominal, strict=False)])
    offset = max(_OFFSET * nominal[2], 2.0 * abs(nominal[3]))
    return Bounds(nominal=nominal, low=np.append(low, -offset), high=np.append(high, offset))


@dataclass(frozen=True, slots=True, kw_only=True)
class DarcGains:
    """Gains of a law of the chain."""

    bandwidth: float  # lambda of the sliding surface [rad/s]
    sliding_rate: float  # K_sigma / mu [rad/s]
    adaptation_share: float = 1.0  # factor on the adaptation gain of (6.37); 0: estimates stay


def darc_gains(model: int, bandwidth: float | None = None, *, adaptation_share: float = 1.0) -> DarcGains:
    """Printed gains of a model, or their proportions at another bandwidth [Hz], above 0."""
    lam, rate = PRINTED_HZ[model] if bandwidth is None else (bandwidth, RATIO[model] * bandwidth)
    if not isfinite(lam) or lam <= 0.0:
        raise InputRefused(f"bandwidth = {lam:.6g} Hz must be finite and above 0, or the surface is unstable")
    return DarcGains(
        bandwidth=2.0 * pi * lam, sliding_rate=2.0 * pi * rate, adaptation_share=adaptation_share
    )


def adaptation_gain(gains: DarcGains, bounds: Bounds, regressor: Array, mu: float) -> Array:
    r"""Diagonal (4,) of :math:`\Gamma = \gamma W_p^2`, Eqs. (6.35)-(6.37), with :math:`\zeta_d = 1`.

    .. math:: W_p = \mathrm{diag}(p_{max} - p_{min}), \quad
        \gamma = \frac{k_m^2}{4\zeta_d^2\,\sup(\varphi_d^T W_p^2\varphi_d/\mu)}, \quad k_m = K_\sigma/\mu
    """
    squares = bounds.spread**2
    largest = float(np.max(regressor**2 @ squares)) / mu
    if largest == 0.0:
        return np.zeros(4)
    gamma = gains.sliding_rate**2 / (4.0 * largest)  # of zeta_d the source gives none
    return gains.adaptation_share * gamma * squares


PRINTED_SLOPE, REFERENCE_SLOPE = 0.5, 50.0


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
    by_reference: bool = False,
) -> LawNumbers:
    """Freeze a law of the chain; ``reference``, (samples, 2n + 3), sets the adaptation gain.

    ``by_reference``: adaptation by the reference's regressor, and tanh(50 w_d) instead of tanh(0.5 w).
    """
    n2 = 2 * flat.size
    mu = bounds.nominal[0] * flat.inertial[-1]  # of the highest derivative
    slope = REFERENCE_SLOPE if by_reference else PRINTED_SLOPE
    speed, acceleration = reference[:, -2], reference[:, -1]
    along = np.column_stack((-acceleration, -speed, -np.tanh(slope * speed), np.ones(len(speed))))
    rows = np.zeros((3, n2 + 1))
    rows[numbers.SURFACE, :n2] = surface(n2 - 1, gains.bandwidth)
    rows[numbers.ELASTIC, :n2], rows[numbers.INERTIAL] = flat.elastic[:n2], flat.inertial
    gain = adaptation_gain(gains, bounds, along, mu)
    return LawNumbers(
        kind=numbers.DARC,
        matrix=np.asarray(np.linalg.inv(flat.states)),
        rows=rows,
        learning=numbers.learning_table(bounds.nominal, bounds.low, bounds.high, gain),
        scalars=np.array([interval, mu * gains.sliding_rate, slope, by_reference, by_reference, mu, 0.0]),
    )
