"""Compiled motion of a lumped chain with what data sheets leave out: friction, cogging, wear, another load.

Each internal step is drift, kick, drift, of order 2 between the instants at which an inertia stops. Coulomb
friction is set-valued on every inertia: a speed that it would turn over, it stops.
"""

from math import exp, inf, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.compiled import njit_in_place, njit_part

Array = NDArray[np.float64]


class DisturbedNumbers(NamedTuple):
    """A lumped chain of n inertias at the first shaft, and its disturbances.

    Attributes
    ----------
    inertias, viscous, coulomb, offsets : ndarray, shape (n,)
        [kg m^2], [N m s/rad], [N m], [N m].
    stiffness, damping : ndarray, shape (n - 1,)
        [N m/rad], [N m s/rad].
    excess, fading : float
        Friction at standstill over Coulomb friction, and the speed at which the excess has fallen to a third
        [rad/s].
    cogging, cogging_lines : float
        Torque [N m] with so many periods per turn of the motor's shaft.
    ripple, ripple_lines : float
        Share of the torque, periods per turn.
    play, slack : float
        Half the backlash of the first link [rad]; twist of the last link at which a span goes slack [rad].
    eccentricity, turning : float
        Of the load's encoder at the first shaft [rad]; turns of the load per turn of the first shaft.
    phases : ndarray, shape (3,)
        Of cogging, ripple and eccentricity [rad].
    softening : float
        Loss of the last link's stiffness per second, as a share.
    warming : float
        Loss of all Coulomb friction per second, as a share.
    load_factor, load_time : float
        Factor of the load's inertia from a time on [s].
    current_rate : float
        Bandwidth of the torque loop [rad/s]; 0: none.
    step : float
        Longest internal step [s].
    field, field_periods : float
        Largest torque of a stepper whose command is the angle of its field [N m], and its periods per radian
        of lag; 0: the command is a torque.
    """

    inertias: Array
    viscous: Array
    coulomb: Array
    offsets: Array
    stiffness: Array
    damping: Array
    excess: float
    fading: float
    cogging: float
    cogging_lines: float
    ripple: float
    ripple_lines: float
    play: float
    slack: float
    eccentricity: float
    turning: float
    phases: Array
    softening: float
    warming: float
    load_factor: float
    load_time: float
    current_rate: float
    step: float
    field: float
    field_periods: float


NONE = np.zeros(0)
UNDISTURBED = DisturbedNumbers(
    inertias=NONE,
    viscous=NONE,
    coulomb=NONE,
    offsets=NONE,
    stiffness=NONE,
    damping=NONE,
    excess=0.0,
    fading=1.0,
    cogging=0.0,
    cogging_lines=0.0,
    ripple=0.0,
    ripple_lines=0.0,
    play=0.0,
    slack=inf,
    eccentricity=0.0,
    turning=0.0,
    phases=np.zeros(3),
    softening=0.0,
    warming=0.0,
    load_factor=1.0,
    load_time=0.0,
    current_rate=0.0,
    step=1.0,
    field=0.0,
    field_periods=0.0,
)
"""No inertias: the chain moves without disturbances."""


@njit_in_place
def link_torque(
    twist: float, rate: float, stiffness: float, damping: float, play: float, slack: float
) -> float:
    """Torque of a link with backlash, and with two spans of which one goes slack beyond a twist."""
    if play > 0.0:
        if abs(twist) <= play:
            return 0.0
        torque = stiffness * (twist - play if twist > 0.0 else twist + play) + damping * rate
        return max(torque, 0.0) if twist > 0.0 else min(torque, 0.0)
    if abs(twist) > slack:
        beyond = twist - slack if twist > 0.0 else twist + slack
        return stiffness * (twist - 0.5 * beyond) + damping * rate
    return stiffness * twist + damping * rate


@njit_in_place
def rubbed(speed: float, change: float) -> float:
    """A speed after friction that may stop it and never turns it."""
    if speed > 0.0:
        return max(speed - change, 0.0)
    return min(speed + change, 0.0)


@njit_part
def disturbed_step(
    d: DisturbedNumbers,
    x: Array,
    command: float,
    motor: float,
    load: float,
    time: float,
    h: float,
    fresh: Array,
) -> None:
    """One internal step from ``time`` on; ``x``: angles, speeds, shaft torque; ``fresh`` (n,) is scratch."""
    n = d.inertias.size
    for i in range(n):
        x[i] += 0.5 * h * x[n + i]
    if d.field > 0.0:
        x[2 * n] = d.field * sin(d.field_periods * (command - x[0]))
    elif d.current_rate > 0.0:
        x[2 * n] += (1.0 - exp(-d.current_rate * h)) * (command - x[2 * n])
    else:
        x[2 * n] = command
    carried = x[2 * n] * (1.0 + d.ripple * sin(d.ripple_lines * x[0] + d.phases[1]))
    carried += d.cogging * sin(d.cogging_lines * x[0] + d.phases[0]) + motor
    last = n - 1
    worn, warm = max(1.0 - d.softening * time, 0.05), max(1.0 - d.warming * time, 0.0)
    for i in range(n):
        link, inertia = 0.0, d.inertias[i]
        if i < last:
            soft, slack = (worn, d.slack) if i == last - 1 else (1.0, np.inf)
            play = d.play if i == 0 else 0.0
            rate = x[n + i] - x[n + i + 1]
            link = link_torque(x[i] - x[i + 1], rate, soft * d.stiffness[i], d.damping[i], play, slack)
        elif i > 0:
            carried += load
        if i == last and time >= d.load_time:
            inertia *= d.load_factor
        friction = warm * d.coulomb[i] * (1.0 + d.excess * exp(-abs(x[n + i]) / d.fading))
        torque = carried - link + d.offsets[i] - d.viscous[i] * x[n + i]
        # Speeds change after every torque of this step is known: the next link still sees the old ones.
        fresh[i] = rubbed(x[n + i] + h * torque / inertia, h * friction / inertia)
        carried = link
    for i in range(n):
        x[n + i] = fresh[i]
        x[i] += 0.5 * h * x[n + i]


@njit_part
def move_disturbed(
    d: DisturbedNumbers,
    x: Array,
    command: float,
    turning: float,
    motor: float,
    load: float,
    begin: float,
    time: float,
    fresh: Array,
) -> int:
    """Move the chain on from an instant under a command that changes by ``turning`` a second.

    Returns whether the motor slips.
    """
    if time <= 0.0:  # jitter may take the next sample before this command acts
        return 0 if x[d.inertias.size] == 0.0 else 1
    steps = int(np.ceil(time / d.step - 1e-9))
    h = time / steps
    for i in range(steps):
        disturbed_step(d, x, command + (i + 0.5) * h * turning, motor, load, begin + i * h, h, fresh)
    return 0 if x[d.inertias.size] == 0.0 else 1
