"""Compiled motion of a lumped chain inside a sampled position loop on the motor's encoder."""

from math import floor

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit
from cabledrive.reduction.chain_kernels import step
from cabledrive.reduction.chain_motion_kernels import COULOMB, EXCESS, SLOPE, ChainNumbers


@njit
def integrate_servo(
    c: ChainNumbers,
    loop: Array,
    reference: Array,
    noise: Array,
    interval: float,
    torque: Array,
    angles: Array,
) -> None:
    """Torque at every fine step, angles at every sample.

    ``loop`` holds the position gain, the speed gain, the share by which the measured speed follows the
    backward difference in one sample, the step and the phase of the encoder, the pole of the current loop
    over a fine step and the largest torque. ``reference`` holds angle and speed at the samples, ``noise`` the
    amplifier's torque; the controller works once per sample and its torque stands until the next.
    ``torque`` has shape (samples, oversampling), ``angles`` (samples, n).
    """
    n = c.body.shape[1]
    kp, kv, follow, quantum, phase, pole, most = loop
    x, s = np.zeros(2 * n), np.zeros((2 * n, 0))
    xe, se = np.empty(2 * n), np.empty((2 * n, 0))
    nx, ns = 2 * n, (2 * n, 0)
    work_x = (np.empty(nx), np.empty(nx), np.empty(nx), np.empty(nx), np.empty(nx))
    work_s = (np.empty(ns), np.empty(ns), np.empty(ns), np.empty(ns), np.empty(ns))
    slip = np.zeros(n, dtype=np.int64)
    for i in range(n):
        x[i] = reference[0, 0]
        if c.body[SLOPE, i] > 0.0 or c.body[COULOMB, i] + c.body[EXCESS, i] <= 0.0:
            slip[i] = 1
    parts = torque.shape[1]
    h = interval / parts
    before = quantum * floor(x[0] / quantum + phase)
    speed, acting = 0.0, 0.0
    for sample in range(reference.shape[1]):
        for i in range(n):
            angles[sample, i] = x[i]
        shown = quantum * floor(x[0] / quantum + phase)
        speed += follow * ((shown - before) / interval - speed)
        before = shown
        wanted = kp * (reference[0, sample] - shown) + kv * (reference[1, sample] - speed)
        wanted = min(max(wanted, -most), most) + noise[sample]
        for part in range(parts):
            last = acting
            acting = pole * acting + (1.0 - pole) * wanted
            torque[sample, part] = last
            step(c, x, s, slip, last, acting, h, xe, se, work_x, work_s)
