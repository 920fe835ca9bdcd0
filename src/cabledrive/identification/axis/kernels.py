"""Compiled observer of one rigid axis with set-valued friction, what disturbances add to it, its shadow."""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit

SPARE = 1.2
"""Half gaps at which a load that was left meets the same side again: less is noise of the speed."""


@njit
def one_sample(p: Array, v: float, u: float, h: float) -> tuple[float, float, float, float, float]:
    """Speed at the end, angle gone through, mean acceleration, direction, and jump of a sensitivity.

    ``p`` holds inertia, viscous and Coulomb friction, offset; the torque ``u`` stands. The speed that turns
    is followed to its zero; there the axis sticks (direction 0) or goes on.
    """
    load = u + p[3]
    side = 1.0 if v > 0.0 else (-1.0 if v < 0.0 else 0.0)
    if side == 0.0:
        if abs(load) <= p[2]:
            return 0.0, 0.0, 0.0, 0.0, 0.0
        side = 1.0 if load > 0.0 else -1.0
        a = (load - side * p[2]) / p[0]
        a -= 0.5 * h * a * p[1] / p[0]
        return h * a, 0.5 * h * h * a, a, side, 1.0
    a = (load - side * p[2] - p[1] * v) / p[0]
    a -= 0.5 * h * a * p[1] / p[0]
    end = v + h * a
    if end * side >= 0.0:
        return end, h * (v + 0.5 * h * a), a, side, 1.0
    first = -v / a
    gone = 0.5 * first * v
    if abs(load) <= p[2]:
        return 0.0, gone, -v / h, 0.0, 0.0
    other = 1.0 if load > 0.0 else -1.0
    after = (load - other * p[2]) / p[0]
    rest = h - first
    return rest * after, gone + 0.5 * rest * rest * after, (rest * after - v) / h, other, after / a


@njit
def observe(p: Array, gains: Array, torque: Array, angle: Array, start: Array, h: float, out: Array) -> None:
    """Innovation, predicted speed, acceleration, direction and jump of a sensitivity at every sample.

    ``torque[k]`` stands from sample k to the next; ``gains`` correct angle and speed by the innovation.
    ``out`` has the rows innovation, speed, acceleration, direction, jump.
    """
    x, v = start[0], start[1]
    for k in range(angle.size):
        e = angle[k] - x
        x += gains[0] * e
        v += gains[1] * e
        end, gone, a, side, jump = one_sample(p, v, torque[k], h)
        out[0, k] = e
        out[1, k] = v
        out[2, k] = a
        out[3, k] = side
        out[4, k] = jump
        x += gone
        v = end


@njit
def answers(p: Array, gains: Array, torques: Array, side: Array, jump: Array, h: float, out: Array) -> None:
    """What small disturbing torques would add to the predicted angle, both of shape (m, samples)."""
    decay = 1.0 - h * p[1] / p[0]
    for c in range(torques.shape[0]):
        x, v = 0.0, 0.0
        for k in range(side.size):
            out[c, k] = x
            v -= gains[1] * x
            x -= gains[0] * x
            if side[k] == 0.0:
                x += 0.5 * h * v
                v = 0.0
            else:
                new = jump[k] * decay * v + h * torques[c, k] / p[0]
                x += 0.5 * h * (v + new)
                v = new


@njit
def loosen(net: Array, speed: Array, gap: float, h: float, contact: int, added: Array) -> None:
    """Torque that backlash adds: all that accelerates an axis while its load is loose, then its return.

    The load coasts while it is loose, takes the speed of the motor where the play ends, and is left again
    where the motor is accelerated away from it. What the motor alone got is taken back over ``contact``
    samples.
    """
    added[:] = 0.0
    apart, load, side, last, surplus = 0.0, 0.0, 0.0, 1.0, 0.0
    half = 0.5 * gap
    for k in range(net.size):
        if side != 0.0 and side * net[k] < 0.0:
            side, load, surplus = 0.0, speed[k], 0.0
        if side == 0.0:
            added[k] += net[k]
            surplus += net[k]
            apart += h * (speed[k] - load)
            if -last * apart >= half or last * apart > SPARE * half:
                side = 1.0 if apart > 0.0 else -1.0
                last = side
                apart = side * half
                for later in range(k + 1, min(k + 1 + contact, net.size)):
                    added[later] -= surplus / contact


@njit
def shadow(
    p: Array, gains: Array, torque: Array, angle: Array, speed: Array, h: float, moved: Array, acting: Array
) -> None:
    """A rigid axis under the torque and a soft servo along the angle: where it goes, and what acts on it.

    ``gains`` are torque per angle and torque per speed.
    """
    x, v = angle[0], speed[0]
    for k in range(angle.size):
        moved[k] = x
        acting[k] = torque[k] + gains[0] * (angle[k] - x) + gains[1] * (speed[k] - v)
        end, gone, _a, _side, _jump = one_sample(p, v, acting[k], h)
        x += gone
        v = end
