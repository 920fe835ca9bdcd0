r"""Preload of two motors on one shaft against the backlash of their gears, and the observer of their flanks.

Motor a presses on one flank of its gear, motor b on the opposite flank of its own. With
:math:`\theta_m, \theta_d` half the sum and half the difference of their angles, half the backlash g, the
stiffness k of each joint and the twist :math:`e = \theta_m - \theta_p` against the shaft,

.. math:: \tau_a = k\,[e + \vartheta]_+, \qquad \tau_b = -k\,[\vartheta - e]_+, \qquad
    \vartheta = \theta_d - g ,

as long as neither has crossed its gap. With both closed the sum is a motor of twice the size without
backlash, :math:`\tau_a + \tau_b = 2ke`, and the difference an oscillator of its own, which no motion of the
shaft enters:

.. math:: J\ddot\vartheta + (b + b_m)\dot\vartheta + k\vartheta = u_d + w, \qquad |w| \le c .

So any law of position takes the sum, and the difference keeps the flanks closed: where
:math:`k\vartheta > |ke|`, half the torque of the joint.
"""

from math import isfinite
from typing import NamedTuple

import numpy as np

from cabledrive.control.numbers import ObserverNumbers
from cabledrive.control.observer_kernels import correct, predict
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.parameters.arrays import Array

ESTIMATE, LAG, HELD, COMMANDS = 0, 3, 5, 7
"""Places of the memory: observer (3), lags of the preload (2), torque loop (2), commands on their way."""


class FlankLaw(NamedTuple):
    """Observer of the difference and numbers of the law."""

    observer: ObserverNumbers  # of twist, speed and disturbing torque of the difference
    stiffness: float  # k of one joint [N m/rad]
    play: float  # g, half the backlash [rad]
    limit: float  # of one motor [N m]
    preload: float  # least torque of a flank where nothing else is asked of it [N m]
    margin: float  # by which the preload exceeds half the joint's torque [N m]
    remaining: float  # part of each lag of the preload that remains after a sample
    damper: float  # torque per speed of the difference [N m s/rad]
    coulomb: float  # largest disturbing torque that is believed [N m]


def first_memory(law: FlankLaw, late_samples: int) -> Array:
    """Memory at rest with the preload on; ``late_samples``: whole samples of the delay."""
    memory = np.full(COMMANDS + late_samples + 2, law.preload)
    memory[ESTIMATE:LAG] = law.preload / law.stiffness, 0.0, 0.0
    return memory


@njit_in_place
def closing_torques(stiffness: float, play: float, twist: float, pressed: float, found: Array) -> None:
    """Write the torques of both flanks in the sense of the preload [N m]; below zero a gap is crossed."""
    for i in range(2):
        closed = pressed + twist if i == 0 else pressed - twist
        found[i] = stiffness * (max(closed, 0.0) + min(closed + 2.0 * play, 0.0))


@njit_in_place
def preload_step(
    law: FlankLaw, memory: Array, reading: float, twist: float, total: float, work: Array, flanks: Array
) -> float:
    """One sample: the torque of the difference, which motor a gets on top of half the total and b less.

    ``memory``: moved on; ``reading``: ϑ by the encoders [rad], not a number: not read; ``twist``: e as the
    filter of the position has it [rad]; ``total``: torque of both motors together [N m]; ``work``, shape
    (>= 6,); ``flanks``, shape (2,): takes the torques observed.
    """
    observer, estimate = law.observer, memory[ESTIMATE:LAG]
    if isfinite(reading):
        work[0] = reading
        correct(observer, 0, estimate, work[:1], work[1:3], work[3:4])
    estimate[2] = min(max(estimate[2], -law.coulomb), law.coulomb)
    closing_torques(law.stiffness, law.play, twist, estimate[0], flanks)
    # What one motor can give beside the position's half is left for the preload: the position goes first.
    room = max(law.limit - 0.5 * abs(total), 0.0)
    wanted = min(max(law.preload, law.stiffness * abs(twist) + law.margin), room)
    for i in range(2):
        memory[LAG + i] = wanted + law.remaining * (memory[LAG + i] - wanted)
        wanted = memory[LAG + i]
    asked = wanted - estimate[2] - law.damper * estimate[1]
    command = min(max(asked, -room), room)
    last = memory.size - 1
    for i in range(COMMANDS, last):
        memory[i] = memory[i + 1]
    memory[last] = command
    # The model of the observer has both flanks closed; where one is open it is told what is missing.
    missing = 0.5 * (flanks[0] + flanks[1]) - law.stiffness * estimate[0]
    predict(observer, estimate, memory[HELD:COMMANDS], memory[COMMANDS], memory[COMMANDS + 1], work)
    for i in range(2):
        estimate[i] -= observer.model[i, 6] * missing
    return command
