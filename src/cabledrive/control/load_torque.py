r"""A torque at the load, carried through the chain to the motor, and learning it between repetitions.

A torque f against the last inertia asks for a twist of the last link, that for a motion of the inertia
before, and so on to the motor. With :math:`\tau_N = f`, :math:`\delta_N = 0`, from the load backwards

.. math:: \delta_i = \delta_{i+1} + \frac{\tau_{i+1}}{k_i D_i}, \qquad
    \tau_i = \tau_{i+1} + J_i\ddot\delta_i + b_i\dot\delta_i, \qquad D_i = 1 + (b_i/k_i)s

:math:`\delta_i` is what each angle, :math:`\tau_1` what the torque of the motor has to add; derivatives of f
up to the 2(N - 1)-th are known along the reference.

Between repetitions, with P from added torque to the load's error in the closed loop, :math:`P = U\Sigma V^T`,
the torque is :math:`w = V_ra` in the first r directions and

.. math:: a_{j+1} = \Pi\big(a_j - g\,\Sigma_r^{-1}U_r^Te_j\big), \qquad e_j = P_{true}V_ra_j + d

with d what repeats and :math:`\Pi` the projection on a ball: a contraction by :math:`\gamma = \lVert I -
g\,\Sigma_r^{-1}U_r^TP_{true}V_r\rVert_2` wherever that is below 1, so that the torque converges to one fixed
point by :math:`\gamma` a repetition (Banach). That lies within the first correction over :math:`1 - \gamma`,
the radius of the ball. r is the most directions with which :math:`\gamma` keeps a limit on every plant that
is looked at, and rounding to counts another.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import toeplitz

from cabledrive.control.numbers import ObserverNumbers
from cabledrive.control.observer_kernels import torque_push
from cabledrive.control.reference import LoadRowNumbers, lag_coefficients, lagged
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain

TURN = 400.0
"""Over the largest speed of the load: K of tanh(K w), before the sign is smoothed."""


def carried(chain: LumpedChain, torque: Array, interval: float) -> tuple[Array, Array]:
    """Angles, then speeds, (samples, 2n), and motor torque [N m] that keep the load still under a torque."""
    times, sources, output = carried_terms(chain)
    stages = [torque]
    for time, source in zip(times, sources, strict=True):
        stages.append(lagged(stages[source], time, interval))
    found = output @ np.concatenate(stages)
    return found[:-1].T, found[-1]


def load_regressors(wanted: Array, turning: float, interval: float) -> Array:
    """Unit Coulomb friction, viscous friction and inertia along a motion, (3, 2n - 1, samples)."""
    rows = len(wanted) - 2
    sign = smoothed_sign(wanted[1], rows, turning, interval)
    return np.array((sign, wanted[1 : rows + 1], wanted[2 : rows + 2]))


def smoothed_sign(speed: Array, rows: int, turning: float, interval: float) -> Array:
    """Sign of a speed, smoothed evenly to both sides, with derivatives that are exact, (rows, samples)."""
    peak = float(np.abs(speed).max())
    if peak == 0.0:
        return np.zeros((rows, len(speed)))
    weights = sign_weights(rows, turning, interval)
    sign = np.pad(np.tanh(TURN * speed / peak), weights.shape[1] // 2, mode="edge")
    return np.array([np.convolve(sign, row[::-1], "valid") for row in weights])


def sign_weights(rows: int, turning: float, interval: float) -> Array:
    """Weights of the samples around, oldest first, in a smoothed sign and its derivatives, (rows, 2h + 1).

    Of averages over boxes, and for each derivative a difference over one box. ``turning``: time from end to
    end of all boxes [s]; an even number of equal boxes shifts by whole samples.
    """
    boxes = rows + 1 + (rows + 1) % 2
    width = max(1, round(turning / (boxes * interval)))
    mean, slope = np.full(width + 1, 1.0 / width), np.zeros(width + 1)
    mean[[0, -1]] = 0.5 / width
    slope[0], slope[-1] = -1.0 / (width * interval), 1.0 / (width * interval)
    found = []
    for row in range(rows):
        weights = np.ones(1)
        for box in range(boxes):
            weights = np.convolve(weights, slope if box < row else mean)
        found.append(weights)
    return np.array(found)


_Terms = dict[int, Array]
"""Coefficients of rising derivatives, by the stage that they are taken of."""


def load_row_numbers(
    chain: LumpedChain, observer: ObserverNumbers, white: Array, turning: float, interval: float
) -> LoadRowNumbers:
    """Numbers of the generator; ``white``, (m, m): of innovations; ``turning``: of friction's sign [s]."""
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


GAIN = 0.7
"""Share of the error that a repetition takes away in the nominal loop."""
MOST_CONTRACTION = 0.8
"""Of the worst plant that is looked at."""
SIGMAS = 5.0
"""Deviations of the command by rounding that keep its limit."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RepetitionLearning:
    """What is learnt between repetitions, in directions of the torque."""

    directions: Array  # (k, r): torque at the nodes of each direction, of length 1
    correction: Array  # (r, k): from mean errors between the nodes [rad] to directions [N m]
    contraction: float  # largest over the plants that were looked at

    def radius(self, error: Array) -> float:
        """Of the ball that holds the fixed point, by the first error, shape (k,) [rad]; [N m]."""
        return float(np.linalg.norm(self.correction @ error)) / (1.0 - self.contraction)

    def corrected(self, place: Array, error: Array, radius: float) -> Array:
        """Directions after a repetition [N m]; ``place``, shape (r,); ``error``, shape (k,) [rad]."""
        found = place - self.correction @ error
        size = float(np.linalg.norm(found))
        return found if size <= radius else found * (radius / size)


def lifted(impulse: Array, nodes: int, width: int) -> Array:
    """Mean errors between nodes from torques there, (nodes, nodes), by the load's impulse response."""
    hat = 1.0 - np.abs(np.arange(1 - width, width)) / width
    smooth = np.convolve(impulse, hat)[: nodes * width]
    smooth = np.pad(smooth, (0, nodes * width - len(smooth)))
    # A node's hat begins a width before it: the first mean holds its rising half alone.
    column = smooth.reshape(nodes, width).mean(axis=1)
    return np.asarray(toeplitz(column, np.zeros(nodes)))


def repetition_learning(
    nominal: Array, others: Sequence[Array], command: Array, noise: float, ripple: float
) -> RepetitionLearning | None:
    """The most directions that keep both limits, contraction on every plant; none: not one direction does.

    ``nominal``, ``others``, ``command``, shape (k, k): from `lifted`, of errors and of the whole command;
    ``noise``: standard deviation of a mean error by rounding [rad]; ``ripple``: most that five deviations of
    the command by it may be [N m].
    """
    u, sizes, v = np.linalg.svd(nominal)
    steps = [GAIN / sizes[:, None] * (u.T @ plant @ v.T) for plant in (nominal, *others)]

    def contraction(r: int) -> float:
        return max(float(np.linalg.norm(np.eye(r) - step[:r, :r], 2)) for step in steps)

    made = np.sum((command @ v.T) ** 2, axis=0) * (GAIN * noise / np.maximum(sizes, 1e-300)) ** 2
    by_rounding = SIGMAS * np.sqrt(np.cumsum(made) / len(sizes))
    low, high = 0, int(np.count_nonzero(by_rounding <= ripple)) + 1
    while high - low > 1:  # the norm of a leading block grows with its size
        middle = (low + high) // 2
        low, high = (middle, high) if contraction(middle) <= MOST_CONTRACTION else (low, middle)
    if low == 0:
        return None
    return RepetitionLearning(
        directions=v[:low].T, correction=GAIN / sizes[:low, None] * u[:, :low].T, contraction=contraction(low)
    )


def torque_along(nodes: Array, width: int, samples: int) -> Array:
    """Torque of every sample, straight lines between nodes [N m], shape (samples,)."""
    places = width * np.arange(len(nodes) + 1.0) - 1.0
    return np.asarray(np.interp(np.arange(samples), places, np.append(0.0, nodes), right=0.0))
