"""Gain scheduling: linear-quadratic feedback with an integral whose gains go by an announced load."""

from dataclasses import replace

import numpy as np

from cabledrive.control.linear_laws import feedforward_generator, lqi_law
from cabledrive.control.load_schedule import LoadSchedule, scheduled_law, with_load
from cabledrive.control.numbers import LawNumbers
from cabledrive.control.reference import ReferenceNumbers
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.laws.baselines import feedforward_table, integral_time, inverse_of, weights
from cabledrive.rig.laws.controllers import Controller, DesignSpec
from cabledrive.rig.laws.eigenvalues import tuning_by_uncertainty
from cabledrive.rig.setting import Payload

NAME = "lqi-scheduled"
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
        name=NAME,
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
