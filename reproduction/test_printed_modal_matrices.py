"""The modal matrices (3.13), (3.20), (3.26), (3.38) against finite elements that know nothing of sines.

The elements are Lagrange polynomials of degree 12 on the Gauss-Lobatto points, with consistent mass; their
lowest frequencies are right to about ten digits.
"""

import numpy as np
import pytest
import sympy as sp
from numpy.polynomial import legendre
from scipy.linalg import eigh
from scipy.optimize import brentq

EA, RADIUS = 2.6e9 * 4.26e-7, 0.03  # Table 3.1
STRETCH = 1 + 5.0 / EA
LE, RHO, MODULUS = STRETCH, 4.9e-4 / STRETCH, EA * STRETCH
C_U = np.sqrt(MODULUS / RHO)
J1, J2 = 0.0011, 7.316e-6
M1, M2 = J1 / RADIUS**2, J2 / RADIUS**2
CARRIAGES = (3 * 2 * LE * RHO, 0.7 * 2 * LE * RHO)
MODES = 8


def element(degree=12):
    """Mass and stiffness of a bar element on [-1, 1] with unit density and modulus."""
    last = np.zeros(degree + 1)
    last[degree] = 1.0
    nodes = np.r_[-1.0, np.sort(legendre.legroots(legendre.legder(last))), 1.0]
    points, weights = legendre.leggauss(degree + 2)
    to_nodes = np.linalg.inv(legendre.legvander(nodes, degree))
    slopes = [legendre.legval(points, legendre.legder(row)) for row in np.eye(degree + 1)]
    values, slopes = legendre.legvander(points, degree) @ to_nodes, np.array(slopes).T @ to_nodes
    return values.T * weights @ values, slopes.T * weights @ slopes


def element_frequencies(spans, masses):
    """Elastic frequencies [rad/s] of spans (from, to, length) between joints with point masses."""
    mass, stiffness = element()
    inner = mass.shape[0] - 2
    size = len(masses) + len(spans) * (2 * inner + 1)
    m, k, free = np.diag(np.r_[masses, np.zeros(size - len(masses))]), np.zeros((size, size)), len(masses)
    for start, end, length in spans:
        nodes = [start, *range(free, free + 2 * inner + 1), end]
        free += 2 * inner + 1
        for half in (nodes[: inner + 2], nodes[inner + 1 :]):
            block = np.ix_(half, half)
            m[block] += RHO * length / 4 * mass
            k[block] += MODULUS * 4 / length * stiffness
    return np.sqrt(eigh(k, m, eigvals_only=True)[1 : MODES + 2])


def loop_3_13(omega):
    s, c = np.sin(omega * LE / C_U), np.cos(omega * LE / C_U)
    m1, m2 = omega * M1 / (C_U * RHO), omega * M2 / (C_U * RHO)
    return np.array([[m1, s, 1, -c], [s, m2, -c, 1], [1, -c, 0, -s], [-c, 1, -s, 0]])


def loop_with_carriage_3_20(omega):
    (s1, s2, se), (c1, c2, ce) = trig(omega, 0.3 * LE, 0.7 * LE, LE)
    m, m1, m2 = (omega * x / (C_U * RHO) for x in (CARRIAGES[0], M1, M2))
    return np.array(
        [
            [s1, m, 0, -c1, 1, 0],
            [m1, 0, se, 1, 0, -ce],
            [0, s2, m2, 0, -c2, 1],
            [1, 0, -ce, 0, 0, -se],
            [0, -c2, 1, 0, -s2, 0],
            [-c1, 1, 0, -s1, 0, 0],
        ]
    )


def open_line_3_26(omega):
    (s1, s2), (c1, c2) = trig(omega, 0.3 * LE, 0.7 * LE)
    m, m1, m2 = (omega * x / (C_U * RHO) for x in (CARRIAGES[0], M1, M2))
    return np.array([[s1, m, -c1, 1], [m1, 0, 1, 0], [0, -m2 * c2 - s2, 0, -m2 * s2 + c2], [c1, -1, s1, 0]])


def loop_with_two_carriages_3_38(omega):
    """Rows 3 and 4 with J omega/(c_u rho r^2); the scanned text has J omega/(c_1 rho_1^2) there."""
    (s1, s2, s3, s4), (c1, c2, c3, c4) = trig(omega, 0.3 * LE, 0.7 * LE, 0.45 * LE, 0.55 * LE)
    ma, mb, m1, m2 = (omega * x / (C_U * RHO) for x in (*CARRIAGES, M1, M2))
    return np.array(
        [
            [s1, ma, 0, 0, -c1, 1, 0, 0],
            [0, 0, s3, mb, 0, 0, -c3, 1],
            [m1, 0, 0, s4, 1, 0, 0, -c4],
            [0, s2, m2, 0, 0, -c2, 1, 0],
            [1, 0, 0, -c4, 0, 0, 0, -s4],
            [0, -c2, 1, 0, 0, -s2, 0, 0],
            [-c1, 1, 0, 0, -s1, 0, 0, 0],
            [0, 0, -c3, 1, 0, 0, -s3, 0],
        ]
    )


def trig(omega, *lengths):
    x = omega * np.array(lengths) / C_U
    return np.sin(x), np.cos(x)


CASES = {
    "3.13": (loop_3_13, [(0, 1, LE), (1, 0, LE)], [M1, M2]),
    "3.20": (
        loop_with_carriage_3_20,
        [(0, 2, 0.3 * LE), (2, 1, 0.7 * LE), (1, 0, LE)],
        [M1, M2, CARRIAGES[0]],
    ),
    "3.26": (open_line_3_26, [(0, 2, 0.3 * LE), (2, 1, 0.7 * LE)], [M1, M2, CARRIAGES[0]]),
    "3.38": (
        loop_with_two_carriages_3_38,
        [(0, 2, 0.3 * LE), (2, 1, 0.7 * LE), (1, 3, 0.45 * LE), (3, 0, 0.55 * LE)],
        [M1, M2, *CARRIAGES],
    ),
}


def zeros(matrix, top):
    """All sign changes of the determinant below ``top`` on a fine grid, refined [rad/s]."""
    grid = np.linspace(top / 4000, top, 4001)
    values = [np.linalg.det(matrix(omega)) for omega in grid]
    change = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
    return np.array(
        [brentq(lambda w: np.linalg.det(matrix(w)), grid[i], grid[i + 1], xtol=1e-9) for i in change]
    )


@pytest.mark.parametrize("case", CASES)
def test_modal_matrix_is_singular_exactly_at_the_finite_element_frequencies(case):
    """`confirmed-3-13-modal-matrices`, `erratum-3-38-inertia-entries`: the same zeros, no more, no less."""
    matrix, spans, masses = CASES[case]
    *omega, beyond = element_frequencies(spans, masses)
    found = zeros(matrix, (omega[-1] + beyond) / 2)
    assert found.size == MODES, f"zeros {found / (2 * np.pi)} Hz, elements {np.array(omega) / (2 * np.pi)} Hz"
    np.testing.assert_allclose(found, omega, rtol=1e-9)


def test_scanned_inertia_entry_of_3_38_is_not_a_number():
    """`erratum-3-38-inertia-entries`: J omega/(c rho^2) keeps the unit m^3/kg; with rho r^2 none is left."""
    unit = {
        "J": (1, 2, 0),
        "omega": (0, 0, -1),
        "c": (0, 1, -1),
        "rho": (1, -1, 0),
        "r": (0, 1, 0),
    }  # kg, m, s

    def unit_of(**powers):
        return tuple(sum(power * unit[name][i] for name, power in powers.items()) for i in range(3))

    assert unit_of(J=1, omega=1, c=-1, rho=-2) == (-1, 3, 0)
    assert unit_of(J=1, omega=1, c=-1, rho=-1, r=-2) == (0, 0, 0)


def test_matrices_follow_from_boundary_conditions_with_the_stretched_rigidity():
    """`erratum-3-16-rigidity`: the matrices have EA(1+eps0)/c_u = c_u rho; with EA, masses weigh too much.

    EA u' = J/r^2 u'' is J(1+eps0)/r^2 in (3.13), so the lowest frequency falls by nearly eps0/2.
    """
    ea, eps0, rho = sp.symbols("EA epsilon_0 rho", positive=True)
    c_u = sp.sqrt(ea * (1 + eps0) / rho)
    assert sp.simplify(ea * (1 + eps0) / c_u - c_u * rho) == 0
    assert sp.simplify(ea / c_u - c_u * rho / (1 + eps0)) == 0

    def with_ea(omega):
        matrix = loop_3_13(omega)
        matrix[[0, 1], [0, 1]] *= STRETCH
        return matrix

    ratio = zeros(with_ea, 600.0)[0] / zeros(loop_3_13, 600.0)[0]
    assert ratio == pytest.approx(1 - (STRETCH - 1) / 2, abs=2e-4), f"ratio {ratio:.6f}"


def test_load_pulley_of_the_open_line_hangs_on_the_end_of_span_2():
    """`erratum-3-22-load-pulley`: J2/r2^2 u2''(L2) = -EA u2'(L2) gives (3.25c) and row 3 of (3.26).

    The printed (3.22c) names a span 3, which the open line does not have; read at the end of span 2 it has
    the wrong sign, and the zeros are then no frequencies of the line.
    """
    omega, x, a2, b2, mass, modulus, c = sp.symbols("omega x a_2 b_2 m K c_u", positive=True)
    shape = a2 * sp.cos(omega * x / c) + b2 * sp.sin(omega * x / c)
    condition = -(omega**2) * mass * shape + modulus * shape.diff(x)
    slope = omega / c * (-a2 * sp.sin(omega * x / c) + b2 * sp.cos(omega * x / c))
    assert sp.simplify(condition + (mass * omega**2 * shape - modulus * slope)) == 0  # (3.25c)

    def with_printed_sign(frequency):
        matrix = open_line_3_26(frequency)
        (s2,), (c2,) = trig(frequency, 0.7 * LE)
        m2 = frequency * M2 / (C_U * RHO)
        matrix[2] = [0, -m2 * c2 + s2, 0, -m2 * s2 - c2]
        return matrix

    _, spans, masses = CASES["3.26"]
    true = element_frequencies(spans, masses)
    wrong = zeros(with_printed_sign, true[-1])
    gap = np.abs(wrong[0] / true - 1).min()
    assert gap > 1e-2, (
        f"lowest zero {wrong[0] / (2 * np.pi):.3f} Hz, true frequencies {true[:3] / (2 * np.pi)} Hz"
    )
