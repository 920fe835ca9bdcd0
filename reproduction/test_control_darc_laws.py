"""Sections 6.3-6.6: the printed laws (6.20), (6.43), (6.53), (6.63), their bounds and their projection.

The laws contain only sums, products and quotients, so they are run on random rational numbers: the sliding
surface and its rate come from powers of the plant's state matrix in exact arithmetic, and an identity leaves
exactly zero.
"""

import math
from fractions import Fraction as F

import numpy as np
import pytest

from oracles.printed_darc_laws import LAWS, Machine, law_3, law_4, printed_states


def chain(inertias, stiffnesses):
    """State matrix and input column of a chain of inertias, states (angles, speeds), torque on the first."""
    n = len(inertias)
    A = np.full((2 * n, 2 * n), F(0))
    A[:n, n:] = np.diag([F(1)] * n)
    for i, k in enumerate(stiffnesses):
        A[n + i, i], A[n + i, i + 1] = A[n + i, i] - k / inertias[i], k / inertias[i]
        A[n + i + 1, i + 1], A[n + i + 1, i] = -k / inertias[i + 1], k / inertias[i + 1]
    B = np.array([F(0)] * n + [1 / inertias[0]] + [F(0)] * (n - 1))
    return A, B


def plant(model, machine):
    """Undamped chain of a model and the printed states as differences of its angles and speeds."""
    m = machine
    inertias, stiffnesses = {
        1: ([m.J1 + m.J2], []),
        2: ([m.J11, m.J12 + m.J2], [m.k_m]),
        3: ([m.J1, m.J2], [m.kk]),
        4: ([m.J11, m.J12, m.J2], [m.k_m, m.kk]),
    }[model]
    return chain(inertias, stiffnesses)


def load_derivatives(A, B, q, torque):
    """theta_2 and its derivatives up to the one that contains the torque, from powers of the state matrix."""
    n = len(q) // 2
    row = np.full(2 * n, F(0))
    row[n - 1] = F(1)
    derivatives = []
    for _ in range(2 * n):
        derivatives.append(row @ q)
        row, last = row @ A, row
    return [*derivatives, row @ q + (last @ B) * torque]


def surface(z, lam):
    """(s + lambda)^n z, n = len(z) - 1, from z and its derivatives."""
    n = len(z) - 1
    return sum(math.comb(n, i) * lam ** (n - i) * z_i for i, z_i in enumerate(z))


def residual_of_the_sigma_dynamics(model, law, rng, machine=None):
    """Residuals of the sigma dynamics (6.23) and of sigma's definition, at a random rational state."""
    machine = machine or Machine()

    def draw(n):
        return np.array([F(int(i), 1000) for i in rng.integers(-2000, 2000, n)])

    A, B = plant(model, machine)
    q, y, estimate_error, (S, disturbance) = draw(len(B)), draw(len(B) + 1), draw(4), draw(2)
    lam, K_sigma = F(69), F("0.0001")
    p = np.array([(machine.J1 + machine.J2, machine.J11, machine.J1, machine.J11)[model - 1], *draw(3)])
    u, sigma, phi, mu = law(machine, printed_states(q), y, p + estimate_error, lam, K_sigma, S)

    motor_speed = q[len(q) // 2]
    net_torque = u - p[1] * motor_speed - p[2] * S + p[3] + disturbance
    z = np.array(load_derivatives(A, B, q, net_torque)) - y
    rate = surface(z[1:], lam)
    return mu * rate + K_sigma * sigma + phi @ estimate_error - disturbance, sigma - surface(z[:-1], lam)


def assert_exact(model, law=None):
    rng = np.random.default_rng(6)
    for _ in range(5):
        dynamics, definition = residual_of_the_sigma_dynamics(model, law or LAWS[model], rng)
        assert definition == 0, f"sigma differs from (s + lambda)^n z1 by {float(definition):.3e}"
        assert dynamics == 0, f"the sigma dynamics are missed by {float(dynamics):.3e} N m"


def test_law_6_20_gives_the_sigma_dynamics_6_23():
    """`confirmed-6-15-6-23`: Model 1, exactly, at random states, references, estimates and disturbances."""
    assert_exact(1)


def test_law_6_43_gives_the_sigma_dynamics_6_45():
    """`confirmed-6-39-6-45`: Model 2, on the joint without damping.

    `erratum-6-39-order`: four states and y_d to its fourth derivative are all it takes.
    """
    assert_exact(2)


def test_law_6_53_gives_the_sigma_dynamics_6_56():
    """`confirmed-6-46-6-56`: Model 3, on the cable without damping, with the fourth derivative in z_eq."""
    assert_exact(3)


def test_law_6_63_gives_the_sigma_dynamics_6_65():
    """`confirmed-6-57-6-65`: Model 4, on joint and cable without damping."""
    assert_exact(4)


def test_z_eq_of_6_51_needs_the_fourth_derivative():
    """`erratum-6-51-fourth-derivative`: with the third one sigma no longer obeys (6.56)."""

    def with_the_third_derivative(machine, x, y, *rest):
        return law_3(machine, x, [*y[:4], y[3]], *rest)

    dynamics, _ = residual_of_the_sigma_dynamics(3, with_the_third_derivative, np.random.default_rng(6))
    assert dynamics != 0
    with pytest.raises(AssertionError, match="missed by"):
        assert_exact(3, with_the_third_derivative)


# --- poles on the damped plant ----------------------------------------------------------------------------


def closed_loop_poles(lam_hz, K_ratio_hz, cable_damping, joint_damping):
    """Poles of Model 4 under (6.63) with true, fixed parameters and no friction; the plant damped or not."""
    m = Machine(*(float(v) for v in (F("0.0011"), F("0.000642"), F("0.00235"), F("2.72"), F(135))))
    lam, bb = 2 * np.pi * lam_hz, 2 * cable_damping * 0.04
    K_sigma = 2 * np.pi * K_ratio_hz * m.J11 * m.J12 / (m.kk / m.J2 * m.k_m)
    p = np.array([m.J11, 0.0, 0.0, 0.0])

    inertia = np.diag([m.J11, m.J12, m.J2])
    links = [np.array([[1, -1, 0], [-1, 1, 0], [0, 0, 0]]), np.array([[0, 0, 0], [0, 1, -1], [0, -1, 1]])]
    stiffness = m.k_m * links[0] + m.kk * links[1]
    damping = joint_damping * links[0] + bb * links[1]
    A = np.block(
        [[np.zeros((3, 3)), np.eye(3)], [-np.linalg.solve(inertia, np.hstack([stiffness, damping]))]]
    )
    feedback = [law_4(m, printed_states(e), np.zeros(7), p, lam, K_sigma, 0.0)[0] for e in np.eye(6)]
    A[3] += np.array(feedback) / m.J11
    return np.linalg.eigvals(A)


def test_dropped_damping_moves_the_poles_of_the_printed_model_4_law():
    """`erratum-6-39-damping`: designed for 23 Hz, five times, and 25 Hz; not so on the damped plant."""
    designed = closed_loop_poles(23, 25, 0.0, 0.0)
    polynomial = np.poly(-2 * np.pi * np.array([23.0] * 5 + [25.0]))
    np.testing.assert_allclose(np.poly(designed).real, polynomial, rtol=1e-9)

    poles = closed_loop_poles(23, 25, 0.18, 0.075)
    pairs = sorted(poles[poles.imag > 1e-3], key=abs)
    frequency, ratio = np.abs(pairs) / (2 * np.pi), [-s.real / abs(s) for s in pairs]
    observed = f"observed {frequency} Hz with damping ratios {ratio}"
    assert np.allclose(frequency[[0, -1]], [6.9, 28.3], atol=0.05), observed
    assert np.allclose([ratio[0], ratio[-1]], [0.81, 0.34], atol=0.005), observed


# --- conditions and projection ----------------------------------------------------------------------------

HIGH = np.array([0.00185, 0.0033, 0.04, 0.01])  # Section 6.5.1
LOW = np.array([0.00165, 0.0029, 0.035, -0.01])


def worst_value_of_condition_1(uncertainty, gain):
    """Maximum over sigma of sigma (u_s2 + uncertainty) with u_s2 = -gain sigma."""
    sigma = uncertainty / (2 * gain)
    return sigma * (-gain * sigma + uncertainty)


def test_example_6_22_meets_condition_1_with_twice_epsilon_only():
    """`erratum-6-22-example`: worst at ||dp|| ||phi|| = delta; the squared sum meets it for any delta."""
    epsilon = 1e-3
    for delta in (0.1, 1.0, 10.0):  # in units of ||dp|| ||phi||, phi parallel to dp
        printed = worst_value_of_condition_1(1 + delta, (1 + delta**2) / (4 * epsilon))
        corrected = worst_value_of_condition_1(1 + delta, (1 + delta) ** 2 / (4 * epsilon))
        assert corrected == pytest.approx(epsilon, rel=1e-12)
        assert epsilon < printed <= 2 * epsilon * (1 + 1e-12), f"observed {printed / epsilon:.3f} epsilon"
        assert delta != 1.0 or printed == pytest.approx(2 * epsilon, rel=1e-12)

    spread, motor_speed = HIGH - LOW, 0.1
    phi = np.array([0.01, motor_speed, np.tanh(0.5 * motor_speed), 1.0])  # a regressor that Model 3 can have
    product = np.linalg.norm(spread) * np.linalg.norm(phi)
    reached = worst_value_of_condition_1(phi @ spread + product, 2 * product**2 / (4 * epsilon))
    assert reached == pytest.approx(1.957 * epsilon, rel=1e-3), f"observed {reached / epsilon:.4f} epsilon"


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
    assert np.linalg.eigvalsh(full).min() > 0
    estimate, truth = np.array([1.0, 1.0]), np.array([0.9, 0.1])
    tau = np.linalg.solve(full, [1.0, 0.0])  # pushes the first estimate out of its bound
    value = property_2(estimate, truth, full, tau, low, high)
    assert value == pytest.approx(31 / 18, rel=1e-12), f"observed {value:.4f}"

    rng = np.random.default_rng(26)
    for _ in range(2000):
        estimate = rng.choice([0.0, 1.0, rng.random()], 2)
        value = property_2(
            estimate, rng.random(2), np.diag(rng.uniform(0.1, 10, 2)), rng.normal(size=2), low, high
        )
        assert value <= 1e-12, f"observed {value:.3e}"


def test_projection_6_24_limits_no_rate_and_a_limit_spoils_6_26():
    """`erratum-6-24-rate-limit`: within bounds (6.24) passes any rate; scaled down, (6.26) may fail."""
    inside, low, high = np.array([0.5]), np.zeros(1), np.ones(1)
    for rate in (1.0, 1e3, 1e9):
        assert project(np.array([rate]), inside, low, high)[0] == rate

    truth, tau, Gamma = np.array([0.9]), np.array([10.0]), np.eye(1)
    assert property_2(inside, truth, Gamma, tau, low, high) <= 0
    limited = property_2(inside, truth, Gamma, tau, low, high, rate_limit=1.0)
    assert limited == pytest.approx(0.4 * 9, rel=1e-12), f"observed {limited:.3f}"
