"""Logs of an axis whose belt has Bouc-Wen hysteresis, under a servo whose motion repeats.

The belt's force is k (a x + (1 - a) z) with the stretch x and z' = x' - (|x'| z + x' |z|) / (2 z_max); the
motor sticks and slips by Coulomb's law. Semi-implicit Euler steps of 25 microseconds.
"""

import numpy as np
from numba import njit

from oracles.axis_catalogue import DURATION, RATE, Made, drawn_axis, reference_of, sought

STEPS = 40
"""Of a sample."""


def hysteretic(seed):
    """One log and what an identification should find: the whole inertia, the motor's friction."""
    rng, count = np.random.default_rng([seed, 99]), round(DURATION * RATE)
    inertia, coulomb, viscous, offset = own = drawn_axis(rng)
    load, omega = rng.uniform(0.3, 0.5) * inertia, 2.0 * np.pi * rng.uniform(15.0, 60.0)
    k = omega**2 * (inertia - load) * load / inertia
    belt = np.array([k, rng.uniform(0.4, 0.8), coulomb / k * rng.uniform(0.5, 3.0), 0.04 * k / omega])
    reference = reference_of("servo-periodic", rng, count)
    omega = 2.0 * np.pi * rng.uniform(4.0, 7.0)
    gains = np.array([inertia * omega**2, 1.6 * inertia * omega, inertia])
    quantum = 2.0 * np.pi / (10_000 if seed % 2 else 2600)
    axis = np.array([inertia - load, load, viscous, coulomb, offset])
    angle, torque = _moved(axis, belt, gains, reference, quantum, 1.0 / (RATE * STEPS))
    torque += 0.003 * np.std(torque) * rng.normal(size=count)
    return Made(np.arange(count) / RATE, torque, angle, sought(*own))


@njit(cache=True)
def _moved(axis, belt, gains, reference, quantum, h):
    motor, load, viscous, coulomb, offset = axis
    k, share, most, damping = belt
    count = reference.shape[1]
    angle, torque = np.zeros(count), np.zeros(count)
    x, w, y, v, z, speed, last = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(count):
        seen = quantum * np.floor(x / quantum)
        speed += 0.3 * ((seen - last) / (h * STEPS) - speed)
        last = seen
        u = gains[0] * (reference[0, i] - seen) + gains[1] * (reference[1, i] - speed)
        u += gains[2] * reference[2, i]
        angle[i], torque[i] = seen, u
        for _ in range(STEPS):
            rate = w - v
            z += h * (rate - 0.5 / most * (abs(rate) * z + rate * abs(z)))
            force = k * (share * (x - y) + (1.0 - share) * z) + damping * rate
            free, rub = w + h * (u + offset - force - viscous * w) / motor, h * coulomb / motor
            w = 0.0 if abs(free) <= rub else free - rub * np.sign(free)
            v += h * force / load
            x, y = x + h * w, y + h * v
    return angle, torque
