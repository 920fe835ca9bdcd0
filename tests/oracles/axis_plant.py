"""One axis under a torque, integrated from event to event: no code is shared with the package.

The motion between two events is smooth (the sign of every speed, every contact and the torque's piece are
fixed) and is integrated by the classical Runge-Kutta scheme of order 4; a sign change of a speed, the end of
a rest and a contact inside a step are located by bisection, the step ends there, and the next begins with
the new signs. States: angle and speed of the motor, angle and speed of the load, deflection of the bristle
or, under `hysteresis`, of the belt's slack part: k (a x + (1 - a) z), z' = x' - (|x'| z + x' |z|)/(2 z_max).
"""

from typing import NamedTuple

import numpy as np
from numba import njit


class Axis(NamedTuple):
    """Numbers of the plant, SI."""

    inertia: float = 0.0
    viscous: float = 0.0
    coulomb: float = 0.0
    offset: float = 0.0
    stribeck_excess: float = 0.0
    stribeck_speed: float = 1.0
    quadratic: float = 0.0
    asymmetry: float = 0.0
    smooth_slope: float = 0.0
    bristle: float = 0.0
    cogging: float = 0.0
    cogging_count: float = 0.0
    cogging_phase: float = 0.0
    gravity: float = 0.0
    load_inertia: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    gap: float = 0.0
    hysteresis: float = 0.0  # 1 - a of Bouc and Wen
    hysteresis_size: float = 1.0  # z_max
    load_coulomb: float = 0.0
    load_viscous: float = 0.0
    coulomb_drift: float = 0.0
    load_dependence: float = 0.0
    ripple: float = 0.0  # of the drive's torque, relative, with the motor's angle
    ripple_count: float = 0.0
    ripple_phase: float = 0.0
    one_sided: float = 0.0  # more torque one way than the other, relative, half the difference
    start: float = 0.0
    start_speed: float = 0.0


STATES = 5


@njit(cache=True)
def _acting(p, x, torque):
    """Torque on the motor except friction and link."""
    return (
        torque * (1.0 + p.ripple * np.sin(p.ripple_count * x[0] + p.ripple_phase))
        + p.one_sided * abs(torque)
        + p.offset
        + p.cogging * np.sin(p.cogging_count * x[0] + p.cogging_phase)
        + p.gravity * np.sin(x[0])
    )


@njit(cache=True)
def _link(p, x, contact):
    if p.load_inertia == 0.0 or (contact == 0.0 and p.gap > 0.0):
        return 0.0
    twist = (1.0 - p.hysteresis) * (x[0] - x[2] - contact * 0.5 * p.gap) + p.hysteresis * x[4]
    return p.stiffness * twist + p.damping * (x[1] - x[3])


@njit(cache=True)
def _sliding(p, w, net, share):
    """Friction while the speed w is not zero, in the direction of w, without the viscous part."""
    if p.smooth_slope > 0.0:
        return share * p.coulomb
    return share * (
        p.coulomb + p.stribeck_excess * np.exp(-((w / p.stribeck_speed) ** 2))
    ) + p.load_dependence * abs(net)


@njit(cache=True)
def _rates(p, x, torque, sides, contact, share, out):
    link = _link(p, x, contact)
    net = _acting(p, x, torque) - link
    w = x[1]
    out[0] = w
    smooth = p.viscous * w + p.quadratic * w * abs(w) + p.asymmetry * abs(w)
    out[4] = 0.0
    if p.hysteresis > 0.0:
        rate = x[1] - x[3]
        out[4] = rate - 0.5 / p.hysteresis_size * (abs(rate) * x[4] + rate * abs(x[4]))
    if p.bristle > 0.0:
        stiff = share * p.coulomb / p.bristle
        level = share * (p.coulomb + p.stribeck_excess * np.exp(-((w / p.stribeck_speed) ** 2)))
        out[4] = w - stiff * abs(w) * x[4] / level
        out[1] = (net - smooth - stiff * x[4] - 0.5 * np.sqrt(stiff * p.inertia) * out[4]) / p.inertia
    elif p.smooth_slope > 0.0:
        out[1] = (net - smooth - share * p.coulomb * np.tanh(p.smooth_slope * w)) / p.inertia
    elif sides[0] == 0.0:
        out[1] = 0.0
    else:
        out[1] = (net - smooth - sides[0] * _sliding(p, w, net, share)) / p.inertia
    out[2] = x[3]
    out[3] = 0.0
    if p.load_inertia > 0.0 and sides[1] != 0.0:
        out[3] = (link - p.load_viscous * x[3] - sides[1] * p.load_coulomb) / p.load_inertia


@njit(cache=True)
def _step(p, x, begin, slope, h, sides, contact, share, work, out):
    """Runge-Kutta over h; the torque runs on the line begin + slope t."""
    rate, y, at = work[0], work[1], 0.0
    y[:], out[:] = x, x
    for weight, ahead in ((1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0)):
        _rates(p, y, begin + at * h * slope, sides, contact, share, rate)
        for i in range(STATES):
            out[i] += h / 6.0 * weight * rate[i]
            y[i] = x[i] + ahead * h * rate[i]
        at = ahead


@njit(cache=True)
def _contact_of(p, x):
    apart = x[0] - x[2]
    if apart >= 0.5 * p.gap:
        return 1.0
    return -1.0 if apart <= -0.5 * p.gap else 0.0


@njit(cache=True)
def _crossed(p, x, torque, sides, contact, share):
    """Whether the signs with which a step was made no longer hold at its end."""
    stiff = p.smooth_slope == 0.0 and p.bristle == 0.0
    if stiff and sides[0] != 0.0 and sides[0] * x[1] < 0.0:
        return 1
    if stiff and sides[0] == 0.0:
        net = _acting(p, x, torque) - _link(p, x, contact)
        if abs(net) > share * (p.coulomb + p.stribeck_excess) + p.load_dependence * abs(net):
            return 2
    if p.load_inertia > 0.0:
        if p.load_coulomb > 0.0 and sides[1] != 0.0 and sides[1] * x[3] < 0.0:
            return 3
        if p.load_coulomb > 0.0 and sides[1] == 0.0 and abs(_link(p, x, contact)) > p.load_coulomb:
            return 4
        if p.gap > 0.0 and _contact_of(p, x) != contact:
            return 5
    return 0


@njit(cache=True)
def _settle(p, x, torque, event, sides, contact, share):
    """New signs after an event."""
    if event in (1, 2):
        x[1] = 0.0
        net = _acting(p, x, torque) - _link(p, x, contact)
        free = abs(net) > share * (p.coulomb + p.stribeck_excess) + p.load_dependence * abs(net)
        sides[0] = np.sign(net) if free else 0.0
    if event in (3, 4):
        x[3] = 0.0
        link = _link(p, x, contact)
        sides[1] = np.sign(link) if abs(link) > p.load_coulomb else 0.0
    return _contact_of(p, x) if event == 5 else contact


@njit(cache=True)
def _advance(p, x, begin, slope, h, sides, contact, share, work):
    """Over h, from event to event."""
    left, last, trial = h, begin, work[2]
    for _ in range(200):
        _step(p, x, last, slope, left, sides, contact, share, work, trial)
        event = _crossed(p, trial, last + slope * left, sides, contact, share)
        if event == 0:
            x[:] = trial
            return contact
        low, high = 0.0, left
        for _ in range(40):
            middle = 0.5 * (low + high)
            _step(p, x, last, slope, middle, sides, contact, share, work, trial)
            now = _crossed(p, trial, last + slope * middle, sides, contact, share)
            if now == 0:
                low = middle
            else:
                high, event = middle, now
            if high - low < 1e-12:
                break
        _step(p, x, last, slope, high, sides, contact, share, work, trial)
        x[:] = trial
        last, left = last + slope * high, left - high
        contact = _settle(p, x, last, event, sides, contact, share)
        if left <= 1e-12:
            return contact
    return contact


@njit(cache=True)
def move(p, command, extra, reference, servo, sensor, interval, fine, line, angle, torque):
    """Angle of the motor and torque of the drive at every tick.

    ``command`` is the torque where ``servo[0]`` is 0, on lines between ticks where ``line`` is 1, else held;
    ``extra`` is a torque that nobody measures, held. ``servo``: on, gain of angle, of speed, of the integral,
    of the reference's acceleration, pole of the speed's filter. ``sensor``: quantum, phase, eccentricity,
    its phase, noise is added elsewhere.
    """
    x, sides, work = np.zeros(STATES), np.zeros(2), np.zeros((3, STATES))
    x[0], x[1], sides[0] = p.start, p.start_speed, np.sign(p.start_speed)
    if p.load_coulomb == 0.0:
        sides[1] = 1.0
    contact, filtered, whole = _contact_of(p, x), 0.0, 0.0
    seen_before = 0.0
    count = command.size
    for k in range(count):
        angle[k] = x[0]
        seen = x[0] + sensor[2] * np.sin(x[0] + sensor[3])
        if sensor[0] > 0.0:
            seen = sensor[0] * np.floor(seen / sensor[0] + sensor[1])
        if k == 0:
            seen_before = seen - interval * x[1]
        filtered += servo[5] * ((seen - seen_before) / interval - filtered)
        seen_before = seen
        if servo[0] > 0.0:
            off = reference[0, k] - seen
            whole += interval * off
            torque[k] = servo[1] * off + servo[2] * (reference[1, k] - filtered) + servo[3] * whole
            torque[k] += servo[4] * reference[2, k] + command[k]
        else:
            torque[k] = command[k]
        share = 1.0 + p.coulomb_drift * k / count
        begin, slope = torque[k] + extra[k], 0.0
        if line == 1 and k + 1 < count:
            slope = (command[k + 1] - command[k]) / interval
        if sides[0] == 0.0 and p.smooth_slope == 0.0 and p.bristle == 0.0:
            contact = _settle(p, x, begin, 2, sides, contact, share)
        for j in range(fine):
            h = interval / fine
            contact = _advance(p, x, begin + slope * j * h, slope, h, sides, contact, share, work)


def parameters(**values):
    """Numbers of the plant by name, all others as they are where a fault is absent."""
    return Axis(**{name: float(value) for name, value in values.items()})
