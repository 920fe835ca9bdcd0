"""A kernel that never changes: what its compilation takes says how fast this machine compiles."""

import math
import time

import numba
import numpy as np


@numba.njit(fastmath=True)
def rates(x, y, out):
    for i in range(1, x.size - 1):
        left, right = x[i] - x[i - 1], x[i + 1] - x[i]
        lift, fall = y[i] - y[i - 1], y[i + 1] - y[i]
        near, far = math.sqrt(1.0 + left * left + lift * lift), math.sqrt(1.0 + right * right + fall * fall)
        out[0, i] = right / far - left / near
        out[1, i] = fall / far - lift / near


@numba.njit(fastmath=True)
def integrate(x, y, speeds, out, steps, step):
    energy = 0.0
    for k in range(steps):
        rates(x, y, out)
        for i in range(x.size):
            speeds[0, i] += step * (out[0, i] - 0.1 * math.tanh(speeds[0, i]))
            speeds[1, i] += step * (out[1, i] + math.sin(k * step))
            x[i] += step * speeds[0, i]
            y[i] += step * speeds[1, i]
        energy += np.sum(speeds[0] ** 2) + np.dot(speeds[1], speeds[1])
    return energy


def seconds() -> float:
    """Processor seconds from the call to the first result."""
    x, y = np.zeros(8), np.zeros(8)
    began = time.process_time()
    integrate(x, y, np.zeros((2, 8)), np.zeros((2, 8)), 3, 1e-3)
    return time.process_time() - began


if __name__ == "__main__":
    print(seconds())
