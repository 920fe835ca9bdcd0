"""Compiled motion of the transporter: strands that lengthen, a swinging payload, a motor that sticks."""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from cabledrive.control.load_schedule import ScheduledLaw, scheduled_step
from cabledrive.mechanics.compiled import njit
from cabledrive.parameters.arrays import Array


class TransporterPlant(NamedTuple):
    """Numbers of the plant; displacements from the start, forces at the rim.

    ``lengths``: span, carriage's start, both unstretched [m]; line [m]. ``cable``: EA [N], prestrain, damping
    time [s]. ``masses``: drive pulley with motor, carriage, load pulley, payload [kg]. ``friction``: motor's
    viscous [N s/m], Coulomb and constant force [N], rail [N s/m], swing [1/s]. ``gravity`` [m/s^2].
    """

    lengths: Array
    cable: Array
    masses: Array
    friction: Array
    gravity: float


class CarriageLoop(NamedTuple):
    """Everything of a run but the plant."""

    law: ScheduledLaw
    reference: Array  # (samples, 10): of `cabledrive.control.transporter.flat_motion`
    wind: Array  # (samples,): force on the payload [N]
    interval: float  # sample time [s]
    substeps: int  # internal steps of the plant per sample
    one_count: float  # of the encoders at the rim [m]; 0: they give the displacements themselves


@njit
def strand_tensions(plant: TransporterPlant, x: Array, tensions: Array) -> None:
    """Tension of the three strands, none of which can push, Eq. (T.2); x: 4 coordinates, 4 rates."""
    span, start = plant.lengths[0], plant.lengths[1]
    rigidity, prestrain, time = plant.cable[0], plant.cable[1], plant.cable[2]
    grown = 1.0 + prestrain
    natural = (start + x[0] / grown, span - start - x[2] / grown, span + (x[2] - x[0]) / grown)
    actual = (start * grown + x[1], (span - start) * grown - x[1], span * grown)
    rate = (x[5] - x[4], x[6] - x[5], x[4] - x[6])
    for i in range(3):
        strain = actual[i] / natural[i] - 1.0 + time * rate[i] / natural[i]
        tensions[i] = max(rigidity * strain, 0.0)


@njit
def transporter_rates(
    plant: TransporterPlant, x: Array, push: tuple[float, float], stuck: bool, tensions: Array, out: Array
) -> float:
    """Rates of the states, Eq. (T.10); returns the force on the motor without its Coulomb friction.

    ``push``: force of the motor and wind on the payload [N]. x[3] is the swing [rad]. A pulley feeds cable at
    its prestrain: it gives T (1 + e / 2) / (1 + prestrain), the derivative of the energy by what is fed, so
    that none is lost.
    """
    cable, masses, friction = plant.cable, plant.masses, plant.friction
    strand_tensions(plant, x, tensions)
    first, second, third = tensions[0], tensions[1], tensions[2]
    first *= (1.0 + 0.5 * first / cable[0]) / (1.0 + cable[1])
    second *= (1.0 + 0.5 * second / cable[0]) / (1.0 + cable[1])
    third *= (1.0 + 0.5 * third / cable[0]) / (1.0 + cable[1])
    motor = push[0] + friction[2] + first - third - friction[0] * x[4]
    for i in range(4):
        out[i] = x[4 + i]
    slip = 0.0
    if x[4] != 0.0:
        slip = 1.0 if x[4] > 0.0 else -1.0
    elif abs(motor) > friction[1]:
        slip = 1.0 if motor > 0.0 else -1.0
    out[4] = 0.0 if stuck else (motor - slip * friction[1]) / masses[0]
    line, payload, wind = plant.lengths[2], masses[3], push[1]
    s, c, turn = sin(x[3]), cos(x[3]), x[7]
    back = plant.gravity * s + friction[4] * line * turn
    pull = tensions[1] - tensions[0] - friction[3] * x[5] + wind * (1.0 - c * c)
    pull += payload * (line * turn * turn * s + c * back)
    out[5] = pull / (masses[1] + payload * (1.0 - c * c))
    out[6] = (third - second) / masses[2]
    out[7] = (wind * c / payload - back - c * out[5]) / line
    return motor


@njit
def transporter_advance(
    plant: TransporterPlant, x: Array, push: tuple[float, float], step: float, tensions: Array, work: Array
) -> None:
    """One internal step of fourth order; a motor that turns in it stops at its end and may stick."""
    stuck = x[4] == 0.0
    if stuck:
        motor = transporter_rates(plant, x, push, True, tensions, work[0])
        stuck = abs(motor) <= plant.friction[1]
    before = x[4]
    weights = (0.0, 0.5, 0.5, 1.0)
    for stage in range(4):
        for i in range(8):
            work[4, i] = x[i] + (weights[stage] * step * work[stage - 1, i] if stage > 0 else 0.0)
        transporter_rates(plant, work[4], push, stuck, tensions, work[stage])
    for i in range(8):
        x[i] += step / 6.0 * (work[0, i] + 2.0 * work[1, i] + 2.0 * work[2, i] + work[3, i])
    if stuck or before * x[4] < 0.0:
        x[4] = 0.0


@njit
def run_transporter(loop: CarriageLoop, plant: TransporterPlant, phases: Array, x: Array, log: Array) -> int:
    """Run all samples, rows as `run_carriage` has them; returns the sample at which the run ended."""
    reference, count, lengths = loop.reference, loop.one_count, plant.lengths
    estimate, fresh = np.zeros(loop.law.transition.shape[1]), np.zeros(loop.law.transition.shape[1])
    readings, tensions, work = np.zeros(2), np.zeros(3), np.zeros((5, 8))
    for k in range(reference.shape[0]):
        place = lengths[1] + x[1]
        if not 0.0 < place < lengths[0]:
            return k
        for j in range(2):
            readings[j] = count * np.rint(x[2 * j] / count + phases[j]) if count > 0.0 else x[2 * j]
        force = scheduled_step(loop.law, estimate, readings, reference, k, fresh)
        strand_tensions(plant, x, tensions)
        for i in range(8):
            log[k, i] = x[i]
        log[k, 8] = x[1] + lengths[2] * sin(x[3])
        for i in range(3):
            log[k, 9 + i] = tensions[i]
        log[k, 12] = force
        for i in range(estimate.size):
            log[k, 13 + i] = estimate[i]
        if min(tensions[0], tensions[1], tensions[2]) <= 0.0:
            return k
        for _ in range(loop.substeps):
            transporter_advance(
                plant, x, (force, loop.wind[k]), loop.interval / loop.substeps, tensions, work
            )
    return reference.shape[0]
