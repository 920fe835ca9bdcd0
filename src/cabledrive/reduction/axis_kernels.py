"""Compiled motion of one rigid axis with Coulomb friction, and its sensitivities.

The quick case of a chain of one: `cabledrive.reduction.chain_kernels`, to which a test holds it equal.
"""

from math import tanh

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit

PARAMETERS = 5
"""Inertia, viscous friction, Coulomb friction, offset, speed at the start."""
CROSSING_STEPS = 12
MOST_TURNS = 8


Friction = tuple[float, float]
"""Slope of smoothed friction, 0 where it is set-valued; direction in which the axis slips, 0 at rest."""


@njit
def axis_rates(p: Array, friction: Friction, u: float, v: float, s: Array, ds: Array) -> float:
    """Acceleration, and the rates of the sensitivities into ``ds``."""
    slope, slip = friction
    if slip == 0.0:
        ds[:] = 0.0
        return 0.0
    level = tanh(slope * v) if slope > 0.0 else slip
    a = (u - p[1] * v - p[2] * level + p[3]) / p[0]
    fall = -p[1] / p[0]
    if slope > 0.0:
        fall -= p[2] * slope * (1.0 - level * level) / p[0]
    for k in range(PARAMETERS):
        ds[k] = fall * s[k]
    ds[0] -= a / p[0]
    ds[1] -= v / p[0]
    ds[2] -= level / p[0]
    ds[3] += 1.0 / p[0]
    return a


@njit
def axis_step(
    p: Array, friction: Friction, drive: tuple[float, float, float], v: float, s: Array, w: Array
) -> float:
    """One Runge-Kutta step of order 4; sensitivities at its end in row 5 of ``w``.

    ``drive``: torque at its start and its end, its length [s].
    """
    u0, u1, h = drive
    um = 0.5 * (u0 + u1)
    a0 = axis_rates(p, friction, u0, v, s, w[0])
    for k in range(PARAMETERS):
        w[4, k] = s[k] + 0.5 * h * w[0, k]
    a1 = axis_rates(p, friction, um, v + 0.5 * h * a0, w[4], w[1])
    for k in range(PARAMETERS):
        w[4, k] = s[k] + 0.5 * h * w[1, k]
    a2 = axis_rates(p, friction, um, v + 0.5 * h * a1, w[4], w[2])
    for k in range(PARAMETERS):
        w[4, k] = s[k] + h * w[2, k]
    a3 = axis_rates(p, friction, u1, v + h * a2, w[4], w[3])
    for k in range(PARAMETERS):
        w[5, k] = s[k] + h / 6.0 * (w[0, k] + 2.0 * (w[1, k] + w[2, k]) + w[3, k])
    return v + h / 6.0 * (a0 + 2.0 * (a1 + a2) + a3)


@njit
def release(load: float, rise: float, friction: float, done: float, interval: float) -> tuple[float, float]:
    """When within a step an axis at rest breaks away, and which way; the end and 0: not in this step."""
    now, end = load + rise * done, load + rise * interval
    if abs(now) > friction:
        return done, 1.0 if now > 0.0 else -1.0
    if abs(end) <= friction:
        return interval, 0.0
    way = 1.0 if end > 0.0 else -1.0
    return min(max(done, (way * friction - load) / rise), interval), way


@njit
def integrate_axis(
    p: Array, slope: float, torque: Array, interval: float, start: float, moved: tuple[Array, Array]
) -> None:
    """Speeds and sensitivities at every sample, into ``moved``; torque on straight lines between samples."""
    speeds, out = moved
    v = start
    s = np.zeros(PARAMETERS)
    s[4] = 1.0
    w = np.empty((6, PARAMETERS))
    slip = 1.0 if slope > 0.0 or v > 0.0 else (-1.0 if v < 0.0 else 0.0)
    for sample in range(torque.size):
        speeds[sample] = v
        for k in range(PARAMETERS):
            out[sample, k] = s[k]
        if sample == torque.size - 1:
            break
        u0, rise = torque[sample], (torque[sample + 1] - torque[sample]) / interval
        done = 0.0
        for _ in range(MOST_TURNS):
            if slip == 0.0:
                done, slip = release(u0 + p[3], rise, p[2], done, interval)
                if slip == 0.0:
                    break
            rest = interval - done
            ua, ub = u0 + rise * done, u0 + rise * interval
            end = axis_step(p, (slope, slip), (ua, ub, rest), v, s, w)
            if slope > 0.0 or slip * end >= 0.0 or p[2] <= 0.0:
                v = end
                s[:] = w[5]
                break
            low, high, at_low, at_high = 0.0, rest, slip * v, slip * end
            part = rest * at_low / (at_low - at_high) if at_low > 0.0 else 0.0
            for _ in range(CROSSING_STEPS):
                end = axis_step(p, (slope, slip), (ua, ua + rise * part, part), v, s, w)
                value = slip * end
                if abs(value) <= 1e-13 * abs(at_low - at_high) or high - low < 1e-14 * interval:
                    break
                if value > 0.0:
                    low, at_low, at_high = part, value, 0.5 * at_high
                else:
                    high, at_high, at_low = part, value, 0.5 * at_low
                part = (
                    low + (high - low) * at_low / (at_low - at_high)
                    if at_low > at_high
                    else 0.5 * (low + high)
                )
            load = ua + rise * part + p[3]
            before = load - slip * p[2]
            after = 0.0
            slip = 0.0 if abs(load) <= p[2] else (1.0 if load > 0.0 else -1.0)
            if slip != 0.0:
                after = load - slip * p[2]
            ratio = after / before if before != 0.0 else 0.0
            for k in range(PARAMETERS):
                s[k] = w[5, k] * ratio
            v = 0.0
            done += part
            if done >= interval * (1.0 - 1e-12):
                break
