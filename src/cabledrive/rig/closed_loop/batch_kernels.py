"""Compiled loop of many plants at once, one in each vector lane: smoothed friction, true states, one law.

A sample has no branch and calls nothing, so that the loop over the lanes becomes vector arithmetic: the law
is a few rows of numbers and a table of its reference, the plant a table, tanh one exponential by powers. All
numbers of a group of plants, the law's too, lie in one array, row after row: nothing can overlap, and the
compiler sees it. `cabledrive.rig.closed_loop.plant_batch` fills it.
"""

from collections.abc import Callable
from math import exp

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.compiled import njit_in_place, njit_inlined

Array = NDArray[np.float64]

STATES, INPUTS = 7, 3
"""Angles and speeds of three inertias and the shaft's torque; command, friction, and its change in a step."""

# Rows of a group: states, estimates, friction of the plant, scores, tables of the plant, law.
ESTIMATE, COULOMB, OFFSET, SCORE, TWIST, TABLES = 7, 11, 12, 13, 19, 20
SIGMA = TABLES + STATES * (STATES + INPUTS)
ACCELERATION, ELASTIC, SPEED, STRETCH = SIGMA + 6, SIGMA + 12, SIGMA + 18, SIGMA + 24
NOMINAL, LOW, HIGH, GAIN, LIMIT = SIGMA + 30, SIGMA + 34, SIGMA + 38, SIGMA + 42, SIGMA + 46
INTERVAL, K_SIGMA, SLOPE, BY_REFERENCE = SIGMA + 50, SIGMA + 51, SIGMA + 52, SIGMA + 53
DESIRED, TORQUE, ROUGHNESS, KEEPS = SIGMA + 54, SIGMA + 55, SIGMA + 56, SIGMA + 57
ROWS = SIGMA + 58


@njit_inlined
def smooth_sign(x: float) -> float:
    """The hyperbolic tangent to 1e-14, as (1 - e) / (1 + e) with e = exp(-2 x) by powers and squares.

    Taylor's series of degree 10 leaves an error that grows with x, and tanh(x) forgets it as exp(-2 x).
    """
    r = min(max(-2.0 * x, -40.0), 40.0) / 32.0
    r2 = r * r
    r4 = r2 * r2
    low = (1.0 + r) + r2 * (0.5 + r * (1.0 / 6.0))
    middle = (1.0 / 24.0 + r * (1.0 / 120.0)) + r2 * (1.0 / 720.0 + r * (1.0 / 5040.0))
    high = (1.0 / 40320.0 + r * (1.0 / 362880.0)) + r2 * (1.0 / 3628800.0)
    e = low + r4 * (middle + r4 * high)
    for _ in range(5):
        e *= e
    return (1.0 - e) / (1.0 + e)


@njit_inlined
def sign_in(lanes: int, x: float) -> float:
    """The same; of a single lane by the library's exponential, which is quicker there."""
    return smooth_sign(x) if lanes > 1 else 1.0 - 2.0 / (1.0 + exp(2.0 * x))


def batch_kernel(lanes: int) -> Callable[..., None]:
    """The loop for a fixed number of lanes.

    Returns takes a group (rows * lanes,), the table (samples, 6) of the law's reference and the sample at
    which the first pulse is over; the group is moved on.
    """

    def integrate_batch(z: Array, table: Array, first_end: int) -> None:
        for k in range(table.shape[0]):
            sigma_d, q_ref, q_d = table[k, 0], table[k, 1], table[k, 2]
            speed_d, friction_d, target = table[k, 3], table[k, 4], table[k, 5]
            early = 1.0 if k < first_end else 0.0
            for i in range(lanes):
                sigma, q, u, speed, twist = -sigma_d, q_ref, 0.0, 0.0, 0.0
                for j in range(6):
                    x = z[j * lanes + i]
                    sigma += z[(SIGMA + j) * lanes + i] * x
                    q += z[(ACCELERATION + j) * lanes + i] * x
                    u += z[(ELASTIC + j) * lanes + i] * x
                    speed += z[(SPEED + j) * lanes + i] * x
                    twist += z[(STRETCH + j) * lanes + i] * x
                by_reference, desired = z[BY_REFERENCE * lanes + i], z[DESIRED * lanes + i]
                own = sign_in(lanes, z[SLOPE * lanes + i] * speed)
                friction = own + by_reference * (friction_d - own)
                q_a = q + desired * (q_d - q)
                speed_a = speed + desired * (speed_d - speed)
                u += z[NOMINAL * lanes + i] * (q - q_a) + z[(NOMINAL + 1) * lanes + i] * (speed - speed_a)
                u -= z[K_SIGMA * lanes + i] * sigma
                for j in range(4):
                    phi = -q_a if j == 0 else -speed_a if j == 1 else -friction if j == 2 else 1.0
                    p = z[(ESTIMATE + j) * lanes + i]
                    u -= phi * p
                    most = z[(LIMIT + j) * lanes + i]
                    rate = min(max(z[(GAIN + j) * lanes + i] * phi * sigma, -most), most)
                    p += z[INTERVAL * lanes + i] * rate
                    p = min(max(p, z[(LOW + j) * lanes + i]), z[(HIGH + j) * lanes + i])
                    z[(ESTIMATE + j) * lanes + i] = p
                limit = z[TORQUE * lanes + i]
                command = min(max(u, -limit), limit)
                error = abs(z[2 * lanes + i] - target)
                at = SCORE * lanes + i
                z[at] = max(z[at], error)
                z[at + lanes] = max(z[at + lanes], error * early)
                z[at + 2 * lanes] = max(z[at + 2 * lanes], error * (1.0 - early))
                z[at + 3 * lanes] += error * error
                z[at + 4 * lanes] = max(z[at + 4 * lanes], abs(command))
                z[at + 5 * lanes] += 1.0 if command != u else 0.0
                z[TWIST * lanes + i] = max(z[TWIST * lanes + i], abs(twist))
                keeps, roughness = z[KEEPS * lanes + i], z[ROUGHNESS * lanes + i]
                x0, x1, x2 = z[i], z[lanes + i], z[2 * lanes + i]
                x3, x4, x5 = z[3 * lanes + i], z[4 * lanes + i], z[5 * lanes + i]
                x6 = keeps * z[6 * lanes + i] + (1.0 - keeps) * command
                coulomb = z[COULOMB * lanes + i]
                before = coulomb * sign_in(lanes, roughness * x3)
                push = z[OFFSET * lanes + i] - before
                for row in range(STATES):
                    at = (TABLES + row * (STATES + INPUTS)) * lanes + i
                    near = z[at] * x0 + z[at + lanes] * x1 + z[at + 2 * lanes] * x2
                    fast = z[at + 3 * lanes] * x3 + z[at + 4 * lanes] * x4 + z[at + 5 * lanes] * x5
                    push_on = z[at + 6 * lanes] * x6 + z[at + 7 * lanes] * command + z[at + 8 * lanes] * push
                    z[row * lanes + i] = near + fast + push_on
                rise = before - coulomb * sign_in(lanes, roughness * z[3 * lanes + i])
                for row in range(STATES):
                    at = (TABLES + row * (STATES + INPUTS) + 9) * lanes + i
                    z[row * lanes + i] += z[at] * rise

    return njit_in_place(integrate_batch)


LANES = 16
integrate_many = batch_kernel(LANES)
integrate_one = batch_kernel(1)
