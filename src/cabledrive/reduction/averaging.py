r"""Averaged equations of the internal resonance and their steady states.

With forcing :math:`\tau\sin\Omega t`, :math:`\nu = \Omega/2`,
:math:`q = \operatorname{Re} Qe^{i\Omega t} + q_0` and
:math:`a_j = \operatorname{Re} z_j e^{i\nu t}`, Eq. (A.9) becomes to first order, Eq. (A.14),

.. math::
    \dot Q &= R_Q = (-\tfrac12 c + i\delta)Q + i\sum_j \alpha_j z_j^2 - f \\
    \dot z_j &= R_j = (-\tfrac12\Gamma + i\delta_j)z_j + i k_j Q z_j^*
        + i\sum_k \big[n_{jk}(\tfrac12|z_k|^2 z_j + \tfrac14 z_k^2 z_j^*) - d_{jk}|z_k|^2 z_j\big]

with :math:`\alpha_j = G_j/(4\Omega M)`, :math:`k_j = G_j/(2\nu m_j)`, :math:`n_{jk} = N_{jk}/(2\nu m_j)` and,
from the static rotation :math:`q_0 = -\sum_k G_k|z_k|^2/(2MW^2)` of the pulleys, :math:`d_{jk} = G_jG_k/(2\nu
m_jMW^2)`.

The state is Cartesian (real and imaginary parts): amplitude and phase are singular at rest.

In a steady state the pulley mode is pinned, :math:`|k Q| = \sqrt{\Gamma^2/4 + D^2}` with :math:`D = \delta_1
+ nX`, and the squared amplitude X solves a quadratic,

.. math:: (\alpha kX + \tfrac14 c\Gamma - \delta D)^2 + (\tfrac12 cD + \tfrac12\delta\Gamma)^2 = k^2|f|^2.
          \qquad \text{Eq. (A.27)}

One span alone, or both with equal amplitudes a quarter turn apart, X their sum; other steady states of equal
spans do not exist but for turns of the plane of vibration.
"""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.parameters.arrays import Array, Complex
from cabledrive.reduction.autoparametric import AutoparametricModel


class AveragedCoefficients(NamedTuple):
    """Coefficients of `averaged_rates` for J transverse modes; every array may end in an axis of lanes."""

    forcing: Array  # (...): Omega [rad/s]
    damping: Array  # (...): c of the pulley mode [1/s]
    detuning: Array  # (...): delta of the pulley mode [1/s]
    force: Complex  # (...): f [m/s]
    transverse_damping: Array  # (J, ...): Gamma, times the cable's share of what moves [1/s]
    transverse_detuning: Array  # (J, ...): delta_j [rad/s]
    feedback: Array  # (J, ...): alpha [1/(m s)]
    pump: Array  # (J, ...): k [1/(m s)]
    cubic: Array  # (J, J, ...): n [1/(m^2 s)]
    static: Array  # (J, J, ...): d [1/(m^2 s)]
    drift: Array  # (J, ...): detuning at the start by the mean rotation after switching a torque on [rad/s]
    drift_decay: Array  # (...): how fast it dies out [1/s]


def averaged_coefficients(
    model: AutoparametricModel,
    *,
    torque: ArrayLike = 0.0,
    forcing: ArrayLike | None = None,
    drift: bool = True,
) -> AveragedCoefficients:
    r"""Coefficients of the averaged equations, Eq. (A.16).

    The rigid rotation is eliminated at the forcing frequency: with :math:`D = i\Omega M_0 + c_{11}`

    .. math:: W'^2 - \Omega^2 + i\Omega c = W^2 - \Omega^2 + i\Omega c_q - \frac{i\Omega c_{12}^2}{MD}, \quad
              f = \frac{\tau}{2\Omega M}\Big(\frac{\phi_\tau}{r_1} - \frac{c_{12}}{r_1 D}\Big).

    A sine that starts at t = 0 leaves a mean rim speed :math:`\tau/(r_1 M_0\Omega)` that decays at
    :math:`c_{11}/M_0`; viscous friction at one pulley turns it into a difference of the span tensions.

    ``torque``, shape (...): amplitude of the torque [N m]; ``forcing``, shape (...): Omega [rad/s]; the
    pulley mode's own unless given; ``drift``: whether the torque is switched on at t = 0; otherwise it has
    always been there.
    """
    omega = np.asarray(model.natural if forcing is None else forcing, dtype=float)
    tau, nu, mass = np.asarray(torque, dtype=float), 0.5 * omega, model.modal_mass
    free = bool(np.all(model.rigid_arm > 0.0))
    turned = model.cross_damping / (1j * omega * model.rigid_mass + model.rigid_damping) if free else 0.0
    dynamic = model.natural**2 - omega**2 + 1j * omega * model.modal_damping
    dynamic = dynamic - 1j * omega * turned * model.cross_damping / mass
    force = tau / (2 * omega * mass) * (model.torque_arm - turned * model.rigid_arm)
    speed = tau * model.rigid_arm / (model.rigid_mass * omega) if free and drift else 0.0 * tau
    turned_by_drift = -model.cross_damping * speed / (mass * model.natural**2)
    back, own = model.coupling / mass, (model.coupling.T / model.transverse_mass).T
    shape = np.broadcast_shapes(omega.shape, tau.shape, own.shape[1:])
    return AveragedCoefficients(
        forcing=omega,
        damping=dynamic.imag / omega,
        detuning=dynamic.real / (2 * omega),
        force=np.asarray(force, dtype=complex),
        transverse_damping=_column(model.transverse_damping * model.cable_share, shape),
        transverse_detuning=(_column(model.transverse, shape) ** 2 - nu**2) / (2 * nu),
        feedback=_column(back, shape) / (4 * omega),
        pump=_column(own, shape) / (2 * nu),
        cubic=_column((model.stiffening.T / model.transverse_mass).T, shape, 2) / (2 * nu),
        static=_column(own, shape)[:, None] * _column(back, shape)[None] / (2 * nu * model.natural**2),
        drift=_column(own, shape) * turned_by_drift / nu,
        drift_decay=np.asarray(model.rigid_damping / model.rigid_mass if free else 0.0),
    )


def _column(values: Array, shape: tuple[int, ...], axes: int = 1) -> Array:
    """Values with their first axes kept and lanes added where they have none."""
    values = np.asarray(values, dtype=float)
    return values if values.ndim > axes or not shape else values.reshape(values.shape + (1,) * len(shape))


def averaged_rates(c: AveragedCoefficients, state: Complex, time: float = 0.0) -> Complex:
    """Rates of Q and z, shape (1 + J, ...) [m/s], a ``time`` [s] after the start, Eq. (A.14)."""
    q, z = state[0], state[1:]
    linear, along = linear_rates(c, time)
    rate_q = along * q + 1j * np.sum(c.feedback * z**2, axis=0) - c.force
    bent = np.einsum("jk...,k...->j...", 0.5 * c.cubic - c.static, np.abs(z) ** 2) * z
    bent = bent + 0.25 * np.einsum("jk...,k...->j...", c.cubic, z**2) * z.conj()
    rate_z = linear * z + 1j * c.pump * q * z.conj() + 1j * bent
    return np.concatenate((rate_q[None], rate_z))


def linear_rates(c: AveragedCoefficients, time: float) -> tuple[Complex, Complex]:
    """Complex growth rates [1/s] of z, (J, ...), and of Q, (...), with the drift as it is at a time [s]."""
    shift = c.drift * np.exp(-c.drift_decay * time)
    across = -0.5 * c.transverse_damping + 1j * (c.transverse_detuning + shift)
    return across, -0.5 * c.damping + 1j * c.detuning


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
        float(c.transverse_damping[0]),
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
    pinned = (-shifted - 0.5j * float(c.transverse_damping[0])) / float(c.pump[0])
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
