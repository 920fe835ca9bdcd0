"""From logs to the answer for one axis: the methods that are possible, and whether they agree."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from operator import itemgetter

import numpy as np

from cabledrive.identification.axis import check
from cabledrive.identification.axis import timing as instant
from cabledrive.identification.axis.axis import Axis, AxisOptions, axis_of, channels_of, values_of
from cabledrive.identification.axis.observer import NotReproduced, best_bandwidth, run_of, twin_axes, unseen
from cabledrive.identification.axis.prediction import NAME as PREDICTION
from cabledrive.identification.axis.prediction import Predicted, predict
from cabledrive.identification.axis.simulated import NOT_FOLLOWED, SEED, refined
from cabledrive.identification.estimates import Finding, Identification
from cabledrive.identification.logs.log import ColumnMap, Log
from cabledrive.parameters import NotComputed
from cabledrive.parameters.fields import described, meaning

CONTRADICTION, ALIKE = 5.0, 0.005
"""Joint standard errors from which two answers contradict each other, and share of the value that is none."""
DRIFT_ROUNDS = 3
"""Corrections of a drift between two clocks."""
REFUSING = {check.MISFIT, NOT_FOLLOWED, "unexplained-torque", "logs-contradict", "negative", "residual"}
"""Codes of findings with which no interval is given."""
FAR, MOST = 4.0, 1e-3
"""Of the size that all but a thousandth of the samples keep within; share of the samples beyond it."""
MOST_LEFT = 0.6
"""Share of the torque up to which a residual is taken for noise."""
SLOWEST = 0.1
"""Interval from which the unit of the time is doubted [s]."""
LOST = (
    "a rigid axis with constant friction does not reproduce the log: another model "
    "is needed, or a disturbance acts"
)


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class IdentifyOptions:
    """What a configuration file may say."""

    model: str = meaning(
        'one of `MODELS`, or "two-inertia"; "rigid-axis" stands for "rigid-axis-coulomb"',
        "rigid-axis-coulomb",
    )
    method: str = meaning("one of `METHODS`", "auto")
    axis: AxisOptions = meaning("of the rigid axis", factory=AxisOptions)
    columns: ColumnMap = meaning("which column is which channel", factory=ColumnMap)
    check: bool = meaning(
        "whether the model is tested against faults, see `cabledrive.identification.axis.faults`",
        True,
    )
    torque: str = meaning(
        "when a logged torque acts: one of `TIMINGS`, see `cabledrive.identification.axis.timing`", "found"
    )


def answer(logs: Sequence[Log], options: IdentifyOptions) -> Identification:
    """Identify one axis from logs in memory; `NotComputed` if an asked method does not follow them."""
    known, torque = options.torque != "found", channels_of(logs[0])[0]
    findings: list[Finding] = []
    cleaned = [without_outliers(log, torque, findings) for log in logs]
    axis = axis_of(cleaned, replace(options.axis, lag=not known))
    timing = instant.given_timing(options.torque, axis.interval) if known else instant.timing_of(axis)
    drift = 0.0
    for _ in range(DRIFT_ROUNDS):
        near = timing.determined and abs(timing.shift) <= instant.CUSTOMARY * timing.interval
        rate = 0.0 if known or near else instant.clock_drift(axis)
        if rate == 0.0:
            break
        drift += rate
        axis = replace(axis, logs=tuple(instant.with_clock(log, torque, rate) for log in axis.logs))
        timing = instant.timing_of(axis)
    if drift != 0.0:
        words = f"the clocks of torque and angle drift apart by {1e6 * drift:.3g} parts in a million: "
        words += "corrected; record both with one clock"
        findings.append(Finding("clock-drift", words))
    plain = timing.moved(axis).regressed()
    found = replace(plain, findings=(*findings, *_doubts_of(axis), *plain.findings))
    found = _by_methods(axis, found, options, timing)
    auto = options.method == "auto"
    if len(logs) > 1 and options.check and auto and options.axis.friction.kind == "coulomb":
        each = [answer([log], replace(options, check=False)) for log in axis.logs]
        found = _compared(found, [one for one in each if not one.refused])
    if (left := found.residual["relative"]) > MOST_LEFT:
        words = (
            f"the residual is {100 * left:.0f} % of the torque, more than {100 * MOST_LEFT:g} %: too much to "
        )
        found = found.saying("residual", f"{words}check the model: record longer, or with a finer encoder")
    if REFUSING & set(found.codes):
        if auto and found.method["name"] == PREDICTION and plain.identifiable:
            # what least depends on what the model misses
            found = replace(
                plain,
                findings=found.findings,
                notes=(*found.notes, "the model does not fit: the values are those of inverse dynamics"),
                method={**found.method, **plain.method},
                checked=found.checked,
                check_reason=found.check_reason,
            )
        found = found.without_intervals("the model does not fit the log")
    return replace(found, reports=tuple(log.report for log in logs))


def without_outliers(log: Log, torque: str, findings: list[Finding]) -> Log:
    """A log with single samples far out of range replaced by straight lines; adds what was found."""
    values, places = log.channel(torque), np.arange(len(log))
    size = np.abs(values - np.median(values))
    far = size > FAR * float(np.quantile(size, 1.0 - MOST))
    if not 0 < far.sum() <= max(1, MOST * values.size):
        return log
    words = (
        f"{log.source}: {far.sum()} samples of {torque} lie far outside the others (up to "
        f"{values[size.argmax()]:.4g} {log.units[torque]}, the first at {log.time[far.argmax()]:.6g} s) and "
        "were replaced by straight lines: check the channel"
    )
    findings.append(Finding("outliers", words))
    return log.having(torque, np.interp(places, places[~far], values[~far]))


def _doubts_of(axis: Axis) -> list[Finding]:
    """What logs say of themselves before any model: a torque at an end of its range, an unlikely interval."""
    found = []
    for log in axis.logs:
        flat = log.saturated.get(axis.torque)
        if flat is not None and flat.any():
            words = (
                f"{log.source}: {axis.torque} stands at an end of its range in {100 * flat.mean():.2g} % of "
                "the samples, which were left out, and the model is not checked: give the sensor more range, "
                "or excite less"
            )
            found.append(Finding("saturated", words))
        if log.interval >= SLOWEST:
            words = f"{log.source}: the interval is {log.interval:.4g} s, too long for a drive's log: "
            words += 'is the time in milliseconds? Then write --column "time=COLUMN:ms"'
            found.append(Finding("interval", words))
    return found


def _by_methods(
    axis: Axis, found: Identification, options: IdentifyOptions, timing: instant.TorqueTiming
) -> Identification:
    """The answer by prediction error, or by what else was asked for or is possible; its model checked."""
    method, smooth = options.method, axis.options.friction.kind in ("coulomb", "tanh")
    if method == "output-error":
        return _checked(timing.moved(axis), refined(timing.moved(axis), timed(found, timing)), options)
    predicted, lost = None, False
    if method != "inverse-dynamics" and smooth:
        try:
            predicted, by_prediction = predict(axis, found, timing)
        except NotComputed as failure:
            if method == "prediction-error":
                raise
            lost = isinstance(failure, NotReproduced) and options.check
    elif method == "prediction-error":
        raise NotComputed("prediction error needs the model rigid-axis-coulomb or rigid-axis-tanh")
    if predicted is None:
        moved, chosen = timing.moved(axis), timed(found, timing)
        if smooth and found.identifiable and "negative" not in found.codes:
            chosen = with_own_error(moved, chosen)
        return _checked(moved, chosen.saying(NOT_FOLLOWED, LOST) if lost else chosen, options)
    moved = predicted.timing.moved(axis)
    chosen = _checked(moved, timed(by_prediction, predicted.timing), options)
    return _with_rest(chosen, predicted, turns=not axis.equation.linear) if options.check else chosen


def with_own_error(axis: Axis, found: Identification) -> Identification:
    """Inverse dynamics with what it misses in logs of a sound axis; said where that is not known."""
    try:
        fits = [twin.regressed() for twin in twin_axes(axis, values_of(found), SEED)]
    except NotReproduced as failure:
        return found.noting(own_error=f"not known: {failure}")
    misses = [fit.values - found.values for fit in fits]
    if not np.all(np.isfinite(misses)):
        return found.noting(own_error="not known: not identifiable")
    extra = unseen(misses, [fit.covariance for fit in fits])
    return found.refitted(found.values, found.covariance + extra, found.freedom, {})


def _checked(axis: Axis, chosen: Identification, options: IdentifyOptions) -> Identification:
    """The answer with the check of its model, or why there is none."""
    kind = axis.options.friction.kind
    if not options.check:
        return replace(chosen, check_reason="not requested")
    if kind not in ("coulomb", "tanh"):
        return replace(chosen, check_reason=f"not made: no check for friction {kind}")
    if NOT_FOLLOWED not in chosen.codes:
        try:
            return check.checked_by_innovations(axis, chosen)
        except NotReproduced:
            chosen = chosen.saying(NOT_FOLLOWED, LOST)
    return replace(chosen, checked=True, check_reason="the model does not reproduce the log")


def timed(found: Identification, timing: instant.TorqueTiming) -> Identification:
    """With what was found of the torque's instant."""
    found = found.noting(torque_shift=timing.shift, torque_shift_error=timing.error)
    if timing.stated:
        return found
    if timing.customary or not timing.determined:
        return found.noting(timing.words)
    return found.noting(torque_delay=-timing.shift).saying("torque-timing", timing.words)


def _compared(found: Identification, each: Sequence[Identification]) -> Identification:
    """The answer with a finding where logs of one axis exclude each other; ``each``: of one log by itself."""
    for one, other in combinations(each, 2):
        apart = []
        for name, a in one.parameters.items():
            b = other.parameters[name]
            off, joint = abs(a.value - b.value), np.hypot(a.standard_error, b.standard_error)
            if off > CONTRADICTION * joint and off > ALIKE * abs(a.value):
                apart.append(f"{name.replace('_', ' ')} {a.value:.4g} and {b.value:.4g}")
        if apart:
            return found.saying("logs-contradict", f"the logs contradict each other: {', '.join(apart)}")
    return found


def _with_rest(chosen: Identification, predicted: Predicted, *, turns: bool) -> Identification:
    """With what the observers that follow the logs best have to add to the torque."""
    tracks, values = predicted.observed.tracks, predicted.values
    runs = [run_of(track, values, best_bandwidth(track, values)) for track in tracks]
    share, words = max(map(check.unexplained, runs), key=itemgetter(0))
    chosen = chosen.noting(unexplained_torque=share)
    wave = max(map(check.position_wave, runs), key=itemgetter(0))[1] if turns else ""
    if wave:  # most of what is left, or far above all others
        return chosen.without(check.MISFIT).saying(check.MISFIT, f"the model does not fit: {wave}")
    said = words and check.MISFIT not in chosen.codes
    return chosen.saying("unexplained-torque", words) if said else chosen
