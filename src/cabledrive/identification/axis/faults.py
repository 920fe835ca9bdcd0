r"""What speaks for each fault of an axis: the torque that it would add, against what the model leaves.

A fault acts on the axis like a disturbing torque that is known up to a factor, written so that the fault
makes the factor positive. The factor and its error follow by least squares beside the parameters themselves.

Where nothing but spectral lines moves the axis, the refined model moves by itself under them, free of noise.
To the torque x of a fault the speed answers with :math:`x/(Js + b)`, which is held against the residual of
the speed. Coulomb's law and a smooth one do not contain one another. Both follow the log; the weighted
squares of their residuals are summed in each segment of time. If the laws were equally far from the truth,
the mean of the differences :math:`d_b` would be zero, and :math:`t = \sqrt{G}\,\bar d / s_d` Student's t of
G - 1 degrees of freedom: Q. H. Vuong, Econometrica 57(2), 307-333, 1989.

Elsewhere the observer's answer is held against its innovations, the error taken from the factor's
contributions :math:`g_b` in segments of time by the differences of neighbours,

.. math:: C = \frac{G}{2(G-1)}\sum_b (g_b - g_{b-1})^2 ,

so that a fault that shows in a part of the log only does not hide itself in its own scatter. A factor beyond
Student's t is then tried again: what logs of a sound axis show, and the doubt about the hold of the torque,
are added to C.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import exp

import numpy as np
from scipy import signal, stats

from cabledrive.identification import estimates
from cabledrive.identification.axis import observer
from cabledrive.identification.axis.axis import BASE, Axis, stacked, values_of
from cabledrive.identification.axis.equation import LAG, loosen
from cabledrive.identification.axis.observer import NotReproduced, Observed, Prediction
from cabledrive.identification.axis.simulated import Case, case_of, refined, weighed_cases
from cabledrive.identification.estimates import Factors, Fit, Identification
from cabledrive.identification.signals import difference, zero_phase
from cabledrive.parameters import NotComputed
from cabledrive.parameters.arrays import Array

FALSE_ALARMS = 0.001
"""Probability that a log without faults raises an alarm, shared by all disturbances tried (Bonferroni)."""
SEED = 4016
"""Of the noise in logs of a sound axis: the same log gives the same result."""
ROUNDS = 3
"""Corrections of the four parameters."""
EFFICIENCY = 2 / 3
"""Of a variance from differences of neighbours, against one from the same number of deviations."""

STRIBECK = (0.01, 0.03, 0.1, 0.3)
"""Fading speeds that are tried, in root mean square speeds; the slowest under lines alone."""
SLOPES = (1.0, 4.0)
"""Slopes of a smooth friction that are tried, over that speed."""
WAVES, RESONANCES, DAMPING = 4, (25.0, 50.0, 100.0), 0.1
"""Half waves of the stroke; resonances of a joint [Hz], and their damping ratio."""
TURNING_GAPS, LINEAR_GAPS = (0.25, 1.0), (0.0005, 0.005)
"""Backlash that is tried: of a turning axis [deg], and of a linear one [strokes]."""
CONTACT = 0.005
"""Time in which both sides of a backlash reach one speed [s]."""
ALONE, HALF = 0.9, 0.5
"""Share of its family's explanation that a spring or a delay, and that a law of friction, reaches alone."""
GAPS = (0.005, 0.0175)
"""Backlash widths that are tried [rad or m]."""
DELAY = "delay"

FAULTS = {  # family, whether only a positive factor indicates it, the fault in short and in a sentence
    "stribeck": ("friction", True, "Stribeck friction",
        "friction is higher near standstill than the model says: Stribeck friction"),
    "slope": ("friction", True, "a smooth law of friction",
        "friction rises smoothly with speed instead of jumping: c tanh(K w)"),
    "jump": ("friction", True, "Coulomb friction",
        "friction jumps where the speed changes sign: Coulomb friction instead of c tanh(K w)"),
    "quadratic": ("friction", True, "friction that rises faster than the speed",
        "friction rises faster than in proportion to the speed"),
    "load": ("friction", True, "friction that grows with the load",
        "friction grows with the torque that is carried"),
    "asymmetry": ("asymmetry", False, "viscous friction that differs between both directions",
        "viscous friction differs between both directions"),
    "position": ("position", False, "a torque that depends on the position",
        "a torque depends on the position: cogging, a screw's or guide's error, a weight"),
    "flexibility": ("link", True, "a flexible joint",
        "the apparent inertia rises with frequency: a flexible joint or belt, not one rigid axis"),
    "backlash": ("link", True, "backlash",
        "the apparent inertia is smaller while the torque changes sign: backlash"),
    DELAY: ("link", False, "a delay of the torque channel",
        "the torque channel is delayed against the motion by {value:.3g} s: shift it"),
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """One disturbing torque with the evidence for it."""

    name: str  # fault, and what was tried of it after a colon
    # value, error: factor and standard error
    value: float
    error: float
    critical: float  # significance that a sound log exceeds at any disturbance with the chance `FALSE_ALARMS`
    gain: float  # share of the residual's power that it explains
    family_gain: float | None = None  # under lines: share that all faults of its family explain together
    shift: tuple[float, ...] = ()  # what it would change in the four parameters
    from_law: bool = False  # whether it comes from the comparison of two laws of friction

    @property
    def fault(self) -> str:
        """Key of `FAULTS`."""
        return self.name.partition(":")[0]

    @property
    def family(self) -> str:
        """Faults that a log separates least."""
        return FAULTS[self.fault][0]

    @property
    def significance(self) -> float:
        """Factor over its standard error; negative where its sign speaks against the fault, but by lines."""
        one_sided = FAULTS[self.fault][1] and self.family_gain is None
        return (self.value if one_sided else abs(self.value)) / self.error if self.error > 0.0 else 0.0

    @property
    def shared(self) -> float:
        """Share that its family explains under lines."""
        return self.family_gain or 0.0

    @property
    def alarms(self) -> bool:
        """Whether it is beyond chance."""
        return self.significance > self.critical

    def moves(self, half_widths: Sequence[float], share: float, times: float = 1.0) -> bool:
        """Whether so many times it would change a parameter by a share of half its interval."""
        return any(times * abs(s) > share * half for s, half in zip(self.shift, half_widths, strict=False))

    def as_dict(self) -> dict[str, float]:
        """Numbers as the answer has them."""
        shared = {} if self.family_gain is None else {"family_share": self.family_gain}
        return {"significance": self.significance, "critical": self.critical, "value": self.value} | shared


def friction_torques(speed: Array, direction: Array, fading: Sequence[float]) -> dict[str, Array]:
    """What other laws of friction would add, each (samples,); ``direction``: 0 where the axis sticks."""
    size = float(np.sqrt(np.mean(speed**2)))
    return {
        "asymmetry": -np.abs(speed),
        "quadratic": -speed * np.abs(speed) / size,
        **{f"stribeck:{s:g}": -direction * np.exp(-((speed / (s * size)) ** 2)) for s in fading},
        **{f"slope:{s:g}": direction - np.tanh(s * speed / size) for s in SLOPES},
    }


def critical(tried: int, freedom: float) -> float:
    """Significance beyond chance among several trials: Student's t of their share of `FALSE_ALARMS`."""
    return float(stats.t.isf(0.5 * FALSE_ALARMS / tried, freedom))


def _strongest(found: Iterable[Evidence]) -> tuple[Evidence, ...]:
    """The best of each fault, that which explains most first."""
    best = {
        one.fault: one for one in sorted(found, key=lambda e: (e.family_gain is None and e.alarms, e.gain))
    }
    return tuple(sorted(best.values(), key=lambda e: -e.gain))


def evidence_by_innovations(axis: Axis, found: Identification) -> tuple[Evidence, ...]:
    """Evidence for each fault in logs of any torque, the best of each, that which explains most first."""
    values = values_of(found)
    seen = observer.observed(axis, values, observer.SLOWER)
    for _ in range(ROUNDS):
        values = values + estimates.solve(seen.factors(values)).values[: len(BASE)]
        if not np.all(np.isfinite(values)) or values[0] <= 0.0 or values[2] < 0.0:
            raise NotReproduced

    def factors_of(these: Observed) -> Factors:
        return these.factors(values, lambda run: _fault_torques(axis, run), observer.HELD_DOUBT)

    factors = factors_of(seen)
    names = tuple(name for name in factors.names if name not in (*observer.NUISANCE, observer.HOLD))
    every = [_by_innovations(factors, name, len(names) + 1) for name in (*names, DELAY)]
    if abs(every[-1].value) <= axis.interval:  # less than a sample is left free
        del every[-1]
    if any(e.alarms for e in every):  # what sound logs show, and the doubt about the hold of the torque
        sound = [factors_of(twin) for twin in seen.twins(values, SEED)]
        for k, e in enumerate(every):
            misses = [_factor_of(made, e.name) for made in sound]
            unseen = max(0.0, float(np.mean([float(fit.values[-1]) ** 2 - b**2 for fit, b in misses])))
            doubt = float(_factor_of(factors, e.name, observer.HOLD)[0].values[-1])
            every[k] = replace(e, error=float(np.sqrt(e.error**2 + unseen + doubt**2)))
    repeated = float(np.sqrt(seen.repetition(values)))
    every = [replace(e, error=repeated * e.error) for e in every]
    return _strongest(every)


def _fault_torques(axis: Axis, run: Prediction) -> dict[str, Array]:
    """What each fault would add along the motion that the observer foresees, each (samples,)."""
    net, track = run.values[0] * run.acceleration, run.track
    h, stroke = track.interval, float(np.ptp(track.position))
    place = (track.position - track.position.min()) / stroke
    found = friction_torques(run.speed, run.direction, STRIBECK[1:])
    found["load"] = -run.direction * np.abs(net)
    found |= {f"position:{k}": np.cos(np.pi * k * place) for k in range(1, WAVES + 1)}
    for hertz in RESONANCES:
        if hertz < 0.2 / axis.interval:
            omega = 2 * np.pi * hertz  # s^2 / (s^2 + 2 zeta omega s + omega^2) of the torque that accelerates
            spring = signal.bilinear([1.0, 0.0, 0.0], [1.0, 2 * DAMPING * omega, omega**2], 1.0 / h)
            found[f"flexibility:{hertz:g}"] = np.asarray(signal.lfilter(*spring, net))
    whole = float(np.ptp(axis.logs[0].channel(axis.position)))
    for gap in LINEAR_GAPS if axis.equation.linear else TURNING_GAPS:
        gap = gap * whole if axis.equation.linear else float(np.radians(gap))
        added = found[f"backlash:{gap:.3g}"] = np.empty_like(net)
        loosen(net, run.speed, gap, h, max(1, round(CONTACT / h)), added)
    return found


def _factor_of(factors: Factors, name: str, left: str = "") -> tuple[Fit, float]:
    """The fit whose last factor is that of one disturbance, and its standard error by differences."""
    names = observer.NUISANCE if name == DELAY else (*observer.NUISANCE, name)
    part = estimates.only(factors, names, left)
    fit = estimates.solve(part)
    whole = estimates.triangle(part.triangles.reshape(-1, len(names) + 1))[: len(names), :-1]
    inner = np.linalg.lstsq(whole.T, estimates.scores(part, fit.values).T, rcond=None)[0]
    moved = np.linalg.lstsq(whole, inner, rcond=None)[0][-1]
    error = np.sqrt(0.5 * np.sum(np.diff(moved) ** 2) * moved.size / (moved.size - 1))
    return fit, float(error)


def _by_innovations(factors: Factors, name: str, tried: int) -> Evidence:
    whole, error = _factor_of(factors, name)
    without = estimates.solve(estimates.only(factors, BASE if name == DELAY else observer.NUISANCE))
    return Evidence(
        name=name,
        value=float(whole.values[-1]),
        error=error,
        critical=critical(tried, EFFICIENCY * factors.triangles.shape[0]),
        gain=1.0 - float(whole.residual) ** 2 / without.residual**2,
        shift=tuple((whole.values[: len(BASE)] - without.values[: len(BASE)]).tolist()),
    )


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
    factors = estimates.suited_segments(stacked(names, parts, 40))
    tried = tuple(name for name in names[len(BASE) + 1 :] if name != LAG)
    return _strongest(_by_lines(factors, name, len(tried)) for name in tried)


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
    without, beside, whole = (
        estimates.solve(estimates.only(factors, (*rigid, *n))) for n in ((), (name,), kin)
    )
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
    ours = _squares(axis, answer.values, weights)
    better = ours - _squares(other, rival.values, weights)
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
        family_gain=max(gain, *(s.shared for s in suspected)),
        from_law=True,
    )


def _squares(axis: Axis, values: Array, weights: Sequence[Array | None]) -> Array:
    """Weighted squares of the residuals in segments of all logs; the torque's instant is free."""
    sums, count = [], max(6, estimates.MOST_SEGMENTS // len(axis.logs))
    for log, weight in zip(axis.logs, weights, strict=True):
        case = replace(case_of(axis, log), weights=weight)
        residual, slopes = case.residual(values, case.start)
        if case.lag:
            late = slopes[:, 5]
            residual = residual - late * (late @ residual) / (late @ late)
        sums += [float(part @ part) for part in np.array_split(residual, count)]
    return np.array(sums)


def verdict_by_lines(found: Sequence[Evidence], late: bool = False) -> Evidence | None:
    """The fault that the evidence speaks for; ``late``: the torque was moved by no convention's time."""
    beyond = [s for s in found if s.alarms]
    if not beyond:
        return None
    own = {s.fault: s for s in found if not s.from_law}
    law = next((s for s in found if s.from_law), None)
    family = max(beyond, key=lambda s: s.shared).family
    if late and law is None and any(s.family == "link" for s in beyond):
        family = "link"  # a torque that seems moved in time, and no other law of friction explains it
    top = max((s for s in found if s.family == family), key=lambda s: s.gain)
    if family == "link":
        # A spring makes the apparent inertia rise with frequency, a delayed channel makes a lag, backlash
        # both and more: what is left where the lag is a parameter.
        spring = top.fault == "flexibility" and DELAY in own and not late
        lags = any(s.fault == DELAY and s.value > 0.0 for s in beyond)
        alone = top.gain > ALONE * top.shared or (spring and not lags)
        return top if alone else own.get("backlash", top)
    if family == "friction":
        if law is not None and law.gain > HALF * law.shared:
            return law
        return own["stribeck"] if own["stribeck"].value > 0.0 else own["slope"]
    return top
