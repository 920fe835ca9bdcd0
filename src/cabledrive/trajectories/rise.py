r"""The polynomial that rises from 0 to 1 with as many derivatives at rest at both ends as its order allows.

Of odd order :math:`2n + 1`, with n derivatives zero at both ends, it is the one whose slope is
:math:`s'(\xi) = C\,\xi^n(1 - \xi)^n`; order 9 is that of Eqs. (6.1)-(6.7).
"""

from functools import cache
from math import comb, factorial

import numpy as np

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

HIGHEST_ORDER = 21


def check_order(order: int) -> int:
    """Number n of derivatives that rest at both ends; an even order, below 3 or above 21, is refused."""
    if order % 2 == 0 or not 3 <= order <= HIGHEST_ORDER:
        raise InputRefused(
            f"order = {order} of the rise must be odd, from 3 to {HIGHEST_ORDER}: 9 is that of (6.1)"
        )
    return (order - 1) // 2


@cache
def rise_coefficients(order: int) -> tuple[float, ...]:
    r"""Coefficients of the rise in powers of :math:`\xi = t/t_f`, the solution of Eqs. (6.2)-(6.3).

    .. math:: a_{n+1+k} = \frac{(2n+1)!}{(n!)^2}\,\frac{(-1)^k}{n+1+k}\binom{n}{k}, \qquad k = 0, \dots, n

    Parameters
    ----------
    order : int
        Odd order 2 n + 1.

    Returns
    -------
    tuple of float, length order + 1
        From the constant upwards; exact, for they are whole numbers.
    """
    n = check_order(order)
    scale = factorial(2 * n + 1) // factorial(n) ** 2
    tail = [scale * (-1) ** k * comb(n, k) // (n + 1 + k) for k in range(n + 1)]
    return (0.0,) * (n + 1) + tuple(map(float, tail))


def smooth_rise(xi: Array, order: int = 9, derivatives: int = 0) -> Array:
    r"""Rise from 0 to 1 and its derivatives, Eqs. (6.1)-(6.7).

    Beyond the ends it rests. The upper half is taken by the symmetry :math:`s(\xi) = 1 - s(1 - \xi)`, so that
    no digits are lost near the end.

    Parameters
    ----------
    xi : ndarray, shape (p,)
        Time over rise time, :math:`\xi = t/t_f`.
    order : int, default 9
        Odd order of the polynomial.
    derivatives : int, default 0
        Highest derivative wanted, with respect to xi.

    Returns
    -------
    ndarray, shape (derivatives + 1, p)

    Raises
    ------
    InputRefused
        If the order is even or out of range.
    """
    polynomial = np.polynomial.Polynomial(rise_coefficients(order))
    late = xi > 0.5
    mirrored = np.where(late, 1.0 - xi, xi)
    moving = (xi >= 0.0) & (xi <= 1.0)
    out = np.zeros((derivatives + 1, xi.size))
    for k in range(derivatives + 1):
        value = polynomial.deriv(k)(mirrored) if k else polynomial(mirrored)
        sign = 1.0 if k % 2 else -1.0
        out[k] = np.where(moving, np.where(late, sign * value + (1.0 if k == 0 else 0.0), value), 0.0)
    out[0, xi > 1.0] = 1.0
    return out


@cache
def peak_factor(order: int, derivative: int) -> float:
    r"""Largest value of a derivative of the unit rise, :math:`\max_\xi |s^{(k)}(\xi)|`.

    A move by an angle in a time :math:`t_f` has the peak value angle times this over :math:`t_f^k`.

    Parameters
    ----------
    order : int
        Odd order of the rise.
    derivative : int
        Which derivative, k >= 1.

    Returns
    -------
    float
    """
    polynomial = np.polynomial.Polynomial(rise_coefficients(order)).deriv(derivative)
    roots = polynomial.deriv().roots() if polynomial.degree() > 0 else np.array([])
    inside = roots[(np.abs(roots.imag) < 1e-6) & (roots.real >= 0.0) & (roots.real <= 0.5 + 1e-9)].real
    return float(np.max(np.abs(polynomial(np.concatenate((inside, [0.0, 0.5]))))))


def derivative_jump(order: int) -> float:
    r"""Jump of the first derivative that does not rest at the ends, :math:`s^{(n+1)}(0) = (2n+1)!/n!`.

    The 9th-order rise of (6.1) jumps in its fifth derivative, though Model 4 assumes six bounded ones; order
    11 puts the jump into the sixth, order 13 beyond.

    Parameters
    ----------
    order : int
        Odd order 2 n + 1.

    Returns
    -------
    float
        For a unit rise in unit time; a move has angle times this over t_f^(n + 1).
    """
    n = check_order(order)
    return float(factorial(2 * n + 1) // factorial(n))
