"""From logs to the answer for one axis: the methods that are possible, and whether they agree."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.identification.axis_refinement import (
    NOT_FOLLOWED,
    clock_drift,
    refine_rigid_axis,
    timing_of,
    with_clock,
)
from cabledrive.identification.estimates import Finding, Identification, code_of, without_intervals
from cabledrive.identification.innovations import NotReproduced, follow, inside_a_loop
from cabledrive.identification.log_doubts import (
    doubtful_interval,
    drifting_clocks,
    saturated_torque,
    without_outliers,
)
from cabledrive.identification.logs.log import Log
from cabledrive.identification.method_error import widened, with_own_error
from cabledrive.identification.model_check import MISFIT, checked_by_innovations, checked_by_lines
from cabledrive.identification.position_waves import position_wave, unexplained_torque
from cabledrive.identification.prediction_error import NAME as PREDICTION
from cabledrive.identification.prediction_error import Predicted, predict_from_some_instant
from cabledrive.identification.rigid_axis import AxisOptions, channels_of, identify_rigid_axis
from cabledrive.identification.torque_timing import (
    TorqueTiming,
    driven_by_lines,
    given_timing,
    noise_between_lines,
    with_torque_moved,
)
from cabledrive.parameters import NotComputed

CONTRADICTION = 5.0
"""Joint standard errors between two methods, or two logs, from which they contradict each other."""
ALIKE = 0.005
"""Share of the value within which no contradiction is stated."""


def contradicted(chosen: Identification, one: Identification, other: Identification) -> Identification:
    """The answer, with a finding where two methods exclude each other.

    ``one``, ``other``: by output error and by prediction error.
    """
    names = _excluding(one, other)
    if not names:
        return chosen
    words = "; ".join(
        f"{name.replace('_', ' ')} {one[name]:.4g} by output error, {other[name]:.4g} by prediction error"
        for name in names
    )
    finding = Finding("methods-contradict", f"two methods contradict each other on this log: {words}")
    return replace(chosen, findings=(*chosen.findings, finding))


def compared(found: Identification, each: Sequence[Identification]) -> Identification:
    """The answer, with a finding where logs of one axis exclude each other.

    ``found``: from all logs; ``each``: from each log by itself.
    """
    for k, one in enumerate(each):
        for other in each[k + 1 :]:
            names = _excluding(one, other)
            if names:
                words = ", ".join(
                    f"{name.replace('_', ' ')} {one[name]:.4g} and {other[name]:.4g}" for name in names
                )
                finding = Finding("logs-contradict", f"the logs contradict each other: {words}")
                return replace(found, findings=(*found.findings, finding))
    return found


def _excluding(one: Identification, other: Identification) -> list[str]:
    names = []
    for name, first in one.parameters.items():
        second = other.parameters[name]
        apart = abs(first.value - second.value)
        joint = float(np.hypot(first.standard_error, second.standard_error))
        if apart > CONTRADICTION * joint and apart > ALIKE * abs(first.value):
            names.append(name)
    return names


CHECKED = ("coulomb", "tanh")
AGREED = 0.5
"""Share of the difference of two methods that counts as a standard error of the one reported."""
DRIFT_ROUNDS = 3
"""Corrections of a drift between two clocks."""
REFUSING = (MISFIT, NOT_FOLLOWED, "unexplained-torque", "methods-contradict", "logs-contradict", "negative")
"""Codes of findings with which no interval is given."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """What is asked of the logs of one axis."""

    axis: AxisOptions
    method: str  # one of `cabledrive.identification.one_log.METHODS`
    check: bool  # whether the model is tested
    torque: str  # one of `cabledrive.identification.torque_timing.TIMINGS`


def answer(logs: Sequence[Log], request: Request) -> Identification:
    """Identify one axis from logs in memory.

    Raises `InputRefused` if a log is refused; `NotComputed` if a method is asked for that does not follow the
    logs.
    """
    torque, _ = channels_of(logs[0], request.axis)
    logs, outliers = without_outliers(logs, torque)
    known = request.torque != "found"
    interval = max(log.interval for log in logs)
    timing = given_timing(request.torque, interval) if known else timing_of(logs, request.axis)
    drift = 0.0
    for _ in range(DRIFT_ROUNDS):
        rate = 0.0 if known or timing.customary(interval) else clock_drift(logs, request.axis)
        if rate == 0.0:
            break
        drift += rate
        logs = [with_clock(log, torque, rate) for log in logs]
        timing = timing_of(logs, request.axis)
    axis = replace(request.axis, lag=not known)
    moved = with_torque_moved(logs, torque, timing)
    found = identify_rigid_axis(moved, axis)
    found = replace(
        found,
        findings=(
            *outliers,
            *drifting_clocks(drift),
            *saturated_torque(logs, torque),
            *doubtful_interval(logs),
            *found.findings,
        ),
    )
    found = _by_methods(logs, found, replace(request, axis=axis), timing)
    if len(logs) > 1 and request.check:
        found = compared(found, _each_alone(logs, replace(request, check=False)))
    if set(REFUSING) & set(found.codes):
        found = without_intervals(
            _averaged(found, moved, axis, request.method), "the model does not fit the log"
        )
    return replace(found, reports=tuple(log.report for log in logs))


def _each_alone(logs: Sequence[Log], request: Request) -> list[Identification]:
    """Each log by itself, where a method with intervals of its own is possible."""
    if request.axis.friction.kind != "coulomb" or request.method != "auto":
        return []
    return [found for found in (answer([log], request) for log in logs) if not found.refused]


def _averaged(found: Identification, moved: Sequence[Log], axis: AxisOptions, method: str) -> Identification:
    """Values of a refused model by inverse dynamics, which least depends on what the model misses."""
    if method != "auto" or found.method["name"] != PREDICTION:
        return found
    plain = identify_rigid_axis(moved, axis)
    if not plain.identifiable:
        return found
    kept = {key: value for key, value in found.method.items() if key not in plain.method}
    words = "the model does not fit: the values are those of inverse dynamics"
    return replace(
        found,
        parameters=plain.parameters,
        residual=plain.residual,
        condition_number=plain.condition_number,
        method=dict(plain.method) | kept,
        covariance=plain.covariance,
        freedom=plain.freedom,
        notes=(*found.notes, words),
    )


def _by_methods(
    logs: Sequence[Log], found: Identification, request: Request, timing: TorqueTiming
) -> Identification:
    """Every method that is possible; the one that answers, with the check of its model."""
    torque, _ = channels_of(logs[0], request.axis)
    options, method = request.axis, request.method
    sound = found.identifiable and "negative" not in found.codes
    turned = (
        next(iter(found.parameters.values())).high < 0.0
    )  # a negative inertia: swapped or reversed columns
    predicted, lost = (None, False) if turned else _predicted(logs, found, request, timing)
    if predicted is not None:
        timing, sound = predicted.timing, True
    moved = with_torque_moved(logs, torque, timing)
    found = _timed(found, timing, max(log.interval for log in logs))
    if not sound or options.friction.kind not in CHECKED:
        if method == "output-error":
            raise NotComputed("output error needs an identifiable rigid axis with one Coulomb friction")
        found = _not_followed(found, lost, request)
        if options.friction.kind != "coulomb" or not request.check:
            return replace(found, check_reason=_reason(request, options))
        return checked_by_innovations(moved, found, options)
    lines = driven_by_lines(moved, options)
    if lines and predicted is not None:
        raw = [log.channel(torque) for log in logs]
        lines = not inside_a_loop(raw, predicted.tracks, predicted.runs, timing.shift)
    alone = lines and noise_between_lines(moved, options)
    refined, why = None, ""
    if method == "output-error" or lines:
        try:
            refined = refine_rigid_axis(moved, found, options)
        except NotComputed as error:
            if method == "output-error":
                raise
            why = str(error)
    follows = refined is not None and NOT_FOLLOWED not in refined.codes
    if method == "output-error" and refined is not None and not follows:
        raise NotComputed(refined.findings[-1])
    chosen = _chosen(found, moved, request, refined if follows else None, predicted, alone)
    if refined is not None and not follows and alone:
        chosen = replace(chosen, findings=(*chosen.findings, refined.findings[-1]))
    elif alone and why:
        chosen = replace(chosen, findings=(*chosen.findings, Finding(NOT_FOLLOWED, why)))
    if follows and refined is not None and predicted is not None and method == "auto":
        chosen = contradicted(chosen, refined, _as_found(predicted, found))
        if chosen.method["name"] == refined.method["name"]:
            apart = [refined[name] - predicted.identification[name] for name in refined.parameters]
            chosen = widened(chosen, AGREED**2 * np.outer(apart, apart))
    if not alone:
        chosen = _not_followed(chosen, lost, request)
    return _checked(chosen, moved, request, refined if follows and alone else None, predicted)


def _reason(request: Request, options: AxisOptions) -> str:
    if not request.check:
        return "not requested"
    return f"not made: no check for friction {options.friction.kind}"


def _predicted(
    logs: Sequence[Log], found: Identification, request: Request, timing: TorqueTiming
) -> tuple[Predicted | None, bool]:
    """Prediction error where it is possible; whether its observer lost the log."""
    torque, _ = channels_of(logs[0], request.axis)
    forced = request.method == "prediction-error"
    if request.axis.friction.kind != "coulomb" or request.method in ("inverse-dynamics", "output-error"):
        if forced:
            raise NotComputed("prediction error needs the model rigid-axis-coulomb")
        return None, False
    try:
        if any(torque in log.saturated and log.saturated[torque].any() for log in logs):
            raise NotComputed("the torque saturates")
        return predict_from_some_instant(logs, found, request.axis, timing), False
    except NotComputed as failure:
        if forced:
            raise
        return None, isinstance(failure, NotReproduced)


def _not_followed(found: Identification, lost: bool, request: Request) -> Identification:
    """A finding where an observer with the axis's own figures loses the log."""
    if not lost or not request.check:
        return found
    words = (
        "a rigid axis with constant friction does not reproduce the log: another model is needed, or a "
        "disturbance acts"
    )
    return replace(found, findings=(*found.findings, Finding(NOT_FOLLOWED, words)))


def _timed(found: Identification, timing: TorqueTiming, interval: float) -> Identification:
    """With what was found of the torque's instant."""
    method = dict(found.method) | {"torque_shift": timing.shift, "torque_shift_error": timing.error}
    if timing.known:
        return replace(found, method=method)
    words = timing.words(interval)
    if timing.customary(interval) or not timing.determined:
        return replace(found, method=method, notes=(*found.notes, words))
    late = Finding("torque-timing", words)
    return replace(found, method=method | {"torque_delay": -timing.shift}, findings=(*found.findings, late))


def _as_found(predicted: Predicted, found: Identification) -> Identification:
    """Prediction error with what was said of the log before."""
    return replace(
        predicted.identification,
        findings=found.findings,
        notes=found.notes,
        method=dict(predicted.identification.method)
        | {key: value for key, value in found.method.items() if key.startswith("torque_")},
    )


def _chosen(
    found: Identification,
    moved: Sequence[Log],
    request: Request,
    refined: Identification | None,
    predicted: Predicted | None,
    alone: bool,
) -> Identification:
    """The method that answers."""
    if request.method == "inverse-dynamics":
        return with_own_error(found, moved, request.axis)
    if refined is not None and (request.method == "output-error" or alone):
        return refined
    if predicted is not None:
        return _as_found(predicted, found)
    return refined if refined is not None else with_own_error(found, moved, request.axis)


def _checked(
    chosen: Identification,
    moved: Sequence[Log],
    request: Request,
    refined: Identification | None,
    predicted: Predicted | None,
) -> Identification:
    """With what the check of the model found."""
    if not request.check:
        return replace(chosen, check_reason="not requested")
    if NOT_FOLLOWED in chosen.codes:
        return replace(chosen, checked=True, check_reason="the model does not reproduce the log")
    if refined is not None:
        chosen = checked_by_lines(moved, chosen, refined, request.axis)
    else:
        chosen = checked_by_innovations(moved, chosen, request.axis)
    if predicted is None:
        return chosen
    followed = [follow(track, predicted.values) for track in predicted.tracks]
    left = unexplained_torque(followed)
    method = dict(chosen.method) | {"unexplained_torque": left.share}
    chosen = replace(chosen, method=method)
    turns = "inertia" in chosen.parameters
    wave = position_wave(followed) if turns else None
    if wave is not None and wave.share > _share_by_lines(chosen):
        others = tuple(one for one in chosen.findings if code_of(one) != MISFIT)
        words = f"the model does not fit: {wave.words}"
        return replace(chosen, findings=(*others, Finding(MISFIT, words)))
    if not left.beyond or MISFIT in chosen.codes:
        return chosen
    return replace(chosen, findings=(*chosen.findings, Finding("unexplained-torque", left.words)))


def _share_by_lines(found: Identification) -> float:
    """Largest share of the residual that a fault beyond chance explains, with its family; 0 without one."""
    tried = found.method.get("suspicions", {}) if MISFIT in found.codes else {}
    shares = [
        one["family_share"]
        for one in tried.values()
        if "family_share" in one and one["significance"] > one["critical"]
    ]
    return max(shares, default=0.0)
