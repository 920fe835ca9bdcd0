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
from scipy import signal

from cabledrive.identification.axis_case import Case, case_of, simulated, simulated_speed
from cabledrive.identification.estimates import Identification
from cabledrive.identification.filters import difference, zero_phase
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
"""Free plays that are tried [rad or m]."""
BASE = ("inertia", "viscous", "coulomb", "offset")

ALARM = 4.0
"""Significance above which a fault is reported."""
SMALLEST_GAIN = {"delay": 0.003, "flexibility": 0.003}
OTHER_GAIN = 0.02
"""Share of the residual's power below which a fault does no harm; this of all others."""
BESIDE = 0.3
"""Delay over flexibility, in significance, above which a load lags because of free play, not of a spring."""

FAULTS = {
    "delay": "the torque channel is delayed against the motion by {value:.3g} s: shift it",
    "flexibility": "the apparent inertia rises with frequency: a flexible joint or belt, not one rigid axis",
    "asymmetry": "viscous friction differs between both directions",
    "stribeck": "friction is higher near standstill than the model says: Stribeck friction",
    "jump": "friction jumps where the speed turns: Coulomb's law instead of c tanh(K w)",
    "slope": "friction rises with speed instead of jumping: a smooth law c tanh(K w)",
    "backlash": "the inertia is smaller while the load changes sides: backlash",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Suspicion:
    """One fault with the evidence for it.

    Attributes
    ----------
    fault : str
        Key of `FAULTS`.
    significance : float
        Factor of its disturbance over its standard error.
    gain : float
        Share of the residual's power that it explains.
    value : float
        The factor.
    """

    fault: str
    significance: float
    gain: float
    value: float

    @property
    def words(self) -> str:
        """The fault in a sentence."""
        return FAULTS[self.fault].format(value=self.value)


def suspicions(
    logs: Sequence[Log], refined: Identification, options: AxisOptions | None = None
) -> tuple[Suspicion, ...]:
    """Evidence for each fault, that which explains most first.

    Parameters
    ----------
    logs : sequence of Log
    refined : Identification
        By output error.
    options : AxisOptions, optional
        Those of the identification.

    Returns
    -------
    tuple of Suspicion
    """
    options = options or AxisOptions()
    torque, position = channels_of(logs[0], options)
    equation = equation_for(logs, torque, position, options)
    values = np.array([estimate.value for estimate in refined.parameters.values()])
    parts = []
    for log in logs:
        case = case_of(log, torque, position, equation)
        residual, sensitivities = simulated(case, values, case.start)
        answers = _answers(case, values)
        regressors = np.column_stack([sensitivities, *answers.values()])
        names = (*BASE, "start", *answers)
        count = max(12, SEGMENTS // len(logs))
        parts.append(factor(regressors, residual, names, min(count, residual.size // 40)))
    factors = suited_segments(joined(parts))
    found = [_suspicion(factors, name) for name in factors.names[len(BASE) + 1 :]]
    best: dict[str, Suspicion] = {}
    for suspicion in found:
        if suspicion.fault not in best or suspicion.gain > best[suspicion.fault].gain:
            best[suspicion.fault] = suspicion
    return tuple(sorted(best.values(), key=lambda s: -s.gain))


def verdict(found: Sequence[Suspicion]) -> str | None:
    """The fault that the evidence speaks for.

    A spring makes the apparent inertia rise with frequency and nothing else. Free play adds a lag, and what
    is left near standstill. Friction shows by its sign: more near standstill, or less.

    Parameters
    ----------
    found : sequence of Suspicion

    Returns
    -------
    str or None
        Key of `FAULTS`; None where no fault is significant.
    """
    strength = {
        s.fault: s.significance if s.gain > SMALLEST_GAIN.get(s.fault, OTHER_GAIN) else 0.0 for s in found
    }
    signs = {s.fault: np.sign(s.value) for s in found}
    if max(strength.values()) < ALARM:
        return None
    spring = strength["flexibility"] if signs["flexibility"] > 0 else 0.0
    lag = strength["delay"] if signs["delay"] > 0 else 0.0
    friction = max(strength["stribeck"], strength["slope"])
    if friction > 1.3 * max(spring, lag) and friction >= ALARM:
        return "stribeck" if signs["stribeck"] < 0 else "slope"
    others = max(spring, friction, strength["backlash"])
    if lag >= ALARM and lag > BESIDE * spring:
        return "backlash" if others >= ALARM else "delay"
    if spring >= ALARM:
        return "flexibility"
    return max(strength, key=lambda fault: strength[fault])


def friction_leads(found: Sequence[Suspicion], *, smoother: bool) -> bool:
    """Whether friction near standstill is the strongest suspicion.

    Parameters
    ----------
    found : sequence of Suspicion
    smoother : bool
        Whether it is to be weaker there than the model says, or stronger.

    Returns
    -------
    bool
    """
    top = max(found, key=lambda s: s.significance)
    weaker = {"slope": top.value < 0, "stribeck": top.value > 0}
    return top.fault in weaker and weaker[top.fault] == smoother


def _answers(case: Case, values: Array) -> dict[str, Array]:
    """Speeds that the faults would add, filtered as the residual is."""
    pole = exp(-values[1] / values[0] * case.interval)
    gain = (1.0 - pole) / values[1] if values[1] != 0.0 else case.interval / values[0]
    names, columns = zip(*disturbances(case, values).items(), strict=True)
    answered = signal.lfilter([0.0, gain], [1.0, -pole], np.column_stack(columns), axis=0)
    filtered = zero_phase(answered, case.interval, case.bandwidth)[case.inner]
    return dict(zip(names, filtered.T, strict=True))


def disturbances(case: Case, values: Array) -> dict[str, Array]:
    """Torques that the faults would add, up to a factor, from the model's own motion.

    Parameters
    ----------
    case : Case
    values : ndarray, shape (4,)
        Inertia, viscous friction, Coulomb friction, offset.

    Returns
    -------
    dict of str to ndarray
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
    """Where a load with free play would be loose: from each change of its drive until the gap is crossed.

    Parameters
    ----------
    speed, acceleration : ndarray, shape (samples,)
    gap : float
        [rad].
    interval : float
        [s].

    Returns
    -------
    ndarray, shape (samples,)
        1 where it is loose, else 0.
    """
    free = np.zeros(speed.size)
    turns = np.flatnonzero(np.diff(np.sign(acceleration)) != 0)
    for start, end in zip(turns, [*turns[1:], speed.size - 1], strict=True):
        away = np.cumsum(speed[start:end] - speed[start]) * interval
        crossed = np.flatnonzero(np.abs(away) > gap)
        free[start : start + (int(crossed[0]) if crossed.size else end - start)] = 1.0
    return free


def _suspicion(factors: Factors, name: str) -> Suspicion:
    rigid = (*BASE, "start")
    without, beside = solve(only(factors, rigid)), solve(only(factors, (*rigid, name)))
    error = float(np.sqrt(beside.covariance[-1, -1]))
    value = float(beside.values[-1])
    return Suspicion(
        fault=name.partition(":")[0],
        significance=abs(value) / error if error > 0 else 0.0,
        gain=1.0 - (beside.residual / without.residual) ** 2 if without.residual > 0 else 0.0,
        value=value,
    )
