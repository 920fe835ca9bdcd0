"""The closed loop of the rig on a lumped chain, compiled: plant and controller, sample after sample."""

from math import isfinite, pi, sin
from typing import NamedTuple

from cabledrive.control.numbers import LawNumbers, ObserverNumbers
from cabledrive.mechanics.compiled import njit_in_place, njit_part
from cabledrive.rig.closed_loop.disturbed_kernels import DisturbedNumbers, move_disturbed
from cabledrive.rig.closed_loop.loop_numbers import DIVERGED, WENT_SLACK, Array, LoopState, RigNumbers
from cabledrive.rig.closed_loop.piecewise_kernels import PiecewiseNumbers, advance_piecewise
from cabledrive.rig.closed_loop.plant_kernels import PlantNumbers, advance
from cabledrive.rig.closed_loop.sample_kernels import decide, farthest, finish_sample


class ChainPlant(NamedTuple):
    """A lumped chain as the loop moves it: linear, in linear pieces, or with disturbances, which go first.

    ``twist_limit``: twist across the cable at which a run ends, for a span is slack [rad].
    """

    linear: PlantNumbers
    piecewise: PiecewiseNumbers
    disturbed: DisturbedNumbers
    twist_limit: float


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


@njit_part
def chain_ends(plant: ChainPlant, gone: float, s: LoopState) -> int:
    """Look at the lumped chain at a sample; why the run ends here, 0 where it goes on.

    Counts what the links do: largest twist, a span slack, the joint inside its backlash.
    """
    x, d = s.x, plant.disturbed
    n = x.size // 2
    play, slack = plant.piecewise.play, plant.piecewise.slack
    if d.inertias.size > 0:
        play, slack = d.play, d.slack
    twist = abs(x[n - 2] - x[n - 1]) if n > 1 else 0.0
    s.summary[7] = max(s.summary[7], twist)
    if twist > slack:
        s.summary[9] += 1.0
    if play > 0.0 and abs(x[0] - x[1]) < play:
        s.summary[10] += 1.0
    if not isfinite(x[n - 1]) or abs(x[n - 1]) > gone or twist > plant.twist_limit:
        return WENT_SLACK if isfinite(twist) and twist > plant.twist_limit else DIVERGED
    return 0


@njit_part
def see_chain(d: DisturbedNumbers, s: LoopState) -> None:
    """Write into ``s.work`` the states that sensors see: the load as its eccentric encoder shows it."""
    for i in range(s.x.size):
        s.work[i] = s.x[i]
    if d.eccentricity > 0.0:
        load = d.inertias.size - 1
        s.work[load] += d.eccentricity * sin(d.turning * s.x[load] + d.phases[2])


@njit_part
def move_chain(plant: ChainPlant, rig: RigNumbers, k: int, s: LoopState) -> None:
    """Move the lumped chain to the next sample, the older command first as long as the delay lasts."""
    span, commands, d = rig.interval, s.controller.commands, plant.disturbed
    if rig.jitter.size > 0:
        span += rig.jitter[k + 1] - rig.jitter[k]
    motor, load, late = rig.forces[k, 0], rig.forces[k, 1], rig.late_part
    if d.inertias.size > 0:
        begin, fresh = k * rig.interval, s.terms[0]
        # The field of a stepper turns on between samples; a torque is held.
        turning = (commands[1] - commands[0]) / rig.interval if d.field > 0.0 else 0.0
        if late > 0.0:
            older = commands[0] + turning * (rig.interval - late)
            move_disturbed(d, s.x, older, turning, motor, load, begin, late, fresh)
        s.discrete[0] = move_disturbed(
            d, s.x, commands[1], turning, motor, load, begin + late, span - late, fresh
        )
        return
    if late > 0.0:
        move(plant.linear, plant.piecewise, s, commands[0], motor, load, late)
    move(plant.linear, plant.piecewise, s, commands[1], motor, load, span - late)


@njit_in_place
def run_loop(
    plant: ChainPlant,
    observer: ObserverNumbers,
    law: LawNumbers,
    rig: RigNumbers,
    reference: Array,
    target: Array,
    first: int,
    last: int,
    s: LoopState,
    log: Array,
) -> int:
    """Run samples ``first`` to ``last`` - 1; returns the sample at which the run ended.

    ``target`` is the wanted load angle at the samples. ``log`` has a row per sample, or none at all: true
    angles and speeds, shaft torque, readings, limited command, slip, sigma, estimates (12), regressor (12),
    states of the law.
    """
    gone = farthest(target)
    for k in range(first, last):
        code = chain_ends(plant, gone, s)
        if code != 0:
            s.discrete[1] = code
            return k
        see_chain(plant.disturbed, s)
        wanted, command, sigma = decide(observer, law, rig, reference, k, s.work, s)
        if plant.disturbed.field > 0.0:  # the command is an angle: the torque is scored, and lost steps
            lag = abs(plant.disturbed.field_periods * (command - s.x[0]))
            command = s.x[s.x.size - 1]
            wanted = command + (1.0 if lag > 0.5 * pi else 0.0)
        finish_sample(rig, target, k, s, log, s.x, wanted, command, sigma, s.discrete[0])
        move_chain(plant, rig, k, s)
    return last
