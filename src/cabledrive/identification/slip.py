r"""A rope that slips on its pulley, in a log of both sides at the first shaft.

The load pulls with :math:`F = J_2\ddot\theta_2`. What has slipped, s, adds to the twist
:math:`\theta_1 - \theta_2`: a rope that leaves a pulley under another tension than it came creeps,
:math:`\dot s = \kappa F|\dot\theta_1|`; where the wrap holds no more it slides under the largest pull,
:math:`\dot s = \dot\theta_1 - \dot\theta_2`. The twist is solved for its elastic part, the friction of the
load and one of the two; a slip is believed where much of the twist that is left without it is gone.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.identification.regression import Fit, factor, joined, only, solve, suited_segments
from cabledrive.identification.signals import difference, zero_phase
from cabledrive.identification.two_sides import TwoSides
from cabledrive.parameters.arrays import Array

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
    tried = [_sliding(motions, share) for share in AT_THE_LIMIT]
    pulls = [m["pull"] for m in motions]
    for _ in range(ROUNDS):  # less what damper and friction take of the pull, once that is known
        fit, slip = _creeping(motions, pulls)
        tried.append((fit, slip))
        sizes = np.array([np.sqrt(np.mean([np.mean(m[name] ** 2) for m in motions])) for name in ELASTIC])
        errors = np.sqrt(np.diag(fit.covariance))[: len(sizes)] * sizes
        if not np.linalg.norm(errors) < KNOWN * fit.values[0] * sizes[0]:
            break
        shares = dict(zip(ELASTIC, fit.values / fit.values[0], strict=False))
        pulls = [np.sum([share * m[name] for name, share in shares.items()], axis=0) for m in motions]
    sure = [slip for fit, slip in tried if _believed(fit, slip)]
    if not sure:
        return list(sides), None
    best = min(sure, key=lambda one: one.left)
    return [replace(one, slipped=path) for one, path in zip(sides, best.paths, strict=True)], best


def _believed(fit: Fit, slip: Slip) -> bool:
    """Whether a slip stands out of its error and explains the twist; what slides does so as a whole."""
    value, error = float(fit.values[-1]), float(np.sqrt(fit.covariance[-1, -1]))
    whole = slip.creep > 0.0 or abs(value - 1.0) < WHOLE
    return bool(value > SURE * error and slip.left < EXPLAINS and whole)


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


def _creeping(motions: Sequence[Mapping[str, Array]], pulls: Sequence[Array]) -> tuple[Fit, Slip]:
    """A rope that creeps under pulls over the load's inertia, each of shape (samples,) [rad/s^2]."""
    paths = [np.cumsum(p * np.abs(m["near"])) * m["interval"] for p, m in zip(pulls, motions, strict=True)]
    fit, left = _twist(motions, paths)
    value, error = float(fit.values[-1]), float(np.sqrt(fit.covariance[-1, -1]))
    share = float(fit.values[-2])
    moved = tuple(value * path + share * m["angle"] for path, m in zip(paths, motions, strict=True))
    return fit, Slip(creep=value, limit=np.inf, error=error, paths=moved, left=left)


def _sliding(motions: Sequence[Mapping[str, Array]], share: float) -> tuple[Fit, Slip]:
    """A rope that slides under pulls above a share of the largest one."""
    most = max(float(np.quantile(np.abs(m["pull"]), 0.999)) for m in motions)
    slides = [(np.abs(m["pull"]) > share * most) & (m["rate"] * m["pull"] > 0.0) for m in motions]
    steps = [np.where(own, m["rate"], 0.0) for own, m in zip(slides, motions, strict=True)]
    paths = tuple(np.cumsum(step) * m["interval"] for step, m in zip(steps, motions, strict=True))
    fit, left = _twist(motions, paths)
    weights, pulls = np.abs(np.concatenate(steps)), np.abs(np.concatenate([m["pull"] for m in motions]))
    limit = float(np.average(pulls, weights=weights)) if weights.any() else np.inf
    return fit, Slip(creep=0.0, limit=limit, error=LIMIT_ERROR * limit, paths=paths, left=left)


def _twist(motions: Sequence[Mapping[str, Array]], paths: Sequence[Array]) -> tuple[Fit, float]:
    """The twist by its parts, the path of a slip the last; the share of its power that the path leaves."""
    parts = []
    for m, path in zip(motions, paths, strict=True):
        rows = np.column_stack([*(m[name] for name in BESIDE), path, m["twist"]])
        step, edge = (max(1, int(time / (BAND * float(m["interval"])))) for time in (0.02, 2.0))
        rows = rows[edge:-edge:step] - rows[edge:-edge:step].mean(axis=0)
        parts.append(factor(rows[:, :-1], rows[:, -1], (*BESIDE, "slip"), 60))
    whole = joined(parts)
    fit, plain = (solve(suited_segments(one)) for one in (whole, only(whole, BESIDE)))
    return fit, (fit.residual / plain.residual) ** 2 if plain.residual > 0.0 else 1.0
