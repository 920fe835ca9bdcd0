"""Whether a recording holds a ping at all: a sudden beginning, and an end that is quieter."""

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from cabledrive.identification.filters import zero_phase
from cabledrive.parameters import NotComputed

Array = NDArray[np.float64]

PERIODS = 3.0
"""Of the first tone, over which the loudness is averaged."""
QUIET, LOUD = 0.35, 0.9
"""Shares of the greatest loudness between which the onset is measured."""
LONGEST_ONSET = 12.0
"""Periods of the first tone that an onset may take, the averaging included."""
FADED = 0.8
"""Share of the greatest loudness to which a ping falls before the recording ends."""


def require_ping(values: Array, interval: float, frequency: float, name: str) -> None:
    """Refuse a recording in which nothing is plucked: a sweep, a hum, a machine that runs.

    ``values``, shape (samples,); ``interval`` [s]; ``frequency``: of the first tone, as it is recorded [Hz];
    ``name``: file and channel.
    Raises `NotComputed` if the loudness rises slowly, or does not fall afterwards.
    """
    width = round(PERIODS / (frequency * interval))
    clear = values - values.mean()
    clear = clear - zero_phase(clear, interval, 0.4 * frequency)
    if clear.size < 4 * width or width < 2:
        return  # too short for a tone to be found in it
    power = signal.convolve(clear**2, np.full(width, 1.0 / width), mode="valid")
    loudness = np.sqrt(np.maximum(power, 0.0))
    greatest = float(loudness.max())
    top = int(np.argmax(loudness >= LOUD * greatest))
    before = np.flatnonzero(loudness[:top] < QUIET * greatest)
    rise = top - int(before[-1]) if before.size else top
    if rise * interval * frequency > LONGEST_ONSET:
        raise NotComputed(
            f"{name}: no ping: the loudness takes {rise * interval:.3g} s to rise, a pluck at most "
            f"{LONGEST_ONSET / frequency:.3g} s: pluck the span once, and record nothing else"
        )
    if float(loudness[-max(1, width) :].mean()) > FADED * greatest:
        raise NotComputed(
            f"{name}: no ping: the tone at {frequency:.4g} Hz does not decay, as a hum: pluck the span, "
            "record longer"
        )
