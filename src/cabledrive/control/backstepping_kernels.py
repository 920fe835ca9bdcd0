"""The compiled step of the backstepping law on a chain of any length."""

from math import tanh

from cabledrive.control.backstepping_recursion import backstepping_steps, parts_of, signal_count
from cabledrive.control.controller_state import ControllerState
from cabledrive.control.numbers import BY_REFERENCE, SLOPE, LawNumbers
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
    last, known, speed = 2 * n, law.scalars[BY_REFERENCE] > 0.0, states[n]
    rows, rates, regressors, x, z = _parts(c.table, n)
    x[0], x[1] = states[n - 1], states[last - 1]
    for j in range(1, n):
        x[2 * j] = scales[j - 1] * (states[n - 1 - j] - states[n - j])
        x[2 * j + 1] = scales[j - 1] * (states[last - 1 - j] - states[last - j])
    friction = tanh(law.scalars[SLOPE] * (reference[k, _signals(n, known)] if known else speed))
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
