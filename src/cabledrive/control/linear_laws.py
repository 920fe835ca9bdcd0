r"""Laws that a user would try first, and adaptive laws about a quadratic feedback.

The feedback u = -K e makes the reference model, :math:`e_{k+1} = A_me_k`. What the plant does beyond it is
laid to a torque at the motor.

- L1: the torque that takes a predictor's error away within one sample, through a low-pass, is subtracted.
  N. Hovakimyan, C. Cao, L1 Adaptive Control Theory, SIAM, 2010, section 3.3.
- MRAC: a sum of known functions of the reference with unknown factors. With P of the Riccati equation
  :math:`b^TPe` is the feedback up to a factor: :math:`\dot\theta = \Gamma\varphi(-Ke)`, within bounds.
- H-infinity: of :math:`\dot x = Ax + B_1w + B_2u` with the cost :math:`|Qx|^2 + |ru|^2 - \gamma^2|w|^2` the
  feedback is :math:`u = -r^{-2}B_2^TXx`, X the stabilizing solution of a Riccati equation with an indefinite
  quadratic term. J. C. Doyle et al., IEEE Trans. Automatic Control 34, 831-847, 1989.
"""

from collections.abc import Sequence
from math import exp, pi, sqrt

import numpy as np
from scipy.linalg import solve_continuous_are
from scipy.signal import cont2discrete

from cabledrive.control import reference as target
from cabledrive.control.numbers import LINEAR, REFERENCE_MODEL, LawNumbers, learning_table
from cabledrive.control.observers import ROUND_OFF, riccati
from cabledrive.parameters import NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain, held, state_space

FRICTION_SLOPE = 50.0


def feedforward_generator(
    chain: LumpedChain,
    flat: target.FlatOutput | None,
    interval: float,
    taps: Sequence[tuple[float, float]] = target.AT_ONCE,
) -> target.ReferenceNumbers:
    """The motion of every inertia and the motor torque that it takes, friction included: rows (2n + 1,).

    ``flat``: with dampers: the damped inverse; without: the undamped one; none: one rigid inertia.
    """
    n = chain.size
    constant = np.zeros(2 * n + 1)
    constant[2 * n] = -chain.offsets[0]
    times: list[float] = []
    if flat is None:
        angle, speed, acceleration = np.eye(2 * n + 1)[:3]
        states, torque = np.array([angle] * n + [speed] * n).T, rigid_inertia(chain) * acceleration
    else:
        rows, times = target.flat_map(flat), flat.time_constants.tolist()
        (states, elastic), speed = target.joint_motion(flat, rows), rows[:, -2]
        torque = chain.inertias[0] * rows[:, -1] + elastic
    table = np.column_stack((states, torque + chain.viscous[0] * speed))
    friction = [(chain.coulomb[0], FRICTION_SLOPE, 2 * n, n)] if chain.coulomb[0] > 0.0 else []
    made = target.reference_numbers(table.T, times, interval, taps=taps, friction=friction)
    return made._replace(constant=constant)


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
    r"""PID on the load's angle, :math:`J(s + \omega)^3` of the rigid machine, with a notch, both in [Hz]."""
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
    """LQ feedback with the integral of the load's error: error [rad], torque [N m], over a time [s]."""
    summed = with_integral(*sampled_motion(chain, interval), (1.0, interval), error, integral_time)
    return linear_law(integral_memory(chain.size, interval), -lq_gain(*summed, 1.0 / torque**2), interval)


def with_integral(
    a: Array, b: Array, row: tuple[float, float], error: float, integral_time: float
) -> tuple[Array, Array, Array]:
    """Matrix and inputs with the integral of the load's angle first, from itself and that, and weight."""
    n = len(a) // 2
    system, weight = np.zeros((2, 2 * n + 1, 2 * n + 1))
    system[0, [0, n]], system[1:, 1:] = row, a
    weight[n, n], weight[0, 0] = 1.0 / error**2, 1.0 / (error * integral_time) ** 2
    return system, np.vstack((np.zeros((1, b.shape[1])), b)), weight


def integral_memory(n: int, interval: float) -> Array:
    """Memory of a law of n inertias that sums the load's error, shape (1, 2n + 2)."""
    matrix = np.zeros((1, 2 * n + 2))
    matrix[0, 0], matrix[0, n] = 1.0, interval
    return matrix


def sampled_motion(chain: LumpedChain, interval: float) -> tuple[Array, Array]:
    """Matrices (2n, 2n), (2n, 1) to angles and speeds one sample on, from these and the torque held."""
    a, b = state_space(chain)
    transition, push = held(a, b[:, 0], interval)
    return transition, push[:, None]


def lq_gain(a: Array, b: Array, weight: Array, cost: float) -> Array:
    """Feedback u = -gain x, (1, states), of least sum of x' weight x + cost u^2, by Riccati's equation."""
    value = riccati(a, b, weight, np.array([[cost]]))
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
    """Quadratic feedback with L1 adaptation, a linear law with predictor and low-pass of a bandwidth [Hz]."""
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
    """Direct MRAC about a feedback without memory; ``low``, ``high``, (p,): bounds of the factors.

    ``rate`` [rad/s] of the torque where all functions are at their ``largest`` (p,) along the reference.
    """
    width = np.maximum(high - low, 0.0)
    gain = rate * width**2 / max(float((width * largest) @ (width * largest)), 1e-300)
    table = learning_table(np.zeros(len(low)), low, high, gain)
    return feedback._replace(kind=REFERENCE_MODEL, learning=table)


def reference_model_generator(
    chain: LumpedChain, flat: target.FlatOutput, interval: float
) -> target.ReferenceNumbers:
    """The feedforward's row with motor acceleration, speed w, tanh(K w) along the reference, and 1."""
    plain, rows = feedforward_generator(chain, flat, interval), target.flat_map(flat)
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


MARGIN = 1.05
"""Over the least gain that has a solution, where the feedback would grow without bound."""
STEPS = 40


def hinf_law(
    chain: LumpedChain,
    error: float,
    torque: float,
    disturbance: float,
    integral_time: float,
    interval: float,
) -> LawNumbers:
    """H-infinity feedback of angles, speeds and the integral over ``integral_time`` [s] of the load's error.

    ``error`` [rad] weighs as much as ``torque`` [N m]; ``disturbance`` [N m] at motor and load as 1.
    """
    system, inputs, weight = with_integral(*state_space(chain), (0.0, 1.0), error, integral_time)
    by_disturbance = disturbance * inputs[:, [0, -1]]
    gain, _ = hinf_gain(system, by_disturbance, inputs[:, :1], weight, 1.0 / torque**2)
    return linear_law(integral_memory(chain.size, interval), -gain, interval)


def hinf_gain(
    a: Array, by_disturbance: Array, by_torque: Array, weight: Array, cost: float
) -> tuple[Array, float]:
    """Feedback u = -gain x near the least worst-case gain, by bisection, and that gain, or `NotComputed`."""
    scaled, back = _scaled(a, by_disturbance, by_torque, weight, cost)
    low, high = 0.0, 1.0
    while _solution(*scaled, high) is None:
        low, high = high, 4.0 * high
        if high > 1e12:
            raise NotComputed("the H-infinity problem has no solution: the motor does not move every state")
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        solved = _solution(*scaled, middle) is not None
        low, high = (low, middle) if solved else (middle, high)
    gamma, found = high, None
    while found is None and gamma < 2.0 * high:  # near the least one round-off may refuse it
        gamma *= MARGIN
        found = _solution(*scaled, gamma)
    if found is None:
        raise NotComputed(f"the H-infinity problem has no solution at a gain of {gamma:.4g}")
    gain = scaled[2].T @ found @ back / sqrt(cost)
    if np.linalg.eigvals(a - by_torque @ gain).real.max() >= 0.0:
        raise NotComputed("round-off leaves the H-infinity feedback without a stable loop")
    return gain, gamma


def _scaled(
    a: Array, by_disturbance: Array, by_torque: Array, weight: Array, cost: float
) -> tuple[tuple[Array, Array, Array, Array, float], Array]:
    """The same problem in units in which each state alone costs 1 without disturbance; units by old states.

    Angles, speeds and an integral differ by orders of magnitude: in them round-off hides that a solution
    exists, and gives some that are none. The cost of a torque is 1 after it.
    """
    unit = np.ones(a.shape[0])
    torque = by_torque / sqrt(cost)
    for _ in range(2):  # the first in units that are bad themselves
        scaled = (a * np.outer(unit, 1 / unit), unit[:, None] * torque, weight / np.outer(unit, unit))
        try:
            free = np.diag(solve_continuous_are(*scaled, np.eye(1)))
        except (np.linalg.LinAlgError, ValueError) as refusal:
            raise NotComputed("the H-infinity problem has no solution without disturbance") from refusal
        unit = unit * np.sqrt(np.where(free > 0.0, free, 1.0))
    change = np.outer(unit, 1 / unit)
    weight = weight / np.outer(unit, unit)
    return (a * change, unit[:, None] * by_disturbance, unit[:, None] * torque, weight, 1.0), np.diag(unit)


def _solution(
    a: Array, by_disturbance: Array, by_torque: Array, weight: Array, cost: float, gamma: float
) -> Array | None:
    """Stabilizing solution X of the Riccati equation, none where it does not exist or is not positive."""
    inputs = np.hstack((by_disturbance, by_torque))
    signed = np.diag([-(gamma**2)] * by_disturbance.shape[1] + [cost])
    try:
        x = np.asarray(solve_continuous_are(a, inputs, weight, signed), dtype=np.float64)
    except (np.linalg.LinAlgError, ValueError):
        return None
    pull = np.linalg.solve(signed, inputs.T @ x)
    terms = (a.T @ x, x @ a, -x @ inputs @ pull, weight)
    if np.abs(sum(terms)).max() > ROUND_OFF * max(np.abs(term).max() for term in terms):
        return None
    closed = a - inputs @ pull
    stable = float(np.linalg.eigvals(closed).real.max()) < 0.0
    positive = float(np.linalg.eigvalsh(x).min()) > -1e-9 * float(np.abs(x).max())
    return x if stable and positive else None
