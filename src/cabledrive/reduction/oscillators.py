r"""The model of internal resonance as oscillators in time, of many parameter sets at once.

One step is half a kick, the exact flow of the damped linear oscillators, half a kick; the kick is

.. math::
    \Delta\dot q &= h\Big(\frac{\phi_\tau\tau/r_1 - c_{12}v - \sum_j G_j a_j^2}{M}\Big), \qquad
    \Delta v = h\,\frac{\tau/r_1 - c_{11}v - c_{12}\dot q}{M_0} \\
    \Delta\dot a_j &= -\frac{h}{m_j}\Big(2G_j q + \sum_k N_{jk}a_k^2\Big)a_j. \qquad \text{Eq. (A.20)}

Frequencies and decays are exact at any step; the coupling is of second order.
"""


# mypy: allow-untyped-defs

from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.mechanics.compiled import njit
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.autoparametric import AutoparametricModel
from cabledrive.reduction.stretches import linear_flow


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


AXES = {"along": 1, "push": 1, "pump": 1, "across": 2, "cubic": 2}
"""Axes of coefficients that are not lanes, where there are any."""


class Largest(NamedTuple):
    """What an ensemble has reached."""

    pulley: Array  # (lanes,): largest q, either way [m]
    spans: Array  # (J, lanes): largest amplitude a of each section [m]
    state: Array  # at the end: q and a, shape (1 + J, lanes)


def oscillator_ensemble(
    c: OscillatorCoefficients, plucks: ArrayLike, steps: int, *, threads: int = 2
) -> Largest:
    """Largest displacements of many parameter sets by the oscillators themselves.

    ``plucks``, shape (J, lanes): amplitudes at t = 0, at rest [m]; ``steps``: of the length in `c`.
    """
    start = np.asarray(plucks, dtype=float)
    if start.ndim != 2:
        raise InputRefused(f"start has {start.ndim} axes, an ensemble needs 2: amplitudes and lanes")
    wide = {}  # coefficients with an axis of lanes each
    for name, value in c._asdict().items():
        own = np.asarray(value)
        own = own[..., None] if own.ndim == AXES.get(name, 0) else own
        wide[name] = np.ascontiguousarray(np.broadcast_to(own, (*own.shape[:-1], start.shape[1])))
    state = np.concatenate((np.zeros((1, *start.shape[1:])), start))
    top = np.zeros_like(state)
    given, edges = (
        c._replace(**wide),
        np.linspace(0, start.shape[1], max(1, threads) + 1).astype(int).tolist(),
    )
    with ThreadPoolExecutor(max(1, threads)) as pool:
        part = partial(integrate_oscillators, given, steps, state, top)
        list(pool.map(part, edges[:-1], edges[1:]))
    return Largest(top[0], top[1:], state)


@njit
def integrate_oscillators(c, steps, state, top, first, last):
    """Half a kick, exact flow, half a kick, of lanes `first` to `last`; state and largest in place."""
    sections = state.shape[0] - 1
    a, b, squares = np.empty(sections), np.empty(sections), np.empty(sections)
    for i in range(first, last):
        q, p, v = 0.0, 0.0, 0.0
        cosine, sine, turn_cos, turn_sin = 1.0, 0.0, np.cos(c.turn[i]), np.sin(c.turn[i])
        for j in range(sections):
            a[j], b[j] = state[1 + j, i], 0.0
        for n in range(steps + 1):
            h = (0.5 if n == 0 or n == steps else 1.0) * c.step[i]
            top[0, i] = max(top[0, i], abs(q))
            force = c.force[i] * sine - c.cross[i] * v
            rigid = c.rigid_force[i] * sine - c.rigid_decay[i] * v - c.rigid_cross[i] * p
            for j in range(sections):
                squares[j] = a[j] * a[j]
            for j in range(sections):
                top[1 + j, i] = max(top[1 + j, i], abs(a[j]))
                force -= c.push[j, i] * squares[j]
                stiff = c.pump[j, i] * q
                for k in range(sections):
                    stiff += c.cubic[j, k, i] * squares[k]
                b[j] -= h * stiff * a[j]
            p += h * force
            v += h * rigid
            if n < steps:
                q, p = c.along[0, i] * q + c.along[1, i] * p, c.along[2, i] * q + c.along[3, i] * p
                for j in range(sections):
                    place, rate = a[j], b[j]
                    a[j] = c.across[0, j, i] * place + c.across[1, j, i] * rate
                    b[j] = c.across[2, j, i] * place + c.across[3, j, i] * rate
                cosine, sine = cosine * turn_cos - sine * turn_sin, sine * turn_cos + cosine * turn_sin
        state[0, i] = q
        for j in range(sections):
            state[1 + j, i] = a[j]
