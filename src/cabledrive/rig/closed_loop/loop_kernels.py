"""The closed loop of the rig on a row of inertias, compiled: plant and controller, sample after sample."""

from math import isfinite

from cabledrive.control.numbers import LawNumbers
from cabledrive.control.observer_numbers import ObserverNumbers
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.rig.closed_loop.kink_kernels import KinkNumbers, advance_kinked
from cabledrive.rig.closed_loop.loop_numbers import DIVERGED, WENT_SLACK, Array, LoopState, RigNumbers
from cabledrive.rig.closed_loop.plant_kernels import PlantNumbers, advance
from cabledrive.rig.closed_loop.sample_kernels import decide, farthest, keep_score, write_row


@njit_in_place
def move(
    plant: PlantNumbers, kinks: KinkNumbers, s: LoopState, u: float, motor: float, load: float, time: float
) -> None:
    """Move the row on under a constant command."""
    if kinks.rates.shape[0] > 0:
        s.discrete[0] = advance_kinked(
            kinks, plant.scalars, s.x, s.discrete[0], u, motor, load, time, s.terms, s.work
        )
    else:
        s.discrete[0] = advance(
            plant.rates,
            plant.tables,
            plant.scalars,
            s.x,
            s.discrete[0],
            u,
            motor,
            load,
            time,
            s.terms,
            s.work,
        )


@njit_in_place
def look_at(kinks: KinkNumbers, x: Array, twist: float, score: Array) -> None:
    """Count what the links do at a sample: largest twist, spans slack, joint in its free play."""
    score[7] = max(score[7], twist)
    if kinks.rates.shape[0] > 0:
        if twist > kinks.slack:
            score[9] += 1.0
        if abs(x[0] - x[1]) < kinks.play:
            score[10] += 1.0


@njit_in_place
def run_loop(
    plant: PlantNumbers,
    observer: ObserverNumbers,
    law: LawNumbers,
    rig: RigNumbers,
    reference: Array,
    target: Array,
    first: int,
    last: int,
    twist_limit: float,
    s: LoopState,
    log: Array,
    kinks: KinkNumbers,
) -> int:
    """Run samples ``first`` to ``last`` - 1; returns the sample at which the run ended.

    ``target`` is the wanted load angle at the samples. ``log`` has a row per sample, or none at all: true
    angles and speeds, shaft torque, readings, limited command, slip, sigma, estimates (12), regressor (12),
    states of the law.
    """
    x, n = s.x, s.x.size // 2
    gone = farthest(target)
    own_offset = rig.counts[rig.counts.size - 1] * rig.phases[rig.phases.size - 1]
    for k in range(first, last):
        twist = abs(x[n - 2] - x[n - 1]) if n > 1 else 0.0
        look_at(kinks, x, twist, s.summary)
        if not isfinite(x[n - 1]) or abs(x[n - 1]) > gone or twist > twist_limit:
            s.discrete[2] = WENT_SLACK if isfinite(twist) and twist > twist_limit else DIVERGED
            return k
        wanted, command, sigma = decide(observer, law, rig, reference, k, x, s)
        error = x[n - 1] - target[k]
        keep_score(s.summary, k < rig.first_end, error, error + own_offset, wanted, command)
        if log.shape[0] > 0:
            slip = s.discrete[0]
            write_row(log[k], x, s.readings, command, slip, sigma, s.parameters, s.regressor, s.states)
        span = rig.interval
        if rig.jitter.size > 0:
            span += rig.jitter[k + 1] - rig.jitter[k]
        motor, load = rig.forces[k, 0], rig.forces[k, 1]
        if rig.late_part > 0.0:
            move(plant, kinks, s, s.commands[0], motor, load, rig.late_part)
        move(plant, kinks, s, s.commands[1], motor, load, span - rig.late_part)
    return last
