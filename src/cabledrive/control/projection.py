r"""The projection that keeps estimates within their bounds, and a rate limit."""

import numpy as np

from cabledrive.parameters.arrays import Array


def projected_rate(rate: Array, estimate: Array, low: Array, high: Array) -> Array:
    r"""Rate of the estimates that does not leave their bounds, Eq. (6.24), of the wanted one, Gamma tau.

    It has property P1, estimates within bounds, and for diagonal :math:`\Gamma` property P2, :math:`\tilde
    p^T(\Gamma^{-1}\mathrm{Proj}(\Gamma\tau) - \tau) \le 0`.
    """
    outwards = ((estimate >= high) & (rate > 0.0)) | ((estimate <= low) & (rate < 0.0))
    return np.where(outwards, 0.0, rate)


def limited_rate(rate: Array, limit: Array) -> Array:
    r"""Each component cut to its largest rate: :math:`\max(-l_i, \min(l_i, \dot p_i))`.

    The theorems speak of a rate limited law and define none; this is the definition used here. P1 stays; P2
    holds while no limit acts, and part (B) of the theorems with it. An infinite limit is none.
    """
    return np.clip(rate, -limit, limit)


def adapted(
    estimate: Array, rate: Array, low: Array, high: Array, interval: float, limit: Array | None = None
) -> Array:
    """Estimates after one sample at a rate Gamma tau; a step that would cross a bound ends on it."""
    allowed = projected_rate(rate, estimate, low, high)
    if limit is not None:
        allowed = limited_rate(allowed, limit)
    return np.clip(estimate + interval * allowed, low, high)
