r"""Laws and filters whose numbers go by an announced load, or by the position of a carriage.

With f the load over the one that the law is made for, the points of the grid lie evenly in :math:`1/f`, in
which numbers are interpolated: the motion of the chain over a sample is :math:`\exp(h(A_0 + A_1/f))`, so that
a model is off by the square of a step times that of h times a frequency of the chain.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import tanh
from typing import NamedTuple

import numpy as np

from cabledrive.control import numbers
from cabledrive.control.linear_laws import FRICTION_SLOPE
from cabledrive.control.numbers import ControllerState, LawNumbers, ObserverNumbers
from cabledrive.mechanics.compiled import njit, njit_in_place
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadSchedule:
    """Loads that a law and its filter are designed for."""

    low: float  # least inertia of the load, as a factor of the drive's [-]
    high: float  # largest [-]
    points: int  # designs, at least 2, from the heaviest load to the lightest, evenly in one over the load

    @property
    def first(self) -> float:
        """One over the heaviest load [-]."""
        return 1.0 / self.high

    @property
    def step(self) -> float:
        """Between two points, in one over the load [-]."""
        return (1.0 / self.low - 1.0 / self.high) / (self.points - 1)

    @property
    def loads(self) -> tuple[float, ...]:
        """Factors of the load's inertia at the points, from the heaviest to the lightest."""
        return tuple(1.0 / (self.first + i * self.step) for i in range(self.points))


def with_load(chain: LumpedChain, factor: float) -> LumpedChain:
    """A chain with a factor of its last inertia."""
    *others, load = chain.inertias
    return replace(chain, inertias=(*others, factor * load))


def scheduled_law(laws: Sequence[LawNumbers], schedule: LoadSchedule, coulomb: float) -> LawNumbers:
    """One law of linear ones with an integral, one per point; ``coulomb`` friction [N m] is fed forward."""
    one = laws[0]
    return LawNumbers(
        kind=numbers.SCHEDULED,
        matrix=one.matrix,
        rows=np.vstack([law.rows for law in laws]),
        learning=numbers.learning_table(*(np.array([v]) for v in (1.0, schedule.low, schedule.high, 0.0))),
        scalars=np.array([one.scalars[0], schedule.first, schedule.step, coulomb, FRICTION_SLOPE, 1.0, 0.0]),
    )


def scheduled_filter(filters: Sequence[ObserverNumbers], schedule: LoadSchedule) -> ObserverNumbers:
    """One filter of the settled ones of each point of a schedule."""
    one = filters[0]
    return one._replace(
        kind=numbers.BY_LOAD,
        model=np.ascontiguousarray(np.vstack([seen.model for seen in filters])),
        gains=np.ascontiguousarray(np.concatenate([seen.gains[-1:] for seen in filters])),
        scalars=np.concatenate((one.scalars, [schedule.first, schedule.step])),
    )


def between(tables: Array, first: float, step: float, value: float) -> Array:
    """Tables of all points of a grid interpolated, as `grid_place`; ``tables``, shape (points, ...)."""
    place = grid_place(first, step, len(tables), value)
    cell = min(int(place), len(tables) - 2)
    return np.asarray((cell + 1 - place) * tables[cell] + (place - cell) * tables[cell + 1])


def law_at(law: LawNumbers, load: float) -> LawNumbers:
    """The linear law that a scheduled one is under a load, a factor in its range; any other as it is."""
    if law.kind != numbers.SCHEDULED:
        return law
    load = min(max(load, law.learning[numbers.LOW, 0]), law.learning[numbers.HIGH, 0])
    row = between(law.rows, law.scalars[1], law.scalars[2], 1.0 / load)
    scalars = law.scalars.copy()
    scalars[1:5] = 0.0
    return law._replace(kind=numbers.LINEAR, rows=row[None], learning=np.zeros((5, 0)), scalars=scalars)


def filter_at(observer: ObserverNumbers, load: float) -> ObserverNumbers:
    """The Kalman filter that a scheduled one is under a load, as a factor; any other as it is."""
    if observer.kind != numbers.BY_LOAD:
        return observer
    states, (first, step) = observer.output.shape[1], observer.scalars[9:]
    models = observer.model.reshape(-1, states, observer.model.shape[1])
    return observer._replace(
        kind=numbers.KALMAN,
        model=np.ascontiguousarray(between(models, first, step, 1.0 / load)),
        gains=between(observer.gains, first, step, 1.0 / load)[None],
        scalars=observer.scalars[:9].copy(),
    )


@njit_in_place
def announced_load(law: LawNumbers, reference: Array, k: int) -> float:
    """Factor of the load that row k announces; beyond the range of the design its nearer end."""
    load = reference[k, reference.shape[1] - 1]
    return min(max(load, law.learning[numbers.LOW, 0]), law.learning[numbers.HIGH, 0])


@njit_in_place
def grid_place(first: float, step: float, count: int, value: float) -> float:
    """Place of a position, or of one over a load, among the points of a grid, held at the ends."""
    return min(max((value - first) / step, 0.0), count - 1.0)


@njit_in_place
def row_at(rows: Array, place: float, j: int) -> float:
    """Entry j of the rows of the grid, interpolated."""
    cell = min(int(place), rows.shape[0] - 2)
    share = place - cell
    return (1.0 - share) * rows[cell, j] + share * rows[cell + 1, j]


@njit_in_place
def scheduled_command(law: LawNumbers, c: ControllerState, reference: Array, k: int) -> tuple[float, float]:
    """Command and error of the load, about the states and the torque that the announced load asks for.

    The memory is a torque, not a sum of errors: another gain of the integral does not make it jump.
    """
    rows, states, n2 = law.rows, c.states, c.states.size
    load = c.parameters[0]
    beyond = load - 1.0
    place = grid_place(law.scalars[1], law.scalars[2], rows.shape[0], 1.0 / load)
    speed = reference[k, n2 // 2] + beyond * reference[k, n2 + 1 + n2 // 2]
    u = c.memory[0] + reference[k, n2] + beyond * reference[k, 2 * n2 + 1]
    u += law.scalars[3] * tanh(law.scalars[4] * speed)
    load = 0.0
    for j in range(n2):
        e = states[j] - reference[k, j] - beyond * reference[k, n2 + 1 + j]
        u += row_at(rows, place, 1 + j) * e
        if j == n2 // 2 - 1:
            load = e
    c.memory[0] += row_at(rows, place, 0) * law.matrix[0, n2 // 2] * load
    return u, load


class ScheduledLaw(NamedTuple):
    """Tables over the positions of the carriage, as the compiled step takes them."""

    grid: Array  # (3,): first position, spacing, start of the carriage [m]
    feedback: Array  # (positions, 8): force per error of the states
    correction: Array  # (positions, 10, 2): of the observer's states by the errors of the two encoders
    transition: Array  # (positions, 10, 10): over one sample
    drive: Array  # (positions, 10): by a force on the motor
    limit: float  # largest force [N]


@njit
def scheduled_step(
    law: ScheduledLaw, estimate: Array, readings: Array, reference: Array, k: int, fresh: Array
) -> float:
    """One sample: the observer takes in the readings, the law acts, the observer goes on; the force [N]."""
    grid, feedback, correction, transition, drive, limit = law
    n, m, states = estimate.size, readings.size, feedback.shape[1]
    place = grid_place(grid[0], grid[1], feedback.shape[0], grid[2] + estimate[1])
    low = min(int(place), feedback.shape[0] - 2)
    share = place - low
    for i in range(n):
        value = estimate[i]
        for j in range(m):
            gain = correction[low, i, j] + share * (correction[low + 1, i, j] - correction[low, i, j])
            value += gain * (readings[j] - estimate[2 * j])
        fresh[i] = value
    force = reference[k, states]
    for i in range(states):
        gain = feedback[low, i] + share * (feedback[low + 1, i] - feedback[low, i])
        force -= gain * (fresh[i] - reference[k, i])
    force = min(max(force, -limit), limit)
    net = force - reference[k, states + 1]
    for i in range(n):
        value = (drive[low, i] + share * (drive[low + 1, i] - drive[low, i])) * net
        for j in range(n):
            part = transition[low, i, j] + share * (transition[low + 1, i, j] - transition[low, i, j])
            value += part * fresh[j]
        estimate[i] = value
    return force
