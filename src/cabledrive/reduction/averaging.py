r"""Averaged equations of the internal resonance: slow amplitudes in place of oscillations.

With forcing :math:`\tau\sin\Omega t`, :math:`\nu = \Omega/2`,
:math:`q = \operatorname{Re} Qe^{i\Omega t} + q_0` and
:math:`a_j = \operatorname{Re} z_j e^{i\nu t}`, Eq. (A.9) becomes to first order, Eq. (A.14),

.. math::
    \dot Q &= R_Q = (-\tfrac12 c + i\delta)Q + i\sum_j \alpha_j z_j^2 - f \\
    \dot z_j &= R_j = (-\tfrac12\Gamma + i\delta_j)z_j + i k_j Q z_j^*
        + i\sum_k \big[n_{jk}(\tfrac12|z_k|^2 z_j + \tfrac14 z_k^2 z_j^*) - d_{jk}|z_k|^2 z_j\big]

with :math:`\alpha_j = G_j/(4\Omega M)`, :math:`k_j = G_j/(2\nu m_j)`, :math:`n_{jk} = N_{jk}/(2\nu m_j)` and,
from the static rotation :math:`q_0 = -\sum_k G_k|z_k|^2/(2MW^2)` of the pulleys, :math:`d_{jk} = G_jG_k/(2\nu
m_jMW^2)`. To second order, Eq. (A.15), the slow rates of change and the third harmonic of the spans come in:

.. math::
    \dot Q &= R_Q + \frac{i}{2\Omega}(\dot R_Q + cR_Q)
        + \frac{i}{16\nu^2\Omega}\sum_j \frac{G_j^2}{Mm_j}|z_j|^2 Q \\
    \dot z_j &= R_j + \frac{i}{2\nu}(\dot R_j + \Gamma R_j) + \frac{i}{16\nu^3}\frac{G_j^2}{m_j^2}|Q|^2 z_j

The state is Cartesian (real and imaginary parts): amplitude and phase are singular at rest.
"""

from typing import NamedTuple

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
    transverse_damping: Array  # (...): Gamma [1/s]
    transverse_detuning: Array  # (J, ...): delta_j [rad/s]
    feedback: Array  # (J, ...): alpha [1/(m s)]
    pump: Array  # (J, ...): k [1/(m s)]
    cubic: Array  # (J, J, ...): n [1/(m^2 s)]
    static: Array  # (J, J, ...): d [1/(m^2 s)]
    drift: Array  # (J, ...): detuning at the start by the mean rotation after switching a torque on [rad/s]
    drift_decay: Array  # (...): how fast it dies out [1/s]
    passive: Array  # (J, ...): mean stretch of the modes that only decay, as a squared amplitude [m^2]
    back_third: Array  # (J, ...): coefficients of the last terms of Eq. (A.15) [1/(m^2 s)], as the next
    third: Array  # (J, ...)
    offset: Array  # (J, ...): static rotation per squared amplitude, G / (2 M W^2) [1/m]
    drift_offset: Array  # (...): static rotation by the drift at the start [m]


def averaged_coefficients(
    model: AutoparametricModel,
    *,
    torque: ArrayLike = 0.0,
    forcing: ArrayLike | None = None,
    passive: ArrayLike = 0.0,
    drift: bool = True,
) -> AveragedCoefficients:
    r"""Coefficients of the averaged equations, Eq. (A.16).

    The rigid rotation is eliminated at the forcing frequency: with :math:`D = i\Omega M_0 + c_{11}`

    .. math:: W'^2 - \Omega^2 + i\Omega c = W^2 - \Omega^2 + i\Omega c_q - \frac{i\Omega c_{12}^2}{MD}, \quad
              f = \frac{\tau}{2\Omega M}\Big(\frac{\phi_\tau}{r_1} - \frac{c_{12}}{r_1 D}\Big).

    A sine that starts at t = 0 leaves a mean rim speed :math:`\tau/(r_1 M_0\Omega)` that decays at
    :math:`c_{11}/M_0`; viscous friction at one pulley turns it into a difference of the span tensions.

    ``torque``, shape (...): amplitude of the torque [N m]; ``forcing``, shape (...): Omega [rad/s]; the
    pulley mode's own unless given; ``passive``, shape (J, ...): stretch of other modes of each section, see
    `triangle_stretch` [m^2]; ``drift``: whether the torque is switched on at t = 0; otherwise it has always
    been there.
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
        transverse_damping=np.asarray(model.transverse_damping, dtype=float),
        transverse_detuning=(_column(model.transverse, shape) ** 2 - nu**2) / (2 * nu),
        feedback=_column(back, shape) / (4 * omega),
        pump=_column(own, shape) / (2 * nu),
        cubic=_column((model.stiffening.T / model.transverse_mass).T, shape, 2) / (2 * nu),
        static=_column(own, shape)[:, None] * _column(back, shape)[None] / (2 * nu * model.natural**2),
        drift=_column(own, shape) * turned_by_drift / nu,
        drift_decay=np.asarray(model.rigid_damping / model.rigid_mass if free else 0.0),
        passive=_column(np.broadcast_to(np.asarray(passive, dtype=float).T, own.T.shape).T, shape),
        back_third=_column(own * back, shape) / (16 * nu**2 * omega),
        third=_column(own**2, shape) / (16 * nu**3),
        offset=_column(back, shape) / (2 * model.natural**2),
        drift_offset=np.asarray(turned_by_drift),
    )


def _column(values: Array, shape: tuple[int, ...], axes: int = 1) -> Array:
    """Values with their first axes kept and lanes added where they have none."""
    values = np.asarray(values, dtype=float)
    return values if values.ndim > axes or not shape else values.reshape(values.shape + (1,) * len(shape))


def averaged_rates(
    c: AveragedCoefficients, state: Complex, time: float = 0.0, *, second: bool = True
) -> Complex:
    """Rates of Q and z, shape (1 + J, ...) [m/s], a ``time`` [s] after the start, Eqs. (A.14), (A.15)."""
    q, z = state[0], state[1:]
    linear, along = linear_rates(c, time)
    size = np.abs(z) ** 2
    rate_q = along * q + 1j * np.sum(c.feedback * z**2, axis=0) - c.force
    bent = np.einsum("jk...,k...->j...", 0.5 * c.cubic - c.static, size) * z
    bent = bent + 0.25 * np.einsum("jk...,k...->j...", c.cubic, z**2) * z.conj()
    rate_z = linear * z + 1j * c.pump * q * z.conj() + 1j * bent
    if not second:
        return np.concatenate((rate_q[None], rate_z))
    nu = 0.5 * c.forcing
    bend_q = along * rate_q + 2j * np.sum(c.feedback * z * rate_z, axis=0)
    bend_z = linear * rate_z + 1j * c.pump * (rate_q * z.conj() + q * rate_z.conj())
    total_q = rate_q + 0.5j / c.forcing * (bend_q + c.damping * rate_q)
    total_q = total_q + 1j * np.sum(c.back_third * size, axis=0) * q
    total_z = rate_z + 0.5j / nu * (bend_z + c.transverse_damping * rate_z)
    return np.concatenate((total_q[None], total_z + 1j * c.third * np.abs(q) ** 2 * z))


def linear_rates(c: AveragedCoefficients, time: float) -> tuple[Complex, Complex]:
    """Complex growth rates [1/s] of z, (J, ...), and of Q, (...), with the drift as it is at a time [s]."""
    passive = c.passive * np.exp(-c.transverse_damping * time)
    shift = np.einsum("jk...,k...->j...", 0.5 * c.cubic - c.static, passive)
    shift = shift + c.drift * np.exp(-c.drift_decay * time)
    across = -0.5 * c.transverse_damping + 1j * (c.transverse_detuning + shift)
    return across, -0.5 * c.damping + 1j * c.detuning


def triangle_stretch(pluck: ArrayLike) -> Array:
    r"""Stretch of the modes 3, 5, ... of a triangular pluck as a squared amplitude of the first, Eq. (A.17).

    .. math:: \sum_{m=3,5,\dots} m^2 |A_m|^2 = \Big(\frac{8}{\pi^2}\Big)^2\Big(\frac{\pi^2}{8} - 1\Big) a^2
              = 0.1535\,a^2

    ``pluck``: height a of the triangle [m].
    Returns [m^2].
    """
    return (8 / np.pi**2) ** 2 * (np.pi**2 / 8 - 1.0) * np.asarray(pluck, dtype=float) ** 2
