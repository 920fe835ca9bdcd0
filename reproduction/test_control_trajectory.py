"""Errata of Section 6.1: the reference pulse (6.1)-(6.8) and the derivatives it is said to have."""

import math

import pytest
import sympy as sp

t, t_f, theta_f = sp.symbols("t t_f theta_f", positive=True)

# The lists of (6.3b)-(6.3e), which (6.7b)-(6.7e) repeat with b_j: (factor, power of t_f) of a_5 .. a_9.
PRINTED_LISTS = {
    "b": [(5, 4), (6, 5), (7, 6), (8, 7), (9, 8)],
    "c": [(20, 3), (30, 4), (42, 5), (56, 6), (72, 7)],
    "d": [(60, 2), (120, 3), (210, 4), (336, 5), (504, 6)],
    "e": [(120, 1), (360, 2), (840, 3), (1680, 4), (3024, 5)],
}


def derivative_list(order):
    """Factor and power of t_f in the derivative of a_5 t^5 + ... + a_9 t^9."""
    return [(math.perm(j, order), j - order) for j in range(5, 10)]


def conditions_at_zero(orders):
    """Rows of the linear system y^(n)(0) = 0 for the ten coefficients a_0 .. a_9."""
    return sp.Matrix([[sp.factorial(n) if j == n else 0 for j in range(10)] for n in orders])


def rest_to_rest(order):
    """Move from 0 to theta_f whose derivatives 1 .. (order - 1)/2 vanish at both ends, Eq. (6.1)-(6.3)."""
    a = sp.symbols(f"a0:{order + 1}")
    y = sum(a_j * t**j for j, a_j in enumerate(a))
    conditions = [y.subs(t, 0), y.subs(t, t_f) - theta_f]
    for n in range(1, (order + 1) // 2):
        conditions += [sp.diff(y, t, n).subs(t, 0), sp.diff(y, t, n).subs(t, t_f)]
    return y.subs(sp.solve(conditions, a, dict=True)[0])


def end_values(y, n):
    """The n-th derivative just inside the move, at its start and at its end; outside it is zero."""
    derivative = sp.diff(y, t, n)
    return sp.simplify(derivative.subs(t, 0)), sp.simplify(derivative.subs(t, t_f))


def test_lists_of_6_3_are_the_derivatives_of_order_one_to_four():
    """`erratum-6-2-dots`: (6.3e), (6.5e), (6.7e) carry three dots over the list of the fourth derivative."""
    for order, letter in enumerate("bcde", start=1):
        assert PRINTED_LISTS[letter] == derivative_list(order), f"(6.3{letter}) is not derivative {order}"
    assert PRINTED_LISTS["e"] != derivative_list(3)

    assert conditions_at_zero([0, 1, 2, 3, 4]).rank() == 5, "read with 0, 1, 2, 3, 4 dots: a_0 .. a_4 vanish"
    assert conditions_at_zero([0, 1, 3, 3, 3]).rank() == 3, "read as scanned: two coefficients stay free"


def test_ninth_order_pulse_jumps_in_its_fifth_derivative():
    """`erratum-6-1-smoothness`: Model 4 assumes six bounded derivatives; (6.1) has four continuous ones."""
    nine = rest_to_rest(9)
    assert end_values(nine, 4) == (0, 0)
    assert end_values(nine, 5) == (15120 * theta_f / t_f**5, 15120 * theta_f / t_f**5)

    eleven = rest_to_rest(11)
    assert end_values(eleven, 5) == (0, 0)
    start, end = end_values(eleven, 6)  # jumps, but is bounded: all that the assumption asks
    assert (start, end) == (332640 * theta_f / t_f**6, -332640 * theta_f / t_f**6)


def test_fifth_derivative_jump_costs_less_than_a_millinewton_metre():
    """`erratum-6-1-smoothness`: the jump of sigma in (6.60) times the printed K_sigma; 45 deg, 0.5 s."""
    jump = 15120 * math.radians(45) / 0.5**5
    assert jump == pytest.approx(3.80e5, rel=1e-3), f"observed {jump:.4g} rad/s^5"

    beta = 2 * 850 * 0.04**2 / 0.00235
    k_sigma = 2 * math.pi * 25 * 0.0011 * 0.000642 / (beta * 135)
    assert k_sigma * jump == pytest.approx(2.7e-4, rel=0.01), f"observed {k_sigma * jump:.3e} N m"


def test_reverse_move_is_the_forward_move_turned_over():
    """`confirmed-6-4-6-7`: (6.4)-(6.7) have the solution b_j = -a_j, j = 5 .. 9."""
    reverse = theta_f - rest_to_rest(9)
    assert reverse.subs(t, 0) == theta_f
    assert sp.simplify(reverse.subs(t, t_f)) == 0
    for n in range(1, 5):
        assert end_values(reverse, n) == (0, 0)
