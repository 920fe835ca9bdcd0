r"""Steady states of the averaged equations in closed form, with their stability.

In a steady state the pulley mode is pinned, :math:`|k Q| = \sqrt{\Gamma^2/4 + D^2}` with :math:`D = \delta_1
+ nX`, and the squared amplitude X solves a quadratic,

.. math:: (\alpha kX + \tfrac14 c\Gamma - \delta D)^2 + (\tfrac12 cD + \tfrac12\delta\Gamma)^2 = k^2|f|^2.
          \qquad \text{Eq. (A.27)}

One span alone, or both with equal amplitudes a quarter turn apart, X their sum; other steady states of equal
spans do not exist but for turns of the plane of vibration.
"""

from typing import Literal

import numpy as np

from cabledrive.parameters.arrays import Array, Complex
from cabledrive.reduction.averaging import AveragedCoefficients, linear_rates

Kind = Literal["one", "both"]


def effective_cubic(c: AveragedCoefficients, kind: Kind) -> float:
    """Detuning per squared amplitude, n of `quadratic`, of two equal spans of which one or both vibrate."""
    own = 0.75 * c.cubic[0, 0] - c.static[0, 0]
    if kind == "one":
        return float(own)
    return float(0.5 * (own + 0.25 * c.cubic[0, 1] - c.static[0, 1]))


def quadratic(c: AveragedCoefficients, kind: Kind) -> Array:
    """Condition for a steady state as a polynomial in X, shape (3,), highest power first, Eq. (A.27)."""
    first, second = _linear_parts(c, kind)
    total = np.polyadd(np.polymul(first, first), np.polymul(second, second))
    total[-1] -= float(np.abs(c.pump[0] * c.force) ** 2)
    return total


def _linear_parts(c: AveragedCoefficients, kind: Kind) -> tuple[Array, Array]:
    """The two brackets of `quadratic`, each as slope and value at X = 0."""
    n, detuning, gamma = (
        effective_cubic(c, kind),
        float(c.transverse_detuning[0]),
        float(c.transverse_damping),
    )
    damping, delta = float(c.damping), float(c.detuning)
    first = [float(c.feedback[0] * c.pump[0]) - delta * n, 0.25 * damping * gamma - delta * detuning]
    second = [0.5 * damping * n, 0.5 * (damping * detuning + delta * gamma)]
    return np.array(first), np.array(second)


def steady_amplitudes(c: AveragedCoefficients, kind: Kind) -> Array:
    """Squared amplitudes X of steady states of two equal spans without drift, ascending [m^2].

    Two where a large motion and none can both persist.
    """
    a, b, rest = quadratic(c, kind)
    inside = b * b - 4 * a * rest
    if inside < 0.0:
        return np.zeros(0)
    half = -0.5 * (b + np.copysign(np.sqrt(inside), b))
    roots = np.array([half / a, rest / half]) if half != 0.0 else np.zeros(0)
    return np.sort(roots[roots > 0.0])


def fold(c: AveragedCoefficients, kind: Kind) -> tuple[float, float] | None:
    """Size of f [m/s] and X [m^2] where two steady states meet; None: amplitudes grow without a jump."""
    (a1, a0), (b1, b0) = _linear_parts(c, kind)
    slope = a1 * a0 + b1 * b0
    size = a1**2 + b1**2
    if slope >= 0.0:
        return None
    return abs(a1 * b0 - a0 * b1) / np.sqrt(size) / abs(float(c.pump[0])), -slope / size


def steady_state(c: AveragedCoefficients, squared: float, kind: Kind) -> Complex:
    """Slow amplitudes Q and both z [m] of the steady state of a squared amplitude X [m^2]."""
    shifted = float(c.transverse_detuning[0]) + effective_cubic(c, kind) * squared
    pinned = (-shifted - 0.5j * float(c.transverse_damping)) / float(c.pump[0])
    along = -0.5 * float(c.damping) + 1j * float(c.detuning)
    turned = complex(c.force) / (along * pinned + 1j * float(c.feedback[0]) * squared)
    turned /= abs(turned)
    first = np.sqrt(turned)
    spans = [np.sqrt(squared), 0.0] if kind == "one" else [np.sqrt(squared / 2), 1j * np.sqrt(squared / 2)]
    return np.array([pinned * turned, *(amplitude * first for amplitude in spans)])


def jacobian(c: AveragedCoefficients, state: Complex) -> Array:
    """Derivative of the first-order rates by real, then imaginary parts, shape (2 + 2 J, 2 + 2 J)."""
    q, z = state[0], state[1:]
    across, along = linear_rates(c, np.inf if c.drift_decay > 0.0 else 0.0)
    plain, conjugate = (np.zeros((state.size, state.size), dtype=complex) for _ in range(2))
    bare = 0.5 * c.cubic - c.static
    plain[0, 0] = along
    plain[0, 1:] = 2j * c.feedback * z
    plain[1:, 0] = 1j * c.pump * z.conj()
    plain[1:, 1:] = 1j * (bare * np.outer(z, z.conj()) + 0.5 * c.cubic * np.outer(z.conj(), z))
    conjugate[1:, 1:] = 1j * bare * np.outer(z, z)
    own = np.arange(1, state.size)
    plain[own, own] += across + 1j * bare @ np.abs(z) ** 2
    conjugate[own, own] += 1j * c.pump * q + 0.25j * c.cubic @ z**2
    both, apart = plain + conjugate, plain - conjugate
    return np.block([[both.real, -apart.imag], [both.imag, apart.real]])


def hopf_torque_force(c: AveragedCoefficients) -> float | None:
    r"""Size of the force f at which one span's steady state gives way to permanent beats, Eq. (A.28).

    With :math:`b = 2\alpha kX` and :math:`H = c^2 + 4\delta^2`

    .. math:: b = \frac{\Gamma cH[H + 4\Gamma(\Gamma + c)]}
                       {4(\Gamma + c)^2[-(8\delta_1\delta + 4\delta^2 + c(c + 2\Gamma))]}

    ``c``: its cubic and static terms are left out.
    Returns [m/s]; None where there are no permanent beats.
    """
    gamma, damping, delta = float(c.transverse_damping), float(c.damping), float(c.detuning)
    detuning, pump = float(c.transverse_detuning[0]), float(c.pump[0])
    opposed = -(8 * detuning * delta + 4 * delta**2 + damping * (damping + 2 * gamma))
    if opposed <= 0.0:
        return None
    size = damping**2 + 4 * delta**2
    b = gamma * damping * size * (size + 4 * gamma * (gamma + damping))
    b /= 4 * (gamma + damping) ** 2 * opposed
    first = 0.5 * b + 0.25 * damping * gamma - delta * detuning
    second = 0.5 * (damping * detuning + delta * gamma)
    return float(np.hypot(first, second) / abs(pump))
