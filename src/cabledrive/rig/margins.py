r"""Margins and torque ripple of a law on its nominal plant, with its filter, delay and torque loop.

The loop is opened at the plant's torque, while the filter gets the command: plant and controller are
sampled linear systems, estimates are frozen and the motor slips. With :math:`S = 1/(1 + L)` and :math:`T =
1 - S` the disk margin is :math:`\alpha = 2/\lVert S - T\rVert_\infty`: gain may change by a factor of
:math:`(2 + \alpha)/(2 - \alpha)` either way, or phase by :math:`2\arctan(\alpha/2)`, or both within the
disk. P. Seiler, A. Packard, P. Gahinet, IEEE Control Systems Magazine 40(5), 78-95, 2020.

How far the load may stray with everything uncertain at once: what theorem and tube leave out included.

The loop, filter and all, is linear but for friction and counts. Both, and whatever of the motor is not known,
enter as bounded signals, and a signal bounded by h(t) moves the load by at most :math:`(|g| * h)(t)` with g
the impulse response: the tube of the theorem, for the true loop. Wrong values of cable and load, which no
torque of the motor can cancel, leave a residual along the reference that is known but for its scale; the loop
is run at the corners of their intervals.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import matrix_balance, schur

from cabledrive.control import numbers
from cabledrive.control.backstepping import fixed_row
from cabledrive.control.bound import impulse_response
from cabledrive.control.load_schedule import filter_at, law_at
from cabledrive.control.observers import Sampling, between_samples
from cabledrive.control.reference import joint_motion
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain, state_space
from cabledrive.rig.closed_loop.chain_plant import linear_step
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.laws.controllers import Spreads
from cabledrive.rig.plant_samples import corners, varied
from cabledrive.rig.setting import DEGREE, none

GRID = 800
LOWEST_HZ = 0.05
SIGMAS = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Margins:
    """How far a loop is from instability, and how much torque rounding makes."""

    disk: float  # disk margin [-]; 0 where the loop is unstable
    gain: float  # factor by which the gain may rise [-]; infinite: any
    phase: float  # phase that may be lost [rad]; infinite: the loop has no crossover
    ripple: float  # five standard deviations of the torque by white rounding to counts [N m]


class Sampled(NamedTuple):
    """A sampled linear system x' = a x + b v, y = c x + d v."""

    a: Array
    b: Array
    c: Array
    d: Array


def margins_of(loop: Loop, load: float = 1.0) -> Margins:
    """Margins of a loop at its motor's torque."""
    controller, plant = sampled_controller(loop, load), sampled_plant(loop)
    closed, by_rounding, torque = closed_loop(controller, plant)
    if float(np.abs(np.linalg.eigvals(closed)).max()) >= 1.0:
        return Margins(disk=0.0, gain=1.0, phase=0.0, ripple=float("inf"))
    variance = np.diag(loop.rig.counts**2 / 12.0)
    spread = settled_covariance(closed, by_rounding @ variance @ by_rounding.T)
    at_once = controller.d[0, : len(variance)]
    power = torque @ spread @ torque + at_once @ variance @ at_once
    transfer = open_loop(controller, plant, loop.rig.interval)
    size = np.abs(transfer)
    turning = np.flatnonzero((transfer.imag[1:] * transfer.imag[:-1] <= 0.0) & (transfer.real[1:] < 0.0))
    above = size[turning + 1][(size[turning + 1] > 0.0) & (size[turning + 1] < 1.0)]
    crossing = np.flatnonzero((size[1:] - 1.0) * (size[:-1] - 1.0) <= 0.0)
    left = np.abs(pi - np.abs(np.angle(transfer[crossing])))
    return Margins(
        disk=float(2.0 / np.abs((1.0 - transfer) / (1.0 + transfer)).max()),
        gain=float(1.0 / above.max()) if above.size else float("inf"),
        phase=float(left.min()) if left.size else float("inf"),
        ripple=SIGMAS * float(np.sqrt(max(float(power), 0.0))),
    )


def settled_covariance(transition: Array, noise: Array) -> Array:
    """Covariance that a stable system gathers of ``noise`` in every sample; sums alone, by doubled times."""
    balanced, scale = matrix_balance(transition, permute=False)
    power, turn = schur(balanced, output="complex")  # whose powers keep what they decay by
    basis, inverse = scale @ turn, turn.conj().T / np.diag(scale)
    more = spread = inverse @ noise @ inverse.conj().T
    while np.abs(more).max() > np.finfo(float).eps * np.abs(spread).max():
        more = power @ spread @ power.conj().T
        spread, power = spread + more, power @ power
    return np.asarray((basis @ spread @ basis.conj().T).real)


def open_loop(controller: Sampled, plant: Sampled, interval: float) -> Array:
    """Minus the transfer from the motor's torque round to it, shape (GRID,)."""
    frequencies = np.geomspace(2.0 * pi * LOWEST_HZ, pi / interval * 0.999, GRID)
    z = np.exp(1j * frequencies * interval)
    m = plant.c.shape[0]

    def response(system: Sampled, columns: slice) -> Array:
        shifted = z[:, None, None] * np.eye(len(system.a)) - system.a
        inputs = np.broadcast_to(system.b[:, columns], (len(z), *system.b[:, columns].shape))
        return np.asarray(system.c @ np.linalg.solve(shifted, inputs) + system.d[:, columns])

    # The plant's torque is cut, not the one the filter gets: it still uses its own command.
    by_readings = (response(controller, slice(0, m)) @ response(plant, slice(0, 1)))[:, 0, 0]
    by_command = response(controller, slice(m, m + 1))[:, 0, 0]
    return -np.asarray(by_readings / (1.0 - by_command))


def closed_loop(controller: Sampled, plant: Sampled) -> tuple[Array, Array, Array]:
    """Transition of plant and controller joined, what rounding adds, and the command per state."""
    m, p, q = plant.c.shape[0], len(plant.a), len(controller.a)
    readings, known = controller.d[:, :m], controller.b[:, m:]
    command = np.concatenate((readings @ plant.c, controller.c), axis=1)[0]
    matrix = np.zeros((p + q, p + q))
    matrix[:p, :p], matrix[p:, p:] = plant.a, controller.a
    matrix[p:, :p] = controller.b[:, :m] @ plant.c
    matrix += np.concatenate((plant.b, known))[:, :1] * command
    by_rounding = np.concatenate((plant.b @ readings, controller.b[:, :m] + known @ readings))
    return matrix, by_rounding, command


def sampled_plant(loop: Loop) -> Sampled:
    """From the command to the encoders' angles: the chain, the torque loop, the delay."""
    rig, (system, inputs) = loop.rig, state_space(loop.chain)
    sampling = Sampling(interval=rig.interval, delay=rig.late_part, current_rate=loop.plant.current_rate)
    transition, push, shaft = between_samples(system, inputs[:, 0], sampling)
    states, queue = len(system) + 1, rig.late_samples + 1
    # Behind the states the command of this sample, which is the input, and the last ones, newest first.
    a = np.zeros((states + queue, states + 1 + queue))
    a[: states - 1, : states - 1] = transition
    a[:states, [states - 1, -1, -2]] = np.vstack((push[:, :3], shaft))
    a[states:, states:-1] = np.eye(queue)
    c = np.eye(states + queue)[rig.encoders]
    return Sampled(np.delete(a, states, axis=1), a[:, states, None], c, np.zeros((len(c), 1)))


def sampled_controller(loop: Loop, load: float = 1.0) -> Sampled:
    """From the encoders' angles and the command as the filter gets it to the command; announced ``load``.

    States: of the filter, torque of its shaft, commands that it waits for, memory of the law, last command.
    """
    seen, law = filter_at(loop.observer, load), law_at(loop.controller.law, load)
    if seen.kind != numbers.KALMAN:
        raise InputRefused("margins are those of a loop with the Kalman filter: leave the observer out")
    rows, memory, update = feedback_of(law, len(seen.chosen))
    states, m, queue, k = seen.model.shape[0], len(seen.output), loop.rig.late_samples + 1, len(memory)
    # Before the commands that it waits for the one of this sample, which is an input.
    shaft, given, kept, last = states, states + 1, states + 2 + queue, states + 2 + queue + k
    size, newer, older, gain = last + 1, kept - 2, kept - 1, seen.gains[-1]
    correct = np.zeros((states, size))
    correct[:, :states] = np.eye(states) - gain @ seen.output
    pick = np.eye(states)[seen.chosen]
    command, at_once = rows @ pick @ correct, rows @ pick @ gain
    command[kept : kept + k] += memory
    if seen.scalars[8] > 0.0:
        command -= correct[seen.places[1]]
        at_once = at_once - gain[seen.places[1]]
    a, b = np.zeros((size, size)), np.zeros((size, m))
    a[:states] = seen.model[:, :states] @ correct
    b[:states] = seen.model[:, :states] @ gain
    a[:states, [shaft, older, newer]] += seen.model[:, states : states + 3]
    a[shaft, [shaft, older, newer]] = seen.scalars[2:5]
    a[given + 1 : kept, given:older] = np.eye(queue)
    if k:
        errors = update[:, k:-1]
        a[kept:last] = errors @ pick @ correct
        a[kept:last, kept:last] += update[:, :k]
        a[kept:last, last] += update[:, -1]
        b[kept:last] = errors @ pick @ gain
    a[last], b[last] = command, at_once
    rest = np.arange(size) != given
    inputs = np.column_stack((b, a[:, given]))[rest]
    return Sampled(a[rest][:, rest], inputs, command[None, rest], np.append(at_once, 0.0)[None])


def feedback_of(law: numbers.LawNumbers, states: int) -> tuple[Array, Array, Array]:
    """Command per state, (2n,), and memory, (k,), and how the memory goes on, (k, k + 2n + 1)."""
    if law.kind in (numbers.LINEAR, numbers.LEARNING, numbers.REFERENCE_MODEL):
        k = law.matrix.shape[0]
        return law.rows[0, k : k + states], law.rows[0, :k], law.matrix
    if law.kind in (numbers.DARC, numbers.BACKSTEPPING):
        return np.array(fixed_row(law, states)), np.zeros(0), np.zeros((0, states + 1))
    raise InputRefused("margins are computed for packaged laws, whose equations are known")


MEMORY, LONG_MEMORY = 0.8, 4.0
COUNTS_PER_PERIOD = 10.0


class ExpectedBound(NamedTuple):
    """Parts of the bound of the load's error along a motion, at the first shaft, shape (samples,) [rad]."""

    matched: Array  # from the motor's inertia, friction and offset within their bounds, adapted or not
    friction: Array  # from friction that sticks where the reference is slower than the noise of the speed
    unmatched: Array  # from cable and load within their intervals
    counts: Array  # from rounding to counts, and from encoder zeros that nobody knows

    @property
    def total(self) -> Array:
        """The bound, shape (samples,)."""
        return np.asarray(sum(self))


def expected_bound(loop: Loop) -> ExpectedBound:
    """Bound of the load's error over everything uncertain."""
    seen, rig, plant = loop.observer, loop.rig, sampled_plant(loop)
    if seen.kind != numbers.KALMAN or rig.late_samples or rig.late_part > 0.0 or loop.cable is not None:
        raise InputRefused(
            "the expected bound is of a lumped chain and a Kalman filter without delay: leave the others out"
        )
    matrix, rounding, _ = closed_loop(sampled_controller(loop), plant)
    angle, speed = np.eye(len(matrix))[[loop.chain.size - 1, loop.chain.size]]
    short, states = round(MEMORY / rig.interval), seen.model.shape[0]
    noise = (impulse_response(matrix, rounding, speed, short) ** 2).sum(axis=0) @ (rig.counts**2 / 12.0)
    pushes = np.zeros((len(matrix), 2))  # a torque that the filter does not know, one that it alone knows
    table, inner = linear_step(loop.chain, rig.interval, loop.plant.current_rate), len(plant.a)
    pushes[: len(table), 0] = table[:, len(table) + 1]
    pushes[inner : inner + states, 1] = seen.model[:, states + 3]
    both = impulse_response(matrix, pushes, angle, short)
    parts = torque_parts(loop, both[:, 0], both[:, 1], SIGMAS * float(np.sqrt(noise)))
    unmatched = unmatched_part(loop, Spreads())
    return ExpectedBound(*parts, unmatched, rounding_part(loop, matrix, rounding))


def bound_over_draws(loop: Loop) -> dict[str, Any]:
    """The bound and its parts in words [deg], or why there is none."""
    made, name = loop.controller, "expected_bound_deg"
    if made.law.kind != numbers.DARC or not made.damped or len(made.shafts) != loop.chain.size:
        return none(name, "only for laws of the chain that count the dampers, on the plant they are made for")
    try:
        found = expected_bound(loop)
    except InputRefused as refused:
        return none(name, str(refused))
    scale, worst = 1.0 / loop.gear / DEGREE, int(found.total.argmax())
    parts = {part: float(values[worst] * scale) for part, values in found._asdict().items()}
    return {name: float(found.total[worst] * scale), "expected_bound_parts_deg": parts}


def rounding_part(loop: Loop, matrix: Array, rounding: Array) -> Array:
    """What rounding to counts and zeros half a count off do to the load, shape (samples,) [rad].

    White noise, of five deviations, while ten counts pass in a period of the bandwidth; slower, any signal.
    """
    from scipy.signal import fftconvolve

    bandwidth, speed = loop.controller.bandwidth, np.abs(loop.controller.reference[:, -2])
    assert bandwidth is not None
    samples = round(LONG_MEMORY / loop.rig.interval)
    responses = impulse_response(matrix, rounding, np.eye(len(matrix))[loop.chain.size - 1], samples)
    found, variance = np.zeros(len(speed)), np.zeros(len(speed))
    for impulse, count in zip(responses.T, loop.rig.counts, strict=True):
        slow = speed < COUNTS_PER_PERIOD * count * bandwidth / (2.0 * pi)
        found += tube(impulse, 0.5 * count * slow) + 0.5 * count * np.abs(np.cumsum(impulse)).max()
        variance += fftconvolve(count**2 / 12.0 * ~slow, impulse**2)[: len(speed)]
    return found + SIGMAS * np.sqrt(np.maximum(variance, 0.0))


def torque_parts(loop: Loop, by_plant: Array, by_filter: Array, speed_noise: float) -> tuple[Array, Array]:
    """Tubes of what is not known of the motor, and of friction that sticks, shape (samples,) [rad].

    ``by_plant``, ``by_filter``, shape (k,): impulse responses of the load. Where the reference is faster than
    the noise of the speed [rad/s] friction has its sign; elsewhere it may be any up to the Coulomb torque.
    """
    made = loop.controller
    learning, slope, reference = made.law.learning, made.law.scalars[2], made.reference
    half = np.maximum(
        learning[numbers.HIGH] - learning[numbers.NOMINAL], learning[numbers.NOMINAL] - learning[numbers.LOW]
    )
    speed, acceleration = np.abs(reference[:, -2]), np.abs(reference[:, -1])
    share = np.tanh(slope * speed)
    both = by_plant + by_filter
    uncertain = np.column_stack((acceleration, speed, share, np.ones(len(share)))) @ half
    matched = tube(both, uncertain) + tube(by_plant, uncertain)
    slow = speed <= speed_noise
    coulomb, nominal = learning[numbers.HIGH][2], learning[numbers.NOMINAL][2]
    seen = np.tanh(loop.observer.scalars[6] * np.maximum(speed - speed_noise, 0.0))
    friction = tube(by_plant, np.where(slow, coulomb, coulomb * (1.0 - share)))
    friction += tube(by_filter, np.where(slow, nominal, nominal * (2.0 - share - seen)))
    return matched, friction + tube(both, np.where(slow, nominal * share, 0.0))


def tube(impulse: Array, height: Array) -> Array:
    """Largest response to any signal within a height, shape (samples,), by its impulse response, (k,)."""
    from scipy.signal import fftconvolve

    return np.asarray(fftconvolve(height, np.abs(impulse))[: len(height)])


def unmatched_part(loop: Loop, spreads: Spreads) -> Array:
    """Largest error along the reference at the corners of cable, load and joint, shape (samples,) [rad]."""
    chain = loop.chain

    def envelope(chains: Sequence[LumpedChain]) -> Array:
        return np.asarray(np.max([np.abs(residual_response(loop, one)) for one in chains], axis=0))

    worst = envelope(corners(chain, spreads))
    if chain.size > 2:
        for width in (
            (spreads.joint_stiffness, 0.0, 0.0),
            (0.0, 0.0, spreads.drive_inertia),
            (0.0, spreads.joint_damping, 0.0),
        ):
            worst = worst + envelope([varied(chain, 1, *(sign * w for w in width)) for sign in (-1.0, 1.0)])
    return worst


def residual_response(loop: Loop, chain: LumpedChain) -> Array:
    """Error along the reference on another row, without friction and counts, shape (samples,) [rad]."""
    made, interval = loop.controller, loop.rig.interval
    assert made.flat is not None
    rate = loop.plant.current_rate
    angles, elastic = joint_motion(made.flat, made.reference)
    p2, p3 = made.law.learning[numbers.NOMINAL][:2]
    shaft = elastic + p2 * made.reference[:, -1] + p3 * made.reference[:, -2]
    command = shaft + (np.gradient(shaft, interval) / rate if rate > 0.0 else 0.0)
    m = 2 * chain.size + 1
    change = (linear_step(chain, interval, rate) - linear_step(loop.chain, interval, rate))[:, : m + 1]
    residual = np.column_stack((angles, shaft, command)) @ change.T
    matrix, _, _ = closed_loop(sampled_controller(loop), sampled_plant(replace(loop, chain=chain)))
    state, found = np.zeros(len(matrix)), np.zeros(len(residual))
    for i, push in enumerate(residual):
        found[i] = state[chain.size - 1]
        state = matrix @ state
        state[: residual.shape[1]] += push
    return found
