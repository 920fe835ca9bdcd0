"""Bounds of laws that learn the load's torque or go by an announced load, along a run.

Between two announcements the law with true states and the chain with the announced load are one linear loop.
Across them the response to a torque of one sample goes on through the new loop from the state that the old
one left, so that the tube is the sum over all samples of the size of that response times what may act there.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cabledrive.control.bound import (
    DEVIATIONS,
    ErrorBound,
    IdealLoop,
    believed_range,
    ideal_loop,
    missing_torque,
)
from cabledrive.control.darc import printed_bounds
from cabledrive.control.load_schedule import law_at, with_load
from cabledrive.control.numbers import HIGH, LOW, LawNumbers
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.assumptions import TOLERANCE, load_along
from cabledrive.rig.closed_loop.linear_loop import driven
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_numbers import ESTIMATES, Array
from cabledrive.rig.expected_bound import tube
from cabledrive.rig.laws.controllers import LoadMotion

NEGLIGIBLE = 1e-3
"""Of a count of the load's encoder: errors that no bound is held against."""
NAMES = (
    "Coulomb friction of the load",
    "viscous friction of the load",
    "inertia of the load beyond its value",
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LearningCheck:
    """Bound along a run, and the sources of the error beside it, at the first shaft."""

    bound: ErrorBound
    # matched, unmatched: (samples,): parts of the error that a torque of the motor makes, and that none makes
    # [rad]
    matched: Array
    unmatched: Array
    lag: Array  # (samples,): by which the law's own reference misses the wanted angle between samples [rad]
    # parameters outside their bounds, and estimates further off than the bound takes them to be
    beyond: tuple[str, ...]

    @property
    def used(self) -> float:
        """Largest share of the bound that the sources of the error use; above 1 an assumption fails."""
        return self._share(np.abs(self.matched) + np.abs(self.unmatched) + self.lag)

    @property
    def unmatched_part(self) -> float:
        """Largest share of the bound by what no torque of the motor makes."""
        return self._share(np.abs(self.unmatched))

    def _share(self, part: Array) -> float:
        share = float(np.max(part / self.bound.tube))
        return share if np.isfinite(share) else float("inf")


def check_learning(loop: Loop, log: Array) -> LearningCheck | None:
    """Bound of a law that learns and sources of the error; none where the plant is another model."""
    made, interval = loop.controller, loop.rig.interval
    motion, law, count = made.load_motion, made.law, len(log)
    if motion is None or loop.own_plant is not None or loop.chain.names != motion.chain.names or count < 2:
        return None
    n, k = motion.chain.size, law.matrix.shape[0]
    ideal = ideal_loop(law, motion.chain, interval)
    wanted, block = made.reference[:count, : 2 * n], made.reference.shape[1] - 2 * n - 1
    width = block // len(motion.states)
    torque = np.array([made.reference[:count, 2 * n + 1 + j * width + 2 * n] for j in range(len(NAMES))])
    states = motion.states[:, :count]
    true = load_parameters(loop.chain, motion)
    estimates, spread = learnt_along(loop, log)
    height = np.sum(
        np.abs(missing_torque(law.rows[0, k : k + 2 * n], states, torque))
        * believed_range(law, estimates, spread),
        axis=1,
    ) + motor_disturbance(motion.chain, wanted, interval)
    bound = tube(np.abs(ideal.response(count)), np.append(height[0], height[:-1]) + height)
    error = log[:, : 2 * n] - wanted - np.einsum("j,jki->ki", true, states)
    matched, unmatched = parts_of(ideal, motion.chain, error, k)
    lag = np.abs(wanted[:, n - 1] - loop.target[:count])
    least = lag + NEGLIGIBLE * loop.rig.counts[-1]  # at the very first samples nothing has moved yet
    return LearningCheck(
        bound=ErrorBound(tube=bound + least, steady=float(bound.max()), printed=float("nan")),
        matched=matched,
        unmatched=unmatched,
        lag=lag,
        beyond=beyond(law.learning, true, estimates, spread),
    )


def load_parameters(chain: LumpedChain, motion: LoadMotion) -> Array:
    """What the law is to learn of a plant, shape (3,): friction, Coulomb and viscous, inertia beyond it."""
    ours = motion.chain
    return np.array(
        [
            chain.coulomb[-1] - ours.coulomb[-1],
            chain.viscous[-1] - ours.viscous[-1],
            chain.inertias[-1] - ours.inertias[-1],
        ]
    )


def learnt_along(loop: Loop, log: Array) -> tuple[Array, Array]:
    """Estimates and their standard deviations at every sample, shape (samples, p)."""
    p = loop.controller.law.learning.shape[1]
    first = 2 * loop.chain.size + 1 + len(loop.rig.encoders) + 3
    kept = log[:, first : first + ESTIMATES]
    covariance = kept[:, p : p + p * p].reshape(-1, p, p)
    variances = np.maximum(np.diagonal(covariance, axis1=1, axis2=2), 0.0)
    return kept[:, :p], np.sqrt(variances)


def motor_disturbance(chain: LumpedChain, wanted: Array, interval: float) -> Array:
    """Most torque of the motor within its bounds and of friction that sticks, shape (samples,)."""
    bounds = printed_bounds(chain, flexible_joint="drive" in chain.names[1:])
    speed = wanted[:, chain.size]
    functions = np.column_stack(
        (np.gradient(speed, interval), speed, np.ones(len(speed)), np.ones(len(speed)))
    )
    return np.asarray(np.abs(functions) @ bounds.spread + bounds.high[2])


def parts_of(ideal: IdealLoop, chain: LumpedChain, error: Array, memory: int) -> tuple[Array, Array]:
    """The load's error by a torque of the motor, and by the rest, told apart in the norm of energy."""
    n, count = chain.size, len(error)
    kept = np.zeros((count, memory))
    for i in range(count - 1):
        kept[i + 1] = ideal.matrix[:memory] @ np.concatenate((kept[i], error[i]))
    whole = np.hstack((kept, error))
    driving = error[1:] - whole[:-1] @ ideal.matrix[memory:].T
    driving = np.vstack((driving, np.zeros(2 * n)))
    push = ideal.push[memory:]
    energy = np.zeros((2 * n, 2 * n))
    for i, stiffness in enumerate(chain.stiffness):
        energy[i : i + 2, i : i + 2] += stiffness * np.array([[1.0, -1.0], [-1.0, 1.0]])
    energy[n:, n:] = np.diag(chain.inertias)
    torque = driving @ energy @ push / (push @ energy @ push)
    picks = np.zeros(len(ideal.matrix))
    picks[ideal.load] = 1.0
    start = np.zeros((count, memory))
    by_motor = np.outer(torque, push)
    matched = driven(ideal.matrix, np.hstack((start, by_motor)), picks)
    return matched, driven(ideal.matrix, np.hstack((start, driving - by_motor)), picks)


def beyond(learning: Array, true: Array, estimates: Array, spread: Array) -> tuple[str, ...]:
    """What the bound takes for granted of the parameters and does not hold."""
    found = []
    for j, name in enumerate(NAMES):
        low, high = learning[LOW, j], learning[HIGH, j]
        if not low <= true[j] <= high:
            found.append(f"{name} {true[j]:.4g} outside its bounds {low:.4g} to {high:.4g}")
        elif np.any(np.abs(estimates[:, j] - true[j]) > DEVIATIONS * spread[:, j]):
            found.append(f"{name}: an estimate lies more than {DEVIATIONS:g} of its deviations off")
    return tuple(found)


ROUNDING = 1e-9
"""Errors that no bound is held against where there are no counts [rad]."""
ROWS = 500
"""Samples whose responses are worked out at once."""


def check_scheduled(loop: Loop, believed: LumpedChain, log: Array) -> LearningCheck | None:
    """Bound and sources of the error along a run; none where the plant is another model."""
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
    """Largest angle of the load by a torque within a height [N m], both of shape (samples,) [rad]."""
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
    """The load's error by a torque of the motor, and by the rest, shape (samples,) [rad] each."""
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
