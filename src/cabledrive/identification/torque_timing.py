r"""When a logged torque acts, its spectral lines, and how late its channel is.

A controller that holds its torque from tick to tick and logs it at the tick makes a torque that acts half an
interval later than its time stamp; a drive that logs the torque of the interval before, half an interval
earlier. Every method therefore has one unknown more, the time :math:`\delta` by which the torque acts later
than it is logged,

.. math:: \tau(t - \delta) = J\ddot\theta + b\dot\theta + c\,S(\dot\theta) - d ,

found by Gauss-Newton steps on the filtered equation. A sensor behind a low-pass of the first order makes
:math:`\tau + T\dot\tau` of the logged torque instead; where the torque is late by more than `NEAR` intervals,
the law with the smaller residual is taken. Afterwards the torque channel is moved, and what is left of
:math:`\delta` stays a column of each regression, so that its doubt is in every interval.

The first figure holds to first order, while the delay is short against the fastest line. Moved back by it,
and fitted anew, the log shows how much is left.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.filters import difference
from cabledrive.identification.logs.log import Log
from cabledrive.identification.rigid_axis import AxisOptions, channels_of
from cabledrive.parameters import InputRefused, NotComputed

Array = NDArray[np.float64]

SPARSE = 0.3
HALF = 0.5
BETWEEN = 2.5
"""Power density between lines over that above them: nearly 1 where the rest is noise; 4 and more where the
torque of a feedback loop happens to have peaks."""


def spectral_lines(values: Array) -> Array:
    """A signal without what lies near its noise floor; the signal itself where it is no sum of lines.

    ``values``, shape (samples,).
    Returns shape (samples,).
    """
    spectrum = np.fft.rfft(values)
    kept = _lines_of(spectrum)
    if kept.mean() > SPARSE:
        return values
    return np.fft.irfft(np.where(kept, spectrum, 0.0), values.size)


def driven_by_lines(logs: Sequence[Log], options: AxisOptions) -> bool:
    """Whether the torque of every log is a sum of lines, so that a motion free of noise is known.

    Returns false where what stands above the noise fills more than half of its band, as steps, chirps and
    torques of feedback loops do; and where the torque channel saturates, for it cannot drive a model then.
    """
    torque, _ = channels_of(logs[0], options)
    for log in logs:
        if torque in log.saturated and log.saturated[torque].any():
            return False
        kept = _lines_of(np.fft.rfft(log.channel(torque)))
        band = np.flatnonzero(kept)
        if band.size == 0 or band.size > HALF * (band[-1] - band[0] + 1) or kept.mean() > SPARSE:
            return False
    return True


def noise_between_lines(logs: Sequence[Log], options: AxisOptions) -> bool:
    """Whether nothing but noise lies between the torque's lines, so that they are all that moves the axis.

    ``logs``: driven by lines, see `driven_by_lines`.
    """
    torque, _ = channels_of(logs[0], options)
    spectra = [np.fft.rfft(log.channel(torque)) for log in logs]
    return all(_between_and_above(np.abs(s) ** 2, _lines_of(s)) <= BETWEEN for s in spectra)


def _between_and_above(power: Array, kept: NDArray[np.bool_]) -> float:
    """Mean power between the lines over that above them; 1 where there is no such place."""
    first, last = np.flatnonzero(kept)[[0, -1]]
    between = power[first:last][~kept[first:last]]
    above = power[last + 1 :]
    return float(between.mean() / above.mean()) if between.size and above.size and above.any() else 1.0


def _lines_of(spectrum: NDArray[np.complex128]) -> NDArray[np.bool_]:
    size = np.abs(spectrum)
    above = size > 12.0 * np.median(size)
    return np.asarray(np.convolve(above, np.ones(3), "same") > 0)


TAPS = 16
"""Half length of the interpolation filter [samples]."""
NEAR = 0.75
"""Delay of the torque channel from which a sensor's low-pass is tried too [intervals]."""
ROUNDS = 8
SETTLED = 0.02
"""Last step [intervals]."""
FARTHEST = 25.0
"""Largest shift that is taken for a matter of time stamps [intervals]."""
SNAP = 0.08
"""Distance to a convention within which it is named [intervals]."""
CUSTOMARY = 1.3
"""Shift up to which it is a note, not a finding [intervals]."""
CONVENTIONS = {"held": 0.5, "interpolated": 0.0, "before": -0.5}
"""Time by which the torque acts later than it is logged [intervals]."""
TIMINGS = ("found", *CONVENTIONS)
WORDS = {
    "held": "the torque is held from the sample at which it is logged",
    "interpolated": "the torque is logged at the instant at which it acts",
    "before": "the logged torque is that of the interval before",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueTiming:
    """How the torque channel was moved."""

    shift: float  # time by which the torque acts later than it is logged [s]
    error: float  # its standard error [s]; 0 where it is given
    law: str = "shift"  # {"shift", "low-pass"}: "low-pass": the sensor lags with the time constant ``-shift``
    known: bool = False  # whether it is given by an option
    # whether the log determines it; else the instant of logging is taken, with a doubt of half an interval
    determined: bool = True
    stated: str = ""  # convention that was given, whose shift is that of each log's own interval; empty: none

    def of(self, interval: float) -> "TorqueTiming":
        """The timing of a log with this interval [s]."""
        return replace(self, shift=CONVENTIONS[self.stated] * interval) if self.stated else self

    def convention(self, interval: float) -> str | None:
        """The convention that the shift agrees with, None where there is none.

        ``interval`` [s].
        Returns key of `CONVENTIONS`.
        """
        near = min(CONVENTIONS, key=lambda name: abs(self.shift / interval - CONVENTIONS[name]))
        off = abs(self.shift - CONVENTIONS[near] * interval)
        agrees = off < max(SNAP * interval, 4.0 * self.error) and self.error < 0.1 * interval
        return near if agrees and self.law == "shift" else None

    def hold(self, interval: float) -> tuple[float, float]:
        """Second difference to be taken off the moved torque for its means between samples, and its doubt.

        A torque that stands from tick to tick has lost 6/48 of it when it is moved by half an interval and
        neighbours are averaged; otherwise it lies between the 4/48 of point samples and the 12/48 of means of
        a held torque.

        ``interval`` [s].
        """
        stands = self.convention(interval) in ("held", "before")
        return (6 / 48, 1 / 48) if stands else (8 / 48, 4 / 48)

    def words(self, interval: float) -> str:
        """The timing in a sentence.

        ``interval`` [s].
        """
        if not self.determined:
            return "the instant at which the torque acts is not determined by the log"
        name = self.convention(interval)
        if name is not None:
            return f"{WORDS[name]} (acts {1e3 * self.shift:+.3g} ms from its time stamp)"
        if self.customary(interval):
            when = "later" if self.shift > 0.0 else "earlier"
            return f"the torque acts {1e3 * abs(self.shift):.3g} ms {when} than its time stamp: corrected"
        if self.law == "low-pass":
            hertz = 1.0 / (2.0 * np.pi * -self.shift)
            return (
                f"the torque channel lags as behind a low-pass of {hertz:.3g} Hz "
                f"({-1e3 * self.shift:.3g} ms): corrected"
            )
        if self.shift < 0.0:
            return (
                f"the torque channel is delayed against the motion by {-self.shift:.3g} s: corrected; "
                "shift it in the log"
            )
        return (
            f"the motion follows the torque channel {self.shift:.3g} s late: a dead time, or a flexible joint"
        )

    def customary(self, interval: float) -> bool:
        """Whether a shift of this size is a habit of logging and no fault.

        ``interval`` [s].
        """
        return abs(self.shift) <= CUSTOMARY * interval


def shifted(values: Array, samples: float, *, periodic: bool = False) -> Array:
    """A signal later by a number of samples, whole or not.

    ``values``, shape (samples,); ``periodic``: whether it is continued periodically, else by its ends.
    Returns shape (samples,).
    """
    if samples == 0.0:
        return values
    whole = int(np.floor(samples))
    part = samples - whole
    reach = TAPS + abs(whole)
    padded = np.pad(values, reach, mode="wrap" if periodic else "edge")
    places = np.arange(-TAPS, TAPS + 1)
    weights = np.sinc(places - part) * np.kaiser(2 * TAPS + 1, 8.0)
    moved = np.convolve(padded, weights / weights.sum(), "same")
    return moved[reach - whole : reach - whole + values.size]


def moved_torque(values: Array, timing: TorqueTiming, interval: float) -> Array:
    """The torque at the instants at which it acts.

    ``values``, shape (samples,): as logged; ``interval`` [s].
    Returns shape (samples,).
    """
    if timing.law == "low-pass":
        return values - timing.shift * difference(values, interval)
    periodic = spectral_lines(values) is not values
    return shifted(values, timing.shift / interval, periodic=periodic)


def with_torque_moved(logs: Sequence[Log], torque: str, timing: TorqueTiming) -> list[Log]:
    """Logs whose torque channel stands at the instants at which it acts.

    ``torque``: channel.
    """
    return [
        replace(
            log,
            channels={
                **log.channels,
                torque: moved_torque(log.channel(torque), timing.of(log.interval), log.interval),
            },
        )
        for log in logs
    ]


def given_timing(name: str, interval: float) -> TorqueTiming:
    """Timing of a convention.

    ``name``: key of `CONVENTIONS`; ``interval`` [s].
    Raises `InputRefused` if it is unknown.
    """
    if name not in CONVENTIONS:
        raise InputRefused(f'identify.torque = "{name}" is unknown: take one of {", ".join(TIMINGS)}')
    return TorqueTiming(shift=CONVENTIONS[name] * interval, error=0.0, known=True, stated=name)


DELAY_ROUNDS = 12


def moved_back(log: Log, channel: str, samples: int) -> Log:
    """A log with one channel earlier by whole samples; what has no partner at either end is left out.

    ``samples``: later where negative.
    """
    size = len(log) - abs(samples)
    own, others = max(samples, 0), max(-samples, 0)
    kept = log.part(float(log.time[others]), float(log.time[others + size - 1]) + log.interval)
    moved = {**kept.channels, channel: log.channels[channel][own : own + size]}
    return replace(kept, channels=moved)


def torque_delay(
    logs: Sequence[Log], options: AxisOptions, first: float, left_in: Callable[[Sequence[Log]], float]
) -> float:
    """Delay of the torque channel against the motion.

    ``first``: its estimate from the logs as they are, to first order [s]; ``left_in``: the same of logs whose
    channel was moved back: what is left [s].
    Returns [s]; to a share of a sample where the torque between samples allows it.
    Raises `NotComputed` if it does not come to an end: the lag is no delay.
    """
    torque, _ = channels_of(logs[0], options)
    interval, samples, left = logs[0].interval, 0, first
    for _ in range(DELAY_ROUNDS):
        step = round(left / interval)
        if step == 0:
            return samples * interval + left
        samples += step
        if abs(samples) > min(len(log) for log in logs) // 4:
            break
        left = left_in([moved_back(log, torque, samples) for log in logs])
    raise NotComputed(f"moved back by {samples * interval:.3g} s the torque channel still lags")
