r"""Between slow amplitudes and what can be seen: the motion they stand for, and the start that fits one.

.. math::
    q = \operatorname{Re} Qe^{i\Omega t} + q_0, \qquad a_j = \operatorname{Re}\Big[z_j e^{i\nu t} +
    \frac{G_j}{8\nu^2 m_j} Q z_j e^{3i\nu t}\Big] \qquad \text{Eq. (A.18)}

A pluck at rest is not Q = 0: the tension of the plucked span holds the pulleys away from where the averaged
motion swings about, and the difference is a real Q(0).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.parameters.arrays import Array, Complex
from cabledrive.reduction.autoparametric import AutoparametricModel
from cabledrive.reduction.averaging import AveragedCoefficients, averaged_rates

PASSES = 12


class Motion(NamedTuple):
    """Displacements and speeds of the model's oscillators."""

    q: Array  # (...) [m]
    q_rate: Array  # (...) [m/s]
    a: Array  # (J, ...) [m]
    a_rate: Array  # (J, ...) [m/s]


def reconstruct(c: AveragedCoefficients, state: Complex, time: float, *, second: bool = True) -> Motion:
    """The motion that belongs to slow amplitudes, shape (1 + J, ...) [m], at a time [s], Eq. (A.18)."""
    rates = averaged_rates(c, state, time, second=second)
    q, z, q_rate, z_rate = state[0], state[1:], rates[0], rates[1:]
    nu = 0.5 * c.forcing
    turn = np.exp(1j * nu * time)
    third = c.pump / (2.0 * c.forcing) * second  # G / (8 nu^2 m), third harmonic per Q z
    wave = z + third * q * z * turn**2
    wave_rate = z_rate + 1j * nu * z + third * turn**2 * (q_rate * z + q * z_rate + 3j * nu * q * z)
    static, static_rate = _static(c, z, z_rate, time)
    return Motion(
        q=(q * turn**2).real + static,
        q_rate=((q_rate + 1j * c.forcing * q) * turn**2).real + static_rate,
        a=(wave * turn).real,
        a_rate=(wave_rate * turn).real,
    )


def start_of(c: AveragedCoefficients, motion: Motion, *, second: bool = True) -> Complex:
    """Slow amplitudes whose reconstruction is a motion at t = 0, Eq. (A.19), by repeated correction."""
    nu = 0.5 * c.forcing
    lanes = np.broadcast_shapes(c.force.shape, np.shape(motion.q), c.transverse_detuning.shape[1:])
    state = np.zeros((1 + c.pump.shape[0], *lanes), dtype=complex)
    for _ in range(PASSES):
        found = reconstruct(c, state, 0.0, second=second)
        state[0] += motion.q - found.q - 1j * (motion.q_rate - found.q_rate) / c.forcing
        state[1:] += motion.a - found.a - 1j * (motion.a_rate - found.a_rate) / nu
    return state


def plucked(c: AveragedCoefficients, plucks: ArrayLike, *, second: bool = True) -> Complex:
    """Slow amplitudes of half-sine plucks [m], shape (J, ...), let go at rest, the pulleys at angle zero."""
    a = np.asarray(plucks, dtype=float)
    zero = np.zeros(a.shape[1:])
    return start_of(c, Motion(q=zero, q_rate=zero, a=a, a_rate=np.zeros_like(a)), second=second)


def _static(c: AveragedCoefficients, z: Complex, z_rate: Complex, time: float) -> tuple[Array, Array]:
    """Static rotation q0 by the mean stretch and by the drift, and its rate."""
    passive = c.passive * np.exp(-c.transverse_damping * time)
    drift = c.drift_offset * np.exp(-c.drift_decay * time)
    size, growth = np.abs(z) ** 2 + passive, 2.0 * (z.conj() * z_rate).real - c.transverse_damping * passive
    q0 = drift - np.sum(c.offset * size, axis=0)
    return q0, -c.drift_decay * drift - np.sum(c.offset * growth, axis=0)


def rigid_rotation(
    model: AutoparametricModel, time: Array, torque: float, forcing: float | None = None
) -> Array:
    r"""Rim displacement of the rigid rotation under a sine torque that starts at t = 0, Eq. (A.21).

    .. math:: s = \frac{\tau}{r_1 M_0\Omega}\Big[\frac{1 - e^{-\sigma t}}{\sigma}
              - \frac{\sin\Omega t}{\Omega}\Big], \qquad \sigma = c_{11}/M_0

    for :math:`\sigma \ll \Omega`; the pulley mode's friction on it is left out.

    ``time``, shape (n,) [s]; ``torque``: amplitude [N m]; ``forcing``: omega [rad/s]; the pulley mode's own
    unless given.
    Returns shape (n,) [m]; zero where a pulley is held.
    """
    omega = model.natural if forcing is None else forcing
    speed = torque * model.rigid_arm / (model.rigid_mass * omega)
    decay = model.rigid_damping / model.rigid_mass
    drift = -np.expm1(-decay * time) / decay if decay > 0.0 else time
    return np.asarray(speed * (drift - np.sin(omega * time) / omega))
