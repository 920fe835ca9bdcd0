"""Compiled steps of the control laws; `cabledrive.control.darc` and its neighbours hold the readable ones."""

from math import isfinite, tanh

from cabledrive.control.backstepping_recursion import backstepping_command
from cabledrive.control.numbers import Array
from cabledrive.mechanics.compiled import njit_in_place


@njit_in_place
def adapt(learning: Array, interval: float, estimate: Array, regressor: Array, sigma: float) -> None:
    """Estimates one sample on, by projected and limited adaptation; ``estimate`` is changed."""
    for i in range(learning.shape[1]):
        rate = learning[3, i] * regressor[i] * sigma
        rate = min(max(rate, -learning[4, i]), learning[4, i])
        estimate[i] = min(max(estimate[i] + interval * rate, learning[1, i]), learning[2, i])


@njit_in_place
def darc_command(
    to_flat: Array,
    rows: Array,
    learning: Array,
    scalars: Array,
    estimate: Array,
    states: Array,
    reference: Array,
    k: int,
    regressor: Array,
) -> tuple[float, float]:
    """Command and sliding variable of the law of the chain at row k; writes the regressor that adapts."""
    n2 = to_flat.shape[0]
    sigma, z_eq, u, q = 0.0, reference[k, n2], 0.0, 0.0
    for i in range(n2):
        z = 0.0
        for j in range(n2):
            z += to_flat[i, j] * states[j]
        e = z - reference[k, i]
        sigma += rows[0, i] * e
        if i > 0:
            z_eq -= rows[0, i - 1] * e
        u += rows[1, i] * z
        q += rows[2, i] * z
    q += rows[2, n2] * z_eq
    speed, speed_d = states[n2 // 2], reference[k, n2 + 1]
    friction = tanh(scalars[2] * (speed_d if scalars[3] > 0.0 else speed))
    u += estimate[2] * friction - estimate[3] - scalars[1] * sigma
    if scalars[4] > 0.0:
        q_d = reference[k, n2 + 2]
        u += learning[0, 0] * (q - q_d) + estimate[0] * q_d
        u += learning[0, 1] * (speed - speed_d) + estimate[1] * speed_d
        q, speed = q_d, speed_d
    else:
        u += estimate[0] * q + estimate[1] * speed
    regressor[0], regressor[1], regressor[2], regressor[3] = -q, -speed, -friction, 1.0
    return u, sigma


@njit_in_place
def linear_command(
    matrix: Array,
    row: Array,
    memory: Array,
    states: Array,
    reference: Array,
    k: int,
    last: float,
    fresh: Array,
) -> float:
    """Feedback of a linear law on the errors of angles and speeds, added to the reference's own torque."""
    m, n2 = memory.size, states.size
    u = reference[k, n2]
    for i in range(m):
        u += row[0, i] * memory[i]
    for j in range(n2):
        u += row[0, m + j] * (states[j] - reference[k, j])
    for i in range(m):
        value = matrix[i, m + n2] * last
        for j in range(m):
            value += matrix[i, j] * memory[j]
        for j in range(n2):
            value += matrix[i, m + j] * (states[j] - reference[k, j])
        fresh[i] = value
    for i in range(m):
        memory[i] = fresh[i]
    return u


@njit_in_place
def learn_from_innovations(
    rows: Array,
    learning: Array,
    scalars: Array,
    estimate: Array,
    innovations: Array,
    reference: Array,
    k: int,
    first: int,
    direction: Array,
) -> None:
    """Least squares with directional forgetting on the innovations of the filter; ``estimate`` is changed.

    ``estimate`` holds p parameters, then their covariance by rows; ``first``: states and 1, where the blocks
    of the reference begin. An innovation that the covariance does not explain is passed over and moves the
    covariance towards that of the beginning: a shock is soon over, another load is learnt anew.
    """
    p, m = learning.shape[1], rows.shape[0] - 1
    kept, gate, renewed, block = scalars[1], scalars[2], scalars[3], first + m
    for i in range(m):
        error, spread = 0.0, 0.0
        for j in range(m):
            error += rows[1 + i, j] * innovations[j]
        for j in range(p):
            slope = reference[k, first + j * block + first + i]
            error -= slope * estimate[j]
            direction[j] = 0.0
            for other in range(p):
                cross = reference[k, first + other * block + first + i]
                direction[j] += estimate[p + j * p + other] * cross
            spread += slope * direction[j]
        if error * error > gate * gate * (1.0 + spread):
            for j in range(p):
                for other in range(p):
                    estimate[p + j * p + other] *= 1.0 - renewed
                estimate[p + j * p + j] += renewed * learning[3, j]
            continue
        if spread <= 0.0:
            continue
        for j in range(p):
            value = estimate[j] + direction[j] * error / (1.0 + spread)
            estimate[j] = min(max(value, learning[1, j]), learning[2, j])
        # Only the direction that was excited is forgotten, and never below its information: no wind-up.
        shrink = max(kept * spread - (1.0 - kept), 0.0) / (spread * kept * (1.0 + spread))
        for j in range(p):
            for other in range(p):
                estimate[p + j * p + other] -= shrink * direction[j] * direction[other]


@njit_in_place
def learning_command(
    matrix: Array,
    rows: Array,
    learning: Array,
    scalars: Array,
    estimate: Array,
    memory: Array,
    states: Array,
    reference: Array,
    k: int,
    last: float,
    regressor: Array,
    work: Array,
) -> tuple[float, float]:
    """Feedback about a reference that carries the estimated torque of the load: command, error of the load.

    ``work`` comes with the innovations of the filter. Row k of the reference: wanted states, torque, then for
    each parameter the states that go with a unit of it less what the filter misses of them, its torque, and
    the innovations that it makes.
    """
    p, n2, m = learning.shape[1], states.size, memory.size
    first = n2 + 1
    block = first + rows.shape[0] - 1
    learn_from_innovations(rows, learning, scalars, estimate, work, reference, k, first, regressor)
    u = reference[k, n2]
    for j in range(p):
        u += estimate[j] * reference[k, first + j * block + n2]
    for i in range(m):
        u += rows[0, i] * memory[i]
        work[i] = matrix[i, m + n2] * last
        for j in range(m):
            work[i] += matrix[i, j] * memory[j]
    load = 0.0
    for i in range(n2):
        e = states[i] - reference[k, i]
        for j in range(p):
            e -= estimate[j] * reference[k, first + j * block + i]
        u += rows[0, m + i] * e
        for j in range(m):
            work[j] += matrix[j, m + i] * e
        if i == n2 // 2 - 1:
            load = e
    for i in range(m):
        memory[i] = work[i]
    return u, load


@njit_in_place
def reference_model_command(
    row: Array, estimate: Array, states: Array, reference: Array, k: int, regressor: Array
) -> tuple[float, float]:
    """Command, and the feedback that drives its adaptation.

    Row k of the reference: wanted states, torque, then the functions that carry the estimates.
    """
    n2 = states.size
    feedback, carried = 0.0, 0.0
    for j in range(n2):
        feedback += row[0, j] * (states[j] - reference[k, j])
    for i in range(reference.shape[1] - n2 - 1):
        regressor[i] = reference[k, n2 + 1 + i]
        carried += estimate[i] * regressor[i]
    return reference[k, n2] + feedback + carried, feedback


@njit_in_place
def law_step(
    kind: int,
    matrix: Array,
    rows: Array,
    learning: Array,
    scalars: Array,
    estimate: Array,
    memory: Array,
    states: Array,
    reference: Array,
    k: int,
    last: float,
    regressor: Array,
    work: Array,
    table: Array,
) -> tuple[float, float, bool]:
    """One sample of any law: command [N m], its sliding variable or first error, and whether it could.

    Where a state is not a number the last command is kept and nothing is learnt.
    """
    for j in range(states.size):
        if not isfinite(states[j]):
            return last, 0.0, False
    sigma = 0.0
    if kind == 3:  # the user's own, which only the loops made for it can step
        return last, sigma, False
    if kind == 0:
        u, sigma = darc_command(matrix, rows, learning, scalars, estimate, states, reference, k, regressor)
        if isfinite(u):
            adapt(learning, scalars[0], estimate, regressor, sigma)
    elif kind == 1:
        u = linear_command(matrix, rows, memory, states, reference, k, last, work)
    elif kind == 4:
        u, sigma = learning_command(
            matrix, rows, learning, scalars, estimate, memory, states, reference, k, last, regressor, work
        )
    elif kind == 5:
        u, sigma = reference_model_command(rows, estimate, states, reference, k, regressor)
        if isfinite(u):
            adapt(learning, scalars[0], estimate, regressor, sigma)
    else:
        u, sigma = backstepping_command(
            matrix, rows, scalars, estimate, states, reference, k, regressor, table
        )
        if isfinite(u):
            adapt(learning, scalars[0], estimate, regressor, 1.0)
    if not isfinite(u):
        return last, sigma, False
    return u, sigma, True
