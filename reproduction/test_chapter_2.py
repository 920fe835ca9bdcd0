"""Chapter 2 derived again: the pulleys, and the difference scheme with its ends."""

from math import pi

import numpy as np
import pytest
import sympy as sp

from reproduction.oracles import DRIVES, LOAD, RADIUS, out_of_phase, stretched

U_X, W_X = sp.symbols("u_x w_x")
EA, EPS0 = sp.symbols("EA epsilon_0", positive=True)
PRETENSION, MODULUS = EA * EPS0, EA * (1 + EPS0)  # T = T0 + K lambda, Eq. (2.10)


def test_energy_keeping_pulley_force_is_the_axial_component():
    """`erratum-2-28-axial-component`: with w = 0 at the rim, the force conjugate to u(0) is T_x, not T."""
    strain = sp.sqrt((1 + U_X) ** 2 + W_X**2) - 1
    conjugate = sp.diff(PRETENSION * strain + MODULUS * strain**2 / 2, U_X)
    tension = PRETENSION + MODULUS * strain
    assert sp.simplify(conjugate - tension * (1 + U_X) / (1 + strain)) == 0
    for force, factor in ((conjugate, EA / 2), (tension, MODULUS / 2)):
        assert sp.simplify(sp.diff(force, W_X, 2).subs({U_X: 0, W_X: 0}) / 2 - factor) == 0


def test_pulley_torques_are_the_virtual_work_of_the_span_tensions():
    """`convention-loop-signs`: -dV/dtheta_1 = r1 (T1 - T2), -dV/dtheta_2 = r2 (T2 - T1); T0 cancels."""
    r1, r2, th1, th2, length, t0 = sp.symbols("r_1 r_2 theta_1 theta_2 L_e T_0", positive=True)
    strain1 = (r2 * th2 - r1 * th1) / length  # u1(0) = r1 th1, u1(Le) = r2 th2; u2 the other way round
    energy = sum(length * (t0 * e + MODULUS * e**2 / 2) for e in (strain1, -strain1))
    difference = 2 * MODULUS * strain1  # T1 - T2
    assert sp.simplify(-sp.diff(energy, th1) - r1 * difference) == 0
    assert sp.simplify(-sp.diff(energy, th2) + r2 * difference) == 0


# --- the difference scheme of Section 2.6 -----------------------------------------------------------------

FIRST_CELL = {1: 1.0, 0: -1.0}  # (u_2 - u_1)/dx, of first order at the rim
ONE_SIDED = {1: 2.0, 0: -1.5, 2: -0.5}  # (-3 u_1 + 4 u_2 - u_3)/(2 dx), of second order at the rim


def semidiscrete_frequency(inertias, n, rim_slope, half_cells):
    """Lowest frequency [Hz] of n segments per span, nodes 0 and n at the rims, the loop closed."""
    length, density, c_u, _ = stretched()
    dx, modulus = length / n, density * c_u**2
    operator = np.zeros((2 * n, 2 * n))
    for i in set(range(2 * n)) - {0, n}:
        for j, weight in ((i - 1, 1.0), (i, -2.0), (i + 1, 1.0)):
            operator[i, j % (2 * n)] += modulus / density / dx**2 * weight
    for i, inertia in zip((0, n), inertias, strict=True):
        mass = inertia / RADIUS**2 + (density * dx if half_cells else 0.0)
        for side in (1, -1):
            for step, weight in rim_slope.items():
                operator[i, (i + side * step) % (2 * n)] += modulus / dx * weight / mass
    return np.sqrt(np.sort(-np.linalg.eigvals(operator).real)[1]) / (2 * pi)


@pytest.mark.parametrize("configuration", DRIVES)
@pytest.mark.parametrize(
    ("rim_slope", "half_cells", "order"),
    [(FIRST_CELL, False, 1), (FIRST_CELL, True, 2), (ONE_SIDED, False, 2), (ONE_SIDED, True, 1)],
)
def test_order_of_the_scheme_by_what_stands_at_the_rim(configuration, rim_slope, half_cells, order):
    """`erratum-2-37-half-cells`, `erratum-2-33-boundary-slope`: half cells or a finer slope, not both."""
    inertias, n = (DRIVES[configuration], LOAD), np.array([20, 40, 80])
    exact = out_of_phase(inertias[0], *stretched()[:3])[0]
    error = np.abs([semidiscrete_frequency(inertias, k, rim_slope, half_cells) - exact for k in n])
    observed = -np.polyfit(np.log(n), np.log(error), 1)[0]
    assert observed == pytest.approx(order, abs=0.06), f"observed order {observed:.3f}, errors {error} Hz"


def test_ghost_value_from_the_wave_equation_is_the_half_cell():
    """`erratum-2-33-boundary-slope`: u_0 eliminated from (2.33a) with (2.32a) gives rho dx/2 a span."""
    u0, u1, u2, dx, rho, modulus, acceleration = sp.symbols("u_0 u_1 u_2 dx rho K a", positive=True)
    wave = sp.Eq(rho * acceleration, modulus * (u2 - 2 * u1 + u0) / dx**2)
    tension = modulus * (u2 - sp.solve(wave, u0)[0]) / (2 * dx)
    assert sp.expand(tension - (modulus * (u2 - u1) / dx - rho * dx / 2 * acceleration)) == 0


def test_spacing_and_second_differences():
    """`erratum-2-31-spacing`: low by (n-1)/n. `erratum-2-34-second-difference`: over 2 dx it is 0."""
    n, (length, _, c_u, _) = 40, stretched()
    k = np.arange(1, n)
    for dx, ratio in ((length / (n - 1), (n - 1) / n), (length / n, 1.0)):
        operator = (2 * np.eye(n - 1) - np.eye(n - 1, k=1) - np.eye(n - 1, k=-1)) * (c_u / dx) ** 2
        discrete = 2 * c_u * n / length * np.sin(k * pi / (2 * n))  # n segments of Le/n with fixed ends
        np.testing.assert_allclose(np.sqrt(np.linalg.eigvalsh(operator)) / discrete, ratio, rtol=1e-10)
    x, dx = sp.symbols("x dx")
    second = sp.exp(x + dx) - 2 * sp.exp(x) + sp.exp(x - dx)
    assert sp.limit(second / (2 * dx), dx, 0) == 0
    assert sp.simplify(sp.limit(second / dx**2, dx, 0) - sp.exp(x)) == 0


def test_start_of_the_drive_pulley_keeps_its_angle():
    """`erratum-2-39-initial-angle`: (2.39a), second line, lacks theta_1(0): its error stays."""
    theta, (t, dt, angle, rate) = sp.Function("theta"), sp.symbols("t dt theta_0 omega_0", positive=True)
    torque, inertia, friction = sp.symbols("K_1 J_1 b_1", positive=True)
    equation = sp.Eq(inertia * theta(t).diff(t, 2), torque - friction * theta(t).diff(t))
    start = {theta(0): angle, theta(t).diff(t).subs(t, 0): rate}
    exact = sp.dsolve(equation, theta(t), ics=start).rhs.subs(t, dt)
    printed = dt * rate + dt**2 / (2 * inertia) * (torque - friction * rate)
    assert sp.simplify(sp.limit(exact - printed, dt, 0) - angle) == 0
    assert sp.simplify(sp.limit((exact - angle - printed) / dt**2, dt, 0)) == 0
