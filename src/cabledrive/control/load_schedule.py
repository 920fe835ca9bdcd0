r"""Numbers of a law and a filter whose gains are scheduled by an announced load.

With f the load over the one that the law is made for, the points of the grid lie evenly in :math:`1/f`: the
motion of the chain over a sample is :math:`\exp(h(A_0 + A_1/f))`, so that a filter's model interpolated in
:math:`1/f` is off by the square of a step times that of h times a frequency of the chain.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.control.linear_laws import FRICTION_SLOPE
from cabledrive.control.numbers import (
    BY_LOAD,
    HIGH,
    KALMAN,
    LINEAR,
    LOW,
    SCHEDULED,
    LawNumbers,
    ObserverNumbers,
    learning_table,
)
from cabledrive.control.schedule_kernels import grid_place
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
        kind=SCHEDULED,
        matrix=one.matrix,
        rows=np.vstack([law.rows for law in laws]),
        learning=learning_table(*(np.array([v]) for v in (1.0, schedule.low, schedule.high, 0.0))),
        scalars=np.array([one.scalars[0], schedule.first, schedule.step, coulomb, FRICTION_SLOPE, 1.0, 0.0]),
    )


def scheduled_filter(filters: Sequence[ObserverNumbers], schedule: LoadSchedule) -> ObserverNumbers:
    """One filter of the settled ones of each point of a schedule."""
    one = filters[0]
    return one._replace(
        kind=BY_LOAD,
        model=np.ascontiguousarray(np.vstack([seen.model for seen in filters])),
        gains=np.ascontiguousarray(np.concatenate([seen.gains[-1:] for seen in filters])),
        scalars=np.concatenate((one.scalars, [schedule.first, schedule.step])),
    )


def _between(tables: Array, first: float, step: float, load: float) -> Array:
    """Tables of all points interpolated for a load; ``tables``, shape (points, ...)."""
    place = grid_place(first, step, len(tables), load)
    cell = min(int(place), len(tables) - 2)
    return np.asarray((cell + 1 - place) * tables[cell] + (place - cell) * tables[cell + 1])


def law_at(law: LawNumbers, load: float) -> LawNumbers:
    """The linear law that a scheduled one is under a load, a factor in its range; any other as it is."""
    if law.kind != SCHEDULED:
        return law
    load = min(max(load, law.learning[LOW, 0]), law.learning[HIGH, 0])
    row = _between(law.rows, law.scalars[1], law.scalars[2], load)
    scalars = law.scalars.copy()
    scalars[1:5] = 0.0
    return law._replace(kind=LINEAR, rows=row[None], learning=np.zeros((5, 0)), scalars=scalars)


def filter_at(observer: ObserverNumbers, load: float) -> ObserverNumbers:
    """The Kalman filter that a scheduled one is under a load, as a factor; any other as it is."""
    if observer.kind != BY_LOAD:
        return observer
    states, (first, step) = observer.output.shape[1], observer.scalars[9:]
    models = observer.model.reshape(-1, states, observer.model.shape[1])
    return observer._replace(
        kind=KALMAN,
        model=np.ascontiguousarray(_between(models, first, step, load)),
        gains=_between(observer.gains, first, step, load)[None],
        scalars=observer.scalars[:9].copy(),
    )
