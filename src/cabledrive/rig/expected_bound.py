r"""How far the load may stray with everything uncertain at once: what theorem and tube leave out included.

The loop, filter and all, is linear but for friction and counts. Both, and whatever of the motor is not known,
enter as bounded signals, and a signal bounded by h(t) moves the load by at most :math:`(|g| * h)(t)` with g
the impulse response: the tube of the theorem, for the true loop. Wrong values of cable and load, which no
torque of the motor can cancel, leave a residual along the reference that is known but for its scale; the loop
is run at the corners of their intervals.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np

from cabledrive.control.numbers import DARC, HIGH, KALMAN, LOW, NOMINAL
from cabledrive.control.reference import joint_motion
from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.chain_plant import linear_step
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.margins import closed_loop, response, sampled_controller, sampled_plant
from cabledrive.rig.plant_samples import Spreads, corners, varied
from cabledrive.rig.setting import DEGREE

MEMORY, LONG_MEMORY = 0.8, 4.0
SIGMAS, COUNTS_PER_PERIOD = 5.0, 10.0
PARTS = ("matched", "friction", "unmatched", "counts")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ExpectedBound:
    """Parts of the bound of the load's error along a motion, at the first shaft, shape (samples,) [rad]."""

    matched: Array  # from the motor's inertia, friction and offset within their bounds, adapted or not
    friction: Array  # from friction that sticks where the reference is slower than the noise of the speed
    unmatched: Array  # from cable and load within their intervals
    counts: Array  # from rounding to counts, and from encoder zeros that nobody knows

    @property
    def total(self) -> Array:
        """The bound, shape (samples,)."""
        return self.matched + self.friction + self.unmatched + self.counts


def expected_bound(loop: Loop, spreads: Spreads | None = None) -> ExpectedBound:
    """Bound of the load's error over everything uncertain; default: the spreads of `plant_samples`."""
    seen, rig, plant = loop.observer, loop.rig, sampled_plant(loop)
    if seen.kind != KALMAN or rig.late_samples or rig.late_part > 0.0 or loop.cable is not None:
        raise InputRefused(
            "the expected bound is of a lumped chain and a Kalman filter without delay: leave the others out"
        )
    matrix, rounding, _ = closed_loop(sampled_controller(loop), plant)
    angle, speed = np.eye(len(matrix))[[loop.chain.size - 1, loop.chain.size]]
    short, states = round(MEMORY / rig.interval), seen.model.shape[0]
    noise = (response(matrix, rounding, speed, short) ** 2).sum(axis=0) @ (rig.counts**2 / 12.0)
    pushes = np.zeros((len(matrix), 2))  # a torque that the filter does not know, one that it alone knows
    table, inner = linear_step(loop.chain, rig.interval, loop.plant.current_rate), len(plant.a)
    pushes[: len(table), 0] = table[:, len(table) + 1]
    pushes[inner : inner + states, 1] = seen.model[:, states + 3]
    both = response(matrix, pushes, angle, short)
    matched, friction = torque_parts(loop, both[:, 0], both[:, 1], SIGMAS * float(np.sqrt(noise)))
    return ExpectedBound(
        matched=matched,
        friction=friction,
        unmatched=unmatched_part(loop, spreads or Spreads()),
        counts=rounding_part(loop, matrix, rounding),
    )


def bound_over_draws(loop: Loop) -> dict[str, Any]:
    """The bound and its parts in words [deg], or why there is none."""
    made, name = loop.controller, "expected_bound_deg"
    if made.law.kind != DARC or not made.damped or len(made.shafts) != loop.chain.size:
        reason = "only for laws of the chain that count the dampers, on the plant they are made for"
        return {name: None, f"{name}_reason": reason}
    try:
        found = expected_bound(loop)
    except InputRefused as refused:
        return {name: None, f"{name}_reason": str(refused)}
    scale, worst = 1.0 / loop.gear / DEGREE, int(found.total.argmax())
    parts = {part: float(getattr(found, part)[worst] * scale) for part in PARTS}
    return {name: float(found.total[worst] * scale), "expected_bound_parts_deg": parts}


def rounding_part(loop: Loop, matrix: Array, rounding: Array) -> Array:
    """What rounding to counts does to the load, and zeros of encoders half a count off.

    While an encoder passes ten counts and more in a period of the bandwidth, its rounding is white noise of
    which five standard deviations are taken; slower, it is any signal of half a count. Returns shape
    (samples,) [rad].
    """
    from scipy.signal import fftconvolve

    bandwidth, speed = loop.controller.bandwidth, np.abs(loop.controller.reference[:, -2])
    assert bandwidth is not None
    samples = round(LONG_MEMORY / loop.rig.interval)
    responses = response(matrix, rounding, np.eye(len(matrix))[loop.chain.size - 1], samples)
    found, variance = np.zeros(len(speed)), np.zeros(len(speed))
    for impulse, count in zip(responses.T, loop.rig.counts, strict=True):
        slow = speed < COUNTS_PER_PERIOD * count * bandwidth / (2.0 * pi)
        found += tube(impulse, 0.5 * count * slow) + 0.5 * count * np.abs(np.cumsum(impulse)).max()
        variance += fftconvolve(count**2 / 12.0 * ~slow, impulse**2)[: len(speed)]
    return found + SIGMAS * np.sqrt(np.maximum(variance, 0.0))


def torque_parts(loop: Loop, by_plant: Array, by_filter: Array, speed_noise: float) -> tuple[Array, Array]:
    """Tubes of what is not known of the motor, and of friction that sticks.

    ``by_plant``, ``by_filter``, shape (k,): impulse responses of the load to both torques; ``speed_noise``
    [rad/s]. Where the reference is faster than the noise of the motor's speed, friction has the sign it is
    taken to have; elsewhere plant and filter may each have any friction up to the Coulomb torque, and only
    what the law feeds forward is known. Returns ``matched, friction``, shape (samples,) [rad].
    """
    made = loop.controller
    learning, slope, reference = made.law.learning, made.law.scalars[2], made.reference
    half = np.maximum(learning[HIGH] - learning[NOMINAL], learning[NOMINAL] - learning[LOW])
    speed, acceleration = np.abs(reference[:, -2]), np.abs(reference[:, -1])
    share = np.tanh(slope * speed)
    both = by_plant + by_filter
    uncertain = np.column_stack((acceleration, speed, share, np.ones(len(share)))) @ half
    matched = tube(both, uncertain) + tube(by_plant, uncertain)
    slow = speed <= speed_noise
    coulomb, nominal = learning[HIGH][2], learning[NOMINAL][2]
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
    p2, p3 = made.law.learning[NOMINAL][:2]
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
