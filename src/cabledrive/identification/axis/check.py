"""Whether the model of an axis holds: faults that its log shows, what is left, how it does on another."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy import signal

from cabledrive.answers.keys import Keys
from cabledrive.identification.axis.axis import Axis, AxisOptions, axis_of
from cabledrive.identification.axis.faults import DELAY, FAULTS, JOINT, Evidence, evidence_by_innovations
from cabledrive.identification.axis.observer import NotReproduced, Prediction, observed, period_of
from cabledrive.identification.axis.simulated import case_of
from cabledrive.identification.axis.timing import timing_of
from cabledrive.identification.estimates import Identification
from cabledrive.identification.logs.log import Log
from cabledrive.identification.signals import difference, rms, zero_phase
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.arrays import Array, Complex

NOT_MADE = {
    "saturated": "not made: the torque saturates, so the torque on the axis is not known",
    "long": "not made, nor a test of two clocks: the log is read in blocks",
    "parameters": "not made: inertia and friction are not identifiable from the log",
}
MATERIAL = 0.7
"""Share of half an interval by which a fault must change a parameter to be stated as a fault; for one of the
joint of the interval that noise alone makes: the doubt about quicker observers is larger with a joint."""
NOTABLE, CLOSE = 0.01, 0.8
"""Share of the power from which it is stated whatever it changes; share of the best explanation from which on
another fault cannot be distinguished from it."""
MISFIT = "model-misfit"
INNOVATIONS = "innovations of an observer"
MOST_WAVES, EVERY = 60, 4
"""Waves per revolution that are tried, and samples between those that are used."""
EXPLAINED, OVERTONE = 0.06, 0.03
"""Shares of the unexplained torque's power from which a wave, and an overtone of it, is named."""
ABOVE, MOST_OF_IT = 40.0, 0.5
"""Of the middle one of all waves, at least; share that names a wave where nothing else is found."""
TURN, PERIODS = 1.0 / 3.0, 1.5
"""Stroke in revolutions below which only waves of so many periods in it are tried."""
RESOLVED = 0.15
"""Of a count of the encoder: a smaller innovation may be the counts' own where a motion repeats itself."""
LARGE, SMALL, COLOURED = 0.04, 0.002, 3.0
"""Shares of the torque, and the rise, from which it is more than noise."""
ROUNDED, COUNTS = 0.1, 0.5
"""Rise, and innovation in counts of the encoder, below which it is rounding alone, whatever its share."""
LOWEST, LONGEST_SEGMENT = 0.3, 8.0
"""[Hz], and of the records whose spectra are averaged [s]."""
MODEL = "rigid-axis-coulomb"


def checked_by_innovations(axis: Axis, answer: Identification) -> Identification:
    """The answer with what an observer's innovations show, or why not; `NotReproduced` if none follows."""
    inertia, _, coulomb, offset = answer.values[:4]
    reason = ""
    if axis.saturated:
        reason = NOT_MADE["saturated"]
    elif not (inertia > 0.0 and coulomb > 0.0 and np.isfinite(offset)):
        reason = NOT_MADE["parameters"]  # viscous friction need not be known for it
    try:
        found = () if reason else evidence_by_innovations(axis, answer)
    except NotReproduced:
        raise
    except NotComputed as failure:
        reason = f"not possible: {failure}"
    if reason:
        return replace(answer.noting(model_check=reason), check_reason=reason)
    numbers = ("significance", "critical", "value")
    shown = {one.fault: {name: getattr(one, name) for name in numbers} for one in found}
    answer = answer.noting(model_check=INNOVATIONS, suspicions=shown)
    answer = replace(answer, checked=True, check_reason=INNOVATIONS)
    half_widths = np.array([0.5 * (one.high - one.low) for one in answer.parameters.values()])
    beyond = []
    for one in (one for one in found if one.alarms):
        halves = one.halves if one.fault in JOINT else half_widths
        if one.gain > NOTABLE or np.any(np.abs(one.shift) > MATERIAL * halves):
            beyond.append(one)
    if faults := [e for e in beyond if e.gain >= CLOSE * beyond[0].gain]:
        return _blamed(axis, answer, faults)
    # notes on faults that change too little, or that a motion that repeats cannot show
    small = ", ".join(FAULTS[one.fault][1] for one in found if one.alarms)
    if small:
        words = f"significant, but no parameter changes by as much as its interval: {small}"
        answer = answer.noting(words)
    unseen = []
    for one in found:  # would move a parameter by more than its interval's width before it alarms
        times = one.critical * one.error / max(abs(one.value), 1e-300)
        if not one.alarms and np.any(times * np.abs(one.shift) > 2.0 * half_widths):
            unseen.append(one)
    if not unseen or not all(period_of(log.channel(axis.torque), log.interval) for log in axis.logs):
        return answer
    names = ", ".join(FAULTS[one.fault][1] for one in unseen)
    words = f"the motion repeats, so this log cannot show a fault that makes the intervals wrong: {names}"
    return answer.noting(words, cannot_show=[one.fault for one in unseen])


def _blamed(axis: Axis, answer: Identification, faults: Sequence[Evidence]) -> Identification:
    """The answer with its faults in a sentence, a delay with its size."""
    words = FAULTS[faults[0].fault][2]
    if faults[0].fault == DELAY:
        late = -timing_of(axis).shift  # not only to first order
        if late * faults[0].value > 0.0 and abs(late) > axis.interval:
            words, answer = words.format(value=late), answer.noting(torque_delay=late)
        else:
            words = "the motion lags the torque, by more than a delay"
    others = ", ".join(FAULTS[one.fault][1] for one in faults[1:])
    alike = f"; this log cannot distinguish it from {others}" if others else ""
    return answer.saying(MISFIT, f"the model does not fit: {words}{alike}")


def unexplained(run: Prediction) -> tuple[float, str]:
    """Torque that a rigid axis leaves: its share, and words if it is no noise."""
    track, hertz = run.track, run.bandwidth / (2.0 * np.pi)
    added = run.added[track.position.size // 20 :]
    length = min(round(LONGEST_SEGMENT / track.interval), added.size)
    frequency, power = signal.welch(added, 1.0 / track.interval, nperseg=length)
    inside = (frequency >= LOWEST) & (frequency < hertz)
    low, high = inside & (frequency < 0.25 * hertz), inside & (frequency >= 0.5 * hertz)
    size = float(np.sqrt(power[inside].sum() * (frequency[1] - frequency[0])))
    share = size / float(np.sqrt(np.mean(track.torque**2)))
    # Near 1 where it is white noise of the torque channel, below where it is noise of the encoder.
    rise = float(power[low].mean() / max(power[high].mean(), 1e-300)) if low.any() and high.any() else 0.0
    rounded = rise < ROUNDED and np.sqrt(np.mean(run.innovation**2)) < COUNTS * track.quantum
    if not ((share > LARGE and not rounded) or (share > SMALL and rise > COLOURED)):
        return share, ""
    much = f"{100 * share:.2g} % of the torque"
    if share >= 1.0:
        much = f"{share:.2g} times as much torque as was measured"
    return share, (
        f"{much} is not explained by a rigid axis with constant friction (below {hertz:.2g} "
        "Hz): an unmeasured disturbance, or a fault that is not in the list"
    )


def position_wave(run: Prediction) -> tuple[float, str]:
    """Share of the unexplained torque's power of one wave per revolution, and words where it is believed."""
    track, values, hertz = run.track, run.values, run.bandwidth / (2.0 * np.pi)
    angle = zero_phase(track.position, track.interval, min(2.0 * hertz, 0.2 / track.interval))
    # The observer's correction lags behind what it corrects by about one radian of its bandwidth.
    added, driven = (
        zero_phase(own, track.interval, min(hertz, 0.2 / track.interval)) for own in (run.added, track.torque)
    )
    edge, late = track.position.size // 20, round(np.sqrt(2.0) / (run.bandwidth * track.interval))
    part = slice(edge, added.size - late, EVERY)
    slipping = run.direction[part] != 0.0
    left, place, driven = added[edge + late :: EVERY][slipping], angle[part][slipping], driven[part][slipping]
    turned = float(np.ptp(place)) / (2.0 * np.pi) if place.size else 0.0
    if left.size < 100 * MOST_WAVES // EVERY or MOST_WAVES * turned < PERIODS:
        return 0.0, ""
    least = 1 if turned >= TURN else int(np.ceil(PERIODS / turned))
    counts = np.arange(least, MOST_WAVES + 1)
    turning = [np.exp(1j * count * place) for count in counts]
    families = [[_explained(left, size * wave) for wave in turning] for size in (1.0, driven)]
    waves = max(families, key=max)
    (best, amplitude), ripple = max(waves), waves is families[1]
    first = int(counts[waves.index((best, amplitude))])

    # An error e of the angle, once per revolution, asks for the torque J e'' + b e'.
    rate, turn = difference(angle, track.interval), np.exp(1j * angle)
    asked = values[0] * (1j * difference(rate, track.interval) - rate**2) + 1j * values[1] * rate
    share, size = _explained(left, (asked * turn)[part][slipping])
    one_sided = _explained(left, np.abs(driven) + 0j)[0]  # is among the faults
    small = np.sqrt(max(share, best) * np.mean(run.innovation**2)) < RESOLVED * track.quantum
    if small or one_sided > max(share, best):
        return 0.0, ""
    if turned >= TURN and share > max(EXPLAINED, best):
        words = (
            f"the encoder's angle is wrong by {size:.2g} rad once per revolution: "
            "eccentricity of its disc or a shaft that runs out"
        )
        return share, words
    sure = turned >= TURN and best >= ABOVE * float(np.median([share for share, _ in waves]))
    sure &= not (ripple and period_of(track.torque, track.interval))  # which makes any wave of others
    if best < (EXPLAINED if sure else MOST_OF_IT):
        return 0.0, ""
    over = (n for n in range(2 * first, MOST_WAVES + 1, first) if sure and waves[n - least][0] > OVERTONE)
    periods = f"with {', '.join(map(str, (first, *over)))} period(s) per revolution"
    if ripple:
        return best, f"the motor's torque varies by {100 * amplitude:.2g} % {periods}: torque ripple"
    words = f"a torque of the position {periods} (amplitude {amplitude:.2g} N m): cogging, a tooth, "
    return best, f"{words}or a weight out of balance"


def _explained(left: Array, wave: Complex) -> tuple[float, float]:
    """Share of a power that a complex wave explains, both its parts free, and its amplitude."""
    columns = np.column_stack([wave.real, wave.imag])
    columns = columns - columns.mean(axis=0)
    weights, *_ = np.linalg.lstsq(columns, left, rcond=None)
    rest = left - columns @ weights
    return 1.0 - float(rest @ rest) / float(left @ left), float(np.hypot(*weights))


AGAINST = Keys(
    "text: source object: open_loop{text: reason? unit? number: error? relative?} closed_loop{text: reason? "
    "unit? torque_unit? number: error? torque_error? relative?} map: cross_test{number: value other text: "
    "unit flag: agrees}"
)


def against(found: Identification, alone: Identification, other: Log, options: AxisOptions) -> dict[str, Any]:
    """An identified axis on another log, as JSON gives it; ``alone``: what that log gives by itself.

    "open_loop": error of the speed simulated under the other log's torque alone; "closed_loop": with an
    observer that follows the angle, what it has to add to the measured torque, "torque_error", and the error
    of its prediction of the angle one sample ahead; "cross_test": by name of a parameter, whether intervals
    overlap. Raises `InputRefused` for another model than an axis with constant friction.
    """
    if found.model != MODEL or len(found.parameters) != 4:
        raise InputRefused(f"--against needs the model {MODEL}, not {found.model}: leave --model out")
    if not np.all(np.isfinite(found.values)):
        raise InputRefused("--against needs every parameter of the axis, and the first log leaves one open")
    axis = axis_of([other], options)
    case = replace(case_of(axis, other), slope=0.0)
    way = other.units[axis.position]
    moved, _ = case.moved(found.values, case.torque, case.start)
    speed, off = case.speed[case.inner], (case.filtered(moved) - case.speed)[case.inner]
    open_loop: dict[str, Any] = {"reason": "its motion diverges"}
    if np.all(np.isfinite(off)):
        open_loop = {"error": rms(off), "unit": f"{way}/s", "relative": rms(off) / rms(speed)}
    try:
        seen = observed(axis, found.values, 1.0)
        (run,) = seen.runs(found.values)
        added = run.added[len(other) // 20 :]
        closed_loop: dict[str, Any] = {
            "error": rms(run.innovation[len(other) // 20 :]),
            "unit": way,
            "torque_error": rms(added),
            "torque_unit": other.units[axis.torque],
            "relative": rms(added) / rms(seen.tracks[0].torque),
        }
    except NotComputed as failure:
        closed_loop = {"reason": str(failure)}
    pairs = ((name, one, alone.parameters.get(name)) for name, one in found.parameters.items())
    cross = {
        name: {
            "value": one.value,
            "other": its.value,
            "unit": one.unit,
            "agrees": bool(one.low <= its.high and its.low <= one.high),
        }
        for name, one, its in pairs
        if its is not None
    }
    return {"source": other.source, "open_loop": open_loop, "closed_loop": closed_loop, "cross_test": cross}
