r"""Rope on pulleys and guides: friction at wraps separated from friction at bearings, and a rope that slips.

A rope that slides over a guide loses tension in proportion to it, a bearing does not. With a pretension T per
log, the motor's torque while the rope slides one way is

.. math:: \tau = J\dot\omega + b\,\omega + d + (c + w\,T)\,\mathrm{sgn}\,\omega

with the bearings' c, at the motor, and the wraps' w; of a loop with one wrap :math:`\varphi` in each strand
:math:`w = 4 r \tanh(\mu\varphi/2)`; :math:`\delta` is the delay between the logged torque and its
effect, such as half a sample of a torque that is held, and :math:`\varepsilon` the first effect of an
elastic cable on the inertia. Around reversals, where the rope has not begun to slide everywhere, samples are
left out. What is left between two reversals is a stroke; errors are those of strokes taken as independent,
and what the terms in :math:`\delta, \varepsilon` change is added to them as an error of the model.

In a log of both sides at the first shaft the load pulls with :math:`F = J_2\ddot\theta_2`. What has slipped,
s, adds to the twist :math:`\theta_1 - \theta_2`: a rope that leaves a pulley under another tension than it
came creeps, :math:`\dot s = \kappa F|\dot\theta_1|`; where the wrap holds no more it slides under the largest
pull, :math:`\dot s = \dot\theta_1 - \dot\theta_2`. The twist is solved for its elastic part, the friction of
the load and one of the two; a slip is believed where much of the twist that is left without it is gone.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from cabledrive.identification import estimates
from cabledrive.identification.axis.axis import channels_of
from cabledrive.identification.estimates import Estimate, Fit
from cabledrive.identification.logs.log import Log
from cabledrive.identification.signals import difference, zero_phase
from cabledrive.identification.two_sides import TwoSides
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
"""Half-width of the wraps' part over all friction from which the two are not separated."""
LEAST_STROKES = 6
LEVEL = 0.01


@dataclass(frozen=True, kw_only=True)
class FrictionSplit:
    """Friction of bearings and of wraps."""

    reason: str  # why they are not separated, else empty
    constant: Estimate  # of motor and bearings at the motor [N m]; without a number where there is a reason
    per_tension: Estimate  # of the wraps over the pretension [N m/N], that is [m]
    total: tuple[Estimate, ...]  # all friction at each tension [N m]
    tensions: tuple[float, ...]  # [N]
    strokes: int
    findings: tuple[str, ...]


def split_friction(logs: Sequence[Log], tensions: Sequence[float]) -> FrictionSplit:
    """Friction of bearings and of wraps from logs at given pretensions [N]."""
    if len(tensions) != len(logs) or any(not 0.0 < tension < np.inf for tension in tensions):
        raise InputRefused(f"--tension: {len(tensions)} given for {len(logs)} logs: give a positive one each")
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
        reason = f"the wraps' part at {mean:.4g} N is known to {half:.3g} N m only, "
        reason += f"all friction is {whole:.3g} N m: spread the tensions further, or record more strokes"
    if reason:
        findings = [f"friction of wraps and of bearings not separated: {reason}"]
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
    torque_name, angle_name = channels_of(log)
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
    whole = estimates.by_label(matrix, torque, np.concatenate(strokes))
    fit, rigid = estimates.solve(whole), estimates.solve(estimates.only(whole, whole.names[:-2]))
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


BAND = 15.0
"""Of the filter [Hz]: what slips, slips slowly."""
EXPLAINS, SURE = 0.6, 8.0
"""Share of the twist's power that a slip may leave, and its least size over its error."""
AT_THE_LIMIT = (0.5, 0.6, 0.7, 0.8, 0.9)
"""Shares of the largest pull from which a wrap that holds no more is looked for."""
WHOLE = 0.2
"""How far from one the share of what slides under the largest pull may be."""
LIMIT_ERROR = 0.04
"""Standard error of the limit, relative: 24 machines with limits from 0.4 to 0.9 of the largest pull."""
ROUNDS, KNOWN = 4, 0.05
"""Of the pull; and largest error of its elastic part, relative, with which that is taken for it."""
ELASTIC = ("pull", "rate", "viscous", "coulomb")
BESIDE = (*ELASTIC, "angle")
"""Creep under the friction of the load, or another gear than the sheet's, is a share of its angle."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Slip:
    """What a rope does on its pulley, and what has slipped."""

    creep: float  # per pull over the load's inertia [s^2/rad]; 0 where it slides
    limit: float  # pull over the load's inertia under which it slides [rad/s^2]; infinite where it creeps
    error: float  # standard error of the one that is found, in its unit
    paths: tuple[Array, ...]  # of each log, shape (samples,) [rad]
    left: float  # share of the twist's power that is left

    def words(self, inertia: float) -> str:
        """What the rope does; ``inertia``: of the load at the first shaft [kg m^2]."""
        if self.creep > 0.0:
            return f"the rope creeps on its pulley by {100.0 * self.creep / inertia:.3g} % of the way per N m"
        return f"the rope slides on its pulley above {self.limit * inertia:.3g} N m"


def without_slip(sides: Sequence[TwoSides]) -> tuple[list[TwoSides], Slip | None]:
    """The sides with what has slipped in them, and what the rope does; as they are where it holds."""
    if any(one.rates or not one.twisted for one in sides):
        return list(sides), None
    motions = [_motion(one) for one in sides]
    sure = [slip for share in AT_THE_LIMIT if (slip := _sliding(motions, share)) is not None]
    pulls = [m["pull"] for m in motions]
    for _ in range(ROUNDS):  # less what damper and friction take of the pull, once that is known
        both = zip(pulls, motions, strict=True)
        paths = [np.cumsum(pull * np.abs(m["near"])) * m["interval"] for pull, m in both]
        fit, value, error, left = _twist(motions, paths)
        if value > SURE * error and left < EXPLAINS:
            pairs, share = zip(paths, motions, strict=True), float(fit.values[-2])
            moved = tuple(value * path + share * m["angle"] for path, m in pairs)
            sure.append(Slip(creep=value, limit=np.inf, error=error, paths=moved, left=left))
        sizes = np.array([np.sqrt(np.mean([np.mean(m[name] ** 2) for m in motions])) for name in ELASTIC])
        errors = np.sqrt(np.diag(fit.covariance))[: len(sizes)] * sizes
        if not np.linalg.norm(errors) < KNOWN * fit.values[0] * sizes[0]:
            break
        shares = dict(zip(ELASTIC, fit.values / fit.values[0], strict=False))
        pulls = [np.sum([share * m[name] for name, share in shares.items()], axis=0) for m in motions]
    if not sure:
        return list(sides), None
    best = min(sure, key=lambda one: one.left)
    return [replace(one, slipped=path) for one, path in zip(sides, best.paths, strict=True)], best


def _motion(one: TwoSides) -> dict[str, Array]:
    """The elastic parts of the twist, the twist and the first pulley's speed below the band, (samples,)."""
    h, near = one.interval, one.motor if one.pulley is None else one.pulley
    band = min(BAND, 0.1 / h)
    first, load = (zero_phase(values, h, band) for values in (near, one.load))
    turned, speed = difference(load, h), difference(first, h)
    return {
        "pull": difference(turned, h),
        "rate": speed - turned,
        "viscous": turned,
        "coulomb": zero_phase(np.sign(one.quick(one.load, band)), h, band),
        "angle": load,
        "twist": first - load,
        "near": speed,
        "interval": np.array(h),
    }


def _sliding(motions: Sequence[Mapping[str, Array]], share: float) -> Slip | None:
    """A rope that slides, as a whole, under pulls above a share of the largest one; None: it does not."""
    most = max(float(np.quantile(np.abs(m["pull"]), 0.999)) for m in motions)
    slides = [(np.abs(m["pull"]) > share * most) & (m["rate"] * m["pull"] > 0.0) for m in motions]
    steps = [np.where(own, m["rate"], 0.0) for own, m in zip(slides, motions, strict=True)]
    paths = tuple(np.cumsum(step) * m["interval"] for step, m in zip(steps, motions, strict=True))
    _, value, error, left = _twist(motions, paths)
    if not (value > SURE * error and left < EXPLAINS and abs(value - 1.0) < WHOLE):
        return None
    weights, pulls = np.abs(np.concatenate(steps)), np.abs(np.concatenate([m["pull"] for m in motions]))
    limit = float(np.average(pulls, weights=weights)) if weights.any() else np.inf
    return Slip(creep=0.0, limit=limit, error=LIMIT_ERROR * limit, paths=paths, left=left)


def _twist(motions: Sequence[Mapping[str, Array]], paths: Sequence[Array]) -> tuple[Fit, float, float, float]:
    """The twist by its parts, a slip's path the last; its factor, the error of that, what share is left."""
    parts = []
    for m, path in zip(motions, paths, strict=True):
        rows = np.column_stack([*(m[name] for name in BESIDE), path, m["twist"]])
        step, edge = (max(1, int(time / (BAND * float(m["interval"])))) for time in (0.02, 2.0))
        rows = rows[edge:-edge:step] - rows[edge:-edge:step].mean(axis=0)
        parts.append(estimates.factor(rows[:, :-1], rows[:, -1], (*BESIDE, "slip"), 60))
    whole = estimates.joined(parts)
    both = whole, estimates.only(whole, BESIDE)
    fit, plain = (estimates.solve(estimates.suited_segments(one)) for one in both)
    left = (fit.residual / plain.residual) ** 2 if plain.residual > 0.0 else 1.0
    return fit, float(fit.values[-1]), float(np.sqrt(fit.covariance[-1, -1])), left
