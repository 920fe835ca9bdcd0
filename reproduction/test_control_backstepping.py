"""Section 6.7: the backstepping law (6.66)-(6.110), derived again and held against the print.

`corrected_backstepping` contains sums, products and quotients only: SymPy runs it on symbols, to derive
along the true plant, and the numerical tests run it on floats. The estimates are p^ = p + p~; `rate` is the
total time derivative along (6.69), in which the truth is p^ - p~.
"""

from functools import cache

import numpy as np
import pytest
import sympy as sp

from oracles.printed_backstepping import Gains, corrected_backstepping, plant


def error_matrix(k, p1):
    """A_z of (6.103), corrected: A_z(3,4) = 1."""
    return [
        [-k.k1, 1, 0, 0],
        [-k.k2g1, -(k.k2g2 + k.k2r), p1, 0],
        [0, -k.k3g2, -(k.k3g3 + k.k3r), 1],
        [0, -k.k4g2, -k.k4g3, -(k.k4g4 + k.k4r)],
    ]


# --- symbols ----------------------------------------------------------------------------------------------

X = sp.symbols("x1 x2 x3bar x4bar")
Y = sp.symbols("y0:6")
P = sp.symbols("p1:8", positive=True)  # the estimates p^
P_ERROR = sp.symbols("e1:8")  # p~
P_RATE = sp.symbols("r1:8")  # d p^/dt
K = Gains(*sp.symbols("k1 k2g1 k2g2 k2r k3g2 k3g3 k3r k4g2 k4g3 k4g4 k4r", positive=True))
S, D2, D, BETA_N, U = sp.symbols("S d_2 d beta_n u")
TRUTH = [p - error for p, error in zip(P, P_ERROR, strict=True)]
K2, K3 = K.k2g2 + K.k2r, K.k3g3 + K.k3r


@cache
def law():
    return corrected_backstepping(X, Y, P, K, BETA_N, S)


def partial_t(f):
    """Derivative with respect to time at fixed states and estimates."""
    return sum(sp.diff(f, Y[n]) * Y[n + 1] for n in range(5))


def rate(f):
    """Total time derivative along the true plant, with u a symbol."""
    along = zip(X, plant(X, U, TRUTH, D2, D, BETA_N, S), strict=True)
    adapted = zip(P, P_RATE, strict=True)
    return partial_t(f) + sum(sp.diff(f, v) * v_rate for v, v_rate in [*along, *adapted])


def is_zero(expression):
    """Over 1/p1^ and 1/p7^ everything here is a polynomial."""
    return sp.expand(expression) == 0


def dot(a, b):
    return sum(a_i * b_i for a_i, b_i in zip(a, b, strict=True))


def adaptation_term(alpha):
    """(d alpha / d p^) dp^/dt."""
    return dot([sp.diff(alpha, p) for p in P], P_RATE)


# --- the plant --------------------------------------------------------------------------------------------


def test_disturbances_of_6_69_are_divided_by_the_inertias():
    """`erratum-6-69-disturbances`: d2~/J2 in (6.69b), d~ = beta_n (d1~/J1 - d2~/J2) in (6.69d)."""
    J1, J2, kk, b1, c1, d1, d2, w1, w2 = sp.symbols(
        "J1 J2 kk b1 c1 d1 d2 w1 w2", positive=True
    )  # w: d1~, d2~
    x2, x3 = X[1], X[2] / BETA_N
    speed = x2 + X[3] / BETA_N
    load = (kk * x3 + d2 + w2) / J2  # (6.67)
    motor = (U - kk * x3 - b1 * speed - c1 * S + d1 + w1) / J1  # (6.66)

    p1, p2 = kk / J2 / BETA_N, d2 / J2
    p3 = (kk / BETA_N + J1 * p1) * BETA_N / J1
    p = (p1, p2, p3, b1 * BETA_N / J1, c1 * BETA_N / J1, (d1 - J1 * p2) * BETA_N / J1, 1 / J1)

    def missing(d_load, d_motor):
        rates = plant(X, U, p, d_load, d_motor, BETA_N, S)
        return sp.simplify(rates[1] - load), sp.simplify(rates[3] - BETA_N * (motor - load))

    assert missing(w2 / J2, BETA_N * (w1 / J1 - w2 / J2)) == (0, 0)
    assert missing(w2, BETA_N * (w1 / J1 - w2))[0] != 0, "as printed, d2~ a torque as in (6.67)"
    assert sp.simplify(missing(w2 / J2, BETA_N * (w1 / J1 - w2))[1]) != 0


def test_only_the_load_equation_is_unmatched():
    """`erratum-6-69-unmatched`: p1, p2 act outside the input channel; p7, the input's gain, inside."""
    p = sp.symbols("q1:8")
    rates = sp.Matrix(plant(X, U, p, D2, D, BETA_N, S))
    channel = sp.diff(rates, U)
    assert list(channel[:3]) == [0, 0, 0]
    for i, p_i in enumerate(p, start=1):
        effect = sp.diff(rates, p_i)
        assert any(effect[:3]) == (i <= 2), f"p{i} acts through {list(effect)}"
    assert sp.diff(rates, p[6])[3] == BETA_N * U


# --- first and second step --------------------------------------------------------------------------------


def test_robust_term_of_6_76_enters_undivided():
    """`erratum-6-76-robust-term`: z2' of (6.78) holds with p1^ alpha_2r, not with alpha_2r."""
    z1, z2, z3, _ = law().z
    alpha2_r = -K.k2r * z2 / P[0]  # (6.76d)
    others = TRUTH[0] * z3 - K.k2g2 * z2 - K.k2g1 * z1 - dot(law().phi2, P_ERROR) + D2
    assert is_zero(rate(z2) - (others + P[0] * alpha2_r))
    assert not is_zero(rate(z2) - (others + alpha2_r))

    alpha1_rate = partial_t(law().alpha[0]) - K.k1 * X[1]  # first line of (6.78)
    alpha2_s = -(K.k2g2 * z2 + K.k2g1 * z1 + K.k2r * z2) / P[0]
    start = TRUTH[0] * z3 + TRUTH[1] - alpha1_rate + D2
    assert is_zero(rate(z2) - start - TRUTH[0] / P[0] * (alpha1_rate - P[1] + P[0] * alpha2_s))
    assert not is_zero(rate(z2) - start - TRUTH[0] / P[0] * (alpha1_rate - P[1] + alpha2_s))


def test_regressor_phi_2_is_alpha_2_and_one():
    """`erratum-6-77-phi-2`: z2' depends on the estimation errors through -(alpha_2, 1, 0, 0, 0, 0, 0)."""
    z2, z3 = law().z[1:3]
    remaining = sp.expand(rate(z2) - TRUTH[0] * z3)  # p1 z3 keeps the true p1 in (6.78)
    observed = [sp.diff(remaining, error) for error in P_ERROR]
    assert all(is_zero(o + phi) for o, phi in zip(observed, law().phi2, strict=True)), observed


def test_rate_of_alpha_2_needs_its_own_derivative():
    """`erratum-6-80-alpha-2`: d alpha_2/dx1 in (6.80), where d alpha_1/dx1 is printed."""
    alpha1, alpha2, _ = law().alpha
    x2_rate = rate(X[1])
    rest = partial_t(alpha2) + sp.diff(alpha2, X[1]) * x2_rate + adaptation_term(alpha2)
    assert is_zero(rate(alpha2) - rest - sp.diff(alpha2, X[0]) * X[1])
    assert not is_zero(rate(alpha2) - rest - sp.diff(alpha1, X[0]) * X[1])


def test_6_81_and_6_89_hold_for_constant_robust_gains_only():
    """`erratum-6-81-nonlinear-gains`: with k_2r = kappa z2^2 it misses 2 kappa z2^2/p1^ of (6.81c)."""
    z2 = law().z[1]
    printed = -(K.k1 + K2) / P[0]  # (6.81c)
    assert is_zero(sp.diff(law().alpha[1], X[1]) - printed)

    kappa = sp.Symbol("kappa")
    alpha2 = law().alpha[1].subs(K.k2r, kappa * z2**2)
    missed = sp.diff(alpha2, X[1]) - printed.subs(K.k2r, kappa * z2**2)
    assert is_zero(missed + 2 * kappa * z2**2 / P[0])

    z3 = law().z[2]
    alpha3 = law().alpha[2].subs(K.k3r, kappa * z3**2)
    missed = sp.diff(alpha3, X[2]) - law().alpha3_partials[3].subs(K.k3r, kappa * z3**2)  # (6.89e)
    assert is_zero(missed + 2 * kappa * z3**2)


def test_derivatives_6_81_6_84_and_6_85_are_right():
    """`confirmed-6-81-6-85`: partial derivatives of alpha_2, phi_3, d3~ and z3', for constant gains."""
    alpha2 = law().alpha[1]
    true = (partial_t(alpha2), sp.diff(alpha2, X[0]), sp.diff(alpha2, X[1]))
    assert all(is_zero(a - b) for a, b in zip(true, law().alpha2_partials, strict=True))

    _, z2, z3, z4 = law().z
    d3 = -law().alpha2_partials[2] * D2
    printed = z4 - K3 * z3 - K.k3g2 * z2 - dot(law().phi3, P_ERROR) + d3 - adaptation_term(alpha2)
    assert is_zero(rate(z3) - printed)


# --- third and fourth step --------------------------------------------------------------------------------


def test_time_derivative_of_alpha_3_begins_with_the_fourth_derivative():
    """`erratum-6-89a-derivatives`: y_d'''' first, and k_2g1 y_d''/p1^, where y_d''' and y_d' are printed."""
    _, y1, y2, y3, y4, _ = Y

    def time_derivative(first, last):
        second = (first + K.k1 * y3 + K2 * (y3 + K.k1 * y2) + K.k2g1 * last) / P[0]
        return second + K3 * law().alpha2_partials[0] + K.k3g2 * (y2 + K.k1 * y1)

    true = partial_t(law().alpha[2])
    assert is_zero(true - time_derivative(y4, y2))
    assert not is_zero(true - time_derivative(y3, y1)), "as scanned"
    assert not is_zero(true - time_derivative(y4, y1)), "with the dots of the first term restored"


def test_speed_derivative_of_alpha_3_lacks_two_terms():
    """`erratum-6-89d-speed-derivative`: -k_2g1/p1^ and -k_3g2 are missing; (6.89c), (6.89e) are right."""
    alpha3 = law().alpha[2]
    alpha2_x1, alpha2_x2 = law().alpha2_partials[1:]
    true = sp.diff(alpha3, X[1])
    printed = -K2 * K.k1 / P[0] + K3 * alpha2_x2
    assert is_zero(true - (alpha2_x1 + K3 * alpha2_x2 - K.k3g2))
    assert is_zero(true - printed + K.k2g1 / P[0] + K.k3g2)

    assert is_zero(sp.diff(alpha3, X[0]) - (K3 * alpha2_x1 - K.k3g2 * K.k1))
    assert is_zero(sp.diff(alpha3, X[2]) + K.k1 + K2 + K3)


def z4_rate_less(robust_term, sign):
    """z4' of the closed loop less the last line of (6.92), with d4~ = d~ + sign (d alpha_3/dx2) d2~."""
    _, z2, z3, z4 = law().z
    phi4 = (*law().phi4[:6], BETA_N * U)
    d4 = D + sign * law().alpha3_partials[2] * D2
    feedback = -K.k4g4 * z4 - K.k4g3 * z3 - K.k4g2 * z2 + robust_term
    difference = rate(z4) - (feedback - dot(phi4, P_ERROR) + d4 - adaptation_term(law().alpha[2]))
    return sp.expand(difference).subs(U, law().u)


def test_load_disturbance_enters_6_93b_with_a_minus():
    """`erratum-6-92-sign`: z4' holds with d4~ = d~ - (d alpha_3/dx2) d2~, as (6.84b) has it for z3."""
    robust = -K.k4r * law().z[3]
    assert is_zero(z4_rate_less(robust, -1))
    assert is_zero(z4_rate_less(robust, +1) + 2 * law().alpha3_partials[2] * D2)


def test_robust_term_of_6_90c_enters_undivided():
    """`erratum-6-90-robust-term`: z4' of (6.92) holds with beta_n p7^ alpha_4r, not with alpha_4r."""
    alpha4_r = -K.k4r * law().z[3] / (BETA_N * P[6])
    assert is_zero(z4_rate_less(BETA_N * P[6] * alpha4_r, -1))
    assert not is_zero(z4_rate_less(alpha4_r, -1))


# --- the whole loop ---------------------------------------------------------------------------------------


def test_error_dynamics_need_a_coupling_of_one_and_four_rows():
    """`erratum-6-103-coupling`: z' = A_z z + B dp^/dt - [0; Phi^T p~ - d~], with A_z(3,4) = 1."""
    z = law().z
    phi4 = (*law().phi4[:6], BETA_N * U)
    disturbances = (0, D2, -law().alpha2_partials[2] * D2, D - law().alpha3_partials[2] * D2)
    errors = (0, *(dot(phi, P_ERROR) for phi in (law().phi2, law().phi3, phi4)))
    adaptation = (0, 0, adaptation_term(law().alpha[1]), adaptation_term(law().alpha[2]))

    def residual(i, row):
        expected = dot(row, z) - adaptation[i] - errors[i] + disturbances[i]
        return sp.expand(rate(z[i]) - expected).subs(U, law().u)

    corrected = error_matrix(K, TRUTH[0])
    for i, row in enumerate(corrected):
        assert is_zero(residual(i, row)), f"row {i + 1}"
    assert is_zero(residual(2, [*corrected[2][:3], 0]) - z[3]), "printed: A_z(3,4) = 0"


Z = sp.symbols("z1:5")
A2 = sp.symbols("a22 a23 a24", nonnegative=True)  # |d alpha_2/d p^| |Gamma phi_i|, i = 2, 3, 4
A3 = sp.symbols("a32 a33 a34", nonnegative=True)  # |d alpha_3/d p^| |Gamma phi_i|
S23, S24, S34 = sp.symbols("s23 s24 s34")  # sign(z_i z_j)


def error_power(p1=TRUTH[0]):
    """z^T A_z z less the robust terms, which (6.94) collects in its brackets."""
    robust = K.k2r * Z[1] ** 2 + K.k3r * Z[2] ** 2 + K.k4r * Z[3] ** 2
    return dot(Z, [dot(row, Z) for row in error_matrix(K, p1)]) + robust


def test_6_94_means_k_2g2():
    """`erratum-6-94-k-2g2`: the coefficient of z2^2 outside the brackets; every other term is right."""
    z1, z2, z3, z4 = Z
    others = (
        z1 * z2 - K.k1 * z1**2 + TRUTH[0] * z2 * z3 - K.k2g1 * z1 * z2 + z3 * z4
        - K.k3g3 * z3**2 - K.k3g2 * z2 * z3 - K.k4g4 * z4**2 - K.k4g3 * z3 * z4 - K.k4g2 * z2 * z4
    )  # fmt: skip
    assert is_zero(error_power() - others + K.k2g2 * z2**2)


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
    """`confirmed-6-99-6-101`: -z^T D_z z is the bound, with sign(z_i z_j) z_i z_j for |z_i z_j|."""
    _, z2, z3, z4 = Z
    adaptation = (
        A2[0] * S23 * z2 * z3 + A2[1] * z3**2 + A2[2] * S34 * z3 * z4
        + A3[0] * S24 * z2 * z4 + A3[1] * S34 * z3 * z4 + A3[2] * z4**2
    )  # fmt: skip
    printed = matrix_6_100(K, TRUTH[0], A2, A3, S23, S24, S34)
    assert is_zero(error_power() + adaptation + dot(Z, [dot(row, Z) for row in printed]))


# --- numbers ----------------------------------------------------------------------------------------------

W = 2 * np.pi * 10.5
GAINS = Gains(k1=W, k2g1=1, k2g2=W, k2r=0, k3g2=1, k3g3=W, k3r=0, k4g2=0, k4g3=1, k4g4=W, k4r=0)
BETA = 2.72 / 0.00235
PARAMETERS = np.array([1.0, 0.0, 2718.9, 2059.8, 24982.0, 0.0, 574.05])
SPREAD = np.array([0.1, 4.0, 163.0, 123.0, 1500.0, 13288.0, 35.0])


@cache
def sensitivities():
    """Gradients of alpha_2 and alpha_3 with respect to the estimates, as a function of (x, y, p, k)."""
    gains = list(vars(K).values())
    gradients = [[sp.diff(alpha, p) for p in P] for alpha in law().alpha[1:]]
    return sp.lambdify([X, Y[:5], P, gains], gradients)


def adaptation_norms(x, k, Gamma):
    """|d alpha_j/d p^| |Gamma phi_i| for j = 2, 3 and i = 2, 3, 4, at rest in the reference."""
    S = np.tanh(0.5 * (x[1] + x[3] / BETA))
    at = corrected_backstepping(x, np.zeros(5), PARAMETERS, k, BETA, S)
    gradients = sensitivities()(x, np.zeros(5), PARAMETERS, list(vars(k).values()))
    weights = [np.linalg.norm(Gamma * np.array(phi)) for phi in (at.phi2, at.phi3, at.phi4)]
    return np.outer(np.linalg.norm(gradients, axis=1), weights)


def smallest_eigenvalue(x, k, Gamma):
    """Smallest eigenvalue of D_z over the signs of z_i z_j."""
    a2, a3 = adaptation_norms(x, k, Gamma)
    signs = [(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
    return min(np.linalg.eigvalsh(np.array(matrix_6_100(k, 1.0, a2, a3, *s), float))[0] for s in signs)


def test_no_constant_gain_keeps_d_z_positive_everywhere():
    """`erratum-6-100-local`: D_z > 0 near rest; D_44 loses a term that grows with the square of the state."""
    Gamma = 1e-12 * SPREAD**2
    direction = np.array([0.01, 0.1, 10.0, 100.0])
    assert smallest_eigenvalue(0.01 * direction, GAINS, Gamma) > 0

    for factor in (1, 10, 100):
        k = Gains(**{name: value * (factor if value == W else 1) for name, value in vars(GAINS).items()})
        loss = [adaptation_norms(scale * direction, k, Gamma)[1, 2] for scale in (1e6, 1e7)]
        growth = np.log10(loss[1] / loss[0])
        assert growth == pytest.approx(2.0, abs=0.01), f"observed order {growth:.4f} at gains times {factor}"
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

    no_adaptation = np.zeros(7)
    seconds, milliseconds = (smallest_eigenvalue(np.zeros(4), k, no_adaptation) for k in (GAINS, scaled))
    assert seconds == pytest.approx(W, rel=1e-12), f"observed {seconds:.3f} 1/s"
    assert milliseconds < -0.5, f"observed {milliseconds:.3f} 1/ms"


def test_neither_v_n_nor_the_error_need_vanish():
    """`erratum-6-110-convergence`: at rest wrong p3, p4, p5, p7 stay; under a disturbance z1 stays."""
    error = SPREAD * np.array([0, 0, 0.3, -0.4, 0.2, 0, 0.25])
    at_rest = corrected_backstepping(np.zeros(4), np.zeros(5), PARAMETERS + error, GAINS, BETA, 0.0)
    state_rate = plant(np.zeros(4), at_rest.u, PARAMETERS, 0.0, 0.0, BETA, 0.0)
    tau = dot([np.array(phi, float) for phi in (at_rest.phi2, at_rest.phi3, at_rest.phi4)], at_rest.z[1:])
    assert not any(at_rest.z), "V = 0"
    assert not any(state_rate), "the state stays"
    assert not any(tau), "so do the estimates"
    assert error @ (error / SPREAD**2) > 0, "V_n keeps this value for ever (Gamma = W_p^2)"

    A = np.array(error_matrix(GAINS, 1.0), float)
    assert np.linalg.eigvals(A).real.max() < 0
    d2 = np.array([0, 1, 0, 0])  # d2~ = sin(2 pi t) rad/s^2, parameters known: steady amplitude of z
    amplitude = np.abs(np.linalg.solve(2j * np.pi * np.eye(4) - A, d2))
    cascade = 1 / (GAINS.k1 * GAINS.k2g2 + (2 * np.pi) ** 2)  # two lags of 10.5 Hz at 1 Hz
    assert amplitude[0] == pytest.approx(cascade, rel=1e-3), f"observed {amplitude[0]:.4e} rad"
