r"""H-infinity feedback of all states: the least worst-case gain from torques at motor and load to the error.

Of :math:`\dot x = Ax + B_1w + B_2u` with the cost :math:`|Qx|^2 + |ru|^2 - \gamma^2|w|^2` the feedback is
:math:`u = -r^{-2}B_2^TXx`, X the stabilizing solution of a Riccati equation whose quadratic term is
indefinite.
J. C. Doyle, K. Glover, P. P. Khargonekar, B. A. Francis, IEEE Trans. Automatic Control 34, 831-847, 1989.
"""

from math import sqrt

import numpy as np
from scipy.linalg import solve_continuous_are

from cabledrive.control.linear_laws import integral_memory, linear_law
from cabledrive.control.numbers import LawNumbers
from cabledrive.parameters import NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain, state_space

MARGIN = 1.05
"""Over the least gain that has a solution, where the feedback would grow without bound."""
STEPS = 40
ROUND_OFF = 1e-7
"""Residual of a Riccati equation over its largest term, above which its solution is none."""


def hinf_law(
    chain: LumpedChain,
    error: float,
    torque: float,
    disturbance: float,
    integral_time: float,
    interval: float,
) -> LawNumbers:
    """H-infinity feedback of angles, speeds and the integral of the load's error.

    ``error`` [rad] of the load weighs as much as ``torque`` [N m]; ``disturbance``: torque at motor and load
    of weight 1 [N m]; ``integral_time`` [s]. `NotComputed` if no gain has a solution.
    """
    system, by_torque, by_disturbance, weight = problem(chain, error, disturbance, integral_time)
    gain, _ = hinf_gain(system, by_disturbance, by_torque, weight, 1.0 / torque**2)
    return linear_law(integral_memory(chain.size, interval), -gain, interval)


def problem(
    chain: LumpedChain, error: float, disturbance: float, integral_time: float
) -> tuple[Array, Array, Array, Array]:
    """Matrix, inputs of torque and of disturbances of motor and load, and weight, with 2n + 1 states.

    The first of them is the integral of the load's angle.
    """
    n = chain.size
    a, b = state_space(chain)
    system = np.zeros((2 * n + 1, 2 * n + 1))
    system[1:, 1:], system[0, n] = a, 1.0
    by_torque = np.vstack(([[0.0]], b[:, :1]))
    by_disturbance = disturbance * np.vstack((np.zeros((1, 2)), b[:, [0, -1]]))
    weight = np.zeros_like(system)
    weight[n, n], weight[0, 0] = 1.0 / error**2, 1.0 / (error * integral_time) ** 2
    return system, by_torque, by_disturbance, weight


def hinf_gain(
    a: Array, by_disturbance: Array, by_torque: Array, weight: Array, cost: float
) -> tuple[Array, float]:
    """Feedback u = -gain x near the least worst-case gain, found by bisection, and the gain that it keeps.

    `NotComputed` if no gain has a solution.
    """
    scaled, back = _scaled(a, by_disturbance, by_torque, weight, cost)
    low, high = 0.0, 1.0
    while _solution(*scaled, high) is None:
        low, high = high, 4.0 * high
        if high > 1e12:
            raise NotComputed("the H-infinity problem has no solution: the motor does not move every state")
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        solved = _solution(*scaled, middle) is not None
        low, high = (low, middle) if solved else (middle, high)
    gamma, found = high, None
    while found is None and gamma < 2.0 * high:  # near the least one round-off may refuse it
        gamma *= MARGIN
        found = _solution(*scaled, gamma)
    if found is None:
        raise NotComputed(f"the H-infinity problem has no solution at a gain of {gamma:.4g}")
    gain = scaled[2].T @ found @ back / sqrt(cost)
    if np.linalg.eigvals(a - by_torque @ gain).real.max() >= 0.0:
        raise NotComputed("round-off leaves the H-infinity feedback without a stable loop")
    return gain, gamma


def _scaled(
    a: Array, by_disturbance: Array, by_torque: Array, weight: Array, cost: float
) -> tuple[tuple[Array, Array, Array, Array, float], Array]:
    """The same problem in units in which each state alone costs 1 without disturbance; units by old states.

    Angles, speeds and an integral differ by orders of magnitude: in them round-off hides that a solution
    exists, and gives some that are none. The cost of a torque is 1 after it.
    """
    unit = np.ones(a.shape[0])
    torque = by_torque / sqrt(cost)
    for _ in range(2):  # the first in units that are bad themselves
        scaled = (a * np.outer(unit, 1 / unit), unit[:, None] * torque, weight / np.outer(unit, unit))
        try:
            free = np.diag(solve_continuous_are(*scaled, np.eye(1)))
        except (np.linalg.LinAlgError, ValueError) as refusal:
            raise NotComputed("the H-infinity problem has no solution without disturbance") from refusal
        unit = unit * np.sqrt(np.where(free > 0.0, free, 1.0))
    change = np.outer(unit, 1 / unit)
    weight = weight / np.outer(unit, unit)
    return (a * change, unit[:, None] * by_disturbance, unit[:, None] * torque, weight, 1.0), np.diag(unit)


def _solution(
    a: Array, by_disturbance: Array, by_torque: Array, weight: Array, cost: float, gamma: float
) -> Array | None:
    """Stabilizing solution X of the Riccati equation, none where it does not exist or is not positive."""
    inputs = np.hstack((by_disturbance, by_torque))
    signed = np.diag([-(gamma**2)] * by_disturbance.shape[1] + [cost])
    try:
        x = np.asarray(solve_continuous_are(a, inputs, weight, signed), dtype=np.float64)
    except (np.linalg.LinAlgError, ValueError):
        return None
    pull = np.linalg.solve(signed, inputs.T @ x)
    terms = (a.T @ x, x @ a, -x @ inputs @ pull, weight)
    if np.abs(sum(terms)).max() > ROUND_OFF * max(np.abs(term).max() for term in terms):
        return None
    closed = a - inputs @ pull
    stable = float(np.linalg.eigvals(closed).real.max()) < 0.0
    positive = float(np.linalg.eigvalsh(x).min()) > -1e-9 * float(np.abs(x).max())
    return x if stable and positive else None
