r"""When a logged torque acts: held from its tick, that of the interval before, behind a sensor; its lines.

A controller that holds its torque from tick to tick and logs it at the tick makes a torque that acts half an
interval later than its time stamp; a drive that logs the torque of the interval before, half an interval
earlier. Every method therefore has one unknown more, the time :math:`\delta` by which the torque acts later
than it is logged, found by Gauss-Newton steps on the filtered equation

.. math:: \tau(t - \delta) = J\ddot\theta + b\dot\theta + c\,S(\dot\theta) - d .

A sensor behind a low-pass of the first order makes :math:`\tau + T\dot\tau` of the logged torque instead;
where the torque is late by more than `NEAR` intervals, the law with the smaller residual is taken. Afterwards
the torque is moved; what is left of :math:`\delta` stays a column of each regression, so that its doubt is in
every interval.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from cabledrive.identification.axis.axis import Axis, Rows, factors_of, stacked
from cabledrive.identification.estimates import Finding, readable, solve, suited_segments
from cabledrive.identification.logs.log import Log
from cabledrive.identification.signals import difference
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

SPARSE = 0.3
"""Largest share of all lines that stand out."""
TAPS = 16
"""Half length of the interpolation filter [samples]."""
NEAR = 0.75
"""Delay of the torque channel from which a sensor's low-pass is tried too [intervals]."""
ROUNDS, SETTLED, FARTHEST = 8, 0.02, 25.0
"""Steps, the last one, and the largest shift that is taken for a matter of time stamps [intervals]."""
SNAP, CUSTOMARY, LATE_SURE = 0.08, 1.3, 4.0
"""Distance to a convention within which it is named, and shift up to which it is a note [intervals], beyond
which a delay is so many standard errors."""
CONVENTIONS = {
    "held": (0.5, "the torque is held from the sample at which it is logged"),
    "interpolated": (0.0, "the torque is logged at the instant at which it acts"),
    "before": (-0.5, "the logged torque is that of the interval before"),
}
"""Time by which the torque acts later than it is logged [intervals], and the convention in words."""
TIMINGS = ("found", *CONVENTIONS)
DRIFT_PARTS, DRIFT_SURE = 8, 12.0
"""Parts of a log whose instants are compared, and standard errors from which they drift."""


def spectral_lines(values: Array) -> Array:
    """A signal without what lies near its noise floor; the signal itself where it is no sum of lines."""
    spectrum = np.fft.rfft(values)
    size = np.abs(spectrum)
    kept = np.convolve(size > 12.0 * np.median(size), np.ones(3), "same") > 0
    return values if kept.mean() > SPARSE else np.fft.irfft(np.where(kept, spectrum, 0.0), values.size)


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueTiming:
    """By how much the torque acts later than it is logged, and by which law its channel is moved."""

    interval: float  # the longest of the logs [s]
    shift: float = 0.0  # [s]
    error: float = 0.0  # its standard error [s]; 0 where it is given
    law: str = "shift"  # {"shift", "low-pass"}: "low-pass": the sensor lags with the time constant ``-shift``
    # whether the log determines it; else the instant of logging is taken, with a doubt of half an interval
    determined: bool = True
    stated: str = ""  # convention that was given, whose shift is that of each log's own interval; empty: none

    @property
    def convention(self) -> str | None:
        """The convention that the shift agrees with, if any."""
        near = min(CONVENTIONS, key=lambda name: abs(self.shift / self.interval - CONVENTIONS[name][0]))
        sharp = self.error < 0.1 * self.interval and self.law == "shift"
        return near if sharp and abs(self.off(near)) < max(SNAP * self.interval, 4.0 * self.error) else None

    @property
    def hold(self) -> tuple[float, float]:
        """Second difference to be taken off the moved torque for its means between samples, and its doubt."""
        # A torque that stands from tick to tick has lost 6/48 when it is moved by half an interval and
        # neighbours are averaged; else it lies between 4/48 of point samples and 12/48 of means.
        return (6 / 48, 1 / 48) if self.convention in ("held", "before") else (8 / 48, 4 / 48)

    @property
    def customary(self) -> bool:
        """Whether a shift of this size is a habit of logging and no fault."""
        return abs(self.shift) <= CUSTOMARY * self.interval + LATE_SURE * self.error

    def off(self, convention: str) -> float:
        """Time from here to a convention [s]."""
        return CONVENTIONS[convention][0] * self.interval - self.shift

    def at(self, convention: str) -> "TorqueTiming":
        """The same at the instant of a convention."""
        return replace(self, shift=CONVENTIONS[convention][0] * self.interval, law="shift")

    def moved(self, axis: Axis) -> Axis:
        """The axis with its torques at the instants at which they act."""
        torques = []
        for log in axis.logs:
            values, interval = log.channel(axis.torque), log.interval
            if self.law == "low-pass":
                torques.append(values - self.shift * difference(values, interval))
            else:
                shift = CONVENTIONS[self.stated][0] * interval if self.stated else self.shift
                periodic = spectral_lines(values) is not values
                torques.append(shifted(values, shift / interval, periodic=periodic))
        return axis.having(axis.torque, torques)

    @property
    def words(self) -> str:
        """The timing in a sentence."""
        size, name = 1e3 * abs(self.shift), self.convention
        if not self.determined:
            return "the instant at which the torque acts is not determined by the log"
        if name is not None:
            return f"{CONVENTIONS[name][1]} (acts {1e3 * self.shift:+.3g} ms from its time stamp)"
        if self.customary:
            when = "later" if self.shift > 0.0 else "earlier"
            return f"the torque acts {size:.3g} ms {when} than its time stamp: corrected"
        if self.law == "low-pass":
            hertz = 1.0 / (2.0 * np.pi * -self.shift)
            return f"the torque channel lags as by a low-pass of {hertz:.3g} Hz ({size:.3g} ms): corrected"
        if self.shift < 0.0:
            late = f"the torque channel is delayed against the motion by {-self.shift:.3g} s: corrected"
            return f"{late}; shift it in the log"
        late = f"the motion follows the torque channel {self.shift:.3g} s late"
        return f"{late}: a dead time, or a flexible joint"


def lag_said(lag: float, half: float, interval: float, input_: str) -> tuple[str, list[Finding]]:
    """The note on a motion so late behind its input [s], and the finding where that is no habit of logs."""
    note = f"the motion is {1e3 * lag:.3g} ms later than the {readable(input_)}: taken out"
    if max(abs(lag) - half, 0.0) <= CUSTOMARY * interval:
        return note, []
    way = "follows the torque" if lag > 0.0 else "is ahead of the torque by"
    words = f"the motion {way} {1e3 * abs(lag):.3g} ms, more than {CUSTOMARY:g} intervals: a delay or lag"
    return note, [Finding("torque-timing", f"{words} of the drive, which the model lacks: shorten it")]


def given_timing(name: str, interval: float) -> TorqueTiming:
    """Timing of a convention; refused if it is unknown."""
    if name not in CONVENTIONS:
        raise InputRefused(f'identify.torque = "{name}" is unknown: take one of {", ".join(TIMINGS)}')
    return TorqueTiming(interval=interval, stated=name).at(name)


def shifted(values: Array, samples: float, *, periodic: bool = False) -> Array:
    """A signal later by a number of samples, whole or not, continued periodically or by its ends."""
    if samples == 0.0:
        return values
    whole = int(np.floor(samples))
    reach = TAPS + abs(whole)
    padded = np.pad(values, reach, mode="wrap" if periodic else "edge")
    weights = np.sinc(np.arange(-TAPS, TAPS + 1) - (samples - whole)) * np.kaiser(2 * TAPS + 1, 8.0)
    moved = np.convolve(padded, weights / weights.sum(), "same")
    return moved[reach - whole : reach - whole + values.size]


def timing_of(axis: Axis) -> TorqueTiming:
    """Time by which the torque acts later than logged, as it is or behind a sensor's low-pass."""
    parts = replace(axis, equation=replace(axis.equation, lag=True)).rows()
    unknown = TorqueTiming(interval=axis.interval, determined=False)
    if solve(factors_of(parts)).unidentifiable.size:
        return unknown
    found = [_shift_under(parts, axis, "shift")]
    if found[0] is not None and found[0][0].shift < -NEAR * axis.interval:
        found.append(_shift_under(parts, axis, "low-pass"))
    return min((one for one in found if one is not None), key=lambda one: one[1], default=(unknown, 0.0))[0]


def _shift_under(parts: list[Rows], axis: Axis, law: str) -> tuple[TorqueTiming, float] | None:
    """The timing under one law and its residual; None where the steps do not come to an end."""
    shift, interval = 0.0, axis.interval
    for number in range(ROUNDS):
        moved = []
        for rows, log in zip(parts, axis.logs, strict=True):
            rate = rows.regressors[:, -1]
            if law == "low-pass":
                left = rows.left - shift * rate
            else:
                left = shifted(rows.left, shift / log.interval)
                rate = difference(left, log.interval)
            moved.append((np.column_stack([rows.regressors[:, :-1], rate]), left))
        factors = stacked(parts[0].names, moved)
        fit = solve(suited_segments(factors) if number else factors)
        error, step = float(np.sqrt(fit.covariance[-1, -1])), float(fit.values[-1])
        shift += step
        if not np.isfinite(step) or error > interval or abs(shift) > FARTHEST * interval:
            return None
        if number and abs(step) < max(SETTLED * interval, 0.2 * error):
            return TorqueTiming(interval=interval, shift=shift, error=error, law=law), fit.residual
    return None


def clock_drift(axis: Axis) -> float:
    """Rate at which the torque's instant moves along every log, as by two clocks, beyond chance; else 0."""
    lagging = replace(axis, equation=replace(axis.equation, lag=True))
    rates = [_rate_of(rows, log) for rows, log in zip(lagging.rows(), axis.logs, strict=True)]
    return float(np.mean(rates)) if all(rates) else 0.0


def _rate_of(rows: Rows, log: Log) -> float:
    """The slope of a line through the instants of the parts of a log, 0 where it may be chance [-]."""
    place = np.arange(rows.left.size)
    time = (place - place.mean()) * log.interval
    inside = (place * DRIFT_PARTS // place.size)[:, None] == np.arange(DRIFT_PARTS)
    middle, line = time @ inside / inside.sum(axis=0), np.zeros(2)
    for _ in range(ROUNDS):
        samples = place - np.polyval(line, time) / log.interval
        left = ndimage.map_coordinates(rows.left, [samples], order=3, mode="nearest")
        columns = [rows.regressors[:, :-1], difference(left, log.interval)[:, None] * inside]
        names = (*rows.names[:-1], *(f"instant {k}" for k in range(DRIFT_PARTS)))
        fit = solve(suited_segments(stacked(names, [(np.column_stack(columns), left)])))
        steps, errors = fit.values[-DRIFT_PARTS:], np.sqrt(np.diag(fit.covariance)[-DRIFT_PARTS:])
        if fit.unidentifiable.size or not (errors.min() > 0.0 and errors.max() < FARTHEST * log.interval):
            return 0.0
        step, square = np.polyfit(middle, steps, 1, w=1.0 / errors, cov="unscaled")
        line = line + step
        if abs(step[0]) * log.report.duration < SETTLED * log.interval:
            break
    else:
        return 0.0
    left_over = (steps - np.polyval(step, middle)) / errors
    error = float(np.sqrt(square[0, 0] * max(1.0, float(left_over @ left_over) / (DRIFT_PARTS - 2))))
    sure = abs(line[0]) >= DRIFT_SURE * error and abs(line[0]) * log.report.duration >= log.interval
    return float(line[0]) if sure else 0.0


def with_clock(log: Log, torque: str, rate: float) -> Log:
    """A log whose torque channel, with a clock of its own, is at the time stamps of the others."""
    samples = np.arange(len(log)) * (1.0 - rate)
    return log.having(
        torque, ndimage.map_coordinates(log.channel(torque), [samples], order=3, mode="nearest")
    )
