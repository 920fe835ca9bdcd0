r"""Backstepping on a chain of inertias of any length: one recursion over its steps.

A chain of n inertias, counted here from the load, has 2n states, scaled so that each is the rate of the one
before it and every virtual control has gain one:

.. math::
    x_1 = q_1, \quad x_{2j+1} = S_j(q_{j+1} - q_j), \quad x_{2j+2} = \dot x_{2j+1}, \qquad
    S_j = S_{j-1}\frac{k_j}{J_j}, \quad S_0 = 1

Estimated rates are linear in the states, in the signals of time (the reference, known accelerations of the
inertias and all their derivatives) and in 1. Every virtual control is therefore a row of slopes over these,
and each step makes the next row from the one before it.
"""

from typing import Any

from cabledrive.mechanics.compiled import for_kernels
from cabledrive.parameters.arrays import Array

RATES = 4


def gain_names(feedback: Array, scales: Array) -> dict[str, float]:
    """Gains by name, k with the step and the error of each, and the scales."""
    last = len(feedback)  # two in a step, three in the last
    pairs = [(i, j) for i in range(1, last + 1) for j in (i - 1, i) if j >= 1]
    pairs.insert(-2, (last, last - 2))
    named = {f"k{i}{j}": float(feedback[i - 1, j - 1]) for i, j in pairs}
    return named | {f"s{j}": float(scale) for j, scale in enumerate(scales, 1)}


def signal_count(inertias: int, known: bool) -> int:
    """Signals of time: y_d to derivative 2n; where known, w_j of inertia j to derivative 2(n - j)."""
    return 2 * inertias + 1 + (inertias**2 if known else 0)


def work_shape(inertias: int) -> tuple[int, int]:
    """Shape of the table in which a step works: rows of virtual controls, rates, regressors, x, z."""
    return 4 * inertias + 3, 4 * inertias + 1


def parts_of(table: Any, inertias: int) -> tuple[Any, Any, Any, Any, Any]:
    """Views of a table of `work_shape`: rows, rates, regressors, x and z of `backstepping_steps`."""
    a = 2 * inertias + 1
    b = a + inertias
    c = b + inertias
    return (table[:a], table[a:b], table[b:c], table[c, : 2 * inertias], table[c + 1, : 2 * inertias])


@for_kernels
def backstepping_steps(
    n: int, feedback: Any, scales: Any, known: bool, p: Any, x: Any, signals: Any, speed: Any, friction: Any,
    rows: Any, rates: Any, regressors: Any, z: Any,
) -> Any:  # fmt: skip
    r"""Command by the steps of Eqs. (6.71), (6.76), (6.82), (6.90), mended, for any length and any numbers.

    The rates of the even states are estimated as

    .. math::
        \dot x_2 = \hat p_1x_3 + \hat p_2 + w_1, \qquad
        \dot x_{2j} = \hat p\,x_{2j+1} - \hat p\,x_{2j-1} + \hat p\,x_{2j-3} + w_j, \qquad
        \dot x_{2n} = S_{n-1}\hat p\,u - \dots - \hat p\,\dot\theta_{11} - \hat p\,S_f + \hat p

    and with r the estimated rate of state i without its virtual control, whose gain is g,

    .. math::
        \alpha_i = \frac1g\Big(\dot\alpha_{i-1} - r_i - \sum_jk_{ij}z_j\Big), \qquad z_i = x_i - \alpha_{i-1},
        \qquad u = \alpha_{2n} .

    ``feedback``, shape (2n, 2n); ``scales`` S_1 to S_(n-1); ``signals`` as `signal_count` orders them.
    Written: ``rows`` (2n + 1, 4n + 1), of each virtual control, alpha_0 = y_d first, its slopes over the 2n
    states, then what else is in it and the derivatives of that in time; ``rates`` (n, 4), of each even state
    what multiplies the virtual control, the state two before it and four before it, and 1; ``regressors`` R
    (n, p) of the even states; errors ``z`` (2n,).
    """
    last, estimates = 2 * n, 3 * n + 1
    zero = 0.0 * p[0]
    for j in range(n):
        for c in range(RATES):
            rates[j, c] = zero
        for m in range(estimates):
            regressors[j, m] = zero
    at = 0
    for j in range(n):
        virtual = at
        if j == 0:
            rates[0, 3], regressors[0, 1] = p[1], 1.0
            at = 2
        else:
            if j < n - 1:
                at += 1
            rates[j, 1], regressors[j, at] = -p[at], -x[2 * j]
            at += 1
            if j >= 2:
                rates[j, 2], regressors[j, at] = p[at], x[2 * j - 2]
                at += 1
            if j == 1 and n > 2:  # with two inertias p6 holds the load's acceleration as well
                rates[1, 3], regressors[1, 1] = -scales[0] * p[1], -scales[0]
        if j < n - 1:
            rates[j, 0], regressors[j, virtual] = p[virtual], x[2 * j + 2]
    rates[n - 1, 0] = scales[n - 2] * p[at + 3]
    rates[n - 1, 3] += p[at + 2] - p[at] * speed - p[at + 1] * friction
    regressors[n - 1, at], regressors[n - 1, at + 1], regressors[n - 1, at + 2] = -speed, -friction, 1.0

    alpha = signals[0]
    for c in range(last):
        rows[0, c] = zero
    for m in range(last + 1):
        rows[0, last + m] = signals[m]
    for i in range(1, last + 1):
        row, before = rows[i], rows[i - 1]
        z[i - 1] = x[i - 1] - alpha
        for c in range(0, last, 2):  # each odd state moves at the next one
            row[c], row[c + 1] = zero, before[c]
        for c in range(last, 2 * last):
            row[c] = before[c + 1]
        row[2 * last] = zero
        start = last + 1  # of w_j among the signals
        for j in range(i // 2):  # even states move at their rates; what is known of the own one is taken off
            own = 2 * j + 2 == i
            share = zero - 1.0 if own else before[2 * j + 1]
            if not own:
                row[2 * j + 2] += share * rates[j, 0]
            if j >= 1:
                row[2 * j] += share * rates[j, 1]
            if j >= 2:
                row[2 * j - 2] += share * rates[j, 2]
            row[last] += share * rates[j, 3]
            if known:
                for m in range(last - i + 1):
                    row[last + m] += share * signals[start + m]
                start += 2 * (n - 1 - j) + 1
        for j in range(max(i - 2, 1), i + 1):
            k, earlier = feedback[i - 1, j - 1], rows[j - 1]
            row[j - 1] -= k
            for c in range(2 * last + 1):
                row[c] += k * earlier[c]
        if i % 2 == 0:
            inverse = 1.0 / rates[i // 2 - 1, 0]
            for c in range(2 * last + 1):
                row[c] *= inverse
        alpha = row[last]
        for c in range(last):
            alpha += row[c] * x[c]
    regressors[n - 1, at + 3] = scales[n - 2] * alpha
    return alpha
