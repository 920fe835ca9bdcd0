r"""The model of internal resonance as oscillators in time: nothing averaged.

One step is half a kick, the exact flow of the damped linear oscillators, half a kick; the kick is

.. math::
    \Delta\dot q &= h\Big(\frac{\phi_\tau\tau/r_1 - c_{12}v - \sum_j G_j a_j^2}{M}\Big), \qquad
    \Delta v = h\,\frac{\tau/r_1 - c_{11}v - c_{12}\dot q}{M_0} \\
    \Delta\dot a_j &= -\frac{h}{m_j}\Big(2G_j q + \sum_k N_{jk}a_k^2\Big)a_j. \qquad \text{Eq. (A.20)}

Frequencies and decays are exact at any step; the coupling is of second order.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.parameters.arrays import Array
from cabledrive.reduction.autoparametric import AutoparametricModel


class OscillatorCoefficients(NamedTuple):
    """What an integration needs; every array may end in an axis of lanes."""

    along: Array  # (4, ...): exact flow of q: q from q, q from rate, rate from q, rate from rate
    across: Array  # (4, J, ...): exact flow of a
    push: Array  # (J, ...): G / M [1/(m s^2)]
    pump: Array  # (J, ...): 2 G / m [1/(m s^2)]
    cubic: Array  # (J, J, ...): N / m [1/(m^2 s^2)]
    force: Array  # (...): acceleration of q by the torque's amplitude [m/s^2]
    rigid_force: Array  # (...): of the rigid rotation [m/s^2]
    turn: Array  # (...): angle of the torque per step [rad]
    cross: Array  # (...): c12 / M [1/s]
    rigid_decay: Array  # (...): c11 / M0 [1/s]
    rigid_cross: Array  # (...): c12 / M0 [1/s]
    step: Array  # (...): h [s]


def oscillator_coefficients(
    model: AutoparametricModel, step: float, *, torque: ArrayLike = 0.0
) -> OscillatorCoefficients:
    """Coefficients of a step [s], Eq. (A.20), with the model's lanes, forced at its pulley mode [N m]."""
    tau = np.asarray(torque, dtype=float)
    damping = np.asarray(model.transverse_damping, dtype=float)
    rigid = model.rigid_arm > 0.0
    cross = model.cross_damping if rigid else 0.0
    return OscillatorCoefficients(
        along=linear_flow(np.asarray(model.natural), np.asarray(model.modal_damping), step),
        across=linear_flow(model.transverse, damping, step),
        push=model.coupling / model.modal_mass,
        pump=2.0 * (model.coupling.T / model.transverse_mass).T,
        cubic=(model.stiffening.T / model.transverse_mass).T,
        force=tau * model.torque_arm / model.modal_mass,
        rigid_force=tau * model.rigid_arm / model.rigid_mass,
        turn=np.asarray(model.natural * step),
        cross=np.asarray(cross / model.modal_mass),
        rigid_decay=np.asarray(model.rigid_damping / model.rigid_mass if rigid else 0.0),
        rigid_cross=np.asarray(cross / model.rigid_mass),
        step=np.asarray(step),
    )


def linear_flow(natural: Array, damping: Array, step: float) -> Array:
    """Exact flow over a step [s], (4, ...): place from place and from rate, rate from place and from rate."""
    root = np.sqrt((natural**2 - 0.25 * damping**2).astype(complex)) * step
    decay = np.exp(-0.5 * damping * step)
    turn = decay * np.cos(root).real
    push = decay * step * np.sinc(root / np.pi).real
    return np.array([turn + 0.5 * damping * push, push, -(natural**2) * push, turn - 0.5 * damping * push])


def integrate_oscillators_reference(
    c: OscillatorCoefficients, plucks: Array, steps: int, stride: int
) -> Array:
    """Readable twin of the compiled integrator, for any number of transverse modes and lanes.

    From plucks [m], shape (J, ...), at rest; returns q, v, a every ``stride`` steps, (records, 2 + J, ...).
    """
    a = np.array(plucks, dtype=float)
    b, q, p, v = np.zeros_like(a), np.zeros(a.shape[1:]), np.zeros(a.shape[1:]), np.zeros(a.shape[1:])
    records = []
    for n in range(steps + 1):
        if n % stride == 0:
            records.append(np.concatenate((q[None], v[None], a)))
        h = (0.5 if n in (0, steps) else 1.0) * c.step
        wave = np.sin(n * c.turn)
        q_force = c.force * wave - c.cross * v - np.sum(c.push * a**2, axis=0)
        v_force = c.rigid_force * wave - c.rigid_decay * v - c.rigid_cross * p
        b = b - h * (c.pump * q + np.einsum("jk...,k...->j...", c.cubic, a**2)) * a
        p, v = p + h * q_force, v + h * v_force
        if n < steps:
            q, p = c.along[0] * q + c.along[1] * p, c.along[2] * q + c.along[3] * p
            a, b = c.across[0] * a + c.across[1] * b, c.across[2] * a + c.across[3] * b
    return np.array(records)
