r"""How far the load may stray with everything uncertain at once: what theorem and tube leave out included.

The loop, filter and all, is linear but for friction and counts. Both, and whatever of the motor is not known,
enter as bounded signals, and a signal bounded by h(t) moves the load by at most :math:`(|g| * h)(t)` with g
the impulse response: the tube of the theorem, for the true loop. Wrong values of cable and load, which no
torque of the motor can cancel, leave a residual along the reference that is known but for its scale; the loop
is run at the corners of their intervals.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import pi
from typing import Any

import numpy as np

from cabledrive.control.numbers import DARC, HIGH, LOW, NOMINAL
from cabledrive.control.reference import joint_motion
from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.chain_plant import linear_step
from cabledrive.rig.closed_loop.linear_loop import LinearLoop, driven, linear_loop, response
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.plant_samples import Spreads
from cabledrive.rig.setting import DEGREE

MEMORY, LONG_MEMORY = 0.8, 4.0
SIGMAS, COUNTS_PER_PERIOD = 5.0, 10.0
PARTS = ("matched", "friction", "unmatched", "counts")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ExpectedBound:
    """Parts of the bound of the load's error along a motion, at the first shaft [rad]."""

    # (samples,): from the motor's inertia, friction and offset within their bounds, adapted or not
    matched: Array
    # (samples,): from friction that sticks where the reference is slower than the noise of the motor's speed
    friction: Array
    unmatched: Array  # (samples,): from cable and load within their intervals
    counts: Array  # (samples,): from rounding to counts, and from encoder zeros that nobody knows
    peak_torque_noise: float  # five standard deviations of the command's noise by rounding [N m]

    @property
    def total(self) -> Array:
        """The bound, shape (samples,)."""
        return self.matched + self.friction + self.unmatched + self.counts


def expected_bound(loop: Loop, spreads: Spreads | None = None) -> ExpectedBound:
    """Bound of the load's error over everything uncertain; default: the spreads of `plant_samples`."""
    linear = linear_loop(loop)
    short = round(MEMORY / loop.rig.interval)
    speed_noise, torque_noise = (SIGMAS * part for part in linear.noise(loop.rig.counts, short))
    by_plant = response(linear.matrix, linear.plant_torque[:, None], linear.load_angle, short)[:, 0]
    by_filter = response(linear.matrix, linear.filter_torque[:, None], linear.load_angle, short)[:, 0]
    matched, friction = torque_parts(loop, by_plant, by_filter, speed_noise)
    unmatched = unmatched_part(loop, spreads or Spreads())
    return ExpectedBound(
        matched=matched,
        friction=friction,
        unmatched=unmatched,
        counts=rounding_part(loop, linear),
        peak_torque_noise=torque_noise,
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


def rounding_part(loop: Loop, linear: LinearLoop) -> Array:
    """What rounding to counts does to the load, and zeros of encoders half a count off.

    While an encoder passes ten counts and more in a period of the bandwidth, its rounding is white noise of
    which five standard deviations are taken; slower, it is any signal of half a count. Returns shape
    (samples,) [rad].
    """
    from scipy.signal import fftconvolve

    bandwidth, speed = loop.controller.bandwidth, np.abs(loop.controller.reference[:, -2])
    assert bandwidth is not None
    samples = round(LONG_MEMORY / loop.rig.interval)
    responses = response(linear.matrix, linear.rounding, linear.load_angle, samples)
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
    chain, last = loop.chain, loop.chain.size - 1
    widths = (spreads.cable_stiffness, spreads.load_inertia, spreads.cable_damping)
    corners = [_varied(chain, last, np.array(signs) * widths) for signs in product((-1.0, 1.0), repeat=3)]
    worst = _envelope(loop, corners)
    if last > 1:
        for width in (
            (spreads.joint_stiffness, 0.0, 0.0),
            (0.0, spreads.drive_inertia, 0.0),
            (0.0, 0.0, spreads.joint_damping),
        ):
            pair = [_varied(chain, 1, sign * np.array(width)) for sign in (-1.0, 1.0)]
            worst = worst + _envelope(loop, pair)
    return worst


def _varied(chain: LumpedChain, place: int, change: Array) -> LumpedChain:
    """A chain whose link before an inertia and that inertia are changed: stiffness, inertia, damping."""
    stiffness, inertias, damping = list(chain.stiffness), list(chain.inertias), list(chain.damping)
    stiffness[place - 1] *= 1.0 + change[0]
    inertias[place] *= 1.0 + change[1]
    damping[place - 1] *= 1.0 + change[2]
    return replace(chain, stiffness=tuple(stiffness), inertias=tuple(inertias), damping=tuple(damping))


def _envelope(loop: Loop, chains: Sequence[LumpedChain]) -> Array:
    return np.asarray(np.max([np.abs(residual_response(loop, chain)) for chain in chains], axis=0))


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
    linear = linear_loop(loop, chain)
    return driven(linear.matrix, residual, linear.load_angle)
