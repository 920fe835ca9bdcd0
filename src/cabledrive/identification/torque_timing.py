r"""When a logged torque acts: held from its tick, that of the interval before, behind a sensor.

A controller that holds its torque from tick to tick and logs it at the tick makes a torque that acts half an
interval later than its time stamp; a drive that logs the torque of the interval before, half an interval
earlier. Every method therefore has one unknown more, the time :math:`\delta` by which the torque acts later
than it is logged,

.. math:: \tau(t - \delta) = J\ddot\theta + b\dot\theta + c\,S(\dot\theta) - d ,

found by Gauss-Newton steps on the filtered equation. A sensor behind a low-pass of the first order makes
:math:`\tau + T\dot\tau` of the logged torque instead; where the torque is late by more than `NEAR` intervals,
the law with the smaller residual is taken. Afterwards the torque channel is moved, and what is left of
:math:`\delta` stays a column of each regression, so that its doubt is in every interval.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.filters import difference
from cabledrive.identification.logs.log import Log
from cabledrive.identification.torque_lines import spectral_lines
from cabledrive.parameters import InputRefused

Array = NDArray[np.float64]

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
    """How the torque channel was moved.

    Attributes
    ----------
    shift : float
        Time by which the torque acts later than it is logged [s].
    error : float
        Its standard error [s]; 0 where it is given.
    law : {"shift", "low-pass"}
        "low-pass": the sensor lags with the time constant ``-shift``.
    known : bool
        Whether it is given by an option.
    determined : bool
        Whether the log determines it; else the instant of logging is taken, with a doubt of half an interval.
    stated : str
        Convention that was given, whose shift is that of each log's own interval; empty: none.
    """

    shift: float
    error: float
    law: str = "shift"
    known: bool = False
    determined: bool = True
    stated: str = ""

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
