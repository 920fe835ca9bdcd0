r"""What speaks for each fault of an axis: the torque that it would add, against what the model leaves.

A fault acts on the axis like a disturbing torque that is known up to a factor, written so that the fault
makes the factor positive. The factor and its error follow by least squares beside the parameters themselves.

The observer's answer is held against its innovations, the error taken from the factor's
contributions :math:`g_b` in segments of time by the differences of neighbours,

.. math:: C = \frac{G}{2(G-1)}\sum_b (g_b - g_{b-1})^2 ,

so that a fault that shows in a part of the log only does not hide itself in its own scatter. A factor beyond
Student's t is then tried again: the mean square of what logs of a sound axis show, and the doubt about the
hold of the torque, are added to C. Of faults of the joint that mean is taken off: it comes of counts and
samples along the whole motion and is well known, not of the few stops on which laws of friction hang.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import signal, stats

from cabledrive.identification import estimates
from cabledrive.identification.axis import observer
from cabledrive.identification.axis.axis import BASE, Axis, values_of
from cabledrive.identification.axis.equation import loosen
from cabledrive.identification.axis.observer import NotReproduced, Observed, Prediction
from cabledrive.identification.estimates import Factors, Fit, Identification
from cabledrive.identification.signals import zero_phase
from cabledrive.parameters.arrays import Array

FALSE_ALARMS = 0.001
"""Probability that a log without faults raises an alarm, shared by all disturbances tried (Bonferroni)."""
SEED = 4016
"""Of the noise in logs of a sound axis: the same log gives the same result."""
ROUNDS = 3
"""Corrections of the four parameters."""
JOINT, UNLIKE = ("backlash", "flexibility"), 0.3
"""Faults of which sound logs show the same everywhere, and the share by which one may show more or less."""
EFFICIENCY = 2 / 3
"""Of a variance from differences of neighbours, against one from the same number of deviations."""

STRIBECK = (0.03, 0.1, 0.3)
"""Fading speeds that are tried, in root mean square speeds."""
SLOPES = (1.0, 4.0)
"""Slopes of a smooth friction that are tried, over that speed."""
WAVES, RESONANCES, DAMPING = 4, (25.0, 50.0, 100.0), 0.1
"""Half waves of the stroke; resonances of a joint [Hz], and their damping ratio."""
TURNING_GAPS, LINEAR_GAPS = (0.25, 1.0), (0.0005, 0.005)
"""Backlash that is tried: of a turning axis [deg], and of a linear one [strokes]."""
CONTACT = 0.005
"""Time in which both sides of a backlash reach one speed [s]."""
DELAY, DRIFT = "delay", "drift"

FAULTS = {  # whether only a positive factor indicates it, the fault in short and in a sentence
    "stribeck": (True, "Stribeck friction",
        "friction is higher near standstill than the model says: Stribeck friction"),
    "slope": (True, "a smooth law of friction",
        "friction rises smoothly with speed instead of jumping: c tanh(K w)"),
    "jump": (True, "Coulomb friction",
        "friction jumps where the speed changes sign: Coulomb friction instead of c tanh(K w)"),
    "quadratic": (True, "friction that rises faster than the speed",
        "friction rises faster than in proportion to the speed"),
    "load": (True, "friction that grows with the load",
        "friction grows with the torque that is carried"),
    "asymmetry": (False, "viscous friction that differs between both directions",
        "viscous friction differs between both directions"),
    "one-sided": (False, "a motor with more torque one way",
        "the torque acts more strongly one way than the other: its motor, amplifier or sensor is one-sided"),
    "filtered": (True, "a filtered torque channel",
        "the logged torque lacks its fast part: its channel is filtered; log it before the filter"),
    DRIFT: (False, "friction that changes while the log lasts",
        "friction changes from the beginning of the log to its end: the axis warms up, or dries"),
    "position": (False, "a torque that depends on the position",
        "a torque depends on the position: cogging, a screw's or guide's error, a weight"),
    "flexibility": (True, "a flexible joint",
        "the apparent inertia rises with frequency: a flexible joint or belt, not one rigid axis"),
    "backlash": (True, "backlash",
        "the apparent inertia is smaller while the torque changes sign: backlash"),
    DELAY: (False, "a delay of the torque channel",
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
    shift: Array  # (4,): what it would change in the parameters
    halves: Array  # (4,): half of their intervals as noise alone makes them

    @property
    def fault(self) -> str:
        """Key of `FAULTS`."""
        return self.name.partition(":")[0]

    @property
    def significance(self) -> float:
        """Factor over its standard error; negative where its sign speaks against the fault."""
        value = self.value if FAULTS[self.fault][0] else abs(self.value)
        return value / self.error if self.error > 0.0 else 0.0

    @property
    def alarms(self) -> bool:
        """Whether it is beyond chance."""
        return self.significance > self.critical


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
            fits = [_factor_of(one, e.name) for one in sound]
            shown, errors = np.array([(fit.values[-1], error) for fit, error in fits]).T
            always, spread = float(shown.mean()), max(0.0, float(shown.var(ddof=1) - np.mean(errors**2)))
            doubt = float(_factor_of(factors, e.name, observer.HOLD)[0].values[-1])
            off, unsure = (always, UNLIKE * always) if e.fault in JOINT else (0.0, always)
            size = np.sqrt(e.error**2 + spread + unsure**2 + doubt**2)
            every[k] = replace(e, value=e.value - off, error=float(size))
    repeated = float(np.sqrt(seen.repetition(values)))
    every = [replace(e, error=repeated * e.error) for e in every]
    best = {one.fault: one for one in sorted(every, key=lambda e: (e.alarms, e.gain))}
    return tuple(sorted(best.values(), key=lambda e: -e.gain))


def _fault_torques(axis: Axis, run: Prediction) -> dict[str, Array]:
    """What each fault would add along the motion that the observer foresees, each (samples,)."""
    net, track = run.values[0] * run.acceleration, run.track
    h, stroke = track.interval, float(np.ptp(track.position))
    speed, way, size = run.speed, run.direction, float(np.sqrt(np.mean(run.speed**2)))
    place = (track.position - track.position.min()) / stroke
    smooth = zero_phase(track.torque, h, min(run.bandwidth / np.pi, 0.2 / h))  # its noise is no motion
    found = {
        "asymmetry": -np.abs(speed),
        "quadratic": -speed * np.abs(speed) / size,
        "load": -way * np.abs(net),
        "one-sided": np.abs(track.torque),
        "filtered": -np.gradient(np.gradient(smooth)),
        DRIFT: -way * np.linspace(-0.5, 0.5, way.size),
    }
    found |= {f"stribeck:{s:g}": -way * np.exp(-((speed / (s * size)) ** 2)) for s in STRIBECK}
    if axis.slope > 0.0:
        found["jump"] = way - np.sign(speed)
    else:
        found |= {f"slope:{s:g}": way - np.tanh(s * speed / size) for s in SLOPES}
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
        loosen(net, speed, gap, h, max(1, round(CONTACT / h)), added)
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
    value = float(whole.values[-1])
    without = estimates.solve(estimates.only(factors, BASE if name == DELAY else observer.NUISANCE))
    shift = whole.values[: len(BASE)] - without.values[: len(BASE)]
    if name == DRIFT:  # at both ends of the log the friction differs from its mean
        shift[BASE.index("coulomb")] += 0.5 * abs(value)
    return Evidence(
        name=name,
        value=value,
        error=error,
        critical=float(stats.t.isf(0.5 * FALSE_ALARMS / tried, EFFICIENCY * factors.triangles.shape[0])),
        gain=1.0 - float(whole.residual) ** 2 / without.residual**2,
        shift=shift,
        halves=without.half_width()[: len(BASE)],
    )
