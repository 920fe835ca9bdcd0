r"""A transporter's law and observer over the positions, its reference, and its weights by one bandwidth.

States of the observer: displacements and speeds of drive pulley, carriage, load pulley and payload, a force
on the motor that walks at random, and the wind on the payload, which fades.

The payload's place y is the flat output of transporter and swing: carriage, cable force and motor follow from
y and its derivatives, without a differential equation but the lags of the dampers.

A mass M on a cost of :math:`x^2/e^2 + u^2/F^2` closes at :math:`\omega^2 = F/(eM)`; a steady observer whose
accelerations are noise of density q and whose readings are noise of density R, at :math:`\omega^4 = q/R`.
"""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from cabledrive.control.linear_laws import lq_gain
from cabledrive.control.load_schedule import ScheduledLaw, between
from cabledrive.control.observers import gathered_noise, settled_gain
from cabledrive.identification.signals import lagged
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import held
from cabledrive.reduction.transporter import (
    BODIES,
    Transporter,
    compliance,
    frozen_state_space,
    held_frequencies,
)
from cabledrive.trajectories.input_shaping import input_shaper

STATES = 2 * BODIES
OBSERVED = STATES + 2
ENCODERS = (0, 2)
"""Bodies whose displacements can be measured: drive pulley, load pulley."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TransporterTuning:
    """What law and observer weigh."""

    payload: float = 2e-3  # error [m] that weighs as much as the force
    carriage: float = 2e-3  # likewise [m]
    stretching: float = 0.02
    """Speed of the carriage against the drive pulley [m/s] that weighs as much; it damps the cable's mode."""
    force: float = 5.0  # [N]
    disturbance: float = 1.0  # walk of the force on the motor [N^2/s]
    wind: float = 0.05  # standard deviation of the wind's force [N]
    wind_time: float = 2.0  # how fast it fades [s]
    acceleration: float = 1e-4  # noise of every acceleration [(m/s^2)^2 s]
    reading: float = 1000.0  # variance of a reading over that of a rounded one


def sampled_model(
    transporter: Transporter, position: float, interval: float, wind_time: float
) -> tuple[Array, Array, Array]:
    """Observer's model at a position [m]: transition (10, 10), drive (10,), continuous matrix (10, 10)."""
    a, b = frozen_state_space(transporter, position)
    system = np.zeros((OBSERVED, OBSERVED))
    system[:STATES, :STATES] = a
    system[:STATES, STATES], system[:STATES, STATES + 1] = b[:, 0], b[:, 3]
    system[STATES + 1, STATES + 1] = -1.0 / wind_time
    return *held(system, np.append(b[:, 0], [0.0, 0.0]), interval), system


def feedback_at(transition: Array, drive: Array, tuning: TransporterTuning) -> Array:
    """Linear-quadratic feedback, (8,), of one frozen position, Eq. (T.6)."""
    weight = np.zeros((STATES, STATES))
    weight[1, 1], weight[3, 3] = tuning.carriage**-2, tuning.payload**-2
    weight[BODIES : BODIES + 2, BODIES : BODIES + 2] = [[1.0, -1.0], [-1.0, 1.0]]
    weight[BODIES:, BODIES:] /= tuning.stretching**2
    return lq_gain(transition, drive[:, None], weight, tuning.force**-2)[0]


def correction_at(
    transition: Array,
    system: Array,
    count: float,
    interval: float,
    tuning: TransporterTuning,
    reads: tuple[int, ...] = ENCODERS,
) -> Array:
    """Steady Kalman gain, (10, 2) by drive and load pulley, Eq. (T.7); ``count`` of encoders [m]."""
    density = np.zeros(OBSERVED)
    density[BODIES:STATES] = tuning.acceleration
    density[STATES] = tuning.disturbance
    density[STATES + 1] = 2.0 * tuning.wind**2 / tuning.wind_time
    output = np.eye(OBSERVED)[list(reads)]
    reading = np.eye(len(reads)) * tuning.reading * count**2 / 12.0
    # in counts: the equation is solved with numbers of one size
    scaled = gathered_noise(system, density, interval) / count**2
    gain = settled_gain(transition, scaled, output, reading / count**2)
    correction = np.zeros((OBSERVED, len(ENCODERS)))
    correction[:, [ENCODERS.index(body) for body in reads]] = gain[0]
    return correction


def scheduled_law(
    transporter: Transporter,
    *,
    interval: float,
    count: float,
    limit: float,
    positions: Array,
    tuning: TransporterTuning | None = None,
    frozen: float | None = None,
    reads: tuple[int, ...] = ENCODERS,
) -> ScheduledLaw:
    """Design law and observer at every position of an even grid [m] of two or more, or as of one ``frozen``.

    ``count``: one count of the encoders at the rim [m]; ``limit``: largest force [N]; ``reads``: `ENCODERS`.
    """
    tuning = tuning or TransporterTuning()
    rows = []
    for position in positions if frozen is None else [frozen]:
        transition, drive, system = sampled_model(transporter, float(position), interval, tuning.wind_time)
        gain = feedback_at(transition[:STATES, :STATES], drive[:STATES], tuning)
        correct = correction_at(transition, system, count, interval, tuning, reads)
        rows.append((gain, correct, transition, drive))
    if frozen is not None:
        rows = rows * len(positions)
    feedback, correction, transitions, drives = (np.array(part) for part in zip(*rows, strict=True))
    return ScheduledLaw(
        grid=np.array([positions[0], positions[1] - positions[0], transporter.start]),
        feedback=feedback,
        correction=correction,
        transition=transitions,
        drive=drives,
        limit=limit,
    )


def frozen_poles(
    law: ScheduledLaw, transporter: Transporter, position: float, interval: float, wind_time: float = 2.0
) -> Array:
    """Poles per sample, (18,), of law and observer on a plant, of its own numbers, frozen at a place [m]."""
    true, force, _ = sampled_model(transporter, position, interval, wind_time)
    plant, column = true[:STATES, :STATES], force[:STATES]
    gain, correct, go, push = (between(table, law.grid[0], law.grid[1], position) for table in law[1:5])
    gain = np.append(gain, np.zeros(OBSERVED - STATES))
    read = np.zeros((2, STATES))
    read[0, 0] = read[1, 2] = 1.0
    kept = np.eye(OBSERVED)
    kept[:, [0, 2]] -= correct
    taken = correct @ read  # corrected estimate = kept x^ + taken x
    closed = go - np.outer(push, gain)
    matrix = np.block(
        [
            [plant - np.outer(column, gain @ taken), -np.outer(column, gain @ kept)],
            [closed @ taken, closed @ kept],
        ]
    )
    return np.linalg.eigvals(matrix)


SLOPE = 500.0
"""K of tanh(K v) by which friction follows the reference's speed [s/m]."""


def flat_motion(transporter: Transporter, payload: Array, interval: float) -> Array:
    r"""States and force along a motion of the payload, Eqs. (T.4) and (T.5).

    .. math::
        s - y &= \frac{\ell}{g}\frac{\ddot y}{1 + T_s p}, \qquad F = m\ddot s + m_p\ddot y + b\dot s, \\
        q_1 - s &= \frac{c(x_0 + s)F}{1 + Tp}

    with p the derivative. ``payload``, (7, samples): wanted displacement and its derivatives [m/s^k]. Returns
    (samples, 10): displacements and speeds of drive pulley, carriage, load pulley, payload; force of the
    motor with its friction; that friction [N].
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
    """A motion through shapers for swing and carriage at a position [m], Eq. (T.9), and its delay [s]."""
    t, late = transporter, 0.0
    swing, cable = (float(f) for f in held_frequencies(t, position)[:2])
    for omega, ratio in ((swing, 0.5 * t.swing_damping * swing), (cable, 0.5 * t.damping_time * cable)):
        made = input_shaper("zv", omega / (2.0 * pi), ratio)
        shift = round(made.duration / interval)
        held_back = np.concatenate((np.zeros((len(wanted), shift)), wanted[:, :-shift]), axis=1)
        wanted = made.amplitudes[0] * wanted + made.amplitudes[1] * held_back
        late += shift * interval
    return wanted, late


OBSERVER = 1.5
"""Bandwidth of the observer over that of the law."""
STRETCHING = 0.24
"""Speed against the drive pulley that weighs as much as the error, over bandwidth times error."""
ERROR, WIND_TIME, READING = 2e-3, 2.0, 1000.0
UNWEIGHED = 1e6


def tuning_for(
    transporter: Transporter, bandwidth: float, *, interval: float, count: float, hanging: bool = True
) -> TransporterTuning:
    """Weights of law and observer by the bandwidth [rad/s] of the rigid whole; ``count``: at the rim [m]."""
    mass, error = float(transporter.masses.sum()), ERROR / sqrt(2.0) if hanging else ERROR
    density = READING * count**2 / 12.0 * interval  # of a reading's noise [m^2 s]
    observer = OBSERVER * bandwidth
    return TransporterTuning(
        payload=ERROR if hanging else UNWEIGHED * ERROR,
        carriage=ERROR,
        stretching=STRETCHING * bandwidth * ERROR,
        force=mass * error * bandwidth**2,
        disturbance=mass**2 * density * observer**6,
        wind=transporter.payload_mass * bandwidth**3 * sqrt(0.5 * WIND_TIME * density),
        wind_time=WIND_TIME,
        acceleration=density * observer**4,
        reading=READING,
    )
