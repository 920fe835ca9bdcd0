"""Laws that go by the load: gains scheduled by an announced one, and its torque learnt while it moves."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from cabledrive.control.linear_laws import feedforward_generator, lq_law, lqi_law
from cabledrive.control.load_schedule import LoadSchedule, scheduled_law, with_load
from cabledrive.control.load_torque import carried, load_regressors, load_row_numbers
from cabledrive.control.numbers import (
    LEARNING,
    LawNumbers,
    ObserverNumbers,
    learning_table,
    start_estimates,
)
from cabledrive.control.observer_kernels import missed_by_filter, whitening
from cabledrive.control.observers import KalmanTuning, Sampling, kalman_filter
from cabledrive.control.reference import ReferenceNumbers
from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.disturbances import control_delay, current_rate
from cabledrive.rig.laws.baselines import feedforward_table, integral_time, inverse_of, weights
from cabledrive.rig.laws.controllers import Controller, DesignSpec, LoadMotion, fitted_encoders, place
from cabledrive.rig.laws.eigenvalues import tuning_by_uncertainty
from cabledrive.rig.setting import Payload

SCHEDULED = "lqi-scheduled"
RATIO = 1.5
"""Between the loads of the two heaviest points of the grid, where its points lie farthest apart."""


def scheduled(spec: DesignSpec) -> Controller:
    """Feedback, filter and feedforward for the load that is announced, each point designed as `lqi`.

    The reference holds beside states and torque what either adds for another load of the drive's own size:
    both are linear in the load's inertia. Its last column is the load that is announced.
    """
    chain = spec.chain
    low, high = spec.motion.payload_range
    schedule = schedule_of(low, high)
    designs = [_designed(spec, with_load(chain, load)) for load in schedule.loads]
    settings = weights(spec)[2]
    smooth = replace(chain, coulomb=(0.0,) * chain.size)  # friction is fed forward in the step
    # States and torque of the drive's own load, what another of its size adds, and a column of ones.
    wanted = spec.wanted(2 * chain.size)
    own, double = (feedforward_table(spec, with_load(smooth, load), wanted) for load in (1.0, 2.0))
    table = np.ascontiguousarray(np.column_stack((own, double - own, np.ones(len(own)))))
    table[:, -1] = announced(spec.motion.payload, spec.interval, len(table))
    return Controller(
        name=SCHEDULED,
        law=scheduled_law(designs, schedule, chain.coulomb[0]),
        reference=table,
        shafts=spec.shafts,
        start=np.ones(1),
        tuning=tuning_by_uncertainty(spec, chain),
        gains=settings | {"designed_for": [low, high], "designs": schedule.points},
        model=spec.number,
        generator=_generator(spec, smooth),
        schedule=schedule,
        believed=chain,
    )


def schedule_of(low: float, high: float) -> LoadSchedule:
    """Points for a range of loads: the two heaviest a given ratio apart, the others nearer."""
    step = (RATIO - 1.0) / high
    return LoadSchedule(low=low, high=high, points=max(2, int(np.ceil((1.0 / low - 1.0 / high) / step)) + 1))


def announced(payload: tuple[Payload, ...], interval: float, samples: int) -> Array:
    """The load in force at every sample as a factor, shape (samples,); ``interval``: sample time [s]."""
    told = np.ones(samples)
    for one in sorted(payload, key=lambda each: each.start):
        told[round(one.start / interval) :] = one.factor
    return told


def told_otherwise(made: Controller, told: Array) -> Controller:
    """The same law with other announcements, shape (samples,); a law that takes none is returned as it is."""
    if made.schedule is None:
        return made
    reference = made.reference.copy()
    reference[:, -1] = told
    return replace(made, reference=reference)


def _designed(spec: DesignSpec, chain: LumpedChain) -> LawNumbers:
    count, torque, _ = weights(spec, chain=chain)
    return lqi_law(chain, count, torque, integral_time(chain, count, torque), spec.interval)


def _generator(spec: DesignSpec, chain: LumpedChain) -> ReferenceNumbers:
    """The generator of the same columns; the load of a row that it makes is the drive's own."""
    own, double = (
        feedforward_generator(one, inverse_of(spec, one), spec.interval)
        for one in (chain, with_load(chain, 2.0))
    )
    output = np.vstack((own.output, double.output - own.output, np.zeros((1, own.output.shape[1]))))
    constant = np.concatenate((own.constant, double.constant - own.constant, [1.0]))
    return own._replace(output=np.ascontiguousarray(output), constant=constant)


LOAD_LEARNING, CHANGING = "lqi-learning", "lqg-learning"
TURNING = 0.06
"""Time in which the sign of friction turns, as a share of a move."""
GATE = 3.0
"""Deviations from which an innovation is passed over."""
PARAMETERS = ("load_coulomb", "load_viscous", "load_inertia")


@dataclass(frozen=True, slots=True, kw_only=True)
class Learning:
    """What distinguishes the laws that learn."""

    # share of the filter's noise at the load that learning leaves; the more, the less it trusts the load's
    # inertia
    unlearnt: float
    inertia_spread: float  # deviation of the load's inertia before anything is learnt, over what is believed
    # deviation of an innovation over that of white rounding: errors of rounding last as long as a count, and
    # taken for white they pass for friction where there is none
    noise: float
    memory: float  # time after which an excited direction is forgotten [s]
    # time in which innovations that are passed over bring the covariance of the beginning back [s]
    renewal: float


KINDS = {
    LOAD_LEARNING: Learning(unlearnt=0.1, inertia_spread=0.2, noise=5.5, memory=2.0, renewal=0.01),
    CHANGING: Learning(unlearnt=1.0, inertia_spread=1.0, noise=1.0, memory=0.03, renewal=0.006),
}
"""The first for a load that stays, the second for one that changes while the machine runs."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoadTables:
    """What the law knows beforehand of a torque at the load, for each parameter."""

    # (samples, p * (2n + 1 + m): states less what the filter misses, motor torque, innovations, of each
    # parameter
    blocks: Array
    states: Array  # (p, samples, 2n): that the law takes and that go with a unit of each parameter
    white: Array  # (m, m)
    tuning: KalmanTuning
    observer: ObserverNumbers  # the filter that they belong to


def load_learning(spec: DesignSpec, name: str = LOAD_LEARNING, turning: float | None = None) -> Controller:
    """Feedback about a reference with the load's friction and inertia, learnt from innovations."""
    kind = KINDS[name]
    chain = spec.chain
    turning = turning or TURNING * spec.motion.rise
    tables = load_tables(replace(spec, bandwidth=None, best=False, adapt=True), name, turning)
    count, torque, settings = weights(spec)
    # What lasts at the load is learnt: an integral would add the unknown zero of the load's encoder.
    base = lq_law(chain, count, torque, spec.interval)
    reference = feedforward_table(spec, chain, spec.wanted(2 * chain.size))
    generator = feedforward_generator(chain, inverse_of(spec, chain), spec.interval)
    m = len(tables.white)
    rows = np.zeros((1 + m, max(base.rows.shape[1], m)))
    rows[0, : base.rows.shape[1]], rows[1:, :m] = base.rows[0], tables.white
    spread, low, high = believed(chain, kind.inertia_spread)
    variance = spread**2 * float(spec.adapt)
    share = spec.interval / m  # each sample brings m innovations
    law = LawNumbers(
        kind=LEARNING,
        matrix=base.matrix,
        rows=rows,
        learning=learning_table(np.zeros(3), low, high, variance),
        scalars=np.array(
            [spec.interval, 1.0 - share / kind.memory, GATE, share / kind.renewal, 0.0, 0.0, 0.0]
        ),
    )
    gains = settings | {"learns": list(PARAMETERS), "upper_bounds": high.tolist()}
    return Controller(
        name=name,
        law=law,
        reference=np.ascontiguousarray(np.hstack((reference, tables.blocks))),
        shafts=spec.shafts,
        start=start_estimates(law),
        tuning=tables.tuning,
        gains=gains,
        model=spec.number,
        generator=generator._replace(
            load=load_row_numbers(chain, tables.observer, tables.white, turning, spec.interval)
        ),
        load_motion=LoadMotion(chain=chain, states=tables.states),
    )


def believed(chain: LumpedChain, inertia_spread: float) -> tuple[Array, Array, Array]:
    """Deviation and bounds of the load's Coulomb and viscous friction and inertia, shape (3,) each."""
    coulomb, viscous, inertia = max(chain.coulomb[0], 1e-9), max(chain.viscous[0], 1e-9), chain.inertias[-1]
    spread = np.array([0.5 * coulomb, viscous, inertia_spread * inertia])
    return (
        spread,
        np.array([0.0, 0.0, -0.7 * inertia]),
        np.array([2.0 * coulomb, 5.0 * viscous, 3.0 * inertia]),
    )


@lru_cache(maxsize=8)
def load_tables(spec: DesignSpec, name: str, turning: float) -> LoadTables:
    """Tables of the law along a motion; ``turning``: time in which the sign of friction turns [s]."""
    kind = KINDS[name]
    options = spec.options
    chain = spec.chain
    if options.ideal_sensors or options.observer != "kalman":
        raise InputRefused(
            f"{name} learns from the innovations of the Kalman filter: leave observer and ideal_sensors out"
        )
    tuning, fitted = tuning_by_uncertainty(spec, chain), fitted_encoders(spec.drive)
    tuning = replace(tuning, load_acceleration=kind.unlearnt * tuning.load_acceleration)
    sampling = Sampling(
        interval=spec.interval,
        delay=control_delay(spec.plant or spec.drive),
        current_rate=current_rate(spec.drive),
    )
    places, chosen = ([place(chain, one) for one in names] for names in (fitted, spec.shafts))
    used = replace(tuning, offsets=()) if options.encoder_phase == "centred" else tuning
    counts = list(fitted.values())
    observer = kalman_filter(chain, places, counts, sampling, chosen=chosen, tuning=used)
    white = whitening(observer, np.array(counts)) / kind.noise
    torques = load_regressors(spec.wanted(2 * chain.size), turning, spec.interval)
    blocks, states = load_blocks(chain, observer, white, torques, spec.interval)
    return LoadTables(blocks=blocks, states=states, white=white, tuning=tuning, observer=observer)


def load_blocks(
    chain: LumpedChain, observer: ObserverNumbers, white: Array, torques: Array, interval: float
) -> tuple[Array, Array]:
    """Blocks and states of `LoadTables` from torques with derivatives, shape (p, 2n - 1, samples)."""
    blocks, carrying = [], []
    for torque in torques:
        states, motor = carried(chain, torque, interval)
        missed, innovations = missed_by_filter(observer, chain, torque[0], interval)
        chosen = states[:, observer.chosen]
        carrying.append(chosen)
        blocks += [chosen - missed, motor[:, None], innovations @ white.T]
    return np.hstack(blocks), np.array(carrying)
