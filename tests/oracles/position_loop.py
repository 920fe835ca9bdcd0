"""One rigid axis inside the loop that moved it: a test of identified parameters that needs no open loop."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.compiled import njit

Array = NDArray[np.float64]


class PositionLoop(NamedTuple):
    """Position loop over a speed loop, both proportional: u = kv (kp (reference - position) - speed)."""

    position_gain: float  # kp [1/s]
    speed_gain: float  # kv [V s/rad or V s/m]
    force_per_volt: float  # gain of amplifier and motor [N m/V or N/V]
    largest_command: float = float("inf")  # [V]


def integrate_position_loop_of(
    values: Array,
    loop: PositionLoop,
    reference: Array,
    interval: float,
    substeps: int = 10,
    start: tuple[float, float] | None = None,
    disturbance: Array | None = None,
) -> tuple[Array, Array, Array]:
    """Position, speed and command, shape (samples,), of an axis along a reference [rad or m].

    ``values``, shape (4,): inertia, viscous friction, Coulomb friction, offset with the sign of (4.16);
    ``substeps``: steps per sample; ``start``: position and speed, by default at rest on the reference;
    ``disturbance``, shape (samples,): torque or force from outside, standing from sample to sample.
    """
    out = np.empty((3, reference.size))
    begin = np.array((reference[0], 0.0) if start is None else start, dtype=float)
    given = np.zeros(reference.size) if disturbance is None else disturbance
    signals = (np.ascontiguousarray(one, dtype=float) for one in (reference, given))
    numbers = PositionLoop(*map(float, loop))
    integrate_position_loop(np.array(values, dtype=float), numbers, *signals, begin, interval, substeps, out)
    return out[0], out[1], out[2]


@njit
def integrate_position_loop(
    p: Array,
    loop: PositionLoop,
    reference: Array,
    disturbance: Array,
    start: Array,
    interval: float,
    substeps: int,
    out: Array,
) -> None:
    """Position, speed and command at every sample.

    The controller works once per sample, on the position and its backward difference, and its command stands
    until the next. Friction is set-valued: the speed after a step solves its equation with the friction in
    it, so that the axis sticks and slips by itself.
    """
    h = interval / substeps
    position, speed = start[0], start[1]
    before = position - interval * speed
    kp, kv, gain, most = loop
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
