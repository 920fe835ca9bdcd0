r"""Is the model right, in a log whose torque is no sum of lines, or whose motion repeats?

Each is written so that the fault makes its factor positive; where only the positive sign is that fault, a
negative factor says nothing.

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
from scipy import fft, signal, stats

from cabledrive.identification.axis_case import case_of
from cabledrive.identification.diagnosis import FALSE_ALARMS
from cabledrive.identification.estimates import Identification
from cabledrive.identification.fault_evidence import Evidence
from cabledrive.identification.innovation_kernels import loosen
from cabledrive.identification.innovations import (
    HELD,
    HELD_DOUBT,
    ORDER,
    SLOWER,
    NotReproduced,
    Prediction,
    Track,
    autoregression,
    best_bandwidth,
    held,
    predicted_angles,
    regression,
)
from cabledrive.identification.logs.log import Log
from cabledrive.identification.method_error import reference_tracks
from cabledrive.identification.regression import (
    FEWEST_SEGMENTS,
    MOST_SEGMENTS,
    Factors,
    joined,
    only,
    solve,
    triangle,
)
from cabledrive.identification.rigid_axis import AxisOptions, channels_of, equation_for

Array = NDArray[np.float64]

BASE = ("inertia", "viscous", "coulomb", "offset")
"""Torques of an error of the four parameters."""
STRIBECK_SHARES = (0.03, 0.1, 0.3)
"""Fading speeds that are tried, in root mean square speeds."""
SLOPE_SHARES = (1.0, 4.0)
"""Slopes of a smooth friction that are tried, over the root mean square speed."""
WAVES = 4
"""Half waves over the stroke of a torque that depends on the position."""
RESONANCES = (25.0, 50.0, 100.0)
"""Of a joint, that are tried [Hz]."""
RESONANCE_DAMPING = 0.1
GAPS = (0.25, 1.0)
"""Backlash widths that are tried, in degrees for a rotating axis."""
LINEAR_GAPS = (0.0005, 0.005)
"""The same for a linear axis, in strokes."""
CONTACT = 0.005
"""Time in which both sides of a backlash reach one speed [s]."""


def base_torques(run: Prediction, track: Track) -> dict[str, Array]:
    """What an error of the parameters would add, and of the instant at which the torque was measured.

    Returns those of `BASE`, and "lag".
    """
    return {
        "inertia": -run.acceleration,
        "viscous": -run.speed,
        "coulomb": -run.direction,
        "offset": np.ones_like(run.speed),
        "lag": np.gradient(track.torque, track.interval),
    }


def fault_torques(run: Prediction, track: Track, gaps: tuple[float, ...]) -> dict[str, Array]:
    """What each fault would add.

    ``gaps``: backlash widths [rad or m].
    Returns by fault, and what was tried of it after a colon.
    """
    net = run.values[0] * run.acceleration
    found = friction_torques(run.speed, run.direction) | {"load": -run.direction * np.abs(net)}
    stroke = float(np.ptp(track.position))
    place = (track.position - track.position.min()) / stroke
    for k in range(1, WAVES + 1):
        found[f"position:{k}"] = np.cos(np.pi * k * place)
    for hertz in RESONANCES:
        if hertz < 0.2 / track.interval:
            found[f"flexibility:{hertz:g}"] = springy(net, 2 * np.pi * hertz, track.interval)
    for gap in gaps:
        found[f"backlash:{gap:.3g}"] = loosened(net, run.speed, gap, track.interval)
    return found


def friction_torques(speed: Array, direction: Array) -> dict[str, Array]:
    """What other laws of friction would add.

    ``speed``, shape (samples,); ``direction``, shape (samples,): 0 where the axis sticks.
    """
    size = float(np.sqrt(np.mean(speed**2)))
    found = {"asymmetry": -np.abs(speed), "quadratic": -speed * np.abs(speed) / size}
    for share in STRIBECK_SHARES:
        found[f"stribeck:{share:g}"] = -direction * np.exp(-((speed / (share * size)) ** 2))
    for share in SLOPE_SHARES:
        found[f"slope:{share:g}"] = direction - np.tanh(share * speed / size)
    return found


def springy(net: Array, resonance: float, interval: float) -> Array:
    r"""What the load's inertia behind a spring adds to the motor's acceleration.

    .. math:: \frac{s^2}{s^2 + 2\zeta\omega_r s + \omega_r^2}

    of the torque that accelerates the axis.

    ``net``, shape (samples,); ``resonance``: motor and load against each other [rad/s]; ``interval`` [s].
    Returns shape (samples,).
    """
    damping = 2 * RESONANCE_DAMPING * resonance
    numerator, denominator = signal.bilinear([1.0, 0.0, 0.0], [1.0, damping, resonance**2], 1.0 / interval)
    return np.asarray(signal.lfilter(numerator, denominator, net))


def loosened(net: Array, speed: Array, gap: float, interval: float) -> Array:
    """What backlash adds: the torque accelerates the motor alone, and contact takes the surplus back.

    ``net``, ``speed``, shape (samples,): torque that accelerates the axis, and its speed; ``gap`` [rad or m];
    ``interval`` [s].
    Returns shape (samples,).
    """
    added = np.empty_like(net)
    loosen(net, speed, gap, interval, max(1, round(CONTACT / interval)), added)
    return added


SHORTEST = 0.3
"""Period that is looked for at least [s]."""
ALIKE = 0.9
"""Correlation of a torque with itself, one period later, from which it counts as periodic."""


def period_of(values: Array, interval: float) -> int:
    """Period of a signal.

    ``values``, shape (samples,); ``interval`` [s].
    Returns [samples]; 0 where it does not repeat at least once.
    """
    centred = values - values.mean()
    size = values.size
    power = np.abs(fft.rfft(centred, fft.next_fast_len(2 * size))) ** 2
    products = fft.irfft(power)[:size]
    energy = np.cumsum(centred**2)
    first, last = round(SHORTEST / interval), size // 2
    lags = np.arange(first, last)
    if lags.size == 0 or energy[-1] == 0.0:
        return 0
    heads, tails = energy[size - 1 - lags], energy[-1] - energy[lags - 1]
    alike = products[lags] / np.sqrt(np.maximum(heads * tails, 1e-300))
    best = int(np.argmax(alike))
    if alike[best] < ALIKE:
        return 0
    # The shortest of the multiples that are as good.
    near = np.flatnonzero(alike > alike[best] - 0.02)
    return int(lags[near[0] + int(np.argmax(alike[near[0] : near[0] + 20]))])


def design_effect(tracks: Sequence[Track], runs: Sequence[Prediction]) -> float:
    r"""Factor of the variances of a log that repeats: :math:`1 + (n - 1)\rho`.

    ``runs``: of the observer.
    Returns with n periods, and the correlation of the whitened innovations with those one period later; 1
    where nothing repeats.
    """
    found = [1.0]
    for track, run in zip(tracks, runs, strict=True):
        period = period_of(track.torque, track.interval)
        if period == 0:
            continue
        white = np.convolve(run.innovation, autoregression(run.innovation), "valid")[ORDER:]
        count = white.size / period
        alike = float(white[period:] @ white[:-period]) / float(white @ white) / (1.0 - 1.0 / count)
        found.append(1.0 + (count - 1.0) * max(alike, 0.0))
    return max(found)


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
