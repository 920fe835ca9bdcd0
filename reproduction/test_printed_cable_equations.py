"""Chapter 2 of the dissertation, before any discretisation: its equations of motion, derived again."""

import numpy as np
import pytest
import sympy as sp

SLOPES = sp.symbols("u_x v_x w_x")
CURVATURES = sp.symbols("u_xx v_xx w_xx")
T0, EA, EPS0, RHO, LAM = sp.symbols("T_0 EA epsilon_0 rho lambda", positive=True)
PRETENSION = EA * EPS0
MODULUS = EA * (1 + EPS0)  # K of T = T0 + K lambda, Eq. (2.10)
CU2, CW2 = MODULUS / RHO, PRETENSION / RHO


def net_force(direction, strain_rate):
    """d/dx of T * direction/(1 + lambda), per mass; direction and lambda depend on x through the slopes."""
    i, numerator = direction
    component = (PRETENSION + MODULUS * LAM) * numerator / (1 + LAM)
    return (sp.diff(component, LAM) * strain_rate + component / numerator * CURVATURES[i]) / RHO


def directions():
    u_x, v_x, w_x = SLOPES
    return list(enumerate((1 + u_x, v_x, w_x)))


def test_exact_equations_are_the_divergence_of_the_tension_vector():
    """`confirmed-2-15-exact-cable`: (2.15)-(2.17) are d/dx [T (1+u', v', w')/(1+lambda)]/rho."""
    u_x, v_x, w_x = SLOPES
    u_xx, v_xx, w_xx = CURVATURES
    product = (1 + u_x) * u_xx + v_x * v_xx + w_x * w_xx
    for direction, curvature in zip(directions(), CURVATURES, strict=True):
        p = direction[1]
        printed = (
            (curvature * CW2 + CU2 * p * product / (LAM + 1)) / (LAM + 1)
            + CU2 * curvature * LAM / (LAM + 1)
            - p * product * (CW2 + CU2 * LAM) / (LAM + 1) ** 3
        )
        difference = sp.simplify(printed - net_force(direction, product / (1 + LAM)))
        assert difference == 0, f"along {p}: {difference}"


def test_weakly_nonlinear_equations_are_the_divergence_of_a_truncated_tension():
    """`confirmed-2-23-weakly-nonlinear`: (2.23)-(2.25) keep the cosines beside the tension of (2.21)."""
    u_xx, v_xx, w_xx = CURVATURES
    strain_rate = u_xx + SLOPES[1] * v_xx + SLOPES[2] * w_xx  # of lambda in (2.19)
    for direction, curvature in zip(directions(), CURVATURES, strict=True):
        p = direction[1]
        printed = (
            CU2 * strain_rate * p / (1 + LAM)
            + (CW2 + CU2 * LAM) * ((1 + LAM) * curvature - p * strain_rate) / (1 + LAM) ** 2
        )
        difference = sp.simplify(printed - net_force(direction, strain_rate))
        assert difference == 0, f"along {p}: {difference}"


def curl(t_x, t_y):
    """Zero when the two force components derive from one strain energy."""
    u_x, v_x, _ = SLOPES
    return sp.factor(sp.diff(t_x, v_x) - sp.diff(t_y, u_x))


def test_printed_weakly_nonlinear_form_has_no_potential():
    """`confirmed-2-23-weakly-nonlinear`: dTx/dv' - dTy/du' = (K - T0) u' v'/(1+lambda)^2 is not zero."""
    u_x, v_x, w_x = SLOPES
    strain = u_x + (v_x**2 + w_x**2) / 2
    tension = PRETENSION + MODULUS * strain
    found = curl(tension * (1 + u_x) / (1 + strain), tension * v_x / (1 + strain))
    assert sp.simplify(found - EA * u_x * v_x / (1 + strain) ** 2) == 0, found


def test_consistent_truncation_and_exact_form_have_a_potential():
    """`confirmed-2-23-weakly-nonlinear`: (T, T v', T w') derives from T0 s + K s^2/2; so does (2.13)."""
    u_x, v_x, w_x = SLOPES
    strain = u_x + (v_x**2 + w_x**2) / 2
    energy = PRETENSION * strain + MODULUS * strain**2 / 2
    tension = PRETENSION + MODULUS * strain
    for slope, component in zip(SLOPES, (tension, tension * v_x, tension * w_x), strict=True):
        assert sp.expand(sp.diff(energy, slope) - component) == 0
    exact = sp.sqrt((1 + u_x) ** 2 + v_x**2 + w_x**2) - 1
    tension = PRETENSION + MODULUS * exact
    assert sp.simplify(curl(tension * (1 + u_x) / (1 + exact), tension * v_x / (1 + exact))) == 0


def test_longitudinal_wave_speed_contains_the_prestrain():
    """`erratum-2-31-wave-speed`: small u in (2.10), (2.14a) travels at sqrt(EA(1+eps0)/rho)."""
    u_x = SLOPES[0]
    axial_force = PRETENSION + MODULUS * u_x
    speed_squared = sp.diff(axial_force, u_x) / RHO
    assert sp.simplify(speed_squared - EA * (1 + EPS0) / RHO) == 0
    assert sp.simplify(speed_squared - EA / RHO) != 0


def test_courant_number_of_the_printed_speed_is_exceeded():
    """`erratum-2-31-wave-speed`: sigma = 0.999 by the printed speed is really 1.0013 and diverges."""
    prestrain = 5.0 / (2.6e9 * 4.26e-7)
    for speed_ratio, stable in ((np.sqrt(1 + prestrain), False), (1.0, True)):
        courant = 0.999 * speed_ratio
        n = 64
        u = np.zeros(n + 1)
        u[1:-1] = (-1.0) ** np.arange(1, n) * np.sin(np.pi * np.arange(1, n) / n)
        before, now = u.copy(), u.copy()
        for _ in range(600):
            after = np.zeros_like(now)
            after[1:-1] = 2 * now[1:-1] - before[1:-1] + courant**2 * np.diff(now, 2)
            before, now = now, after
        growth = np.abs(now).max()
        assert (growth < 60) == stable, f"true Courant number {courant:.5f}: amplitude {growth:.3g}"


def test_pulley_torques_are_the_virtual_work_of_the_span_tensions():
    """`convention-loop-signs`: -dV/dtheta_1 = r1 (T1 - T2), -dV/dtheta_2 = r2 (T2 - T1); T0 cancels."""
    r1, r2, th1, th2, length = sp.symbols("r_1 r_2 theta_1 theta_2 L_e", positive=True)
    strain1 = (r2 * th2 - r1 * th1) / length  # u1(0) = r1 th1, u1(Le) = r2 th2
    strain2 = (r1 * th1 - r2 * th2) / length  # u2(0) = r2 th2, u2(Le) = r1 th1
    energy = sum(length * (T0 * e + MODULUS * e**2 / 2) for e in (strain1, strain2))
    tension1, tension2 = (T0 + MODULUS * e for e in (strain1, strain2))
    torque1, torque2 = -sp.diff(energy, th1), -sp.diff(energy, th2)
    assert sp.simplify(torque1 - r1 * (tension1 - tension2)) == 0
    assert sp.simplify(torque2 - r2 * (tension2 - tension1)) == 0
    assert T0 not in sp.expand(torque1).free_symbols


def test_lower_span_axes_turn_gravity_round():
    """`convention-loop-signs`: with X2 = -X1 and the pulley axis kept, a right-handed frame has Z2 = -Z1."""
    x2, y2 = -np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    z2 = np.cross(x2, y2)
    gravity = np.array([0.0, 0.0, -9.81])
    assert gravity @ z2 == pytest.approx(9.81)


def test_energy_keeping_pulley_force_is_the_axial_component():
    """`erratum-2-28-axial-component`: with w = 0 at the rim, the force conjugate to u(0) is T_x, not T."""
    u_x, w_x = sp.symbols("u_x w_x")
    strain = sp.sqrt((1 + u_x) ** 2 + w_x**2) - 1
    energy_per_length = PRETENSION * strain + MODULUS * strain**2 / 2
    conjugate = sp.diff(energy_per_length, u_x)
    tension = PRETENSION + MODULUS * strain
    assert sp.simplify(conjugate - tension * (1 + u_x) / (1 + strain)) == 0
    for force, factor in ((conjugate, EA / 2), (tension, MODULUS / 2)):
        quadratic = sp.diff(force, w_x, 2).subs({u_x: 0, w_x: 0}) / 2
        assert sp.simplify(quadratic - factor) == 0, quadratic
