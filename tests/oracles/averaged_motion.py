r"""Motion by the averaged equations to first and to second order, beside the exact loop.

To second order, Eq. (A.15), the slow rates of change and the third harmonic of the spans come in:

.. math::
    \dot Q &= R_Q + \frac{i}{2\Omega}(\dot R_Q + cR_Q)
        + \frac{i}{16\nu^2\Omega}\sum_j \frac{G_j^2}{Mm_j}|z_j|^2 Q \\
    \dot z_j &= R_j + \frac{i}{2\nu}(\dot R_j + \Gamma R_j) + \frac{i}{16\nu^3}\frac{G_j^2}{m_j^2}|Q|^2 z_j

and the motion that belongs to slow amplitudes is, Eq. (A.18),

.. math::
    q = \operatorname{Re} Qe^{i\Omega t} + q_0, \qquad a_j = \operatorname{Re}\Big[z_j e^{i\nu t} +
    \frac{G_j}{8\nu^2 m_j} Q z_j e^{3i\nu t}\Big]

A pluck at rest is not Q = 0: the tension of the plucked span holds the pulleys away from where the averaged
motion swings about, and the difference is a real Q(0). Free exchange in closed form: two plucks a > b in one
plane, no damping, tuned. With A, B the amplitudes of the spans, AB stays and half the logarithm of A/B swings
in a well of hyperbolic cosine: the spans swap their amplitudes and swap them back.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from reproduction.forced_motion import SeenMotion, envelope
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.averaging import (
    AveragedCoefficients,
    averaged_coefficients,
    averaged_rates,
    linear_rates,
)

HARMONICS = np.arange(3, 40, 2)
FIRST_SINE = 8 / np.pi**2  # of a triangle of height one
PASSES = 12


@dataclass(frozen=True)
class Slow:
    """Averaged equations to an order, with the stretch of modes that only decay, (J, ...) [m^2]."""

    c: AveragedCoefficients
    passive: object = 0.0
    second: bool = True

    def rates(self, state, time=0.0):
        """Rates of Q and z, shape (1 + J, ...) [m/s], Eqs. (A.14), (A.15)."""
        c, q, z = self.c, state[0], state[1:]
        decayed = np.zeros_like(np.abs(z)) + self.passive * np.exp(-c.transverse_damping * time)
        shift = np.einsum("jk...,k...->j...", 0.5 * c.cubic - c.static, decayed)
        first = averaged_rates(c, state, time)
        rate_q, rate_z = first[0], first[1:] + 1j * shift * z
        if not self.second:
            return np.concatenate((rate_q[None], rate_z))
        (linear, along), nu = linear_rates(c, time), 0.5 * c.forcing
        linear = linear + 1j * shift
        bend_q = along * rate_q + 2j * np.sum(c.feedback * z * rate_z, axis=0)
        bend_z = linear * rate_z + 1j * c.pump * (rate_q * z.conj() + q * rate_z.conj())
        total_q = rate_q + 0.5j / c.forcing * (bend_q + c.damping * rate_q)
        total_q = total_q + 1j * np.sum(c.pump * c.feedback / (2.0 * nu) * np.abs(z) ** 2, axis=0) * q
        total_z = rate_z + 0.5j / nu * (bend_z + c.transverse_damping * rate_z)
        third = 1j * c.pump**2 / (4.0 * nu) * np.abs(q) ** 2 * z
        return np.concatenate((total_q[None], total_z + third))

    def static(self, z, z_rate, time):
        """Static rotation q0 by the mean stretch and by the drift, and its rate."""
        c = self.c
        offset = 0.5 * np.einsum("jj...->j...", c.static) / c.pump
        passive = self.passive * np.exp(-c.transverse_damping * time)
        drift = 0.5 * c.drift[0] / c.pump[0] * np.exp(-c.drift_decay * time)
        size = np.abs(z) ** 2 + passive
        growth = 2.0 * (z.conj() * z_rate).real - c.transverse_damping * passive
        return drift - np.sum(offset * size, axis=0), -c.drift_decay * drift - np.sum(offset * growth, axis=0)


class Motion(NamedTuple):
    """Displacements [m] and speeds [m/s] of the oscillators."""

    q: object
    q_rate: object
    a: object
    a_rate: object


def reconstruct(slow, state, time):
    """The motion that belongs to slow amplitudes, shape (1 + J, ...) [m], at a time [s], Eq. (A.18)."""
    c, rates = slow.c, slow.rates(state, time)
    q, z, q_rate, z_rate = state[0], state[1:], rates[0], rates[1:]
    nu = 0.5 * c.forcing
    turn = np.exp(1j * nu * time)
    third = c.pump / (2.0 * c.forcing) * slow.second  # G / (8 nu^2 m), third harmonic per Q z
    wave = z + third * q * z * turn**2
    wave_rate = z_rate + 1j * nu * z + third * turn**2 * (q_rate * z + q * z_rate + 3j * nu * q * z)
    static, static_rate = slow.static(z, z_rate, time)
    return Motion(
        q=(q * turn**2).real + static,
        q_rate=((q_rate + 1j * c.forcing * q) * turn**2).real + static_rate,
        a=(wave * turn).real,
        a_rate=(wave_rate * turn).real,
    )


def start_of(slow, motion):
    """Slow amplitudes whose reconstruction is a motion at t = 0, Eq. (A.19), by repeated correction."""
    c, nu = slow.c, 0.5 * slow.c.forcing
    lanes = np.broadcast_shapes(c.force.shape, np.shape(motion.q), c.transverse_detuning.shape[1:])
    state = np.zeros((1 + c.pump.shape[0], *lanes), dtype=complex)
    for _ in range(PASSES):
        found = reconstruct(slow, state, 0.0)
        state[0] += motion.q - found.q - 1j * (motion.q_rate - found.q_rate) / c.forcing
        state[1:] += motion.a - found.a - 1j * (motion.a_rate - found.a_rate) / nu
    return state


def plucked(slow, plucks):
    """Slow amplitudes of half-sine plucks [m], shape (J, ...), let go at rest, the pulleys at angle zero."""
    a = np.asarray(plucks, dtype=float)
    zero = np.zeros(a.shape[1:])
    return start_of(slow, Motion(q=zero, q_rate=zero, a=a, a_rate=np.zeros_like(a)))


def triangle_stretch(pluck):
    r"""Stretch of the modes 3, 5, ... of a triangular pluck as a squared amplitude of the first, Eq. (A.17).

    .. math:: \sum_{m=3,5,\dots} m^2 |A_m|^2 = \Big(\frac{8}{\pi^2}\Big)^2\Big(\frac{\pi^2}{8} - 1\Big) a^2
              = 0.1535\,a^2
    """
    return (8 / np.pi**2) ** 2 * (np.pi**2 / 8 - 1.0) * np.asarray(pluck, dtype=float) ** 2


def averaged_motion(case, time, *, second=True):
    """The same motion at times (n,) [s] by the averaged equations and the rigid rotation, Eq. (A.21)."""
    model, plucks = autoparametric_model(case.drive, number=1), np.array(case.plucks)
    passive = triangle_stretch(plucks) if case.shape == "triangle" else np.zeros(2)
    first = plucks * (FIRST_SINE if case.shape == "triangle" else 1.0)
    c = Slow(averaged_coefficients(model, torque=case.torque, forcing=case.forcing), passive, second=second)
    state = averaged_history(c, plucked(c, first), time)
    lanes = averaged_coefficients(model, torque=[case.torque], forcing=case.forcing)
    motion = reconstruct(Slow(lanes, passive[:, None], second=second), state, time)  # one time a lane
    across = motion.a[0]
    if case.shape == "triangle":
        size = np.abs(state[1:]) ** 2 + passive[:, None] * np.exp(-c.c.transverse_damping[:, None] * time)
        across = across + _harmonics(case.plucks[0], model, c.c, time, size, state[0])
    # the rigid rotation under a sine that starts at t = 0; the pulley mode's friction is left out
    decay, speed = model.rigid_damping / model.rigid_mass, case.torque * model.rigid_arm / model.rigid_mass
    drift = -np.expm1(-decay * time) / decay if decay > 0.0 else time
    rim = model.rims[1] * motion.q + speed / case.omega * (drift - np.sin(case.omega * time) / case.omega)
    return SeenMotion(time=time, load_angle=rim / model.load_radius, midpoint=across)


def _harmonics(pluck, model, c, time, size, q):
    """Sines 3, 5, ... of the upper span at midspan: they decay, follow the tension, bear side bands of q."""
    shift = (0.5 * c.cubic - c.static)[0] @ size + c.drift[0] * np.exp(-float(c.drift_decay) * time)
    rate = model.transverse[0] + shift
    phase = np.concatenate(([0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(time))))
    height = FIRST_SINE * pluck * np.exp(-0.5 * float(c.transverse_damping[0]) * time)
    omega, m = float(c.forcing), HARMONICS[:, None]
    strength = m**2 * c.pump[0] * q * np.exp(1j * omega * time) / omega
    side = 1.0 + strength / (m + 1) - strength.conj() / (m - 1)
    return height * np.sum((side * np.exp(1j * m * phase)).real / m**2, axis=0)


def averaged_history(c, start, times):
    """Slow amplitudes from `start`, shape (1 + J,) [m], at times (n,) [s] from 0 on; shape (1 + J, n)."""
    span = (0.0, float(times[-1]))
    found = solve_ivp(
        lambda time, state: c.rates(state, time),
        span,
        start.astype(complex),
        "DOP853",
        times,
        rtol=1e-10,
        atol=1e-14,
    )
    return np.asarray(found.y)


def disagreement(case, exact, other):
    """Largest difference of two motions' envelopes over the largest envelope, of load angle and midpoint.

    A peak is taken over two periods of the forcing; both motions are at the same times.
    """
    errors = []
    for name in ("load_angle", "midpoint"):
        signals = (getattr(motion, name) for motion in (exact, other))
        true, found = (envelope(exact.time, signal, 4 * np.pi / case.omega) for signal in signals)
        errors.append(float(np.max(np.abs(found - true)) / np.max(true)))
    return errors[0], errors[1]


def own_sensitivity(case, time):
    """How much a change of the plucks by a thousandth changes the motion: the larger of the disagreements."""
    nudged = replace(case, plucks=(case.plucks[0] * 1.001, case.plucks[1]))
    return max(disagreement(case, averaged_motion(case, time), averaged_motion(nudged, time)))


def exchange_period(model, first, second):
    r"""Time in which two unequal plucks swap and swap back, Eq. (A.30).

    .. math:: T = \frac{2K(m)}{\sqrt{\alpha k\,ab}}, \qquad m = -\frac{(a - b)^2}{4ab}

    with the complete elliptic integral K of parameter m; of a tuned model whose dampings and detunings are
    left out, and plucks a and b [m].
    Returns [s]; infinite where one span alone was plucked, all its energy ending in the pulleys.
    """
    a, b = abs(first), abs(second)
    if a * b == 0.0:
        return float("inf")
    c = averaged_coefficients(model)
    rate = float(np.sqrt(c.feedback[0] * c.pump[0] * a * b))
    return float(2.0 * ellipk(-((a - b) ** 2) / (4 * a * b)) / rate)


def largest_exchange(model, first, second):
    r"""Largest displacement [m] of the pulley mode while two plucks [m] swap, tuned, undamped, Eq. (A.31).

    .. math:: q_{\max} = \sqrt{\frac{m_t}{4M}}\,|a - b|

    """
    return float(np.sqrt(model.transverse_mass[0] / (4 * model.modal_mass)) * abs(abs(first) - abs(second)))
