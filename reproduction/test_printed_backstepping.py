"""Section 6.7: the backstepping law (6.66)-(6.110), derived again and held against the print.

`corrected_backstepping` contains sums, products and quotients only: SymPy runs it on symbols, to derive
along the true plant, and the numerical tests run it on floats. The estimates are p^ = p + p~; `rate` is the
total time derivative along (6.69), in which the truth is p^ - p~.
"""

from functools import cache
from itertools import product

import numpy as np
import pytest
import sympy as sp

from oracles.printed_laws import Gains, corrected_backstepping, plant
from reproduction.oracles import BETA

X = sp.symbols("x1 x2 x3bar x4bar")
Y = sp.symbols("y0:6")
P = sp.symbols("p1:8", positive=True)  # the estimates p^
P_ERROR = sp.symbols("e1:8")  # p~
P_RATE = sp.symbols("r1:8")  # d p^/dt
K = Gains(*sp.symbols("k1 k2g1 k2g2 k2r k3g2 k3g3 k3r k4g2 k4g3 k4g4 k4r", positive=True))
S, D2, D, BETA_N, U = sp.symbols("S d_2 d beta_n u")
TRUTH = [p - error for p, error in zip(P, P_ERROR, strict=True)]
K2, K3 = K.k2g2 + K.k2r, K.k3g3 + K.k3r
LAW = corrected_backstepping(X, Y, P, K, BETA_N, S)
Z1, Z2, Z3, Z4 = LAW.z
A1, A2, A3 = LAW.alpha
A2_T, A2_X1, A2_X2 = LAW.alpha2_partials
PHI_4 = (*LAW.phi4[:6], BETA_N * U)


def error_matrix(k, p1):
    """A_z of (6.103), corrected: A_z(3,4) = 1."""
    return [
        [-k.k1, 1, 0, 0],
        [-k.k2g1, -(k.k2g2 + k.k2r), p1, 0],
        [0, -k.k3g2, -(k.k3g3 + k.k3r), 1],
        [0, -k.k4g2, -k.k4g3, -(k.k4g4 + k.k4r)],
    ]


def dot(a, b):
    return sum(a_i * b_i for a_i, b_i in zip(a, b, strict=True))


def partial_t(f):
    """Derivative with respect to time at fixed states and estimates."""
    return sum(sp.diff(f, Y[n]) * Y[n + 1] for n in range(5))


@cache
def rate(f):
    """Total time derivative along the true plant, with u a symbol."""
    along = zip(X, plant(X, U, TRUTH, D2, D, BETA_N, S), strict=True)
    return partial_t(f) + sum(sp.diff(f, v) * v_rate for v, v_rate in along) + adaptation(f)


def adaptation(alpha):
    """(d alpha / d p^) dp^/dt."""
    return dot([sp.diff(alpha, p) for p in P], P_RATE)


def is_zero(expression):
    """Over 1/p1^ and 1/p7^ everything here is a polynomial; u is the law's where it is left over."""
    return sp.expand(sp.expand(expression).subs(U, LAW.u)) == 0


# --- the plant --------------------------------------------------------------------------------------------


def test_disturbances_of_6_69_are_divided_by_the_inertias():
    """`erratum-6-69-disturbances`: d2~/J2 in (6.69b), d~ = beta_n (d1~/J1 - d2~/J2) in (6.69d)."""
    J1, J2, kk, b1, c1, d1, d2, w1, w2 = sp.symbols("J1 J2 kk b1 c1 d1 d2 w1 w2", positive=True)  # w: d~
    x2, x3, speed = X[1], X[2] / BETA_N, X[1] + X[3] / BETA_N
    load = (kk * x3 + d2 + w2) / J2  # (6.67)
    motor = (U - kk * x3 - b1 * speed - c1 * S + d1 + w1) / J1  # (6.66)
    p1, p2 = kk / J2 / BETA_N, d2 / J2
    p3 = (kk / BETA_N + J1 * p1) * BETA_N / J1
    p = (p1, p2, p3, b1 * BETA_N / J1, c1 * BETA_N / J1, (d1 - J1 * p2) * BETA_N / J1, 1 / J1)

    def missing(d_load, d_motor):
        rates = plant((X[0], x2, *X[2:]), U, p, d_load, d_motor, BETA_N, S)
        return sp.simplify(rates[1] - load), sp.simplify(rates[3] - BETA_N * (motor - load))

    assert missing(w2 / J2, BETA_N * (w1 / J1 - w2 / J2)) == (0, 0)
    assert 0 not in missing(w2, BETA_N * (w1 / J1 - w2)), "as printed, d2~ a torque as in (6.67)"


def test_only_the_load_equation_is_unmatched():
    """`erratum-6-69-unmatched`: p1, p2 act outside the input channel; p7, the input's gain, inside."""
    rates = sp.Matrix(plant(X, U, P, D2, D, BETA_N, S))
    assert [any(sp.diff(rates, p)[:3]) for p in (U, *P)] == [False, True, True, *[False] * 5]
    assert sp.diff(rates, P[6])[3] == BETA_N * U


# --- the steps of the law ---------------------------------------------------------------------------------


def test_regressor_phi_2_is_alpha_2_and_one():
    """`erratum-6-77-phi-2`: z2' depends on the estimation errors through -(alpha_2, 1, 0, 0, 0, 0, 0)."""
    remaining = sp.expand(rate(Z2) - TRUTH[0] * Z3)  # p1 z3 keeps the true p1 in (6.78)
    assert all(is_zero(sp.diff(remaining, e) + phi) for e, phi in zip(P_ERROR, LAW.phi2, strict=True))


def test_the_corrected_forms_leave_nothing_and_the_printed_ones_do():
    """`erratum-6-76-robust-term`, `erratum-6-90-robust-term`: undivided. `erratum-6-92-sign`.

    `erratum-6-80-alpha-2`: d alpha_2/dx1. `erratum-6-89a-derivatives`: the fourth and the second derivative.
    `erratum-6-89d-speed-derivative`: -k_2g1/p1^ and -k_3g2 are missing.
    """
    _, y1, y2, y3, y4, _ = Y
    alpha2_r, alpha4_r = -K.k2r * Z2 / P[0], -K.k4r * Z4 / (BETA_N * P[6])
    step_2 = rate(Z2) - (TRUTH[0] * Z3 - K.k2g2 * Z2 - K.k2g1 * Z1 - dot(LAW.phi2, P_ERROR) + D2)
    feedback = -K.k4g4 * Z4 - K.k4g3 * Z3 - K.k4g2 * Z2 - dot(PHI_4, P_ERROR) - adaptation(A3)
    step_4, load = rate(Z4) - feedback - D, LAW.alpha3_partials[2] * D2
    alpha2 = rate(A2) - partial_t(A2) - sp.diff(A2, X[1]) * rate(X[1]) - adaptation(A2)
    speed = sp.diff(A3, X[1]) - K3 * A2_X2

    def alpha3(first, last):
        second = (first + K.k1 * y3 + K2 * (y3 + K.k1 * y2) + K.k2g1 * last) / P[0]
        return partial_t(A3) - second - K3 * A2_T - K.k3g2 * (y2 + K.k1 * y1)

    for equation, right, *printed in (
        ("6.76", step_2 - P[0] * alpha2_r, step_2 - alpha2_r),
        ("6.80", alpha2 - sp.diff(A2, X[0]) * X[1], alpha2 - sp.diff(A1, X[0]) * X[1]),
        ("6.89a", alpha3(y4, y2), alpha3(y3, y1), alpha3(y4, y1)),
        ("6.89d", speed - A2_X1 + K.k3g2, speed + K2 * K.k1 / P[0]),
        ("6.90c", step_4 + load - BETA_N * P[6] * alpha4_r, step_4 + load - alpha4_r),
        ("6.92", step_4 + load + K.k4r * Z4, step_4 - load + K.k4r * Z4),
    ):
        assert is_zero(right), equation
        assert not any(map(is_zero, printed)), equation


def test_derivatives_6_81_to_6_89_are_right_for_constant_robust_gains():
    """`confirmed-6-81-6-85`: derivatives of alpha_2, phi_3, d3~ and z3'; so are (6.89c), (6.89e).

    `erratum-6-81-nonlinear-gains`: with k_2r = kappa z2^2 the term 2 kappa z2^2/p1^ of (6.81c) is missing.
    """
    true = (partial_t(A2), sp.diff(A2, X[0]), sp.diff(A3, X[0]))
    assert all(is_zero(a - b) for a, b in zip(true, (A2_T, A2_X1, K3 * A2_X1 - K.k3g2 * K.k1), strict=True))
    printed = Z4 - K3 * Z3 - K.k3g2 * Z2 - dot(LAW.phi3, P_ERROR) - A2_X2 * D2 - adaptation(A2)
    assert is_zero(rate(Z3) - printed)
    kappa = sp.Symbol("kappa")
    for alpha, x, printed, gain, z, scale in (
        (A2, X[1], A2_X2, K.k2r, Z2, P[0]),
        (A3, X[2], LAW.alpha3_partials[3], K.k3r, Z3, 1),
    ):
        assert is_zero(sp.diff(alpha, x) - printed)
        missed = sp.diff(alpha.subs(gain, kappa * z**2), x) - printed.subs(gain, kappa * z**2)
        assert is_zero(missed + 2 * kappa * z**2 / scale)


def test_error_dynamics_need_a_coupling_of_one_and_four_rows():
    """`erratum-6-103-coupling`: z' = A_z z + B dp^/dt - [0; Phi^T p~ - d~], with A_z(3,4) = 1."""
    disturbances = (0, D2, -A2_X2 * D2, D - LAW.alpha3_partials[2] * D2)
    errors = (0, *(dot(phi, P_ERROR) for phi in (LAW.phi2, LAW.phi3, PHI_4)))
    lost = (0, 0, adaptation(A2), adaptation(A3))
    linear = [dot(row, LAW.z) for row in error_matrix(K, TRUTH[0])]
    rest = [rate(z) - linear[i] + lost[i] + errors[i] - disturbances[i] for i, z in enumerate(LAW.z)]
    assert all(map(is_zero, rest))
    assert not is_zero(rest[2] + Z4), "printed: A_z(3,4) = 0"


Z = sp.symbols("z1:5")
LOSS_2 = sp.symbols("a22 a23 a24", nonnegative=True)  # |d alpha_2/d p^| |Gamma phi_i|, i = 2, 3, 4
LOSS_3 = sp.symbols("a32 a33 a34", nonnegative=True)  # |d alpha_3/d p^| |Gamma phi_i|
S23, S24, S34 = sp.symbols("s23 s24 s34")  # sign(z_i z_j)


def matrix_6_100(k, p1, a2, a3, s23, s24, s34):
    """D_z as printed, (6.100), (6.101)."""
    d12 = (k.k2g1 - 1) / 2
    d23 = (k.k3g2 - p1 - a2[0] * s23) / 2
    d24 = (k.k4g2 - a3[0] * s24) / 2
    d33 = k.k3g3 - a2[1]
    d34 = (k.k4g3 - 1 - a2[2] * s34 - a3[1] * s34) / 2
    d44 = k.k4g4 - a3[2]
    return [[k.k1, d12, 0, 0], [d12, k.k2g2, d23, d24], [0, d23, d33, d34], [0, d24, d34, d44]]


def test_matrix_6_100_collects_the_bound_6_99():
    """`erratum-6-94-k-2g2`: of z2^2; `confirmed-6-99-6-101`: -z^T D_z z is the bound."""
    z1, z2, z3, z4 = Z
    robust = K.k2r * z2**2 + K.k3r * z3**2 + K.k4r * z4**2  # (6.94) collects it in its brackets
    power = dot(Z, [dot(row, Z) for row in error_matrix(K, TRUTH[0])]) + robust
    printed = z1 * z2 - K.k1 * z1**2 + TRUTH[0] * z2 * z3 - K.k2g1 * z1 * z2 + z3 * z4 - K.k3g3 * z3**2
    printed += -K.k3g2 * z2 * z3 - K.k4g4 * z4**2 - K.k4g3 * z3 * z4 - K.k4g2 * z2 * z4
    assert is_zero(power - printed + K.k2g2 * z2**2)
    losses = LOSS_2[0] * S23 * z2 * z3 + LOSS_2[1] * z3**2 + LOSS_2[2] * S34 * z3 * z4
    losses += LOSS_3[0] * S24 * z2 * z4 + LOSS_3[1] * S34 * z3 * z4 + LOSS_3[2] * z4**2
    D_z = matrix_6_100(K, TRUTH[0], LOSS_2, LOSS_3, S23, S24, S34)
    assert is_zero(power + losses + dot(Z, [dot(row, Z) for row in D_z]))


# --- numbers ----------------------------------------------------------------------------------------------

W = 2 * np.pi * 10.5
GAINS = Gains(k1=W, k2g1=1, k2g2=W, k2r=0, k3g2=1, k3g3=W, k3r=0, k4g2=0, k4g3=1, k4g4=W, k4r=0)
PARAMETERS = np.array([1.0, 0.0, 2718.9, 2059.8, 24982.0, 0.0, 574.05])
SPREAD = np.array([0.1, 4.0, 163.0, 123.0, 1500.0, 13288.0, 35.0])


GRADIENTS = [[sp.diff(alpha, p) for p in P] for alpha in (A2, A3)]
SENSITIVITIES = sp.lambdify([X, Y[:5], P, list(vars(K).values())], GRADIENTS)


def adaptation_norms(x, k, Gamma):
    """|d alpha_j/d p^| |Gamma phi_i| for j = 2, 3 and i = 2, 3, 4, at rest in the reference."""
    friction = np.tanh(0.5 * (x[1] + x[3] / BETA))
    at = corrected_backstepping(x, np.zeros(5), PARAMETERS, k, BETA, friction)
    gradients = SENSITIVITIES(x, np.zeros(5), PARAMETERS, list(vars(k).values()))
    weights = [np.linalg.norm(Gamma * np.array(phi)) for phi in (at.phi2, at.phi3, at.phi4)]
    return np.outer(np.linalg.norm(gradients, axis=1), weights)


def smallest_eigenvalue(x, k, Gamma):
    """Smallest eigenvalue of D_z over the signs of z_i z_j."""
    a2, a3 = adaptation_norms(x, k, Gamma)
    signs = product((-1, 1), repeat=3)
    return min(np.linalg.eigvalsh(np.array(matrix_6_100(k, 1.0, a2, a3, *s), float))[0] for s in signs)


@pytest.mark.parametrize("factor", [1, 10, 100])
def test_no_constant_gain_keeps_d_z_positive_everywhere(factor):
    """`erratum-6-100-local`: D_z > 0 near rest; D_44 loses a term that grows with the square of the state."""
    Gamma, direction = 1e-12 * SPREAD**2, np.array([0.01, 0.1, 10.0, 100.0])
    assert smallest_eigenvalue(0.01 * direction, GAINS, Gamma) > 0
    k = Gains(**{name: value * (factor if value == W else 1) for name, value in vars(GAINS).items()})
    loss = [adaptation_norms(scale * direction, k, Gamma)[1, 2] for scale in (1e6, 1e7)]
    assert np.log10(loss[1] / loss[0]) == pytest.approx(2.0, abs=0.01), "observed order"
    far = 10 * 1e6 * max(1.0, np.sqrt(k.k4g4 / loss[0])) * direction
    assert adaptation_norms(far, k, Gamma)[1, 2] > k.k4g4, "D_44 < 0"


def test_d_z_depends_on_the_unit_of_time():
    """`erratum-6-105-units`: one loop, one set of gains: D_z > 0 in seconds, indefinite in milliseconds."""
    T = 1e-3
    per_time = {"k1", "k2g2", "k3g3", "k4g4", "k2r", "k3r", "k4r"}
    scaled = Gains(**{n: v * (T if n in per_time else T**2) for n, v in vars(GAINS).items()})
    change = np.diag(T ** np.arange(4))  # z_i carries 1/time^(i - 1)
    A, A_scaled = (np.array(error_matrix(k, 1.0), float) for k in (GAINS, scaled))
    np.testing.assert_allclose(A_scaled, T * change @ A @ np.linalg.inv(change), rtol=1e-12, atol=1e-12)
    seconds, milliseconds = (smallest_eigenvalue(np.zeros(4), k, np.zeros(7)) for k in (GAINS, scaled))
    assert seconds == pytest.approx(W, rel=1e-12)
    assert milliseconds < -0.5


def test_neither_v_n_nor_the_error_need_vanish():
    """`erratum-6-110-convergence`: at rest wrong p3, p4, p5, p7 stay; under a disturbance z1 stays."""
    error = SPREAD * np.array([0, 0, 0.3, -0.4, 0.2, 0, 0.25])
    at_rest = corrected_backstepping(np.zeros(4), np.zeros(5), PARAMETERS + error, GAINS, BETA, 0.0)
    tau = dot([np.array(phi, float) for phi in (at_rest.phi2, at_rest.phi3, at_rest.phi4)], at_rest.z[1:])
    assert not any(at_rest.z), "V = 0"
    assert not any(plant(np.zeros(4), at_rest.u, PARAMETERS, 0.0, 0.0, BETA, 0.0)), "the state stays"
    assert not any(tau), "so do the estimates, and V_n keeps its value for ever"
    A = np.array(error_matrix(GAINS, 1.0), float)
    assert np.linalg.eigvals(A).real.max() < 0
    d2 = np.array([0, 1, 0, 0])  # d2~ = sin(2 pi t) rad/s^2, parameters known: steady amplitude of z
    amplitude = np.abs(np.linalg.solve(2j * np.pi * np.eye(4) - A, d2))[0]
    assert amplitude == pytest.approx(1 / (W * W + (2 * np.pi) ** 2), rel=1e-3)  # two lags of 10.5 Hz at 1 Hz
    assert amplitude == pytest.approx(2.3e-4, rel=0.03)
