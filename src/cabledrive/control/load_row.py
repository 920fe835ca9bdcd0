"""The generator of the columns that a law takes which learns the load's torque."""

import numpy as np

from cabledrive.control.innovations_of_load import torque_push
from cabledrive.control.load_row_numbers import LoadRowNumbers
from cabledrive.control.load_torque import TURN, sign_weights
from cabledrive.control.observer_numbers import ObserverNumbers
from cabledrive.control.reference_numbers import lag_coefficients
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain

_Terms = dict[int, Array]
"""Coefficients of rising derivatives, by the stage that they are taken of."""


def load_row_numbers(
    chain: LumpedChain, observer: ObserverNumbers, white: Array, turning: float, interval: float
) -> LoadRowNumbers:
    """Numbers of the generator of `cabledrive.control.load_torque` and the filter's settled error.

    ``white``, (m, m): what makes innovations white; ``turning``: time in which the sign of friction turns
    [s].
    """
    rows = 2 * chain.size - 1
    times, sources, output = carried_terms(chain)
    states = observer.model.shape[0]
    push = torque_push(chain, states, interval)
    asked = np.vstack((output[:-1][observer.chosen], output[-1:]))
    return LoadRowNumbers(
        sign=sign_weights(rows, turning, interval),
        lags=np.array([lag_coefficients(time, interval) for time in times]).reshape(-1, 3),
        sources=np.array(sources, dtype=np.int64),
        output=np.ascontiguousarray(asked),
        transition=np.column_stack((observer.model[:, :states], push)),
        seen=observer.output.copy(),
        gains=observer.gains[-1].copy(),
        chosen=observer.chosen.copy(),
        white=np.ascontiguousarray(white),
        scalars=np.array([interval, TURN]),
    )


def carried_terms(chain: LumpedChain) -> tuple[list[float], list[int], Array]:
    """What `cabledrive.control.load_torque.carried` adds, as filters of the torque and one linear map.

    Returns time constants [s] of the filters; the stage that each takes, 0 being the torque; the map, shape
    (2n + 1, stages * (2n - 1)): angles, speeds, motor torque.
    """
    n, rows = chain.size, 2 * chain.size - 1
    times: list[float] = []
    sources: list[int] = []
    link: _Terms = {0: np.eye(rows)[0]}
    angle: _Terms = {}
    states: list[_Terms] = [{} for _ in range(2 * n)]
    for i in range(n - 2, -1, -1):
        k, b = chain.stiffness[i], chain.damping[i]
        for stage, terms in link.items():
            times.append(b / k)
            sources.append(stage)
            angle = _sum(angle, {len(times): terms / k})
        states[i], states[n + i] = angle, _derived(angle, 1, 1.0)
        inertia, friction = chain.inertias[i], chain.viscous[i]
        link = _sum(_sum(link, _derived(angle, 2, inertia)), _derived(angle, 1, friction))
    found = np.zeros((2 * n + 1, len(times) + 1, rows))
    for column, terms_of in enumerate((*states, link)):
        for stage, terms in terms_of.items():
            found[column, stage] = terms
    return times, sources, found.reshape(2 * n + 1, -1)


def _sum(one: _Terms, other: _Terms) -> _Terms:
    zero = np.zeros_like(next(iter((one or other).values())))
    return {stage: one.get(stage, zero) + other.get(stage, zero) for stage in sorted({*one, *other})}


def _derived(terms: _Terms, order: int, factor: float) -> _Terms:
    """A factor times a derivative."""
    shifted = {}
    for stage, row in terms.items():
        shifted[stage] = np.concatenate((np.zeros(order), factor * row[:-order]))
    return shifted
