"""Compiled motion of one rigid axis inside a sampled position loop with an inner speed loop."""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit


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
