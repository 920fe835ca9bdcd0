"""Section 2.6 of the dissertation: the difference scheme (2.31)-(2.39), its spacing, ends and order."""

from math import pi

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

EA, DENSITY, LENGTH, RADIUS = 2.6e9 * 4.26e-7, 4.9e-4, 1.0, 0.03  # Table 3.1; density per unstretched metre
STRETCH = 1 + 5.0 / EA
LE, RHO, MODULUS = LENGTH * STRETCH, DENSITY / STRETCH, EA * STRETCH
INERTIA = {"configuration 1": (7.316e-6, 7.316e-6), "configuration 2": (0.0011, 7.316e-6)}
FIRST_CELL = {1: 1.0, 0: -1.0}  # (u_2 - u_1)/dx, of first order at the rim
ONE_SIDED = {1: 2.0, 0: -1.5, 2: -0.5}  # (-3 u_1 + 4 u_2 - u_3)/(2 dx), of second order at the rim


def exact_frequency(inertias):
    """Lowest out-of-phase root of (3.13) [Hz]."""
    chi1, chi2 = (J / (2 * RHO * RADIUS**2 * LE) for J in inertias)
    x = brentq(
        lambda x: (chi1 * chi2 * x**2 - 1) * np.sin(x) - (chi1 + chi2) * x * np.cos(x), 1e-6, pi - 1e-6
    )
    return x * np.sqrt(MODULUS / RHO) / LE / (2 * pi)


def semidiscrete_frequency(inertias, n, rim_slope, half_cells):
    """Lowest frequency [Hz] of n segments per span, nodes 0 and n at the rims, the loop closed."""
    dx = LE / n
    operator = np.zeros((2 * n, 2 * n))
    for i in set(range(2 * n)) - {0, n}:
        for j, weight in ((i - 1, 1.0), (i, -2.0), (i + 1, 1.0)):
            operator[i, j % (2 * n)] += MODULUS / RHO / dx**2 * weight
    for i, inertia in zip((0, n), inertias, strict=True):
        mass = inertia / RADIUS**2 + (RHO * dx if half_cells else 0.0)
        for side in (1, -1):
            for step, weight in rim_slope.items():
                operator[i, (i + side * step) % (2 * n)] += MODULUS / dx * weight / mass
    return np.sqrt(np.sort(-np.linalg.eigvals(operator).real)[1]) / (2 * pi)


def observed_order(inertias, rim_slope, half_cells):
    exact, n = exact_frequency(inertias), np.array([20, 40, 80])
    error = np.abs([semidiscrete_frequency(inertias, k, rim_slope, half_cells) - exact for k in n])
    return -np.polyfit(np.log(n), np.log(error), 1)[0], error


@pytest.mark.parametrize("inertias", INERTIA.values(), ids=INERTIA.keys())
def test_pulley_alone_at_the_rim_node_converges_with_order_one(inertias):
    """`erratum-2-37-half-cells`: with the first cell's tension, (2.37) leaves out the half cells: order 1."""
    order, error = observed_order(inertias, FIRST_CELL, half_cells=False)
    assert order == pytest.approx(1.0, abs=0.05), f"observed order {order:.3f}, errors {error} Hz"


@pytest.mark.parametrize("inertias", INERTIA.values(), ids=INERTIA.keys())
def test_half_cells_of_cable_at_the_rim_node_restore_order_two(inertias):
    """`erratum-2-37-half-cells`: J + rho dx r^2, half a cell of each span, makes the scheme of order 2."""
    order, error = observed_order(inertias, FIRST_CELL, half_cells=True)
    assert order == pytest.approx(2.0, abs=0.05), f"observed order {order:.3f}, errors {error} Hz"


@pytest.mark.parametrize("inertias", INERTIA.values(), ids=INERTIA.keys())
def test_second_order_slope_at_the_rim_restores_order_two_without_half_cells(inertias):
    """`erratum-2-33-boundary-slope`: a second-order slope in (2.38) serves as well as half cells."""
    order, error = observed_order(inertias, ONE_SIDED, half_cells=False)
    assert order == pytest.approx(2.0, abs=0.05), f"observed order {order:.3f}, errors {error} Hz"


@pytest.mark.parametrize("inertias", INERTIA.values(), ids=INERTIA.keys())
def test_both_remedies_together_count_the_half_cells_twice(inertias):
    """`erratum-2-33-boundary-slope`: second-order slope and half cells together are of order 1 again."""
    order, error = observed_order(inertias, ONE_SIDED, half_cells=True)
    assert order == pytest.approx(1.0, abs=0.06), f"observed order {order:.3f}, errors {error} Hz"


def test_ghost_value_from_the_wave_equation_is_the_half_cell():
    """`erratum-2-33-boundary-slope`: u_0 eliminated from (2.33a) with (2.32a) gives rho dx/2 a span."""
    u0, u1, u2, dx, rho, modulus, acceleration = sp.symbols("u_0 u_1 u_2 dx rho K a", positive=True)
    wave = sp.Eq(rho * acceleration, modulus * (u2 - 2 * u1 + u0) / dx**2)
    tension = modulus * (u2 - sp.solve(wave, u0)[0]) / (2 * dx)
    assert sp.expand(tension - (modulus * (u2 - u1) / dx - rho * dx / 2 * acceleration)) == 0


def test_second_differences_are_divided_by_the_square_of_the_spacing():
    """`erratum-2-34-second-difference`: over 2 dx, the limit of (2.34) is zero; over dx^2 it is u''."""
    x, dx = sp.symbols("x dx")
    second = sp.exp(x + dx) - 2 * sp.exp(x) + sp.exp(x - dx)
    assert sp.limit(second / (2 * dx), dx, 0) == 0
    assert sp.simplify(sp.limit(second / dx**2, dx, 0) - sp.exp(x)) == 0


def test_printed_spacing_makes_the_span_too_long():
    """`erratum-2-31-spacing`: n segments of Le/(n-1) are too long: frequencies low by (n-1)/n."""
    n, c_u = 40, np.sqrt(MODULUS / RHO)
    k = np.arange(1, n)
    for dx, ratio in ((LE / (n - 1), (n - 1) / n), (LE / n, 1.0)):
        operator = (2 * np.eye(n - 1) - np.eye(n - 1, k=1) - np.eye(n - 1, k=-1)) * (c_u / dx) ** 2
        omega = np.sqrt(np.linalg.eigvalsh(operator))
        discrete = 2 * c_u * n / LE * np.sin(k * pi / (2 * n))  # exact for n segments of Le/n with fixed ends
        np.testing.assert_allclose(omega / discrete, ratio, rtol=1e-10)
        assert n * dx == pytest.approx(LE / ratio, rel=1e-14), f"the nodes reach {n * dx:.5f} m of {LE:.5f} m"


def test_start_of_the_drive_pulley_keeps_its_angle():
    """`erratum-2-39-initial-angle`: (2.39a), second line, lacks theta_1(0): its error stays."""
    t, dt, angle, rate, torque, inertia, friction = sp.symbols(
        "t dt theta_0 omega_0 K_1 J_1 b_1", positive=True
    )
    theta = sp.Function("theta")
    equation = sp.Eq(inertia * theta(t).diff(t, 2), torque - friction * theta(t).diff(t))
    start = {theta(0): angle, theta(t).diff(t).subs(t, 0): rate}
    exact = sp.dsolve(equation, theta(t), ics=start).rhs.subs(t, dt)
    printed = dt * rate + dt**2 / (2 * inertia) * (torque - friction * rate)
    assert sp.simplify(sp.limit(exact - printed, dt, 0) - angle) == 0
    assert sp.simplify(sp.limit((exact - angle - printed) / dt**2, dt, 0)) == 0
