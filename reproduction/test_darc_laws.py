"""Sections 6.3-6.6: the printed laws (6.20), (6.43), (6.53), (6.63) and their projection.

The laws contain only sums, products and quotients, so they are run on random rational numbers: the sliding
surface and its rate come from powers of the plant's state matrix in exact arithmetic, and an identity leaves
exactly zero.
"""

import math
from fractions import Fraction as F

import numpy as np
import pytest

from oracles.printed_laws import LAWS, Machine, law_3, law_4, printed_states
from reproduction.oracles import link_matrix, state_matrix


def plant(model, m):
    """State matrix and input column of the undamped chain of a model, torque on the first inertia."""
    inertias, stiffnesses = {
        1: ([m.J1 + m.J2], []),
        2: ([m.J11, m.J12 + m.J2], [m.k_m]),
        3: ([m.J1, m.J2], [m.kk]),
        4: ([m.J11, m.J12, m.J2], [m.k_m, m.kk]),
    }[model]
    n = len(inertias)
    A = np.full((2 * n, 2 * n), F(0))
    A[:n, n:] = np.diag([F(1)] * n)
    for i, k in enumerate(stiffnesses):
        A[n + i, i], A[n + i, i + 1] = A[n + i, i] - k / inertias[i], k / inertias[i]
        A[n + i + 1, i + 1], A[n + i + 1, i] = -k / inertias[i + 1], k / inertias[i + 1]
    return A, np.array([F(0)] * n + [1 / inertias[0]] + [F(0)] * (n - 1))


def load_derivatives(A, B, q, torque):
    """theta_2 and its derivatives up to the one that contains the torque, from powers of the state matrix."""
    n = len(q) // 2
    row, derivatives = np.full(2 * n, F(0)), []
    row[n - 1] = F(1)
    for _ in range(2 * n):
        derivatives.append(row @ q)
        row, last = row @ A, row
    return [*derivatives, row @ q + (last @ B) * torque]


def surface(z, lam):
    """(s + lambda)^n z, n = len(z) - 1, from z and its derivatives."""
    n = len(z) - 1
    return sum(math.comb(n, i) * lam ** (n - i) * z_i for i, z_i in enumerate(z))


def residuals(model, law, rng):
    """Residuals of the sigma dynamics (6.23) and of sigma's definition, at a random rational state."""
    machine = Machine()

    def draw(n):
        return np.array([F(int(i), 1000) for i in rng.integers(-2000, 2000, n)])

    A, B = plant(model, machine)
    q, y, estimate_error, (S, disturbance) = draw(len(B)), draw(len(B) + 1), draw(4), draw(2)
    lam, K_sigma = F(69), F("0.0001")
    p = np.array([(machine.J1 + machine.J2, machine.J11, machine.J1, machine.J11)[model - 1], *draw(3)])
    u, sigma, phi, mu = law(machine, printed_states(q), y, p + estimate_error, lam, K_sigma, S)
    net_torque = u - p[1] * q[len(q) // 2] - p[2] * S + p[3] + disturbance
    z = np.array(load_derivatives(A, B, q, net_torque)) - y
    dynamics = mu * surface(z[1:], lam) + K_sigma * sigma + phi @ estimate_error - disturbance
    return dynamics, sigma - surface(z[:-1], lam)


@pytest.mark.parametrize("model", LAWS)
def test_laws_give_the_sigma_dynamics(model):
    """`confirmed-6-15-6-23`, `confirmed-6-39-6-45`, `confirmed-6-46-6-56`, `confirmed-6-57-6-65`: exactly.

    `erratum-6-39-order`: of Model 2, four states and y_d to its fourth derivative are all it takes.
    """
    rng = np.random.default_rng(6)
    for _ in range(5):
        assert residuals(model, LAWS[model], rng) == (0, 0)


def test_z_eq_of_6_51_needs_the_fourth_derivative():
    """`erratum-6-51-fourth-derivative`: with the third one sigma no longer obeys (6.56)."""
    third = lambda machine, x, y, *rest: law_3(machine, x, [*y[:4], y[3]], *rest)  # noqa: E731
    assert residuals(3, third, np.random.default_rng(6))[0] != 0


def closed_loop_poles(lam_hz, K_ratio_hz, dampings):
    """Poles of Model 4 under (6.63) with true, fixed parameters and no friction; the plant damped or not."""
    m = Machine(*(float(v) for v in (F("0.0011"), F("0.000642"), F("0.00235"), F("2.72"), F(135))))
    K_sigma = 2 * np.pi * K_ratio_hz * m.J11 * m.J12 / (m.kk / m.J2 * m.k_m)
    A = state_matrix((m.J11, m.J12, m.J2), link_matrix([m.k_m, m.kk]), link_matrix(dampings))
    p = np.array([m.J11, 0.0, 0.0, 0.0])
    arguments = np.zeros(7), p, 2 * np.pi * lam_hz, K_sigma, 0.0
    A[3] += np.array([law_4(m, printed_states(e), *arguments)[0] for e in np.eye(6)]) / m.J11
    return np.linalg.eigvals(A)


def test_dropped_damping_moves_the_poles_of_the_printed_model_4_law():
    """`erratum-6-39-damping`: designed for 23 Hz, five times, and 25 Hz; not so on the damped plant."""
    polynomial = np.poly(-2 * np.pi * np.array([23.0] * 5 + [25.0]))
    np.testing.assert_allclose(np.poly(closed_loop_poles(23, 25, (0.0, 0.0))).real, polynomial, rtol=1e-9)
    poles = closed_loop_poles(23, 25, (0.075, 2 * 0.18 * 0.04))  # of joint and cable, Table 6.2
    first, *_, last = sorted(poles[poles.imag > 1e-3], key=abs)
    np.testing.assert_allclose(np.abs([first, last]) / (2 * np.pi), [6.9, 28.3], atol=0.05)
    np.testing.assert_allclose([-s.real / abs(s) for s in (first, last)], [0.81, 0.34], atol=0.005)


def project(rate, estimate, low, high):
    """Eq. (6.24), component by component."""
    leaving = ((estimate >= high) & (rate > 0)) | ((estimate <= low) & (rate < 0))
    return np.where(leaving, 0.0, rate)


def property_2(estimate, truth, Gamma, tau, low, high, rate_limit=np.inf):
    """Left side of (6.26), which should not be positive."""
    rate = project(Gamma @ tau, estimate, low, high)
    rate = rate * min(1.0, rate_limit / max(np.linalg.norm(rate), 1e-300))
    return (estimate - truth) @ (np.linalg.solve(Gamma, rate) - tau)


def test_projection_6_24_needs_a_diagonal_gain_for_6_26():
    """`erratum-6-26-diagonal`: never positive for diagonal Gamma; positive for a full definite one."""
    low, high = np.zeros(2), np.ones(2)
    full = np.array([[1.0, 0.8], [0.8, 1.0]])
    tau = np.linalg.solve(full, [1.0, 0.0])  # pushes the first estimate out of its bound
    value = property_2(np.array([1.0, 1.0]), np.array([0.9, 0.1]), full, tau, low, high)
    assert value == pytest.approx(31 / 18, rel=1e-12)
    rng = np.random.default_rng(26)
    for _ in range(2000):
        estimate, truth = rng.choice([0.0, 1.0, rng.random()], 2), rng.random(2)
        assert (
            property_2(estimate, truth, np.diag(rng.uniform(0.1, 10, 2)), rng.normal(size=2), low, high)
            <= 1e-12
        )


def test_projection_6_24_limits_no_rate_and_a_limit_spoils_6_26():
    """`erratum-6-24-rate-limit`: within bounds (6.24) passes any rate; scaled down, (6.26) may fail."""
    inside, low, high = np.array([0.5]), np.zeros(1), np.ones(1)
    assert project(np.array([1e9]), inside, low, high)[0] == 1e9
    limited = property_2(inside, np.array([0.9]), np.eye(1), np.array([10.0]), low, high, rate_limit=1.0)
    assert limited == pytest.approx(0.4 * 9, rel=1e-12)
