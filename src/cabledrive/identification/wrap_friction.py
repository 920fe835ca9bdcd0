r"""Friction at wraps told from friction at bearings, and inertias from the differences of rigs.

A rope that slides over a guide loses tension in proportion to it, a bearing does not. With a pretension T per
log, the motor's torque while the rope slides one way is

.. math:: \tau = J\dot\omega + b\,\omega + d + (c + w\,T)\,\mathrm{sgn}\,\omega

with the bearings' c, at the motor, and the wraps' w; of a loop with one wrap :math:`\varphi` in each strand
:math:`w = 4 r \tanh(\mu\varphi/2)`; :math:`\delta` is the delay between the logged torque and its
effect, such as half a sample of a torque that is held, and :math:`\varepsilon` the first effect of an
elastic cable on the inertia. Around reversals, where the rope has not begun to slide everywhere, samples are
left out. What is left between two reversals is a stroke; errors are those of strokes taken as independent,
and what the terms in :math:`\delta, \varepsilon` change is added to them as an error of the model.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from cabledrive.identification.axis.axis import AxisOptions, channels_of
from cabledrive.identification.estimates import Estimate, Identification
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import Fit, by_label, only, solve
from cabledrive.identification.signals import difference, zero_phase
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

BANDWIDTH = 20.0
"""Of the filter on torque and angle [Hz]: below the modes of a cable-driven joint."""
AWAY = 1.5
"""Time left out on both sides of a reversal, times the bandwidth."""
SLOW = 0.1
"""Part of the largest speed below which a sample is left out."""
ALIKE = 0.05
"""Spread of the tensions, relative, below which nothing tells the two frictions apart."""
WIDE = 0.5
"""Half-width of the wraps' part over all friction from which the two are not told apart."""
LEAST_STROKES = 6
LEVEL = 0.01


@dataclass(frozen=True, kw_only=True)
class FrictionSplit:
    """Friction of bearings and of wraps."""

    reason: str  # why they are not told apart, else empty
    constant: Estimate  # of motor and bearings at the motor [N m]; without a number where there is a reason
    per_tension: Estimate  # of the wraps over the pretension [N m/N], that is [m]
    total: tuple[Estimate, ...]  # all friction at each tension [N m]
    tensions: tuple[float, ...]  # [N]
    strokes: int
    findings: tuple[str, ...]


def split_friction(logs: Sequence[Log], tensions: Sequence[float]) -> FrictionSplit:
    """Friction of bearings and of wraps from logs at given pretensions [N]."""
    if len(tensions) != len(logs) or any(not 0.0 < tension < np.inf for tension in tensions):
        raise InputRefused(
            f"--tension: {len(tensions)} given for {len(logs)} logs: give a positive one for each"
        )
    rows = [_rows(log) for log in logs]
    levels = np.array(sorted(set(map(float, tensions))))
    free = _fit(rows, [levels == tension for tension in tensions])
    split = _fit(rows, [np.array([1.0, tension]) for tension in tensions])
    constant, slope = _estimate(split, 0, "N m"), _estimate(split, 1, "m")
    mean, reason = float(np.mean(tensions)), ""
    half, whole = 0.5 * (slope.high - slope.low) * mean, abs(constant.value + slope.value * mean)
    if levels[-1] - levels[0] < ALIKE * levels[-1]:
        reason = f"all logs are at {levels[-1]:.4g} N: take one at another pretension"
    elif half > WIDE * whole:
        reason = (
            f"the wraps' part at {mean:.4g} N is known to {half:.3g} N m only, all friction is {whole:.3g} "
            "N m: spread the tensions further, or record more strokes"
        )
    if reason:
        findings = [f"friction of wraps and of bearings not told apart: {reason}"]
        constant, slope = (Estimate.unknown(unit, "the logs do not tell it") for unit in ("N m", "m"))
    else:
        findings = _findings(free[0], levels, constant, slope)
    return FrictionSplit(
        reason=reason,
        constant=constant,
        per_tension=slope,
        total=tuple(_estimate(free, k, "N m") for k in range(levels.size)),
        tensions=tuple(map(float, tensions)),
        strokes=sum(len(set(own[-1])) for own in rows),
        findings=tuple(findings),
    )


_Rows = tuple[Array, Array, Array, Array, NDArray[np.intp]]
"""Filtered torque, sign of the speed, acceleration and speed (rows, 2), two rates of the torque (rows, 2),
number of the stroke; away from reversals."""


def _rows(log: Log) -> _Rows:
    torque_name, angle_name = channels_of(log, AxisOptions())
    step = log.interval
    torque = zero_phase(log.channel(torque_name), step, BANDWIDTH)
    speed = difference(zero_phase(log.channel(angle_name), step, BANDWIDTH), step)
    away = int(np.ceil(AWAY / BANDWIDTH / step))
    turns = np.flatnonzero(np.diff(np.sign(speed)) != 0.0)
    keep = np.abs(speed) > SLOW * np.abs(speed).max()
    for turn in [0, *turns, len(speed)]:
        keep[max(turn - away, 0) : turn + away + 1] = False
    stroke = np.searchsorted(turns, np.arange(len(speed)))[keep]
    if len(set(stroke)) < LEAST_STROKES:
        raise InputRefused(
            f"{log.source}: {len(set(stroke))} strokes longer than {2.0 * AWAY / BANDWIDTH:.3g} s, at least "
            f"{LEAST_STROKES} are needed: record longer or slower ones, back and forth"
        )
    sign = zero_phase(np.sign(speed), step, BANDWIDTH)  # as the filter shows a friction that turns round
    rate = difference(torque, step)
    motion = np.column_stack([difference(speed, step), speed])
    rates = np.column_stack([rate, difference(rate, step)])
    return torque[keep], sign[keep], motion[keep], rates[keep], stroke


def _fit(rows: Sequence[_Rows], frictions: Sequence[Array]) -> tuple[Fit, Array]:
    """Frictions first, inertia and viscous friction of all logs, an offset of each; what lag and spring move.

    ``frictions``: of each log, by what the direction makes each of them, shape (frictions,).
    """
    blocks, strokes, number = [], [], 0
    for log, ((_, sign, motion, rates, stroke), share) in enumerate(zip(rows, frictions, strict=True)):
        offsets = np.zeros((sign.size, len(rows)))
        offsets[:, log] = 1.0
        blocks.append(np.hstack([np.outer(sign, share), motion, offsets, rates]))
        strokes.append(stroke + number)
        number += int(stroke.max()) + 1
    matrix, torque = np.vstack(blocks), np.concatenate([own[0] for own in rows])
    whole = by_label(matrix, torque, np.concatenate(strokes))
    fit, rigid = solve(whole), solve(only(whole, whole.names[:-2]))
    return fit, np.abs(fit.values[: len(frictions[0])] - rigid.values[: len(frictions[0])])


def _estimate(found: tuple[Fit, Array], k: int, unit: str) -> Estimate:
    """One friction with its 95 % interval."""
    fit, doubt = found
    error = float(np.sqrt(fit.covariance[k, k]))
    return Estimate.of(fit.values[k], unit, error, float(fit.half_width()[k] + doubt[k]))


def _findings(free: Fit, levels: Array, constant: Estimate, slope: Estimate) -> list[str]:
    """Where the friction does not grow as that of wraps does, and what two tensions cannot show."""
    found = []
    if levels.size == 2:
        found.append("two tensions: that friction grows in proportion to them is assumed, not checked")
    else:
        away = np.linalg.svd(np.column_stack([np.ones(levels.size), levels]))[0][:, 2:].T
        gap, count = away @ free.values[: levels.size], levels.size
        covariance = away @ free.covariance[:count, :count] @ away.T
        size = float(gap @ np.linalg.solve(covariance, gap)) / gap.size
        if stats.f.sf(size, gap.size, free.freedom) < LEVEL:
            found.append("friction does not lie on a line over the tension: it is not that of wraps alone")
    if slope.high < 0.0 or constant.high < 0.0:
        found.append("one of the two frictions is negative: a tension, a sign or the model is wrong")
    return found


def inertias_of_the_rigs(
    motor: Identification, with_drive_pulley: Identification, with_load_pulley: Identification
) -> dict[str, Estimate]:
    """Inertias of motor, drive pulley and load pulley, as in Table 4.2, from rigs with more and more on.

    "J1", "J11", "J12", "J2", intervals propagated from those of the rigs, which are independent.
    """
    return {
        "J1": with_drive_pulley.parameters["inertia"],
        "J11": motor.parameters["inertia"],
        "J12": difference_of(with_drive_pulley, motor),
        "J2": difference_of(with_load_pulley, motor),
    }


def difference_of(larger: Identification, smaller: Identification, name: str = "inertia") -> Estimate:
    """Difference of one parameter of two independent identifications, with Welch's degrees of freedom."""
    a, b = larger.parameters[name], smaller.parameters[name]
    error = hypot(a.standard_error, b.standard_error)
    parts = a.standard_error**4 / larger.freedom + b.standard_error**4 / smaller.freedom
    half = float(stats.t.ppf(0.975, error**4 / parts)) * error if parts > 0 else float("inf")
    return Estimate.of(a.value - b.value, a.unit, error, half)
