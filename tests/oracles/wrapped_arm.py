"""A motor and a joint coupled by two strands, each over one rough wrap: sticking, sliding, elastic.

The rope slides on a wrap where the tensions of its two sides would part by more than the capstan's ratio, and
then has exactly that ratio. Friction at motor and joint is Coulomb's, independent of tension.
"""

from math import exp

import numpy as np


def _held(force, impulse_bound, momentum):
    """Momentum after friction that stops or opposes it."""
    moved = momentum + force
    return max(moved - impulse_bound, 0.0) if moved > 0.0 else min(moved + impulse_bound, 0.0)


def _slid(near, far, place, tension, stiffness, ratio):
    """Where the rope lies on a wrap between two ends, and the tensions of its sides; near end first."""
    first = tension + stiffness * (near - place)
    last = tension + stiffness * (place - far)
    if first > ratio * last:
        place = (tension * (1.0 - ratio) + stiffness * (near + ratio * far)) / (stiffness * (1.0 + ratio))
    elif last > ratio * first:
        place = (tension * (ratio - 1.0) + stiffness * (ratio * near + far)) / (stiffness * (1.0 + ratio))
    return place, tension + stiffness * (near - place), tension + stiffness * (place - far)


def arm_log(drive_torque, rate, tension, arm, noise, rng, fine=20):
    """Torque, motor angle and joint angle at a rate, shapes (t,).

    ``drive_torque``: function of time, motor angle and speed; ``arm``: dict of the machine's numbers.
    """
    steps, h = arm["samples"] * fine, 1.0 / (rate * fine)
    ratio = exp(arm["friction"] * arm["wrap"])
    r, big, k = arm["radius"], arm["joint_radius"], arm["stiffness"]
    angle = speed = joint = joint_speed = upper = lower = 0.0
    rows = np.empty((arm["samples"], 3))
    push = 0.0
    for step in range(steps):
        if step % fine == 0:  # a drive holds its torque between samples
            push = drive_torque(step * h, angle, speed)
            rows[step // fine] = push, angle, joint
        upper, at_motor, at_joint = _slid(r * angle, big * joint, upper, tension, k, ratio)
        lower, back_motor, back_joint = _slid(-r * angle, -big * joint, lower, tension, k, ratio)
        damp = arm["damping"] * (r * speed - big * joint_speed)
        moment = push - r * (at_motor - back_motor + damp) - arm["viscous"] * speed
        load = big * (at_joint - back_joint + damp)
        speed = _held(h * moment, h * arm["motor_coulomb"], arm["inertia"] * speed) / arm["inertia"]
        joint_speed = (
            _held(h * load, h * arm["joint_coulomb"], arm["joint_inertia"] * joint_speed)
            / arm["joint_inertia"]
        )
        angle, joint = angle + h * speed, joint + h * joint_speed
    rows[:, 0] += noise * rng.normal(size=len(rows))
    for column, counts in ((1, arm["counts"]), (2, arm["joint_counts"])):
        rows[:, column] = np.floor(rows[:, column] * counts / (2.0 * np.pi)) * 2.0 * np.pi / counts
    return rows.T
