"""Bounds along a run: of the theorem, of laws that learn the load's torque or go by an announced load.

Between two announcements the law with true states and the chain with the announced load are one linear loop.
Across them the response to a torque of one sample goes on through the new loop from the state that the old
one left, so that the tube is the sum over all samples of the size of that response times what may act there.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from cabledrive.control import bound as theory
from cabledrive.control import numbers
from cabledrive.control.bound import ErrorBound
from cabledrive.control.darc import printed_bounds
from cabledrive.control.load_schedule import law_at, with_load
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.own_plant import models_of
from cabledrive.rig.laws.controllers import place, plant_chain
from cabledrive.rig.margins import tube

NEGLIGIBLE = 1e-3
"""Of a count of the load's encoder: errors that no bound is held against."""
TOLERANCE = 0.05
"""Of an announced load, as `cabledrive.rig.plant_samples.Spreads` has that of a data sheet."""
NAMES = (
    "Coulomb friction of the load",
    "viscous friction of the load",
    "inertia of the load beyond its value",
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BoundCheck:
    """Bound along a run, and the sources of the error beside it, at the first shaft [rad]."""

    bound: ErrorBound
    sources: Array  # (samples,): all of them, by their sizes
    unmatched: Array  # (samples,): what no torque of the motor makes
    # parameters outside their bounds, and estimates further off than the bound takes them to be
    beyond: tuple[str, ...] = ()

    @property
    def used(self) -> float:
        """Largest share of the bound that the sources of the error use; above 1 an assumption fails."""
        return self._share(self.sources)

    @property
    def unmatched_part(self) -> float:
        """Largest share of the bound by what no torque of the motor makes."""
        return self._share(np.abs(self.unmatched))

    def _share(self, part: Array) -> float:
        inside = self.bound.tube > 0.0
        share = float(np.max(part[inside] / self.bound.tube[inside], initial=0.0))
        return share if np.isfinite(share) else float("inf")


def check_theorem(loop: Loop, log: Array) -> BoundCheck | None:
    """Bound of the theorem and sources of the error along a run; None for laws that have no bound here."""
    made = loop.controller
    if made.believed is not None:  # by the load, where the plant is the model that the law is made for
        if loop.own_plant is not None or loop.chain.names != made.believed.names or len(log) < 2:
            return None
        if made.load_motion is not None:
            return check_learning(loop, made.believed, made.load_motion, log)
        return check_scheduled(loop, made.believed, log)
    bound = bound_along(loop, log)
    if bound is None:
        return None
    assert made.flat is not None
    assert made.bandwidth is not None
    nominal = float(made.law.learning[numbers.NOMINAL, 0])
    share = float(true_parameters(loop)[0]) / nominal if nominal > 0.0 else 1.0
    off = law_states(loop, log) @ made.law.matrix.T - made.reference[: len(log), : 2 * made.flat.size]
    error = log[:, loop.chain.size - 1] - loop.target[: len(log)]
    given = made.law, made.flat, made.bandwidth, share * made.law.mu, off, error
    sources, unmatched = theory.sliding_residual(*given)
    return BoundCheck(bound=bound, sources=sources, unmatched=unmatched)


def foreign(loop: Loop, drive: Drive) -> bool:
    """Whether the plant is a lumped chain of the user's own that is none of the drive's models."""
    return bool(loop.named) and loop.own_plant is None and loop.chain not in models_of(drive)


def true_parameters(loop: Loop) -> Array:
    """First inertia, viscous and Coulomb friction and offset torque as they are, shape (4,)."""
    chain = plant_chain(loop.spec.actual, loop.controller.model)
    if foreign(loop, loop.spec.actual) and loop.chain.names == chain.names:
        chain = loop.chain
    return np.array([chain.inertias[0], chain.viscous[0], chain.coulomb[0], chain.offsets[0]])


def load_along(loop: Loop, samples: int) -> Array:
    """Inertia of the plant's load at every sample, shape (samples,) [kg m^2 at the first shaft]."""
    found = np.full(samples, loop.chain.inertias[-1])
    found[round(loop.plant.load_time / loop.rig.interval) :] *= loop.plant.load_factor
    return found


def bound_along(loop: Loop, log: Array) -> ErrorBound | None:
    """Bound of the theorem along a run, actuator and friction at rest counted; None for laws without one."""
    made, n = loop.controller, loop.chain.size
    if made.law.kind != numbers.DARC or made.bandwidth is None or made.flat is None or len(log) < 2:
        return None
    column = 2 * n + 1 + len(loop.rig.encoders)
    start = column + 3 + numbers.ESTIMATES
    delta = disturbance_bound(made.law, log[:, 2 * n], log[:, column])
    deviation = None
    if made.law.scalars[numbers.DESIRED]:
        deviation = theory.regressor_deviation(made.law, law_states(loop, log), made.reference[: len(log)])
    estimates = log[:, start : start + made.law.learning.shape[1]]
    times = made.flat.time_constants
    return theory.error_bound(made.law, made.bandwidth, estimates, delta, times, deviation)


def law_states(loop: Loop, log: Array) -> Array:
    """True angles, then speeds, of the inertias that a law takes, shape (samples, 2n)."""
    places = [place(loop.chain, shaft) for shaft in loop.controller.shafts]
    return np.ascontiguousarray(log[:, [*places, *(loop.chain.size + i for i in places)]])


def disturbance_bound(law: numbers.LawNumbers, shaft: Array, command: Array) -> Array:
    """Bound of the disturbance: friction at rest, and torque less command, shape (samples,) [N m]."""
    late = np.abs(np.append(shaft[1:], shaft[-1]) - command)
    return np.asarray(law.learning[numbers.HIGH][2] + late, dtype=np.float64)


def check_learning(loop: Loop, believed: LumpedChain, states: Array, log: Array) -> BoundCheck:
    """Bound of a law that learns, and sources of the error; ``states``: as `Controller.load_motion`."""
    made, interval = loop.controller, loop.rig.interval
    law, count, states = made.law, len(log), states[:, : len(log)]
    n, k = believed.size, law.matrix.shape[0]
    whole = Segment(law, believed, None, interval, (0, count))
    wanted, block = made.reference[:count, : 2 * n], made.reference.shape[1] - 2 * n - 1
    width = block // len(states)
    torque = np.array([made.reference[:count, 2 * n + 1 + j * width + 2 * n] for j in range(len(NAMES))])
    chains = (loop.chain, believed)
    ends = [np.array([one.coulomb[-1], one.viscous[-1], one.inertias[-1]]) for one in chains]
    true = ends[0] - ends[1]
    true[0] = ends[0][0]  # all of the load's Coulomb friction, which the reference leaves out
    p = law.learning.shape[1]
    first = 2 * loop.chain.size + 1 + len(loop.rig.encoders) + 3
    kept = log[:, first : first + numbers.ESTIMATES]
    covariance = kept[:, p : p + p * p].reshape(-1, p, p)
    spread = np.sqrt(np.maximum(np.diagonal(covariance, axis1=1, axis2=2), 0.0))
    estimates = kept[:, :p]
    missing = np.abs(torque - states @ law.rows[0, k : k + 2 * n]).T
    low, high = law.learning[[numbers.LOW, numbers.HIGH]]
    off = np.minimum(np.maximum(high - estimates, estimates - low), theory.DEVIATIONS * spread)
    height = np.sum(missing * off, axis=1)
    height += motor_disturbance(believed, wanted, interval)
    error = log[:, : 2 * n] - wanted - np.einsum("j,jki->ki", true, states)
    found = _held(loop, [whole], wanted[:, n - 1], height, error)
    return replace(found, beyond=beyond(law.learning, true, estimates, spread))


def _held(loop: Loop, parts: list["Segment"], wanted: Array, height: Array, error: Array) -> BoundCheck:
    """The check of a run; ``height``: of what may act on the motor [N m]; ``error``: of all states."""
    bound = switched_tube(parts, np.append(height[0], height[:-1]) + height)
    matched, unmatched = switched_parts(parts, error)
    lag = np.abs(wanted - loop.target[: len(error)])  # by which the law's own reference misses the angle
    # At the very first samples nothing has moved yet.
    least = lag + max(NEGLIGIBLE * float(loop.rig.counts[-1]), ROUNDING)
    return BoundCheck(
        bound=ErrorBound(tube=bound + least, printed=float("nan")),
        sources=np.abs(matched) + np.abs(unmatched) + lag,
        unmatched=unmatched,
    )


def motor_disturbance(chain: LumpedChain, wanted: Array, interval: float) -> Array:
    """Most torque of the motor within its bounds and of friction that sticks, shape (samples,)."""
    bounds = printed_bounds(chain, flexible_joint="drive" in chain.names[1:])
    speed = wanted[:, chain.size]
    ones = np.ones(len(speed))
    functions = np.column_stack((np.gradient(speed, interval), speed, ones, ones))
    return np.asarray(np.abs(functions) @ bounds.spread + bounds.high[2])


def beyond(learning: Array, true: Array, estimates: Array, spread: Array) -> tuple[str, ...]:
    """What the bound takes for granted of the parameters and does not hold."""
    found = []
    for j, name in enumerate(NAMES):
        low, high = learning[numbers.LOW, j], learning[numbers.HIGH, j]
        if not low <= true[j] <= high:
            found.append(f"{name} {true[j]:.4g} outside its bounds {low:.4g} to {high:.4g}")
        elif np.any(np.abs(estimates[:, j] - true[j]) > theory.DEVIATIONS * spread[:, j]):
            found.append(f"{name}: an estimate lies more than {theory.DEVIATIONS:g} of its deviations off")
    return tuple(found)


ROUNDING = 1e-9
"""Errors that no bound is held against where there are no counts [rad]."""
ROWS = 500
"""Samples whose responses are worked out at once."""


def check_scheduled(loop: Loop, believed: LumpedChain, log: Array) -> BoundCheck:
    """Bound and sources of the error of a law that knows the load."""
    made, interval, count, n = loop.controller, loop.rig.interval, len(log), believed.size
    stated = made.reference[:count, -1]
    own, further = made.reference[:count, : 2 * n], made.reference[:count, 2 * n + 1 : 4 * n + 2]
    wanted = own + (stated - 1.0)[:, None] * further[:, :-1]
    true = load_along(loop, count) / believed.inertias[-1]
    error = log[:, : 2 * n] - own - (true - 1.0)[:, None] * further[:, :-1]
    stretches = pairwise([0, *(np.flatnonzero(np.diff(stated)) + 1).tolist(), count])
    parts = [Segment(made.law, believed, stated[ends[0]], interval, ends) for ends in stretches]
    height = motor_disturbance(believed, wanted, interval)
    for one in parts:
        inside = slice(one.first, one.last)
        missing = further[inside, -1] - further[inside, :-1] @ one.feedback
        height[inside] += TOLERANCE * stated[one.first] * np.abs(missing)
    return _held(loop, parts, wanted[:, n - 1], height, error)


class Segment:
    """The loop with true states over a stretch of samples; ``load``: that is announced there, if any is.

    The memory of a law that knows the load is kept as a torque, which goes on through an announcement.
    """

    def __init__(
        self,
        law: numbers.LawNumbers,
        believed: LumpedChain,
        load: float | None,
        interval: float,
        ends: tuple[int, int],
    ) -> None:
        self.first, self.last = ends
        self.chain = believed if load is None else with_load(believed, float(load))
        one = law if load is None else law_at(law, float(load))
        self.memory = one.matrix.shape[0]
        if load is not None:
            row, matrix = one.rows.copy(), one.matrix.copy()
            matrix[0, 1:] *= row[0, 0]
            row[0, 0] = 1.0
            one = one._replace(rows=row, matrix=matrix)
        self.feedback: Array = one.rows[0, self.memory :]
        self.ideal: theory.IdealLoop = theory.ideal_loop(one, self.chain, interval)


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
            more = np.abs(rows[k : k + ROWS] @ carried) @ heights
            found[one.first + k : one.first + min(k + ROWS, count)] += more
        carried = np.hstack((np.linalg.matrix_power(ideal.matrix, count) @ carried, responses))
        heights = np.concatenate((heights, here))
    return found


def switched_parts(parts: list[Segment], error: Array) -> tuple[Array, Array]:
    """The load's error by a torque of the motor, and by the rest, shape (samples,) [rad] each."""
    count, size = len(error), len(parts[0].ideal.matrix)
    matched, unmatched = np.zeros((count, size)), np.zeros((count, size))
    kept = parts[0].memory
    unmatched[0, kept:] = error[0]
    memory = np.zeros(kept)
    for one in parts:
        matrix, push, n = one.ideal.matrix, one.ideal.push, one.chain.size
        energy = np.zeros((2 * n, 2 * n))  # norm in joules of angles and speeds
        for i, stiffness in enumerate(one.chain.stiffness):
            energy[i : i + 2, i : i + 2] += stiffness * np.array([[1.0, -1.0], [-1.0, 1.0]])
        energy[n:, n:] = np.diag(one.chain.inertias)
        weight = energy @ push[kept:] / (push[kept:] @ energy @ push[kept:])
        for k in range(one.first, min(one.last, count - 1)):
            after = matrix @ np.concatenate((memory, error[k]))
            driving = error[k + 1] - after[kept:]
            memory, torque = after[:kept], driving @ weight
            matched[k + 1] = matrix @ matched[k] + torque * push
            unmatched[k + 1] = matrix @ unmatched[k]
            unmatched[k + 1, kept:] += driving - torque * push[kept:]
    place = parts[0].ideal.load
    return matched[:, place], unmatched[:, place]
