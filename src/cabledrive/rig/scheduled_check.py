r"""The bound of a law that goes by an announced load along a run, and how much of it the run used.

Between two announcements the law with true states and the chain with the announced load are one linear loop.
Across them the response to a torque of one sample goes on through the new loop from the state that the old
one left, so that the tube is the sum over all samples of the size of that response times what may act there.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from cabledrive.control.bound import ErrorBound, IdealLoop, ideal_loop
from cabledrive.control.load_schedule import law_at, with_load
from cabledrive.control.numbers import LawNumbers
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.assumptions import TOLERANCE, load_along
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.expected_bound import tube
from cabledrive.rig.learning_check import NEGLIGIBLE, LearningCheck, motor_disturbance

ROUNDING = 1e-9
"""Errors that no bound is held against where there are no counts [rad]."""
ROWS = 500
"""Samples whose responses are worked out at once."""


def check_scheduled(loop: Loop, believed: LumpedChain, log: Array) -> LearningCheck | None:
    """Bound and sources of the error along a run; none where the plant is another model.

    ``believed``: chain of the drive's own load; ``log``, shape (samples, columns).
    """
    made, interval, count, n = loop.controller, loop.rig.interval, len(log), believed.size
    if loop.own_plant is not None or loop.chain.names != believed.names or count < 2 or made.load is None:
        return None
    told = made.reference[:count, -1]
    own, further = made.reference[:count, : 2 * n], made.reference[:count, 2 * n + 1 : 4 * n + 2]
    wanted = own + (told - 1.0)[:, None] * further[:, :-1]
    true = load_along(loop, count) / made.load
    error = log[:, : 2 * n] - own - (true - 1.0)[:, None] * further[:, :-1]
    parts = [Segment(made.law, believed, told[first], interval, first, last) for first, last in runs_of(told)]
    height = motor_disturbance(believed, wanted, interval)
    for one in parts:
        inside = slice(one.first, one.last)
        missing = further[inside, -1] - further[inside, :-1] @ one.feedback
        height[inside] += TOLERANCE * one.load * np.abs(missing)
    bound = switched_tube(parts, np.append(height[0], height[:-1]) + height)
    matched, unmatched = switched_parts(parts, error)
    lag = np.abs(wanted[:, n - 1] - loop.target[:count])
    least = lag + max(NEGLIGIBLE * float(loop.rig.counts[-1]), ROUNDING)
    return LearningCheck(
        bound=ErrorBound(tube=bound + least, steady=float(bound.max()), printed=float("nan")),
        matched=matched,
        unmatched=unmatched,
        lag=lag,
        beyond=(),
    )


def runs_of(told: Array) -> Iterator[tuple[int, int]]:
    """First sample and the one after the last of each stretch of one announced load."""
    return pairwise([0, *(np.flatnonzero(np.diff(told)) + 1).tolist(), len(told)])


class Segment:
    """The loop with true states while one load is announced; its memory is a torque."""

    def __init__(
        self, law: LawNumbers, believed: LumpedChain, load: float, interval: float, first: int, last: int
    ) -> None:
        self.load, self.first, self.last = float(load), first, last
        self.chain = with_load(believed, self.load)
        one = law_at(law, self.load)
        row, matrix = one.rows.copy(), one.matrix.copy()
        matrix[0, 1:] *= row[0, 0]
        row[0, 0] = 1.0
        self.feedback: Array = row[0, 1:]
        self.ideal: IdealLoop = ideal_loop(one._replace(rows=row, matrix=matrix), self.chain, interval)

    @property
    def energy(self) -> Array:
        """Norm in joules of angles and speeds, shape (2n, 2n)."""
        n = self.chain.size
        found = np.zeros((2 * n, 2 * n))
        for i, stiffness in enumerate(self.chain.stiffness):
            found[i : i + 2, i : i + 2] += stiffness * np.array([[1.0, -1.0], [-1.0, 1.0]])
        found[n:, n:] = np.diag(self.chain.inertias)
        return found


def switched_tube(parts: list[Segment], height: Array) -> Array:
    """Largest angle of the load by any torque of the motor within a height, shape (samples,) [rad].

    ``height``, shape (samples,) [N m].
    """
    found = np.zeros(len(height))
    carried, heights = np.zeros((len(parts[0].ideal.matrix), 0)), np.zeros(0)
    for one in parts:
        ideal, count = one.ideal, one.last - one.first
        here = height[one.first : one.last]
        found[one.first : one.last] = tube(np.abs(ideal.response(count)), here)
        rows, row = np.zeros((count, len(ideal.matrix))), np.eye(len(ideal.matrix))[ideal.load]
        responses, state = np.zeros((len(ideal.matrix), count)), ideal.push
        for k in range(count):
            rows[k], row = row, row @ ideal.matrix
            responses[:, count - 1 - k], state = state, ideal.matrix @ state
        for k in range(0, count if carried.shape[1] else 0, ROWS):
            found[one.first + k : one.first + min(k + ROWS, count)] += (
                np.abs(rows[k : k + ROWS] @ carried) @ heights
            )
        carried = np.hstack((np.linalg.matrix_power(ideal.matrix, count) @ carried, responses))
        heights = np.concatenate((heights, here))
    return found


def switched_parts(parts: list[Segment], error: Array) -> tuple[Array, Array]:
    """What drove the load's error: a torque of the motor, and the rest, told apart in the norm of energy.

    ``error``, shape (samples, 2n): of angles and speeds.
    Returns each part's share of the load's angle, shape (samples,) [rad].
    """
    count, size = len(error), len(parts[0].ideal.matrix)
    matched, unmatched = np.zeros((count, size)), np.zeros((count, size))
    unmatched[0, 1:] = error[0]
    memory = 0.0
    for one in parts:
        matrix, push, energy = one.ideal.matrix, one.ideal.push, one.energy
        weight = energy @ push[1:] / (push[1:] @ energy @ push[1:])
        for k in range(one.first, min(one.last, count - 1)):
            after = matrix @ np.concatenate(([memory], error[k]))
            driving = error[k + 1] - after[1:]
            memory, torque = after[0], driving @ weight
            matched[k + 1] = matrix @ matched[k] + torque * push
            unmatched[k + 1] = matrix @ unmatched[k]
            unmatched[k + 1, 1:] += driving - torque * push[1:]
    place = parts[0].ideal.load
    return matched[:, place], unmatched[:, place]
