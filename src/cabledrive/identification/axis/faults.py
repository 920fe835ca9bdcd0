r"""What speaks for each fault of an axis: the torque that it would add, against what the model leaves.

A fault acts on the axis like a disturbing torque that is known up to a factor, written so that the fault
makes the factor positive. The factor and its error follow by least squares beside the parameters themselves.
Where nothing but spectral lines moves the axis, the refined model moves by itself, free of noise, and what
the speed answers is held against the residual of the speed (`axis.lines`). Elsewhere the observer's answer is
held against its innovations, the error taken from the factor's contributions :math:`g_b` in segments of time
by the differences of neighbours,

.. math:: C = \frac{G}{2(G-1)}\sum_b (g_b - g_{b-1})^2 ,

so that a fault that shows in a part of the log only does not hide itself in its own scatter. A factor beyond
Student's t is then tried again: what logs of a sound axis show, and the doubt about the hold of the torque,
are added to C.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import signal, stats

from cabledrive.identification.axis.axis import BASE, Axis, values_of
from cabledrive.identification.axis.equation import loosen
from cabledrive.identification.axis.observer import (
    HELD_DOUBT,
    HOLD,
    NUISANCE,
    SLOWER,
    NotReproduced,
    Observed,
    Prediction,
    observed,
)
from cabledrive.identification.estimates import Identification
from cabledrive.identification.regression import Factors, only, solve, triangle
from cabledrive.parameters.arrays import Array

FALSE_ALARMS = 0.001
"""Probability that a log without faults raises an alarm, shared by all disturbances tried (Bonferroni)."""
SEED = 4016
"""Of the noise in logs of a sound axis: the same log gives the same result."""
ROUNDS = 3
"""Corrections of the four parameters."""
EFFICIENCY = 2 / 3
"""Of a variance from differences of neighbours, against one from the same number of deviations."""
MATERIAL = 0.7
"""Share of half an interval by which a fault must change a parameter to be stated as a fault."""
NOTABLE, CLOSE = 0.02, 0.8
"""Share of the power from which it is stated whatever it changes; share of the best explanation from which on
another fault cannot be distinguished from it."""
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


def strongest(found: Iterable[Evidence]) -> tuple[Evidence, ...]:
    """The best of each fault, that which explains most first; ``found``: the best last."""
    best = {one.fault: one for one in found}
    return tuple(sorted(best.values(), key=lambda e: -e.gain))


def evidence_by_innovations(axis: Axis, found: Identification) -> tuple[Evidence, ...]:
    """Evidence for each fault in logs of any torque, that which explains most first; of each fault the best.

    ``found``: with Coulomb friction; only the viscous friction may be missing. Raises `NotComputed` if the
    observer cannot follow the log.
    """
    values = values_of(found)
    seen = observed(axis, values, SLOWER)
    for _ in range(ROUNDS):
        values = values + solve(seen.factors(values)).values[: len(BASE)]
        if not np.all(np.isfinite(values)) or values[0] <= 0.0 or values[2] < 0.0:
            raise NotReproduced

    def factors_of(these: Observed) -> Factors:
        return these.factors(values, lambda run: _fault_torques(axis, run), HELD_DOUBT)

    factors = factors_of(seen)
    names = tuple(name for name in factors.names if name not in (*NUISANCE, HOLD))
    every = [_by_innovations(factors, name, len(names) + 1) for name in (*names, DELAY)]
    if abs(every[-1].value) <= axis.interval:  # less than a sample is left free
        del every[-1]
    if any(e.alarms for e in every):
        sound = [factors_of(twin) for twin in seen.twins(values, SEED)]
        every = [_doubted(e, factors, sound) for e in every]
    repeated = float(np.sqrt(seen.repetition(values)))
    every = [replace(e, error=repeated * e.error) for e in every]
    return strongest(sorted(every, key=lambda e: (e.alarms, e.gain)))


def _fault_torques(axis: Axis, run: Prediction) -> dict[str, Array]:
    r"""What each fault would add along the motion that the observer foresees, each (samples,).

    The load's inertia behind a spring adds to the motor's acceleration, of the torque that accelerates the
    axis,

    .. math:: \frac{s^2}{s^2 + 2\zeta\omega_r s + \omega_r^2}
    """
    net, track = run.values[0] * run.acceleration, run.track
    h, stroke = track.interval, float(np.ptp(track.position))
    place = (track.position - track.position.min()) / stroke
    found = friction_torques(run.speed, run.direction, STRIBECK[1:])
    found["load"] = -run.direction * np.abs(net)
    found |= {f"position:{k}": np.cos(np.pi * k * place) for k in range(1, WAVES + 1)}
    for hertz in RESONANCES:
        if hertz < 0.2 / axis.interval:
            omega = 2 * np.pi * hertz
            spring = signal.bilinear([1.0, 0.0, 0.0], [1.0, 2 * DAMPING * omega, omega**2], 1.0 / h)
            found[f"flexibility:{hertz:g}"] = np.asarray(signal.lfilter(*spring, net))
    whole = float(np.ptp(axis.logs[0].channel(axis.position)))
    for gap in LINEAR_GAPS if axis.equation.linear else TURNING_GAPS:
        gap = gap * whole if axis.equation.linear else float(np.radians(gap))
        added = found[f"backlash:{gap:.3g}"] = np.empty_like(net)
        loosen(net, run.speed, gap, h, max(1, round(CONTACT / h)), added)
    return found


def _factor_of(factors: Factors, name: str, left: str | None = None) -> tuple[float, float, float]:
    """Factor of one disturbance, its standard error by differences of neighbours, and the residual."""
    names = NUISANCE if name == DELAY else (*NUISANCE, name)
    last = len(factors.names) if left is None else factors.names.index(left)
    places = [*(factors.names.index(n) for n in names), last]
    part = Factors(names=names, triangles=triangle(factors.triangles[:, :, places]), rows=factors.rows)
    fit = solve(part)
    upper, right = part.triangles[:, :, :-1], part.triangles[:, :, -1]
    scores = np.einsum("bij,bi->bj", upper, right - upper @ fit.values)
    whole = triangle(part.triangles.reshape(-1, len(names) + 1))[: len(names), :-1]
    moved = np.linalg.lstsq(whole, np.linalg.lstsq(whole.T, scores.T, rcond=None)[0], rcond=None)[0][-1]
    error = np.sqrt(0.5 * np.sum(np.diff(moved) ** 2) * moved.size / (moved.size - 1))
    return float(fit.values[-1]), float(error), float(fit.residual)


def _by_innovations(factors: Factors, name: str, tried: int) -> Evidence:
    value, error, residual = _factor_of(factors, name)
    rigid, beside = (BASE, NUISANCE) if name == DELAY else (NUISANCE, (*NUISANCE, name))
    without, whole = solve(only(factors, rigid)), solve(only(factors, beside))
    return Evidence(
        name=name,
        value=value,
        error=error,
        critical=critical(tried, EFFICIENCY * factors.triangles.shape[0]),
        gain=1.0 - residual**2 / without.residual**2,
        shift=tuple((whole.values[: len(BASE)] - without.values[: len(BASE)]).tolist()),
    )


def _doubted(one: Evidence, factors: Factors, sound: Sequence[Factors]) -> Evidence:
    """With what sound logs show, and with the doubt about the hold of the torque."""
    misses = [_factor_of(made, one.name) for made in sound]
    unseen = max(0.0, float(np.mean([value**2 - error**2 for value, error, _ in misses])))
    doubt = _factor_of(factors, one.name, HOLD)[0]
    return replace(one, error=float(np.sqrt(one.error**2 + unseen + doubt**2)))


def material(found: Sequence[Evidence], half_widths: Sequence[float]) -> list[Evidence]:
    """The fault beyond chance that explains most, and those that explain nearly it.

    Of those that matter: they change a parameter by a share of its interval, or explain much.
    """
    beyond = [e for e in found if e.alarms and (e.moves(half_widths, MATERIAL) or e.gain > NOTABLE)]
    return [e for e in beyond if e.gain >= CLOSE * beyond[0].gain]


def hidden(found: Sequence[Evidence], half_widths: Sequence[float]) -> list[Evidence]:
    """Faults that would move a parameter by more than its interval's width before they alarm."""
    least = ((one, one.critical * one.error / max(abs(one.value), 1e-300)) for one in found if not one.alarms)
    return [one for one, times in least if one.moves(half_widths, 2.0, times)]
