r"""Is the model right where spectral lines move the axis? The residual of its simulated speed, by faults.

The refined model moves by itself under the torque's spectral lines, free of noise. To the torque x of a fault
the speed answers with :math:`x/(Js + b)`. No regressor carries noise, so a sound log raises no alarm.

Coulomb's law and a smooth one do not contain one another. Both follow the log; the weighted squares of their
residuals are summed in each segment of time. If the laws were equally far from the truth, the mean of the
differences :math:`d_b` would be zero, and :math:`t = \sqrt{G}\,\bar d / s_d` Student's t of G - 1 degrees of
freedom: Q. H. Vuong, "Likelihood ratio tests for model selection and non-nested hypotheses", Econometrica
57(2), 307-333, 1989.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import exp

import numpy as np
from scipy import signal

from cabledrive.identification.axis.axis import BASE, Axis, stacked
from cabledrive.identification.axis.equation import LAG
from cabledrive.identification.axis.faults import (
    DELAY,
    FAULTS,
    STRIBECK,
    Evidence,
    critical,
    friction_torques,
    strongest,
)
from cabledrive.identification.axis.simulated import Case, case_of, refined, weighed_cases
from cabledrive.identification.estimates import Identification
from cabledrive.identification.regression import MOST_SEGMENTS, Factors, only, solve, suited_segments
from cabledrive.identification.signals import difference, zero_phase
from cabledrive.parameters import NotComputed
from cabledrive.parameters.arrays import Array

ALONE, HALF = 0.9, 0.5
"""Share of its family's explanation that a spring or a delay, and that a law of friction, reaches alone."""
GAPS = (0.005, 0.0175)
"""Backlash widths that are tried [rad or m]."""


def evidence_by_lines(axis: Axis, answer: Identification) -> tuple[Evidence, ...]:
    """Evidence for each fault from the residual of the simulated speed, that which explains most first."""
    values, parts = answer.values, []
    for case in weighed_cases(axis, values):
        residual, slopes = case.residual(values, case.start)
        answers = _answers(case, values)
        if case.lag:
            answers[LAG] = slopes[:, 5]
            del answers[DELAY]
        names = (*BASE, "start", *answers)
        parts.append((np.column_stack([slopes[:, :5], *answers.values()]), residual))
    factors = suited_segments(stacked(names, parts, 40))
    tried = tuple(name for name in names[len(BASE) + 1 :] if name != LAG)
    return strongest(sorted((_by_lines(factors, name, len(tried)) for name in tried), key=lambda e: e.gain))


def _answers(case: Case, values: Array) -> dict[str, Array]:
    """Speeds that the faults would add along the model's own motion, filtered as the residual is."""
    h = case.interval
    speed, _ = case.moved(values, case.lines, case.start)
    smooth = zero_phase(speed, h, case.bandwidth)
    acceleration = difference(smooth, h)
    torques = {
        DELAY: difference(zero_phase(case.lines, h, case.bandwidth), h),
        "flexibility": difference(difference(acceleration, h), h),
        **friction_torques(speed, np.sign(speed), STRIBECK),
        **{f"backlash:{gap:g}": acceleration * loose(speed, acceleration, gap, h) for gap in GAPS},
    }
    del torques["quadratic"]
    pole = exp(-values[1] / values[0] * h)
    gain = (1.0 - pole) / values[1] if values[1] != 0.0 else h / values[0]
    answered = signal.lfilter([0.0, gain], [1.0, -pole], np.column_stack([*torques.values()]), axis=0)
    return dict(zip(torques, case.compared(case.filtered(answered)).T, strict=True))


def loose(speed: Array, acceleration: Array, gap: float, interval: float) -> Array:
    """Where a load with backlash would be loose: from each change of its drive until the gap is crossed."""
    free = np.zeros(speed.size)
    turns = np.flatnonzero(np.diff(np.sign(acceleration)) != 0)
    for start, end in zip(turns, [*turns[1:], speed.size - 1], strict=True):
        crossed = np.flatnonzero(np.abs(np.cumsum(speed[start:end] - speed[start]) * interval) > gap)
        free[start : start + (int(crossed[0]) if crossed.size else end - start)] = 1.0
    return free


def _by_lines(factors: Factors, name: str, tried: int) -> Evidence:
    rigid = (*BASE, "start", *((LAG,) if LAG in factors.names else ()))
    family = FAULTS[name.partition(":")[0]][0]
    kin = tuple(n for n in factors.names if FAULTS.get(n.partition(":")[0], ("",))[0] == family)
    without, beside, whole = (solve(only(factors, (*rigid, *n))) for n in ((), (name,), kin))
    power = max(without.residual**2, 1e-300)
    return Evidence(
        name=name,
        value=float(beside.values[-1]),
        error=float(np.sqrt(beside.covariance[-1, -1])),
        critical=critical(tried, beside.freedom),
        gain=1.0 - beside.residual**2 / power,
        family_gain=1.0 - whole.residual**2 / power,
    )


def other_law(axis: Axis, answer: Identification, suspected: Sequence[Evidence]) -> Evidence | None:
    """Evidence for the smooth law where Coulomb's was fitted, and the other way round."""
    smooth = axis.options.friction.kind == "coulomb"
    friction = replace(axis.options.friction, kind="tanh" if smooth else "coulomb")
    options, equation = replace(axis.options, friction=friction), replace(axis.equation, friction=friction)
    other = replace(axis, options=options, equation=equation)
    try:
        found = other.regressed()
        if not found.identifiable or min(found["coulomb_friction"], found.values[0]) <= 0.0:
            return None
        rival = refined(other, found)
    except NotComputed:
        return None
    weights = [case.weights for case in weighed_cases(axis, answer.values)]
    ours, theirs = _squares(axis, answer, weights), _squares(other, rival, weights)
    better = ours - theirs
    if better.sum() <= 0.0:
        return None
    gain, slope = float(better.sum() / ours.sum()), axis.options.friction.slope
    significance = float(np.sqrt(better.size) * better.mean() / better.std(ddof=1))
    return Evidence(
        name="slope" if smooth else "jump",
        value=slope,
        error=slope / significance,
        critical=critical(len(suspected) + 1, better.size - 1),
        gain=gain,
        family_gain=max(gain, *(_shared(s) for s in suspected)),
        from_law=True,
    )


def _squares(axis: Axis, answer: Identification, weights: Sequence[Array | None]) -> Array:
    """Weighted squares of the residuals in segments of all logs; the torque's instant is free."""
    values, sums, count = answer.values, [], max(6, MOST_SEGMENTS // len(axis.logs))
    for log, weight in zip(axis.logs, weights, strict=True):
        case = replace(case_of(axis, log), weights=weight)
        residual, slopes = case.residual(values, case.start)
        if case.lag:
            late = slopes[:, 5]
            residual = residual - late * (late @ residual) / (late @ late)
        sums += [float(part @ part) for part in np.array_split(residual, count)]
    return np.array(sums)


def verdict_by_lines(found: Sequence[Evidence], late: bool = False) -> Evidence | None:
    """The fault that the evidence speaks for: of the family that explains most, the plainest that suffices.

    A law of friction that alone explains half of it is the reason; other friction shows by its sign: more
    near standstill, or less. A spring makes the apparent inertia rise with frequency, a delayed channel makes
    a lag, backlash does both and more.

    ``late``: the torque was moved by a time that is no convention of logging.
    """
    beyond = [s for s in found if s.alarms]
    if not beyond:
        return None
    family = max(beyond, key=_shared).family
    if late and any(s.family == "link" for s in beyond) and not any(s.from_law for s in found):
        family = "link"  # a torque that seems moved in time, and no other law of friction explains it
    top = max((s for s in found if s.family == family), key=lambda s: s.gain)
    if family == "link":
        lags = late or any(s.fault == DELAY and s.value > 0.0 for s in beyond)
        fitted = DELAY not in {
            s.fault for s in found
        }  # the lag is a parameter: what a spring leaves, backlash
        alone = top.gain > ALONE * _shared(top) or (top.fault == "flexibility" and not lags and not fitted)
        return top if alone else next((s for s in found if s.fault == "backlash"), top)
    if family == "friction":
        law = next((s for s in found if s.from_law), None)
        if law is not None and law.gain > HALF * _shared(law):
            return law
        near_rest = next(s for s in found if s.fault == "stribeck")
        return near_rest if near_rest.value > 0.0 else next(s for s in found if s.fault == "slope")
    return top


def _shared(one: Evidence) -> float:
    return one.family_gain or 0.0
