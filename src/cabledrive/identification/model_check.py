r"""An answer with what the check of its model found, and two laws of friction compared.

Both follow the log; the weighted squares of their residuals are summed in each segment of time. If the laws
were equally far from the truth, the mean of the differences :math:`d_b` would be zero, and

.. math:: t = \sqrt{G}\,\bar d / s_d

Student's t of G - 1 degrees of freedom: Q. H. Vuong, "Likelihood ratio tests for model selection and
non-nested hypotheses", Econometrica 57(2), 307-333, 1989.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.axis_case import case_of, simulated, weighed
from cabledrive.identification.axis_refinement import refine_rigid_axis
from cabledrive.identification.diagnosis import FAULTS, Suspicion, critical, suspicions, verdict
from cabledrive.identification.estimates import Finding, Identification
from cabledrive.identification.fault_evidence import SHORT as FAULT_NAMES
from cabledrive.identification.fault_evidence import evidence_words, material, named, unseen
from cabledrive.identification.logs.log import Log
from cabledrive.identification.loop_check import evidence, period_of
from cabledrive.identification.regression import MOST_SEGMENTS
from cabledrive.identification.rigid_axis import AxisOptions, channels_of, equation_for, identify_rigid_axis
from cabledrive.identification.torque_timing import TorqueTiming, torque_delay
from cabledrive.parameters import NotComputed

Array = NDArray[np.float64]


def other_law(
    logs: Sequence[Log], refined: Identification, options: AxisOptions, suspected: Sequence[Suspicion]
) -> Suspicion | None:
    """Evidence for the smooth law where Coulomb's was fitted, and the other way round.

    ``refined``: by output error, with Coulomb or smooth friction; ``options``: those it was found with;
    ``suspected``: what was found without it; they share the chance of a false alarm with this one.
    Returns of "slope" or "jump"; None where the other law gives no machine, or follows no better.
    """
    smooth = options.friction.kind == "coulomb"
    other = replace(options, friction=replace(options.friction, kind="tanh" if smooth else "coulomb"))
    try:
        found = identify_rigid_axis(logs, other)
        if (
            not found.identifiable
            or min(found["coulomb_friction"], found[next(iter(found.parameters))]) <= 0.0
        ):
            return None
        rival = refine_rigid_axis(logs, found, other)
    except NotComputed:
        return None
    squares = _squares(logs, [(refined, options), (rival, other)])
    difference = squares[0] - squares[1]
    if difference.sum() <= 0.0:
        return None
    count, gain = difference.size, float(difference.sum() / squares[0].sum())
    return Suspicion(
        fault="slope" if smooth else "jump",
        significance=float(np.sqrt(count) * difference.mean() / difference.std(ddof=1)),
        critical=critical(len(suspected) + 1, count - 1),
        gain=gain,
        family_gain=max(gain, *(s.family_gain for s in suspected)),
        value=options.friction.slope,
        from_law=True,
    )


def _squares(logs: Sequence[Log], rivals: Sequence[tuple[Identification, AxisOptions]]) -> Array:
    """Weighted squares of the residuals of each rival in segments of all logs, weights of the first."""
    sums: list[list[float]] = [[] for _ in rivals]
    weights: list[Array | None] = []
    for number, (found, options) in enumerate(rivals):
        torque, position = channels_of(logs[0], options)
        equation = equation_for(logs, torque, position, options)
        values = np.array([estimate.value for estimate in found.parameters.values()])
        cases = [case_of(log, torque, position, equation) for log in logs]
        if number == 0:
            weights = [c.weights for c in weighed(cases, values, np.array([c.start for c in cases]))]
        for case, weight in zip(cases, weights, strict=True):
            residual, slopes = simulated(replace(case, weights=weight), values, case.start)
            if case.lag:  # the instant of the torque is free under either law
                residual = residual - slopes[:, 5] * (slopes[:, 5] @ residual) / (slopes[:, 5] @ slopes[:, 5])
            count = max(6, MOST_SEGMENTS // len(logs))
            sums[number] += [float(part @ part) for part in np.array_split(residual, count)]
    return np.array(sums)


NOT_MADE = {
    "saturated": "not made: the torque saturates, so the torque on the axis is not known",
    "smooth": "not made: the torque is not a sum of lines, and for such logs only Coulomb friction can be "
    "checked",
    "long": "not made: the log is read in blocks",
    "parameters": "not made: inertia and friction are not identifiable from the log",
}
MISFIT = "model-misfit"
LINES = "disturbances of known faults added to the refined model"
INNOVATIONS = "innovations of an observer"
NOISE_SEED = 4016
"""Seed of the noise in the simulated logs for comparison: the same log gives the same result."""


def checked_by_lines(
    read: Sequence[Log], answer: Identification, refined: Identification, options: AxisOptions
) -> Identification:
    """The answer with what the check of a torque of spectral lines found.

    ``refined``: by output error.
    """
    method = dict(answer.method)
    found = suspicions(read, refined, options)
    if verdict(found) is not None:
        rival = other_law(read, refined, options, found)
        found = found if rival is None else (*found, rival)
    method["suspicions"] = {
        s.fault: {
            "significance": s.significance,
            "critical": s.critical,
            "value": s.value,
            "family_share": s.family_gain,
        }
        for s in found
    }
    answer = replace(answer, checked=True, check_reason=LINES)
    fault = verdict(found, _unexplained_shift(answer, read[0].interval))
    if fault is None:
        return replace(answer, method=method)
    value = next((s.value for s in found if s.fault == fault), 0.0)
    words = FAULTS[fault].format(value=value)
    if fault == "delay":
        words, measured = _delay_words(read, options, value, lambda moved: _left_by_lines(moved, options))
        method |= measured
    finding = Finding(MISFIT, f"the model does not fit: {words}")
    return replace(answer, method=method, findings=(*answer.findings, finding))


def _unexplained_shift(answer: Identification, interval: float) -> bool:
    """Whether the torque was moved by a time that is no convention of logging."""
    shift = float(answer.method.get("torque_shift", 0.0))
    error = float(answer.method.get("torque_shift_error", 0.0))
    return TorqueTiming(shift=shift, error=error).convention(interval) is None


def checked_by_innovations(
    read: Sequence[Log], answer: Identification, options: AxisOptions
) -> Identification:
    """The answer with what the check of any torque found, or why it was not made."""
    method = dict(answer.method)
    reason = _not_made(read, answer, options)
    if reason is not None:
        return replace(
            answer, method=method | {"model_check": NOT_MADE[reason]}, check_reason=NOT_MADE[reason]
        )
    try:
        found = evidence(read, answer, options, np.random.default_rng(NOISE_SEED))
    except NotComputed as failure:
        words = f"not possible: {failure}"
        return replace(answer, method=method | {"model_check": words}, check_reason=words)
    answer = replace(answer, checked=True, check_reason=INNOVATIONS)
    method |= {"model_check": INNOVATIONS, "suspicions": {e.fault: e.as_dict() for e in found}}
    half_widths = [0.5 * (one.high - one.low) for one in answer.parameters.values()]
    faults = named(material(found, half_widths))
    small = [FAULT_NAMES[one.fault] for one in found if one.alarms] if not faults else []
    if small:
        words = f"significant, but no parameter changes by as much as its interval: {', '.join(small)}"
        answer = replace(answer, notes=(*answer.notes, words))
    if not faults:
        hidden = unseen(found, half_widths) if _repeats(read, options) else ()
        if hidden:
            method |= {"cannot_show": [one.fault for one in hidden]}
            names = ", ".join(FAULT_NAMES[one.fault] for one in hidden)
            words = (
                f"the motion repeats, so this log cannot show a fault that makes the intervals wrong: {names}"
            )
            answer = replace(answer, notes=(*answer.notes, words))
        return replace(answer, method=method)
    first = None
    if faults[0].fault == "delay":
        value = faults[0].value
        first, measured = _delay_words(read, options, value, lambda moved: _left_beside(moved, options))
        method |= measured
    finding = Finding(MISFIT, evidence_words(faults, first))
    return replace(answer, method=method, findings=(*answer.findings, finding))


def _repeats(read: Sequence[Log], options: AxisOptions) -> bool:
    """Whether the torque of every log repeats."""
    torque, _ = channels_of(read[0], options)
    return all(period_of(log.channel(torque), log.interval) > 0 for log in read)


def _delay_words(
    read: Sequence[Log], options: AxisOptions, first: float, left_in: Callable[[Sequence[Log]], float]
) -> tuple[str, dict[str, float]]:
    """The delay in words, and measured where it is one."""
    try:
        delay = torque_delay(read, options, first, left_in)
    except NotComputed as failure:
        return f"the motion lags the torque, by more than a delay: {failure}", {}
    return FAULTS["delay"].format(value=delay), {"torque_delay": delay}


def _left_by_lines(logs: Sequence[Log], options: AxisOptions) -> float:
    refined = refine_rigid_axis(logs, identify_rigid_axis(logs, options), options)
    return next(s.value for s in suspicions(logs, refined, options) if s.fault == "delay")


def _left_beside(logs: Sequence[Log], options: AxisOptions) -> float:
    """Below a sample, which the check leaves free, there is none."""
    rng = np.random.default_rng(NOISE_SEED)
    found = evidence(logs, identify_rigid_axis(logs, options), options, rng)
    return next((e.value for e in found if e.fault == "delay"), 0.0)


def _not_made(read: Sequence[Log], answer: Identification, options: AxisOptions) -> str | None:
    """Key of `NOT_MADE`, or None where the check can be made; viscous friction need not be known for it."""
    torque, _ = channels_of(read[0], options)
    if any(torque in log.saturated and log.saturated[torque].any() for log in read):
        return "saturated"
    if options.friction.kind != "coulomb":
        return "smooth"
    inertia, _, coulomb, offset = (estimate.value for estimate in answer.parameters.values())
    return None if inertia > 0.0 and coulomb > 0.0 and np.isfinite(offset) else "parameters"
