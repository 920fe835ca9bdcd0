r"""Laws that a user would try first, and adaptive laws about a quadratic feedback.

The feedback u = -K e makes the reference model, :math:`e_{k+1} = A_me_k`. What the plant does beyond it is
laid to a torque at the motor.

- L1: a predictor runs beside the plant; the torque that takes its error away within one sample, through a
  low-pass, is subtracted. N. Hovakimyan, C. Cao, L1 Adaptive Control Theory, SIAM, 2010, section 3.3.
- MRAC: the torque is a sum of known functions of the reference with unknown factors. With P of the Riccati
  equation :math:`b^TPe` is the feedback itself up to a factor, so that :math:`\dot\theta = \Gamma\varphi
  (-Ke)`, projected on bounds.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import exp, pi

import numpy as np
from scipy.linalg import expm, solve_discrete_are
from scipy.signal import cont2discrete

from cabledrive.control.numbers import LINEAR, REFERENCE_MODEL, LawNumbers, learning_table
from cabledrive.control.reference import (
    AT_ONCE,
    FlatOutput,
    ReferenceNumbers,
    flat_map,
    joint_motion,
    reference_numbers,
)
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain, state_space

FRICTION_SLOPE = 50.0


def feedforward(chain: LumpedChain, flat: FlatOutput, reference: Array) -> Array:
    """Motion of every inertia along the reference and the motor torque it takes, friction included.

    ``flat``: with dampers: the damped inverse; without: the undamped one; of one inertia: the rigid one.
    Returns shape (samples, 2n + 1): angles, speeds, torque [N m].
    """
    states, elastic = joint_motion(flat, reference)
    speed, acceleration = reference[:, -2], reference[:, -1]
    friction = chain.viscous[0] * speed + chain.coulomb[0] * np.tanh(FRICTION_SLOPE * speed)
    torque = chain.inertias[0] * acceleration + elastic + friction - chain.offsets[0]
    return np.column_stack((states, torque))


def feedforward_generator(
    chain: LumpedChain,
    flat: FlatOutput | None,
    interval: float,
    taps: Sequence[tuple[float, float]] = AT_ONCE,
) -> ReferenceNumbers:
    """The generator of the rows of `feedforward`; without a flat output those of one rigid inertia."""
    n = chain.size
    frictionless = replace(chain, coulomb=(0.0,) * n, offsets=(0.0,) * n)
    constant = np.zeros(2 * n + 1)
    constant[2 * n] = -chain.offsets[0]
    times: list[float] = []
    if flat is None:
        table = rigid_feedforward(frictionless, np.eye(2 * n + 1))
    else:
        table, times = feedforward(frictionless, flat, flat_map(flat)), flat.time_constants.tolist()
    friction = [(chain.coulomb[0], FRICTION_SLOPE, 2 * n, n)] if chain.coulomb[0] > 0.0 else []
    return reference_numbers(table.T, times, interval, taps=taps, constant=constant, friction=friction)


def rigid_feedforward(chain: LumpedChain, wanted: Array) -> Array:
    """As `feedforward`, of one rigid inertia; ``wanted``, shape (>= 3, samples): load angle, derivatives."""
    angle, speed, acceleration = wanted[:3]
    torque = rigid_inertia(chain) * acceleration + chain.viscous[0] * speed - chain.offsets[0]
    torque = torque + chain.coulomb[0] * np.tanh(FRICTION_SLOPE * speed)
    return np.column_stack([angle] * chain.size + [speed] * chain.size + [torque])


def rigid_inertia(chain: LumpedChain) -> float:
    """Whole inertia of a chain between equal angles [kg m^2]."""
    return float(sum(chain.inertias))


def pd_law(chain: LumpedChain, bandwidth: float, interval: float) -> LawNumbers:
    r"""PD on the motor's angle, poles of the rigid machine at a bandwidth [Hz]: :math:`J(s + \omega)^2`."""
    j, w, n = rigid_inertia(chain), 2.0 * pi * bandwidth, chain.size
    row = np.zeros((1, 2 * n))
    row[0, 0], row[0, n] = -j * w**2, -2.0 * j * w
    return linear_law(np.zeros((0, 2 * n + 1)), row, interval)


def pid_law(chain: LumpedChain, bandwidth: float, notch: float, interval: float) -> LawNumbers:
    r"""PID on the load's angle, :math:`J(s + \omega)^3` for the rigid machine, with a notch.

    ``bandwidth``, ``notch`` [Hz]; zeros of damping ratio 0.1, poles of 1.
    """
    j, w, n, v = rigid_inertia(chain), 2.0 * pi * bandwidth, chain.size, 2.0 * pi * notch
    notched = (
        np.array([[0.0, 1.0], [-(v**2), -2.0 * v]]),
        np.array([[0.0], [1.0]]),
        np.array([[0.0, -1.8 * v]]),
        np.array([[1.0]]),
    )
    a, b, c, d, _ = cont2discrete(notched, interval, "bilinear")
    error = np.zeros((1, 2 * n))
    error[0, n - 1], error[0, 2 * n - 1] = 3.0 * j * w**2, 3.0 * j * w
    integral = j * w**3
    matrix = np.zeros((3, 3 + 2 * n + 1))
    matrix[0, 0], matrix[0, 3 + n - 1] = 1.0, interval
    matrix[1:, :1], matrix[1:, 1:3], matrix[1:, 3 : 3 + 2 * n] = integral * b, a, b @ error
    row = -np.hstack((integral * d, c, d @ error))
    return linear_law(matrix, row, interval)


def lq_torque(chain: LumpedChain, error: float, bandwidth: float) -> float:
    r"""Torque [N m] that weighs as much as an error [rad], :math:`J\omega^2 e` for a bandwidth [Hz].

    LQ feedback of a double integrator by Bryson's rule has both poles at :math:`\omega`, damping ratio 0.71.
    """
    return rigid_inertia(chain) * (2.0 * pi * bandwidth) ** 2 * error


def lq_law(chain: LumpedChain, error: float, torque: float, interval: float) -> LawNumbers:
    """Linear-quadratic feedback of angles and speeds by Bryson's rule: error [rad] weighs as torque [N m]."""
    n = chain.size
    weight = np.zeros((2 * n, 2 * n))
    weight[n - 1, n - 1] = 1.0 / error**2
    gain = lq_gain(*sampled_motion(chain, interval), weight, 1.0 / torque**2)
    return linear_law(np.zeros((0, 2 * n + 1)), -gain, interval)


def lqi_law(
    chain: LumpedChain, error: float, torque: float, integral_time: float, interval: float
) -> LawNumbers:
    """Linear-quadratic feedback of angles, speeds and the integral of the load's error, by Bryson's rule.

    ``error`` [rad] of the load weighs as much as ``torque`` [N m], and as its integral over ``integral_time``
    [s].
    """
    n = chain.size
    a, b = sampled_motion(chain, interval)
    summed = np.eye(2 * n + 1)  # the integral first: it is the memory of the law
    summed[1:, 1:], summed[0, n] = a, interval
    weight = np.zeros((2 * n + 1, 2 * n + 1))
    weight[n, n], weight[0, 0] = 1.0 / error**2, 1.0 / (error * integral_time) ** 2
    gain = lq_gain(summed, np.vstack(([[0.0]], b)), weight, 1.0 / torque**2)
    return linear_law(integral_memory(n, interval), -gain, interval)


def integral_memory(n: int, interval: float) -> Array:
    """Memory of a law of n inertias that sums the load's error, shape (1, 2n + 2)."""
    matrix = np.zeros((1, 2 * n + 2))
    matrix[0, 0], matrix[0, n] = 1.0, interval
    return matrix


def sampled_motion(chain: LumpedChain, interval: float) -> tuple[Array, Array]:
    """Matrices (2n, 2n), (2n, 1) to angles and speeds one sample on, from these and the torque held."""
    n = chain.size
    a, b = state_space(chain)
    block = np.zeros((2 * n + 1, 2 * n + 1))
    block[: 2 * n, : 2 * n], block[: 2 * n, 2 * n] = a, b[:, 0]
    power = expm(block * interval)
    return power[: 2 * n, : 2 * n], power[: 2 * n, 2 * n :]


def lq_gain(a: Array, b: Array, weight: Array, cost: float) -> Array:
    """Feedback u = -gain x, (1, states), of least sum of x' weight x + cost u^2, by Riccati's equation."""
    value = solve_discrete_are(a, b, weight, np.array([[cost]]))
    return np.asarray(np.linalg.solve(cost + b.T @ value @ b, b.T @ value @ a))


def linear_law(matrix: Array, row: Array, interval: float) -> LawNumbers:
    """Numbers of a linear law, shapes as in `cabledrive.control.numbers.LawNumbers`."""
    return LawNumbers(
        kind=LINEAR,
        matrix=matrix,
        rows=row,
        learning=np.zeros((5, 0)),
        scalars=np.array([interval, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
    )


def l1_law(chain: LumpedChain, error: float, torque: float, bandwidth: float, interval: float) -> LawNumbers:
    """Quadratic feedback with L1 adaptation, which is a linear law: memory of predictor and low-pass.

    ``error`` [rad] and ``torque`` [N m] weigh the same; ``bandwidth``: of the low-pass [Hz].
    """
    n2 = 2 * chain.size
    a, b = sampled_motion(chain, interval)
    gain = -lq_law(chain, error, torque, interval).rows
    model = a - b @ gain
    seen = -b[:, 0] / float(b[:, 0] @ b[:, 0])  # torque at the motor per error of the prediction
    newest = 1.0 - exp(-2.0 * pi * bandwidth * interval)
    # Memory: predicted errors, then the low-passed torque; inputs: memory, errors, last command. What the
    # prediction misses, matched or not, is given to the predictor at once: it starts from the errors anew.
    matrix = np.zeros((n2 + 1, 2 * n2 + 2))
    matrix[:n2, n2] = -b[:, 0]
    matrix[:n2, n2 + 1 : 2 * n2 + 1] = model
    matrix[n2, :n2], matrix[n2, n2] = newest * seen, 1.0 - newest
    matrix[n2, n2 + 1 : 2 * n2 + 1] = -newest * seen
    row = np.hstack((np.zeros((1, n2)), [[-1.0]], -gain))
    return linear_law(matrix, row, interval)


def reference_model_law(
    feedback: LawNumbers, low: Array, high: Array, largest: Array, rate: float
) -> LawNumbers:
    """Direct MRAC about a feedback without memory.

    ``low``, ``high``, shape (p,): bounds of the factors; ``largest``, shape (p,): largest values of the
    functions along the reference; ``rate``: at which the torque adapts where all functions are at their
    largest [rad/s], in a loop whose feedback answers a torque by itself.
    """
    width = np.maximum(high - low, 0.0)
    gain = rate * width**2 / max(float((width * largest) @ (width * largest)), 1e-300)
    return feedback._replace(
        kind=REFERENCE_MODEL, learning=learning_table(np.zeros(len(low)), low, high, gain)
    )


def reference_model_generator(chain: LumpedChain, flat: FlatOutput, interval: float) -> ReferenceNumbers:
    """The generator of the feedforward's row with the four functions that carry the motor's parameters.

    These are acceleration, speed w and tanh(K w) of the motor along the reference, and 1.
    """
    plain, rows = feedforward_generator(chain, flat, interval), flat_map(flat)
    width, before = len(rows), len(plain.output)
    functions = np.zeros((4, plain.output.shape[1]))
    functions[:2, -width:] = rows[:, [-1, -2]].T  # of the last stage, whose filters have been passed
    sign = np.array([[1.0, FRICTION_SLOPE]]), np.array([[before + 2, before + 1]])
    return plain._replace(
        output=np.vstack((plain.output, functions)),
        constant=np.concatenate((plain.constant, [0.0, 0.0, 0.0, 1.0])),
        friction=np.vstack((plain.friction, sign[0])),
        places=np.vstack((plain.places, sign[1])),
    )
