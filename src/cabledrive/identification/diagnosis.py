r"""Is the model right? What it leaves unexplained is compared with what each fault would make.

The refined model moves by itself under the torque's spectral lines, free of noise. A fault acts on it like a
disturbance torque x(t), known up to a factor from that motion; the speed answers with
:math:`x/(Js + b)`. The factor and its robust standard error follow from the residual of the speed by least
squares, beside the parameters themselves. No regressor carries noise, so a sound log raises no alarm.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.typing import NDArray
from scipy import signal, stats

from cabledrive.identification.axis_case import Case, case_of, simulated, simulated_speed, weighed
from cabledrive.identification.estimates import Identification
from cabledrive.identification.filters import difference, zero_phase
from cabledrive.identification.inverse_dynamics import LAG
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import Factors, factor, joined, only, solve, suited_segments
from cabledrive.identification.rigid_axis import AxisOptions, channels_of, equation_for

Array = NDArray[np.float64]

SEGMENTS = 240
STRIBECK_SHARES = (0.01, 0.03, 0.1, 0.3)
"""Fading speeds that are tried, in root mean square speeds."""
SLOPE_SHARES = (1.0, 4.0)
"""Slopes K of a smooth friction that are tried, over the root mean square speed."""
GAPS = (0.005, 0.0175)
"""Backlash widths that are tried [rad or m]."""
BASE = ("inertia", "viscous", "coulomb", "offset")

FALSE_ALARMS = 0.001
"""Probability that a log without faults raises an alarm, shared by all disturbances tried (Bonferroni)."""
FAMILIES = {
    "friction": ("stribeck", "slope", "jump"),
    "link": ("delay", "flexibility", "backlash"),
    "asymmetry": ("asymmetry",),
}
"""Faults that a log separates least."""
ALONE = 0.9
"""Share of its family's explanation that a spring, or a delay, reaches alone; backlash does not."""

HALF = 0.5

FAULTS = {
    "delay": "the torque channel is delayed against the motion by {value:.3g} s: shift it",
    "flexibility": "the apparent inertia rises with frequency: a flexible joint or belt, not one rigid axis",
    "asymmetry": "viscous friction differs between both directions",
    "stribeck": "friction is higher near standstill than the model says: Stribeck friction",
    "jump": "friction jumps where the speed changes sign: Coulomb friction instead of c tanh(K w)",
    "slope": "friction rises smoothly with speed instead of jumping: c tanh(K w)",
    "backlash": "the apparent inertia is smaller while the load crosses a gap: backlash",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Suspicion:
    """One fault with the evidence for it."""

    fault: str  # key of `FAULTS`
    significance: float  # factor of its disturbance over its standard error
    # significance that a sound log exceeds at any fault with the chance `FALSE_ALARMS`, by Student's t
    critical: float
    gain: float  # share of the weighted residual's power that it explains
    family_gain: float  # share that all faults of its family explain together
    value: float  # the factor
    from_law: bool = False  # whether it comes from the comparison of two laws of friction

    @property
    def family(self) -> str:
        """Key of `FAMILIES`."""
        return next(family for family, faults in FAMILIES.items() if self.fault in faults)

    @property
    def alarms(self) -> bool:
        """Whether it is beyond chance."""
        return self.significance > self.critical

    @property
    def words(self) -> str:
        """The fault in a sentence."""
        return FAULTS[self.fault].format(value=self.value)


def suspicions(
    logs: Sequence[Log], refined: Identification, options: AxisOptions | None = None
) -> tuple[Suspicion, ...]:
    """Evidence for each fault, that which explains most first.

    ``refined``: by output error; ``options``: those of the identification.
    """
    options = options or AxisOptions()
    torque, position = channels_of(logs[0], options)
    equation = equation_for(logs, torque, position, options)
    values = np.array([estimate.value for estimate in refined.parameters.values()])
    cases = [case_of(log, torque, position, equation) for log in logs]
    parts = []
    for case in weighed(cases, values, np.array([case.start for case in cases])):
        residual, sensitivities = simulated(case, values, case.start)
        answers = _answers(case, values)
        if case.lag:
            answers[LAG] = sensitivities[:, 5]
            del answers["delay"]
        regressors = np.column_stack([sensitivities[:, :5], *answers.values()])
        names = (*BASE, "start", *answers)
        count = max(12, SEGMENTS // len(logs))
        parts.append(factor(regressors, residual, names, min(count, residual.size // 40)))
    factors = suited_segments(joined(parts))
    tried = tuple(name for name in factors.names[len(BASE) + 1 :] if name != LAG)
    found = [_suspicion(factors, name, len(tried)) for name in tried]
    best: dict[str, Suspicion] = {}
    for suspicion in found:
        if suspicion.fault not in best or suspicion.gain > best[suspicion.fault].gain:
            best[suspicion.fault] = suspicion
    return tuple(sorted(best.values(), key=lambda s: -s.gain))


def verdict(found: Sequence[Suspicion], late: bool = False) -> str | None:
    """The fault that the evidence speaks for: of the family that explains most, the plainest that suffices.

    A law of friction that alone explains half of it is the reason; other friction shows by its sign: more
    near standstill, or less. A spring makes the apparent inertia rise with frequency, a delayed channel makes
    a lag, backlash does both and more.

    ``late``: whether the torque had to be moved by a time that no convention of logging explains.
    Returns key of `FAULTS`; None where nothing is beyond chance.
    """
    beyond = [s for s in found if s.alarms]
    if not beyond:
        return None
    family = max(beyond, key=lambda s: s.family_gain).family
    if late and any(s.family == "link" for s in beyond) and not any(s.from_law for s in found):
        family = "link"  # a torque that seems moved in time, and no other law of friction explains it
    members = sorted((s for s in found if s.family == family), key=lambda s: -s.gain)
    top = members[0]
    if family == "link":
        lags = late or any(s.fault == "delay" and s.value > 0.0 for s in beyond)
        fitted = all(
            s.fault != "delay" for s in found
        )  # the lag is a parameter: what a spring leaves, backlash
        springs = top.fault == "flexibility" and not lags and not fitted
        return top.fault if springs or top.gain > ALONE * top.family_gain else "backlash"
    if family == "friction":
        law = next((s for s in members if s.from_law), None)
        if law is not None and law.gain > HALF * law.family_gain:
            return law.fault
        near_rest = next(s for s in members if s.fault == "stribeck")
        return "stribeck" if near_rest.value < 0.0 else "slope"
    return top.fault


def _answers(case: Case, values: Array) -> dict[str, Array]:
    """Speeds that the faults would add, filtered as the residual is."""
    pole = exp(-values[1] / values[0] * case.interval)
    gain = (1.0 - pole) / values[1] if values[1] != 0.0 else case.interval / values[0]
    names, columns = zip(*disturbances(case, values).items(), strict=True)
    answered = signal.lfilter([0.0, gain], [1.0, -pole], np.column_stack(columns), axis=0)
    filtered = case.compared(case.filtered(answered))
    return dict(zip(names, filtered.T, strict=True))


def disturbances(case: Case, values: Array) -> dict[str, Array]:
    """Torques that the faults would add, up to a factor, from the model's own motion.

    ``values``, shape (4,): inertia, viscous friction, Coulomb friction, offset.
    """
    speed = simulated_speed(case, values)
    size = float(np.sqrt(np.mean(speed**2)))
    sign = np.sign(speed)
    smooth = zero_phase(speed, case.interval, case.bandwidth)
    acceleration = difference(smooth, case.interval)
    found = {
        "delay": difference(zero_phase(case.lines, case.interval, case.bandwidth), case.interval),
        "flexibility": difference(difference(acceleration, case.interval), case.interval),
        "asymmetry": np.abs(speed),
    }
    for share in STRIBECK_SHARES:
        found[f"stribeck:{share:g}"] = sign * np.exp(-((speed / (share * size)) ** 2))
    for share in SLOPE_SHARES:
        found[f"slope:{share:g}"] = np.tanh(share * speed / size) - sign
    for gap in GAPS:
        found[f"backlash:{gap:g}"] = acceleration * loose(speed, acceleration, gap, case.interval)
    return found


def loose(speed: Array, acceleration: Array, gap: float, interval: float) -> Array:
    """Where a load with backlash would be loose: from each change of its drive until the gap is crossed.

    ``speed``, ``acceleration``, shape (samples,); ``gap`` [rad]; ``interval`` [s].
    Returns shape (samples,): 1 where it is loose, else 0.
    """
    free = np.zeros(speed.size)
    turns = np.flatnonzero(np.diff(np.sign(acceleration)) != 0)
    for start, end in zip(turns, [*turns[1:], speed.size - 1], strict=True):
        away = np.cumsum(speed[start:end] - speed[start]) * interval
        crossed = np.flatnonzero(np.abs(away) > gap)
        free[start : start + (int(crossed[0]) if crossed.size else end - start)] = 1.0
    return free


def _suspicion(factors: Factors, name: str, tried: int) -> Suspicion:
    free = (LAG,) if LAG in factors.names else ()
    rigid, fault = (*BASE, "start", *free), name.partition(":")[0]
    family = next(faults for faults in FAMILIES.values() if fault in faults)
    kin = tuple(n for n in factors.names if n.partition(":")[0] in family)
    without, beside, whole = (solve(only(factors, (*rigid, *n))) for n in ((), (name,), kin))
    error = float(np.sqrt(beside.covariance[-1, -1]))
    value = float(beside.values[-1])
    power = max(without.residual**2, 1e-300)
    return Suspicion(
        fault=fault,
        significance=abs(value) / error if error > 0 else 0.0,
        critical=critical(tried, beside.freedom),
        gain=1.0 - beside.residual**2 / power,
        family_gain=1.0 - whole.residual**2 / power,
        value=value,
    )


def critical(tried: int, freedom: int) -> float:
    """Significance beyond chance among several trials.

    Returns Student's t of the two-sided level `FALSE_ALARMS` / ``tried``.
    """
    return float(stats.t.isf(0.5 * FALSE_ALARMS / tried, freedom))
