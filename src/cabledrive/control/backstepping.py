r"""Backstepping: for a rigid joint and a flexible cable, for a whole chain, and what its theorem asks.

The law is `cabledrive.control.backstepping_recursion`. Of two inertias, with :math:`x_1 = \theta_2`,
:math:`x_2 = \dot\theta_2`, :math:`\bar x_3 = \beta_n(\theta_1 - \theta_2)`, :math:`\bar x_4`, the seven
parameters follow (6.69). Of three, with :math:`x_3 = S_1(\theta_{12} - \theta_2)`, :math:`x_5 =
S_2(\theta_{11} - \theta_{12})` and their rates, :math:`S_1 = k_k/J_2`, :math:`S_2 = S_1k_m/J_{12}`:

.. math::
    \dot x_2 &= p_1x_3 + p_2 + w_1, \qquad
    \dot x_4 = p_3x_5 - p_4x_3 - S_1p_2 + w_2, \\
    \dot x_6 &= S_2p_{10}u - p_5x_5 + p_6x_3 - p_7\dot\theta_{11} - p_8S + p_9 + w_3

:math:`w_j`, what the dampers add, is taken along the reference with its derivatives. With signs :math:`s_i`
of the errors,

.. math::
    D_z = -\tfrac12(A + A^T) - \tfrac12(S + S^T), \qquad
    S_{ij} = s_is_j\Big|\frac{\partial\alpha_{i-1}}{\partial\hat p}\Big|\,|\Gamma\varphi_j|

must be positive definite for every choice of signs. As printed it adds errors of different units. Derivatives
are taken by complex steps, exact to round-off.
"""

from itertools import product
from math import isfinite, pi
from typing import Any

import numpy as np

from cabledrive.control import numbers
from cabledrive.control.backstepping_recursion import backstepping_steps, parts_of, signal_count, work_shape
from cabledrive.control.darc import printed_bounds
from cabledrive.control.numbers import LawNumbers
from cabledrive.control.reference import ReferenceNumbers, reference_numbers
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain

PRINTED_HZ = 10.5
SMOOTH = 0.5
# Table 6.3 over its own nominal values, p5 and p7 corrected; p2 and p6 are not printed.
_SHARES = {1: 0.05, 3: 0.03, 4: 0.03, 5: 0.03, 7: 0.03}
_LOAD_ACCELERATION = 2.0  # rad/s^2
_MOTOR_TORQUE = 0.01  # N m


def unmatched_parameters(chain: LumpedChain) -> tuple[Array, Array, float]:
    """The seven parameters of (6.69), their half widths after Table 6.3, and beta_n [1/s^2], of Model 3."""
    j1, j2 = chain.inertias
    beta = chain.stiffness[0] / j2
    scale = beta / j1
    parameters = np.array(
        [
            1.0,
            0.0,
            chain.stiffness[0] / j1 + beta,
            chain.viscous[0] * scale,
            chain.coulomb[0] * scale,
            chain.offsets[0] * scale,
            1.0 / j1,
        ]
    )
    widths = np.array([_SHARES.get(i, 0.0) for i in range(1, 8)]) * parameters
    widths[1], widths[5] = _LOAD_ACCELERATION, _MOTOR_TORQUE * scale
    return parameters, widths, beta


REFERENCE_SLOPE = 50.0

# Relative half widths of stiffnesses and inertias: cable, load, joint, drive pulley.
_CABLE, _LOAD, _JOINT, _PULLEY = 0.05, 0.05, 0.10, 0.05


def chain_scales(chain: LumpedChain) -> tuple[float, float]:
    """S_1 [1/s^2] and S_2 [1/s^4], which give the virtual controls gain one, of three inertias, Model 4."""
    s1 = chain.stiffness[1] / chain.inertias[2]
    return s1, s1 * chain.stiffness[0] / chain.inertias[1]


def chain_parameters(chain: LumpedChain) -> tuple[Array, Array]:
    """The ten parameters and their half widths, of three inertias between equal angles, Model 4."""
    s2 = chain_scales(chain)[1]
    motor, pulley, load = chain.inertias
    joint, cable = chain.stiffness
    bounds = printed_bounds(chain, flexible_joint=True)
    inertia, friction = bounds.spread[0] / (2.0 * motor), bounds.spread[1:] / 2.0 * s2 / motor
    matched = np.array([chain.viscous[0], chain.coulomb[0], chain.offsets[0]]) * s2 / motor
    parameters = np.array(
        [
            1.0,
            chain.offsets[2] / load,
            1.0,
            cable / pulley + cable / load,
            joint / motor + joint / pulley,
            joint * cable / pulley**2,
            *matched,
            1.0 / motor,
        ]
    )
    shares = np.array(
        [
            _CABLE + _LOAD,
            0.0,
            _JOINT + _PULLEY,
            _CABLE + _LOAD,
            _JOINT + inertia,
            _CABLE + _JOINT + 2.0 * _PULLEY,
            0.0,
            0.0,
            0.0,
            inertia,
        ]
    )
    widths = shares * parameters
    widths[1] = _LOAD_ACCELERATION
    widths[6:9] = friction + inertia * np.abs(matched)
    return parameters, widths


def chain_generator(chain: LumpedChain, interval: float) -> ReferenceNumbers:
    r"""The generator of what the law of six states takes at each sample.

    Along it :math:`x_3 = \ddot y_d/D_2`, :math:`x_5 = S_1(1 + J_2/J_{12})\ddot y_d/D_1 + y_d^{(4)}/(D_1D_2)`.
    Rows, (17,): y_d to its sixth derivative, w1 to its fourth, w2 to its second, w3, motor speed.
    """
    joint, cable = (d / k for d, k in zip(chain.damping, chain.stiffness, strict=True))
    wanted, cabled, jointed, both = np.split(np.eye(28), 4)  # and through the lags of cable, joint, both
    s1, s2 = chain_scales(chain)
    motor, pulley, load = chain.inertias
    x3 = cabled[2:]
    x5 = s1 * (1.0 + load / pulley) * jointed[2:5] + both[4:]
    p4 = chain.stiffness[1] / pulley + s1
    w1 = wanted[2:] - x3
    w2 = x3[2:] - x5 + p4 * x3[:3]
    joint_torque = chain.damping[0] * x5[1] / s2
    cable_torque = chain.damping[1] * x3[1] / s1
    w3 = s2 * (cable_torque / pulley - joint_torque * (1.0 / motor + 1.0 / pulley))
    speed = wanted[1] + x3[1] / s1 + x5[1] / s2
    output = np.vstack((wanted, w1, w2, w3, speed))
    return reference_numbers(output, (cable, joint, cable), interval, sources=(0, 0, 2))


def backstepping_numbers(
    chain: LumpedChain, bandwidth: float, adaptation: float, interval: float
) -> LawNumbers:
    """Freeze the law of four states, Model 3, or six, Model 4; ``adaptation``: gamma of (6.36), 0: none.

    ``bandwidth`` [Hz]: of every step, above 0. Cross gains are 1, the last one 0: nearly triangular (6.103).
    """
    if not isfinite(bandwidth) or bandwidth <= 0.0:
        raise InputRefused(f"bandwidth = {bandwidth:.6g} Hz must be finite and above 0: errors grow")
    if chain.size == 2:
        parameters, widths, beta = unmatched_parameters(chain)
        scales: tuple[float, ...] = (beta,)
        more = (SMOOTH, 0.0, 0.0, 1.0, beta)
    else:
        (parameters, widths), scales = chain_parameters(chain), chain_scales(chain)
        more = (REFERENCE_SLOPE, 1.0, 0.0, 1.0, 0.0)
    learning = numbers.learning_table(
        parameters, parameters - widths, parameters + widths, adaptation * (2.0 * widths) ** 2
    )
    return LawNumbers(
        kind=numbers.BACKSTEPPING,
        matrix=2.0 * pi * bandwidth * np.eye(2 * chain.size) + np.eye(2 * chain.size, k=-1),
        rows=np.array([scales]),
        learning=learning,
        scalars=np.array([interval, 0.0, *more]),
    )


STEP = 1e-30


def errors_matrix(law: LawNumbers, estimate: Array, size: int) -> Array:
    """A of the errors' dynamics of 4 or 6 states with fixed estimates, (size, size), Eq. (6.103)."""
    matrix = np.diag(np.ones(size - 1), 1) - law.matrix
    for place in range(1, size - 1, 2):
        matrix[place, place + 1] = estimate[place - 1]
    return matrix


def scaled_states(law: LawNumbers, states: Array) -> Array:
    """States x of the law, (2n,), from angles and speeds, (2n,), from the motor to the load."""
    n = len(states) // 2
    x = np.empty(2 * n)
    x[0], x[1] = states[n - 1], states[2 * n - 1]
    for j in range(1, n):
        scale = law.rows[0, j - 1]
        x[2 * j] = scale * (states[n - 1 - j] - states[n - j])
        x[2 * j + 1] = scale * (states[2 * n - 1 - j] - states[2 * n - j])
    return x


def fixed_row(law: LawNumbers, size: int) -> list[float]:
    """Command per angle and speed of a law that adapts, estimates fixed, no Coulomb friction and offset."""
    estimate = law.learning[numbers.NOMINAL].copy()
    if law.kind == numbers.DARC:
        surface, elastic, inertial = law.rows
        rate = inertial[:size] - inertial[size] * np.append(0.0, surface[: size - 1])
        row = (elastic[:size] + estimate[0] * rate - law.k_sigma * surface[:size]) @ law.matrix
        row[size // 2] += estimate[1]
        return row.tolist()
    estimate[-3:-1] = 0.0  # Coulomb friction and offset, before the gain of the input
    signals = np.zeros(signal_count(size // 2, bool(law.scalars[numbers.BY_REFERENCE])))

    def command(states: Array) -> float:
        x, speed = scaled_states(law, states), states[size // 2]
        return float(backstepping_step(law, estimate, x, signals, speed, 0.0)[0])

    return [command(unit) - command(np.zeros(size)) for unit in np.eye(size)]


def backstepping_step(
    law: LawNumbers, p: Any, x: Any, signals: Any, speed: Any, friction: Any
) -> tuple[Any, Any, Any, Any]:
    r"""Step of a law from its scaled states, in floats, complex or other numbers, see `backstepping_steps`.

    .. math::
        \varphi_i = R_i - \sum_j\frac{\partial\alpha_{i-1}}{\partial x_{2j}}R_j

    All that its proof needs: u, z (2n,), alpha (2n - 1,), phi (2n, p).
    """
    n, known = len(x) // 2, bool(law.scalars[numbers.BY_REFERENCE])
    table = np.zeros(work_shape(n), dtype=np.result_type(np.asarray(p), np.asarray(x), np.asarray(signals)))
    rows, rates, regressors, _, z = parts_of(table, n)
    given = (known, p, x, signals, speed, friction)
    u = backstepping_steps(n, law.matrix, law.rows[0], *given, rows, rates, regressors, z)
    own = np.zeros((2 * n, 3 * n + 1), dtype=table.dtype)
    own[1::2] = regressors[:, : 3 * n + 1]
    phi = own.copy()
    for i in range(1, 2 * n):
        for j in range(i // 2):
            phi[i] -= rows[i, 2 * j + 1] * own[2 * j + 1]
    if not known:
        phi[1, 0] = x[2] - z[2]  # (6.77), mended: the virtual control in place of the state
    return u, z, x[1:] - z[1:], phi


def stability_margin(law: LawNumbers, estimate: Array, states: Array, reference: Array) -> float:
    """Smallest eigenvalue [rad/s] of D_z over all signs at a state; above 0 Eq. (6.100) holds there."""
    size = len(states)
    x, speed = scaled_states(law, states), states[size // 2]
    signals = reference[:-1] if law.scalars[numbers.BY_REFERENCE] else reference[: size + 1]
    turning = reference[-1] if law.scalars[numbers.BY_REFERENCE] else speed
    friction = np.tanh(law.scalars[numbers.SLOPE] * turning)
    given = (x, signals, speed, friction)
    *_, phi = backstepping_step(law, estimate, *given)
    slopes = np.zeros((size, len(estimate)))
    for m in range(len(estimate)):
        moved = estimate.astype(complex)
        moved[m] += 1j * STEP * abs(estimate[m] or 1.0)
        _, _, virtual, _ = backstepping_step(law, moved, *given)
        slopes[1:, m] = virtual.imag / (STEP * abs(estimate[m] or 1.0))
    learnt = np.linalg.norm(phi * law.learning[numbers.GAIN], axis=1)
    coupling = np.outer(np.linalg.norm(slopes, axis=1), learnt)
    fixed = errors_matrix(law, estimate, size)
    worst = np.inf
    for signs in product((1.0, -1.0), repeat=size - 1):
        s = np.array([1.0, *signs])
        matrix = fixed + coupling * np.outer(s, s)
        worst = min(worst, float(np.linalg.eigvalsh(-0.5 * (matrix + matrix.T))[0]))
    return worst
