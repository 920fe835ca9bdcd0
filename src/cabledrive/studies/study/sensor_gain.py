r"""What encoders cost: the load's error per error of a reading, as a bound over the whole motion.

In the linear closed loop (filter at its last gains, estimates at rest, no Coulomb friction) an error of the
readings :math:`|\nu_j| \le q_j/2` moves the load by at most :math:`\tfrac{q_j}{2}\sum_k|g_j(k)|` with the
impulse response :math:`g_j`; the unknown phase of an encoder is a step of at most :math:`q_j/2`.
"""

import numpy as np
from scipy.linalg import expm

from cabledrive.control.darc import darc_step
from cabledrive.control.numbers import NOMINAL, LawNumbers
from cabledrive.reduction.lumped_chain import state_space
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_numbers import Array

UNSTABLE = 1e3


def law_rows(law: LawNumbers, states: int) -> Array:
    """Command of a law of the chain per state, estimates at their nominal values, no Coulomb friction.

    ``states``: 2n.
    Returns shape (2n,).
    """
    frozen = law.learning[NOMINAL].copy()
    frozen[2:] = 0.0
    rest = np.zeros(states + 3)
    return np.array([darc_step(law, frozen, unit, rest).command for unit in np.eye(states)])


def closed_loop_matrix(loop: Loop) -> tuple[Array, Array]:
    """One sample of the linear closed loop, from sample to sample.

    ``loop``: with a law of the chain and a Kalman filter.
    Returns ``transition``, shape (m, m): states: plant, shaft torque, filter, its shaft torque, commands on
    their way; ``readings``, shape (m, encoders): what an error of each reading adds.
    """
    n, q, late = 2 * loop.chain.size, loop.observer.model.shape[0], loop.rig.late_samples
    size = n + 1 + q + 1 + late + 2
    count = len(loop.rig.encoders)
    every = _sample(loop, np.eye(size, size + count), np.eye(size + count)[size:])
    return every[:, :size], every[:, size:]


def _sample(loop: Loop, states: Array, errors: Array) -> Array:
    """Next states of many loops at once, one per column."""
    n, q = 2 * loop.chain.size, loop.observer.model.shape[0]
    plant, observed = states[: n + 1], states[n + 1 : n + 1 + q]
    held, commands = states[n + 1 + q], states[n + 2 + q :]
    observer, scalars = loop.observer, loop.observer.scalars
    innovation = plant[loop.rig.encoders] + errors - observer.output @ observed
    observed = observed + observer.gains[-1] @ innovation
    command = law_rows(loop.controller.law, len(observer.chosen)) @ observed[observer.chosen]
    commands = np.vstack((commands[1:], command))
    known = observer.model[:, :q] @ observed
    inputs = np.vstack((held, commands[0], commands[1]))
    known = known + observer.model[:, q : q + 3] @ inputs
    carried = scalars[2] * held + scalars[3] * commands[0] + scalars[4] * commands[1]
    early, rest = _transitions(loop)
    plant = early @ np.vstack((plant, commands[0]))
    plant = rest @ np.vstack((plant, commands[1]))
    return np.vstack((plant, known, carried, commands))


def _transitions(loop: Loop) -> tuple[Array, Array]:
    """Plant and torque loop over the delay and over the rest of a sample; last column: the command."""
    n = 2 * loop.chain.size
    a, b = state_space(loop.chain)
    rate = loop.plant.current_rate
    whole = np.zeros((n + 2, n + 2))
    whole[:n, :n] = a
    if rate > 0.0:
        whole[:n, n] = b[:, 0]
        whole[n, n], whole[n, n + 1] = -rate, rate
    else:
        whole[:n, n + 1] = b[:, 0]
    late = loop.rig.late_part
    return expm(whole * late)[: n + 1], expm(whole * (loop.rig.interval - late))[: n + 1]


def sensor_bound(loop: Loop) -> float | None:
    """Largest error of the load that counting and unknown phases of the encoders can make.

    Returns [rad] at the load; None if the linear loop is unstable.
    """
    transition, readings = closed_loop_matrix(loop)
    if np.abs(np.linalg.eigvals(transition)).max() > 1.0 + 1e-6:
        return None
    load, samples = loop.chain.size - 1, len(loop.target)
    state, total = readings.copy(), np.zeros(readings.shape[1])
    step, highest = np.zeros(readings.shape[1]), np.zeros(readings.shape[1])
    for _ in range(samples):
        response = state[load]
        total += np.abs(response)
        step += response
        highest = np.maximum(highest, np.abs(step))
        state = transition @ state
    bound = float(0.5 * loop.rig.counts @ (total + highest) / loop.gear)
    return bound if bound < UNSTABLE else None
