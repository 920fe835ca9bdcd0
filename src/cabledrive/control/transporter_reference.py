r"""What a transporter needs to carry its payload along a wanted motion, and what a user would give it.

The payload's place y is the flat output of transporter and swing: carriage, cable force and motor follow from
y and its derivatives, without a differential equation but the lags of the dampers.
"""

from math import exp, pi, sqrt

import numpy as np

from cabledrive.control.reference import lagged
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.transporter import (
    BODIES,
    Transporter,
    compliance,
    held_frequencies,
)

SLOPE = 500.0
"""K of tanh(K v) by which friction follows the reference's speed [s/m]."""


def flat_motion(transporter: Transporter, payload: Array, interval: float) -> Array:
    r"""States and force along a motion of the payload, Eqs. (T.4) and (T.5).

    .. math::
        s - y &= \frac{\ell}{g}\frac{\ddot y}{1 + T_s p}, \qquad F = m\ddot s + m_p\ddot y + b\dot s, \\
        q_1 - s &= \frac{c(x_0 + s)F}{1 + Tp}

    with p the derivative; those of :math:`c(x_0 + s)F` follow by the product rule from those of y.

    ``payload``, shape (7, samples): wanted displacement of the payload and its derivatives [m/s^k];
    ``interval``: sample time [s].
    Returns shape (samples, 10): displacements and speeds of drive pulley, carriage, load pulley, payload;
    force of the motor with its friction; that friction [N].
    """
    t, y = transporter, payload
    s = y[:5] + t.line_length / t.gravity * lagged(y[2:], t.swing_damping, interval)
    share = t.span_length / (2.0 * t.span_length - t.start - s[0])  # of the load pulley that moves with s
    mass = t.carriage_mass + t.load_mass * share
    force = mass * s[2:] + t.payload_mass * y[2:5] + t.rail_friction * s[1:4]
    c0, c1, c2 = compliance(t, t.start + s[0])
    stretch = np.array(
        [
            c0 * force[0],
            c1 * s[1] * force[0] + c0 * force[1],
            (c2 * s[1] ** 2 + c1 * s[2]) * force[0] + 2.0 * c1 * s[1] * force[1] + c0 * force[2],
        ]
    )
    motor = s[:3] + lagged(stretch, t.damping_time, interval)
    load = share * s[:3] + (1.0 - share) * motor[:3]
    needed = t.drive_mass * motor[2] + t.load_mass * load[2] + t.carriage_mass * s[2] + t.payload_mass * y[2]
    needed = needed + t.rail_friction * s[1]
    return _rows(t, (motor, s, load, y), needed)


def rigid_motion(transporter: Transporter, wanted: Array) -> Array:
    """As `flat_motion` of a transporter without flexibility and swing, Eq. (T.8), from derivatives to s''."""
    t = transporter
    force = t.masses.sum() * wanted[2] + t.rail_friction * wanted[1]
    return _rows(t, (wanted,) * BODIES, force)


def _rows(transporter: Transporter, motions: tuple[Array, ...], force: Array) -> Array:
    t, speed = transporter, motions[0][1]
    friction = t.viscous * speed + t.coulomb * np.tanh(SLOPE * speed) - t.offset
    dry = friction - t.viscous * speed
    columns = [m[0] for m in motions] + [m[1] for m in motions] + [force + friction, dry]
    return np.ascontiguousarray(np.column_stack(columns))


def shaped(transporter: Transporter, wanted: Array, interval: float, position: float) -> tuple[Array, float]:
    """A motion through zero-vibration shapers for swing and carriage, Eq. (T.9), and by how much longer [s].

    ``position``: of the carriage for which the shaper is made, the motor held [m].
    """
    t, late = transporter, 0.0
    swing, cable = (float(f) for f in held_frequencies(t, position)[:2])
    for omega, ratio in ((swing, 0.5 * t.swing_damping * swing), (cable, 0.5 * t.damping_time * cable)):
        omega_d = omega * sqrt(1.0 - ratio**2)
        fade = exp(-ratio * pi / sqrt(1.0 - ratio**2))
        shift = round(pi / omega_d / interval)
        held_back = np.concatenate((np.zeros((len(wanted), shift)), wanted[:, :-shift]), axis=1)
        wanted = (wanted + fade * held_back) / (1.0 + fade)
        late += shift * interval
    return wanted, late
