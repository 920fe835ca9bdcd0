"""Many plants under one law of the chain, with true states and smoothed friction: a vectorised batch."""

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import islice

import numpy as np

from cabledrive.control.numbers import DARC, ELASTIC, IDEAL, INERTIAL, LIMIT, SURFACE, LawNumbers
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop import batch_kernels as row
from cabledrive.rig.closed_loop.batch_kernels import (
    INPUTS,
    LANES,
    ROWS,
    STATES,
    integrate_many,
    integrate_one,
)
from cabledrive.rig.closed_loop.batch_tables import free_transitions
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY, Array
from cabledrive.rig.closed_loop.sample_kernels import farthest

PLACES = {1: (0,), 2: (0, 2), 3: (0, 1, 2)}
"""Which of three angles each inertia of a chain has; of one inertia load and motor are the same."""
MADE_AT_ONCE = 512


def fits_batch(loop: Loop) -> bool:
    """Whether a loop can run in a vectorised batch.

    Returns a law of the chain on true states; smoothed friction of the motor and none of the load; one
    internal step per sample; no backlash, slack, delay, jitter, disturbance or encoder dropout.
    """
    rig, scalars = loop.rig, loop.plant.scalars
    exact = loop.observer.kind == IDEAL and loop.controller.law.kind == DARC
    exact = exact and loop.cable is None and loop.own_plant is None and loop.disturbed is None
    smooth = scalars[8] > 0.0 and scalars[4] == 0.0 and loop.chain.size in PLACES
    punctual = rig.late_samples == 0 and rig.late_part == 0.0 and rig.jitter.size == 0
    quiet = not rig.forces.any() and rig.dropout[0] < 0 and loop.piecewise.rates.shape[0] == 0
    return bool(exact and smooth and punctual and quiet and scalars[0] == rig.interval)


def run_batch(
    loop: Loop, chains: Iterable[LumpedChain], *, threads: int = 2, twist_limits: Array | None = None
) -> tuple[Array, Array]:
    """Run the law of a loop on many lumped chains.

    ``loop``: one that `fits_batch`; ``chains``: as many inertias as the plant of the loop; ``twist_limits``,
    shape (rows,): twist at which a span of each goes slack [rad]; default: that of the loop.
    Returns ``scores``, shape (rows, scores): as `cabledrive.rig.closed_loop.loop_numbers.SUMMARY` names them,
    at the first shaft; ``failed``, shape (rows,): whether a span went slack or the plant diverged; the run
    was not ended for it.
    """
    table, law = reference_table(loop), law_rows(loop)

    def integrate(group: Array) -> Array:
        integrate_many(group, table, loop.rig.first_end)
        return group

    with ThreadPoolExecutor(threads) as pool:
        groups = [(count, pool.submit(integrate, group)) for count, group in _groups(loop, law, chains)]
    integrated = [done.result().reshape(ROWS, LANES)[:, :count] for count, done in groups]
    return _scores(loop, np.hstack(integrated), loop.twist_limit if twist_limits is None else twist_limits)


def run_one(loop: Loop) -> Array:
    """Run a loop that `fits_batch` as a batch of one.

    Returns shape (scores,): as `cabledrive.rig.closed_loop.loop_numbers.SUMMARY` names them, at the first
    shaft.
    """
    return integrate_alone(loop, single_batch(loop), reference_table(loop))


def single_batch(loop: Loop) -> Array:
    """A loop at rest, as the numbers of a batch of one."""
    tables = free_transitions([loop.chain], loop.rig.interval, float(loop.plant.scalars[6]))
    return _filled(loop, law_rows(loop), [loop.chain], tables, 1)


def integrate_alone(loop: Loop, single: Array, table: Array) -> Array:
    """Run a batch of one; it is kept as it was.

    ``single``: from `single_batch`; ``table``, shape (samples, 6): from `reference_table`.
    Returns shape (scores,).
    """
    moving = single.copy()
    integrate_one(moving, table, loop.rig.first_end)
    scores: Array = _scores(loop, moving[:, None], loop.twist_limit)[0][0]
    return scores


def _groups(loop: Loop, law: Array, chains: Iterable[LumpedChain]) -> Iterator[tuple[int, Array]]:
    """Groups of plants, the last one filled up with its last plant; each with its number of plants."""
    rest, rate = iter(chains), float(loop.plant.scalars[6])
    while some := list(islice(rest, MADE_AT_ONCE)):
        tables = free_transitions(some, loop.rig.interval, rate)
        for first in range(0, len(some), LANES):
            count = min(LANES, len(some) - first)
            chosen = [min(first + i, len(some) - 1) for i in range(LANES)]
            yield count, _filled(loop, law, [some[i] for i in chosen], tables[chosen], LANES)


def _filled(loop: Loop, law: Array, chains: list[LumpedChain], tables: Array, lanes: int) -> Array:
    """The numbers of a group at rest."""
    n = loop.chain.size
    z = np.zeros((ROWS, lanes))
    start = loop.controller.start
    z[row.ESTIMATE : row.ESTIMATE + 4] = start[:, None]
    z[row.COULOMB] = [chain.coulomb[0] for chain in chains]
    z[row.OFFSET] = [chain.offsets[0] for chain in chains]
    z[row.SIGMA :] = law[:, None]
    wide = np.zeros((STATES, STATES + INPUTS, lanes))
    places = _places(n)
    columns = [*places, STATES, STATES + 1, STATES + 2]
    used = [*range(2 * n + 1), 2 * n + 1, 2 * n + 2, 2 * n + 4]
    wide[np.ix_(places, columns)] = np.moveaxis(tables[:, :, used], 0, 2)
    if n == 1:
        wide[2], wide[5] = wide[0], wide[3]
    z[row.TABLES : row.SIGMA] = wide.reshape(-1, lanes)
    return z.ravel()


def _places(n: int) -> list[int]:
    angles = PLACES[n]
    return [*angles, *(3 + i for i in angles), 6]


def law_rows(loop: Loop) -> Array:
    """Numbers of the law, in the order of the rows of a group.

    Returns shape (58,).
    """
    law, rig = loop.controller.law, loop.rig
    surface, acceleration, elastic = _flat_rows(law)
    chosen = [_places(loop.chain.size)[i] for i in loop.observer.chosen]
    wide = np.zeros((5, 6))
    for i, values in enumerate((surface, acceleration, elastic)):
        wide[i, chosen] = values @ law.matrix
    wide[3, chosen[len(chosen) // 2]] = 1.0
    if np.isfinite(loop.slack):
        wide[4, 2], wide[4, PLACES[loop.chain.size][-2]] = -1.0, 1.0
    interval, k_sigma, slope, by_reference, desired = law.scalars[:5]
    smoothing, loops = loop.plant.scalars[8], loop.plant.scalars[6] > 0.0
    limits = np.minimum(law.learning[LIMIT], 1e300)
    learning = (*law.learning[:LIMIT], limits)
    order = (interval, k_sigma, slope, by_reference, desired)
    rest = (min(rig.torque_limit, 1e300), smoothing, 1.0 if loops else 0.0)
    return np.concatenate((wide.ravel(), *learning, order, rest))


def _flat_rows(law: LawNumbers) -> tuple[Array, Array, Array]:
    """Sigma, acceleration of the first inertia and elastic torque per flat output and its derivatives."""
    n2 = law.matrix.shape[0]
    surface, inertial = law.rows[SURFACE, :n2], law.rows[INERTIAL].copy()
    inertial[1:n2] -= inertial[n2] * surface[:-1]
    return surface, inertial[:n2], law.rows[ELASTIC, :n2]


def reference_table(loop: Loop) -> Array:
    """What of the law depends on the time alone, at every sample.

    Returns shape (samples, 6): sigma and acceleration of the reference, its regressors, the wanted angle.
    """
    law, reference = loop.controller.law, loop.controller.reference
    n2 = law.matrix.shape[0]
    surface, last = law.rows[SURFACE, :n2], law.rows[INERTIAL, n2]
    speed = reference[:, n2 + 1]
    ahead = last * (reference[:, n2] + reference[:, 1:n2] @ surface[:-1])
    friction = np.tanh(law.scalars[2] * speed)
    return np.column_stack(
        (reference[:, :n2] @ surface, ahead, reference[:, n2 + 2], speed, friction, loop.target)
    )


def _scores(loop: Loop, z: Array, twist_limit: float | Array) -> tuple[Array, Array]:
    """Scores of integrated groups, and which of them failed; ``twist_limit`` [rad]."""
    scores = np.zeros((z.shape[1], len(SUMMARY)))
    scores[:, :6] = z[row.SCORE : row.SCORE + 6].T
    scores[:, SUMMARY.index("twist")] = z[row.TWIST]
    scores[:, SUMMARY.index("own_peak")] = z[row.SCORE]
    diverged = ~np.isfinite(z[:STATES]).all(axis=0) | (z[row.SCORE] > farthest(loop.target))
    return scores, diverged | (z[row.TWIST] > twist_limit)
