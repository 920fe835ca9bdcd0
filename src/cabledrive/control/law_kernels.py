"""Compiled steps of the control laws.

Every law takes its numbers, what the controller keeps, and row k of its reference. It returns the command
[N m] and its sliding variable or first error, and changes its memory and regressor. The last command, which
laws with a memory take, is ``c.held[1]``.
"""

from math import isfinite, tanh

from cabledrive.control import numbers
from cabledrive.control.backstepping_recursion import backstepping_steps, parts_of, signal_count
from cabledrive.control.load_schedule import scheduled_command
from cabledrive.control.numbers import ControllerState, LawNumbers
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.parameters.arrays import Array

_steps = njit_in_place(backstepping_steps)
_parts = njit_in_place(parts_of)
_signals = njit_in_place(signal_count)


@njit_in_place
def backstepping_command(
    law: LawNumbers, c: ControllerState, reference: Array, k: int
) -> tuple[float, float]:
    """Command and first error; writes the adaptation function tau, Eq. (6.95), as the regressor."""
    # A length that is a constant lets the compiler unroll every loop: twice as fast.
    if c.states.size == 4:
        return _command(2, law, c, reference, k)
    if c.states.size == 6:
        return _command(3, law, c, reference, k)
    return _command(c.states.size // 2, law, c, reference, k)


@njit_in_place
def _command(n: int, law: LawNumbers, c: ControllerState, reference: Array, k: int) -> tuple[float, float]:
    r"""The command for n inertias; tau by the weight of each even state, which is shorter than by each error:

    .. math::
        \tau = \sum_i\varphi_iz_i
             = \sum_jR_j\Big(z_{2j} - \sum_{i>2j}\frac{\partial\alpha_{i-1}}{\partial x_{2j}}z_i\Big)
    """
    states, scales, tau = c.states, law.rows[0], c.regressor
    last, known, speed = 2 * n, law.scalars[numbers.BY_REFERENCE] > 0.0, states[n]
    rows, rates, regressors, x, z = _parts(c.table, n)
    x[0], x[1] = states[n - 1], states[last - 1]
    for j in range(1, n):
        x[2 * j] = scales[j - 1] * (states[n - 1 - j] - states[n - j])
        x[2 * j + 1] = scales[j - 1] * (states[last - 1 - j] - states[last - j])
    friction = tanh(law.scalars[numbers.SLOPE] * (reference[k, _signals(n, known)] if known else speed))
    u = _steps(
        n, law.matrix, scales, known, c.parameters, x, reference[k], speed, friction, rows, rates,
        regressors, z,
    )  # fmt: skip
    for m in range(3 * n + 1):
        tau[m] = 0.0
    for j in range(n):
        weight = z[2 * j + 1]
        for i in range(2 * j + 2, last):
            weight -= rows[i, 2 * j + 1] * z[i]
        for m in range(3 * n + 1):
            tau[m] += weight * regressors[j, m]
    if not known:
        tau[0] -= z[1] * z[2]  # alpha_2 for x_3, as Eq. (6.77) mended takes it
    return u, z[0]


KEPT, GATE, RENEWED = 1, 2, 3
"""Places among the scalars of a law that learns from innovations."""


@njit_in_place
def adapt(law: LawNumbers, c: ControllerState, sigma: float) -> None:
    """Estimates one sample on, by projected and limited adaptation, Eq. (6.24)."""
    learning, estimate, interval = law.learning, c.parameters, law.scalars[numbers.INTERVAL]
    for i in range(learning.shape[1]):
        rate = learning[numbers.GAIN, i] * c.regressor[i] * sigma
        rate = min(max(rate, -learning[numbers.LIMIT, i]), learning[numbers.LIMIT, i])
        estimate[i] = min(
            max(estimate[i] + interval * rate, learning[numbers.LOW, i]), learning[numbers.HIGH, i]
        )


@njit_in_place
def darc_command(law: LawNumbers, c: ControllerState, reference: Array, k: int) -> tuple[float, float]:
    """Command and sliding variable, Eqs. (6.20), (6.43), (6.53), (6.63); writes the regressor that adapts."""
    to_flat, rows, learning, scalars = law.matrix, law.rows, law.learning, law.scalars
    estimate, states, regressor = c.parameters, c.states, c.regressor
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
    friction = tanh(scalars[numbers.SLOPE] * (speed_d if scalars[numbers.BY_REFERENCE] > 0.0 else speed))
    u += estimate[2] * friction - estimate[3] - scalars[numbers.K_SIGMA] * sigma
    if scalars[numbers.DESIRED] > 0.0:
        q_d = reference[k, n2 + 2]
        u += learning[0, 0] * (q - q_d) + estimate[0] * q_d
        u += learning[0, 1] * (speed - speed_d) + estimate[1] * speed_d
        q, speed = q_d, speed_d
    else:
        u += estimate[0] * q + estimate[1] * speed
    regressor[0], regressor[1], regressor[2], regressor[3] = -q, -speed, -friction, 1.0
    return u, sigma


@njit_in_place
def learn_from_innovations(law: LawNumbers, c: ControllerState, reference: Array, k: int) -> None:
    """Least squares with directional forgetting on the innovations of the filter, which ``c.work`` holds.

    An innovation that the covariance does not explain is passed over and moves the covariance towards that of
    the beginning: a shock is soon over, another load is learnt anew.
    """
    rows, learning, scalars = law.rows, law.learning, law.scalars
    estimate, innovations, direction = c.parameters, c.work, c.regressor
    p, m, first = learning.shape[1], rows.shape[0] - 1, c.states.size + 1
    kept, gate, renewed, block = scalars[KEPT], scalars[GATE], scalars[RENEWED], first + m
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
                estimate[p + j * p + j] += renewed * learning[numbers.GAIN, j]
            continue
        if spread <= 0.0:
            continue
        for j in range(p):
            value = estimate[j] + direction[j] * error / (1.0 + spread)
            estimate[j] = min(max(value, learning[numbers.LOW, j]), learning[numbers.HIGH, j])
        # Only the direction that was excited is forgotten, and never below its information: no wind-up.
        shrink = max(kept * spread - (1.0 - kept), 0.0) / (spread * kept * (1.0 + spread))
        for j in range(p):
            for other in range(p):
                estimate[p + j * p + other] -= shrink * direction[j] * direction[other]


@njit_in_place
def feedback_command(law: LawNumbers, c: ControllerState, reference: Array, k: int) -> tuple[float, float]:
    """Feedback on the errors about a reference with the estimated torque of the load: command, load's error.

    Row k: wanted states, torque, then as `load_columns` has it. Without parameters the second number is 0.
    """
    matrix, rows, estimate = law.matrix, law.rows, c.parameters
    memory, states, fresh = c.memory, c.states, c.work
    p, n2, m = law.learning.shape[1], states.size, memory.size
    first = n2 + 1
    block = first + rows.shape[0] - 1
    u = reference[k, n2]
    for j in range(p):
        u += estimate[j] * reference[k, first + j * block + n2]
    for i in range(m):
        u += rows[0, i] * memory[i]
        fresh[i] = matrix[i, m + n2] * c.held[1]
        for j in range(m):
            fresh[i] += matrix[i, j] * memory[j]
    load = 0.0
    for i in range(n2):
        e = states[i] - reference[k, i]
        for j in range(p):
            e -= estimate[j] * reference[k, first + j * block + i]
        u += rows[0, m + i] * e
        for j in range(m):
            fresh[j] += matrix[j, m + i] * e
        if p > 0 and i == n2 // 2 - 1:
            load = e
    for i in range(m):
        memory[i] = fresh[i]
    return u, load


@njit_in_place
def reference_model_command(
    law: LawNumbers, c: ControllerState, reference: Array, k: int
) -> tuple[float, float]:
    """Command, and the feedback that drives its adaptation, by functions at the end of the row."""
    states, n2 = c.states, c.states.size
    feedback, carried = 0.0, 0.0
    for j in range(n2):
        feedback += law.rows[0, j] * (states[j] - reference[k, j])
    for i in range(reference.shape[1] - n2 - 1):
        c.regressor[i] = reference[k, n2 + 1 + i]
        carried += c.parameters[i] * c.regressor[i]
    return reference[k, n2] + feedback + carried, feedback


@njit_in_place
def law_step(law: LawNumbers, c: ControllerState, reference: Array, k: int) -> tuple[float, float, bool]:
    """One sample of any law: command [N m], sliding variable or first error, and whether it could."""
    last = c.held[1]
    for j in range(c.states.size):
        if not isfinite(c.states[j]):
            return last, 0.0, False
    if law.kind == numbers.OWN:  # the user's own, which only the loops made for it can step
        return last, 0.0, False
    if law.kind == numbers.DARC:
        u, sigma = darc_command(law, c, reference, k)
        drive = sigma
    elif law.kind == numbers.LINEAR or law.kind == numbers.LEARNING:
        if law.kind == numbers.LEARNING:
            learn_from_innovations(law, c, reference, k)
        u, sigma = feedback_command(law, c, reference, k)
        drive = 0.0
    elif law.kind == numbers.SCHEDULED:
        u, sigma = scheduled_command(law, c, reference, k)
        drive = 0.0
    elif law.kind == numbers.REFERENCE_MODEL:
        u, sigma = reference_model_command(law, c, reference, k)
        drive = sigma
    else:
        u, sigma = backstepping_command(law, c, reference, k)
        drive = 1.0
    if not isfinite(u):
        return last, sigma, False
    if law.kind != numbers.LINEAR and law.kind != numbers.LEARNING and law.kind != numbers.SCHEDULED:
        adapt(law, c, drive)
    return u, sigma, True
