"""The closed loop of the rig on a lumped chain, compiled: plant and controller, sample after sample."""

from math import isfinite

from cabledrive.control.numbers import LawNumbers
from cabledrive.control.observer_numbers import ObserverNumbers
from cabledrive.mechanics.compiled import njit_in_place, njit_part
from cabledrive.rig.closed_loop.loop_numbers import DIVERGED, WENT_SLACK, Array, LoopState, RigNumbers
from cabledrive.rig.closed_loop.piecewise_kernels import PiecewiseNumbers, advance_piecewise
from cabledrive.rig.closed_loop.plant_kernels import PlantNumbers, advance
from cabledrive.rig.closed_loop.sample_kernels import decide, farthest, finish_sample


@njit_part
def move(
    plant: PlantNumbers,
    piecewise: PiecewiseNumbers,
    s: LoopState,
    u: float,
    motor: float,
    load: float,
    time: float,
) -> None:
    """Move the chain on under a constant command."""
    if piecewise.rates.shape[0] > 0:
        s.discrete[0] = advance_piecewise(
            piecewise, plant.scalars, s.x, s.discrete[0], u, motor, load, time, s.terms, s.work
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
def look_at(piecewise: PiecewiseNumbers, x: Array, twist: float, score: Array) -> None:
    """Count what the links do at a sample: largest twist, spans slack, joint inside its backlash."""
    score[7] = max(score[7], twist)
    if piecewise.rates.shape[0] > 0:
        if twist > piecewise.slack:
            score[9] += 1.0
        if abs(x[0] - x[1]) < piecewise.play:
            score[10] += 1.0


@njit_part
def chain_ends(piecewise: PiecewiseNumbers, twist_limit: float, gone: float, s: LoopState) -> int:
    """Look at the lumped chain at a sample; why the run ends here, 0 where it goes on."""
    x = s.x
    n = x.size // 2
    twist = abs(x[n - 2] - x[n - 1]) if n > 1 else 0.0
    look_at(piecewise, x, twist, s.summary)
    if not isfinite(x[n - 1]) or abs(x[n - 1]) > gone or twist > twist_limit:
        return WENT_SLACK if isfinite(twist) and twist > twist_limit else DIVERGED
    return 0


@njit_part
def move_chain(
    plant: PlantNumbers, piecewise: PiecewiseNumbers, rig: RigNumbers, k: int, s: LoopState
) -> None:
    """Move the lumped chain to the next sample, the older command first as long as the delay lasts."""
    span, commands = rig.interval, s.controller.commands
    if rig.jitter.size > 0:
        span += rig.jitter[k + 1] - rig.jitter[k]
    motor, load = rig.forces[k, 0], rig.forces[k, 1]
    if rig.late_part > 0.0:
        move(plant, piecewise, s, commands[0], motor, load, rig.late_part)
    move(plant, piecewise, s, commands[1], motor, load, span - rig.late_part)


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
    piecewise: PiecewiseNumbers,
) -> int:
    """Run samples ``first`` to ``last`` - 1; returns the sample at which the run ended.

    ``target`` is the wanted load angle at the samples. ``log`` has a row per sample, or none at all: true
    angles and speeds, shaft torque, readings, limited command, slip, sigma, estimates (12), regressor (12),
    states of the law.
    """
    gone = farthest(target)
    for k in range(first, last):
        code = chain_ends(piecewise, twist_limit, gone, s)
        if code != 0:
            s.discrete[1] = code
            return k
        wanted, command, sigma = decide(observer, law, rig, reference, k, s.x, s)
        finish_sample(rig, target, k, s, log, s.x, wanted, command, sigma, s.discrete[0])
        move_chain(plant, piecewise, rig, k, s)
    return last
