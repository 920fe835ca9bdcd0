"""One rigid axis inside the loop that moved it: a test of identified parameters that needs no open loop."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.compiled import njit

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class PositionLoop:
    """Proportional position loop over a proportional speed loop: u = kv (kp (reference - position) - speed).

    ``position_gain``: kp [1/s]; ``speed_gain``: kv [V s/rad or V s/m]; ``force_per_volt``: gain of amplifier
    and motor [N m/V or N/V]; ``largest_command``: [V].
    """

    position_gain: float
    speed_gain: float
    force_per_volt: float
    largest_command: float = float("inf")


def integrate_position_loop_of(
    values: Array,
    loop: PositionLoop,
    reference: Array,
    interval: float,
    substeps: int = 10,
    start: tuple[float, float] | None = None,
    disturbance: Array | None = None,
) -> tuple[Array, Array, Array]:
    """Move an axis along a reference.

    ``values``, shape (4,): inertia, viscous friction, Coulomb friction, offset with the sign of (4.16);
    ``reference``, shape (samples,) [rad or m]; ``interval`` [s]; ``substeps``: steps per sample; ``start``:
    position and speed at the first sample; default: at rest on the reference; ``disturbance``, shape
    (samples,): torque or force from outside, standing from sample to sample; default: none.
    Returns ``position, speed, command``, shape (samples,).
    """
    out = np.empty((3, reference.size))
    numbers = np.array([loop.position_gain, loop.speed_gain, loop.force_per_volt, loop.largest_command])
    begin = np.array((reference[0], 0.0) if start is None else start, dtype=float)
    integrate_position_loop(
        np.array(values, dtype=float),
        numbers,
        np.ascontiguousarray(reference, dtype=float),
        np.zeros(reference.size) if disturbance is None else np.ascontiguousarray(disturbance, dtype=float),
        begin,
        interval,
        substeps,
        out,
    )
    return out[0], out[1], out[2]


@njit
def integrate_position_loop(
    p: Array,
    loop: Array,
    reference: Array,
    disturbance: Array,
    start: Array,
    interval: float,
    substeps: int,
    out: Array,
) -> None:
    """Position, speed and command at every sample.

    ``loop`` holds kp, kv, gain and largest command; ``start`` position and speed; ``disturbance`` is a force
    that stands from sample to sample. The controller works once
    per sample, on the position and its backward difference, and its command stands until the next. Friction
    is set-valued: the speed after a step solves its equation with the friction in it, so that the axis sticks
    and slips by itself.
    """
    h = interval / substeps
    position, speed = start[0], start[1]
    before = position - interval * speed
    kp, kv, gain, most = loop[0], loop[1], loop[2], loop[3]
    half = 0.5 * h * p[1] / p[0]
    shrink = h / p[0] * p[2]
    for sample in range(reference.size):
        command = kv * (kp * (reference[sample] - position) - (position - before) / interval)
        command = min(max(command, -most), most)
        before = position
        out[0, sample] = position
        out[1, sample] = speed
        out[2, sample] = command
        for _ in range(substeps):
            free = (1.0 - half) * speed + h / p[0] * (gain * command + disturbance[sample] + p[3])
            if free > shrink:
                new = (free - shrink) / (1.0 + half)
            elif free < -shrink:
                new = (free + shrink) / (1.0 + half)
            else:
                new = 0.0
            position += 0.5 * h * (speed + new)
            speed = new
