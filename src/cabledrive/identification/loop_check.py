r"""Is the model right, in a log whose torque is no sum of lines: steps, chirps, feedback loops.

The innovations of `cabledrive.identification.innovations` are held against what each fault would add to them,
beside the four parameters and the instant at which the torque is measured. The standard error of a factor
comes from its contributions :math:`g_b` in segments of time, by the differences of neighbours,

.. math:: C = \frac{G}{2(G-1)}\sum_b (g_b - g_{b-1})^2

so that a fault that shows in a part of the log only does not hide itself in its own scatter. A factor beyond
Student's t is then tried again: what the same check finds in logs of a sound axis that moves alike, its angle
rounded and its torque noisy, is added to C, and so is the doubt about the hold of the torque channel.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from cabledrive.identification.axis_case import case_of
from cabledrive.identification.diagnosis import FALSE_ALARMS
from cabledrive.identification.estimates import Identification
from cabledrive.identification.fault_evidence import Evidence
from cabledrive.identification.innovations import (
    HELD,
    HELD_DOUBT,
    SLOWER,
    NotReproduced,
    Track,
    best_bandwidth,
    held,
    predicted_angles,
    regression,
)
from cabledrive.identification.logs.log import Log
from cabledrive.identification.loop_disturbances import (
    BASE,
    GAPS,
    LINEAR_GAPS,
    base_torques,
    fault_torques,
)
from cabledrive.identification.reference_logs import reference_tracks
from cabledrive.identification.regression import (
    FEWEST_SEGMENTS,
    MOST_SEGMENTS,
    Factors,
    joined,
    only,
    solve,
    triangle,
)
from cabledrive.identification.repetition import design_effect
from cabledrive.identification.rigid_axis import AxisOptions, channels_of, equation_for

Array = NDArray[np.float64]

NUISANCE = (*BASE, "lag")
HOLD = "hold"
DELAY = "delay"
"""Of the torque channel against the motion, by more than a sample: less is left free."""
SEGMENT = 80
"""Samples of a segment at least, in a log that is long enough for few of them."""
ROUNDS = 3
"""Corrections of the four parameters."""
EFFICIENCY = 2 / 3
"""Of a variance from differences of neighbours, against one from the same number of deviations."""


def evidence(
    logs: Sequence[Log], found: Identification, options: AxisOptions, rng: np.random.Generator
) -> tuple[Evidence, ...]:
    """Evidence for each fault in logs of any torque, that which explains most first.

    ``found``: by inverse dynamics, with Coulomb friction; only the viscous friction may be missing;
    ``options``: those it was found with; ``rng``: for the noise of the sound logs.
    Returns of each fault the one that explains most.
    Raises `NotComputed` if the observer cannot follow the log.
    """
    tracks = tracks_of(logs, options)
    values = np.array([estimate.value for estimate in found.parameters.values()])
    values[1] = np.nan_to_num(values[1])
    slow = [SLOWER * best_bandwidth(track, values) for track in tracks]
    values = refitted(tracks, values, slow)
    gaps = backlash_widths(logs[0], options)
    factors = joint_factors(tracks, values, slow, gaps)
    names = tuple(name for name in factors.names if name not in (*NUISANCE, HOLD))
    tried = len(names) + 1
    found_first = tuple(_evidence(factors, name, tried) for name in names)
    delay = _evidence(factors, DELAY, tried)
    if abs(delay.value) > tracks[0].interval:
        found_first = (*found_first, delay)
    if any(e.alarms for e in found_first):
        sound = [
            joint_factors(made, values, slow, gaps) for made in reference_tracks(tracks, values, slow, rng)
        ]
        found_first = tuple(_doubted(e, factors, sound) for e in found_first)
    runs = [predicted_angles(*one) for one in zip(tracks, [values] * len(tracks), slow, strict=True)]
    repeated = float(np.sqrt(design_effect(tracks, runs)))
    found_first = tuple(replace(e, error=repeated * e.error) for e in found_first)
    best: dict[str, Evidence] = {}
    for one in sorted(found_first, key=lambda e: (e.alarms, e.gain)):
        best[one.fault] = one
    return tuple(sorted(best.values(), key=lambda e: -e.gain))


def tracks_of(logs: Sequence[Log], options: AxisOptions, share: float = HELD) -> list[Track]:
    """Logs as the observer takes them.

    ``share``: of the second difference that is taken off the torque.
    """
    torque, position = channels_of(logs[0], options)
    equation = equation_for(logs, torque, position, options)
    return [
        Track(
            torque=held(log.channel(torque), share),
            position=log.channel(position),
            start=case_of(log, torque, position, equation).start,
            interval=log.interval,
            quantum=log.report.quantum.get(position, 0.0),
        )
        for log in logs
    ]


def backlash_widths(log: Log, options: AxisOptions) -> tuple[float, ...]:
    """Free plays that are tried.

    Returns [rad or m].
    """
    torque, position = channels_of(log, options)
    if log.units[torque] == "N":
        return tuple(share * float(np.ptp(log.channel(position))) for share in LINEAR_GAPS)
    return tuple(float(np.radians(gap)) for gap in GAPS)


def refitted(tracks: Sequence[Track], values: Array, bandwidths: Sequence[float]) -> Array:
    """The four parameters that leave the smallest innovations.

    ``values``, shape (4,): to begin with; ``bandwidths``: of the observers [rad/s].
    Returns shape (4,).
    Raises `NotComputed` if they are no machine's.
    """
    for _ in range(ROUNDS):
        values = values + solve(joint_factors(tracks, values, bandwidths)).values[: len(BASE)]
        if not np.all(np.isfinite(values)) or values[0] <= 0.0 or values[2] < 0.0:
            raise NotReproduced
    return values


def joint_factors(
    tracks: Sequence[Track],
    values: Array,
    bandwidths: Sequence[float],
    gaps: tuple[float, ...] | None = None,
    hold: float = 0.0,
) -> Factors:
    """Innovations of all logs against what disturbances add to them.

    ``values``, shape (4,); ``bandwidths``: of the observers [rad/s]; ``gaps``: of backlash; default: none;
    ``hold``: doubt about what the torque does between samples, as a column `HOLD` where there are no faults.
    Returns of `NUISANCE` alone, or with all faults and `HOLD`.
    """
    parts = []
    for track, bandwidth in zip(tracks, bandwidths, strict=True):
        run = predicted_angles(track, values, bandwidth)
        torques = base_torques(run, track)
        if gaps is not None:
            torques |= fault_torques(run, track, gaps)
            hold = HELD_DOUBT
        if hold > 0.0:
            torques[HOLD] = hold * np.diff(track.torque, 2, prepend=0.0, append=0.0)
        most = min(MOST_SEGMENTS // len(tracks), track.position.size // SEGMENT)
        parts.append(regression(track, run, torques, max(FEWEST_SEGMENTS, most)))
    return joined(parts)


def factor_of(factors: Factors, name: str, left: str | None = None) -> tuple[float, float, float]:
    """Factor of one disturbance, its standard error by differences of neighbours, and the residual.

    ``name``: of a disturbance, or `DELAY`; ``left``: column on the left side; default: the innovations.
    """
    names = (*BASE, "lag") if name == DELAY else (*NUISANCE, name)
    last = len(factors.names) if left is None else factors.names.index(left)
    places = [*(factors.names.index(n) for n in names), last]
    part = Factors(names=names, triangles=triangle(factors.triangles[:, :, places]), rows=factors.rows)
    fit = solve(part)
    upper, right = part.triangles[:, :, :-1], part.triangles[:, :, -1]
    scores = np.einsum("bij,bi->bj", upper, right - upper @ fit.values)
    whole = triangle(part.triangles.reshape(-1, len(names) + 1))[: len(names), :-1]
    moved = np.linalg.lstsq(whole, np.linalg.lstsq(whole.T, scores.T, rcond=None)[0], rcond=None)[0][-1]
    count = moved.size
    error = np.sqrt(0.5 * np.sum(np.diff(moved) ** 2) * count / (count - 1))
    return float(fit.values[-1]), float(error), float(fit.residual)


def _evidence(factors: Factors, name: str, tried: int) -> Evidence:
    value, error, residual = factor_of(factors, name)
    rigid = BASE if name == DELAY else NUISANCE
    freedom = EFFICIENCY * factors.triangles.shape[0]
    return Evidence(
        name=name,
        value=value,
        error=error,
        critical=float(stats.t.isf(0.5 * FALSE_ALARMS / tried, freedom)),
        shift=_shift(factors, name),
        gain=1.0 - residual**2 / solve(only(factors, rigid)).residual ** 2,
    )


def _shift(factors: Factors, name: str) -> tuple[float, ...]:
    """What a disturbance beside the parameters changes in them."""
    beside = only(factors, (*BASE, "lag")) if name == DELAY else only(factors, (*NUISANCE, name))
    without = only(factors, BASE if name == DELAY else NUISANCE)
    moved = solve(beside).values[: len(BASE)] - solve(without).values[: len(BASE)]
    return tuple(moved.tolist())


def _doubted(one: Evidence, factors: Factors, sound: Sequence[Factors]) -> Evidence:
    """With what sound logs show, and with the doubt about the hold of the torque."""
    misses = [factor_of(made, one.name) for made in sound]
    unseen = max(0.0, float(np.mean([value**2 - error**2 for value, error, _ in misses])))
    doubt = factor_of(factors, one.name, HOLD)[0]
    return replace(one, error=float(np.sqrt(one.error**2 + unseen + doubt**2)))
