"""Whether two fitted families can be distinguished, and by what a family is known to be that of a span."""

from math import pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.tension.decaying_tones import TonesFit
from cabledrive.identification.tension.prepared_recording import PreparedRecording

Array = NDArray[np.float64]

SPANS = ("upper", "lower")
ABOUT = 4.0
"""Line widths about a tone within which what is left is its noise."""
WHOLE = (2, 3)
BELOW = 0.5
"""Loudness of a tone at half or a third of a family's first mode, over that mode's, from which it is a first
mode itself: a plucked span has more speed in its first mode than in its second, most points hear it."""
LOUDER = 1.5
"""Ratio of the loudness of both families from which the louder one is that of the plucked span."""


def strength(fit: TonesFit, family: int) -> float:
    """Loudness of a family: root of the sum of squares of its amplitudes."""
    return float(np.linalg.norm(fit.amplitude[fit.tones.family == family]))


def line_widths(fit: TonesFit, duration: float) -> Array:
    """Width of each tone: at half power by its decay, and of the record.

    ``duration`` [s].
    Returns shape (tones,) [Hz].
    """
    return np.asarray(fit.tones.decay / pi + 1.0 / duration)


def excess(prepared: PreparedRecording, fit: TonesFit, family: int) -> float:
    """Density of what is left about the tones of a family, over its mean over all frequencies.

    Returns 1 in white noise.
    """
    density = np.abs(np.fft.rfft(fit.left)) ** 2
    frequency = np.fft.rfftfreq(fit.left.size, prepared.interval)
    own = fit.tones.family == family
    reach = ABOUT * line_widths(fit, prepared.duration)[own]
    near = np.abs(frequency[:, None] - fit.tones.frequency[own]) < reach
    about = np.array([density[column].mean() if column.any() else 0.0 for column in near.T])
    weights = (fit.amplitude[own] * fit.tones.frequency[own]) ** 2
    return float(weights @ about / weights.sum() / density.mean())


def apart(prepared: PreparedRecording, fit: TonesFit, spans: tuple[str, str]) -> bool:
    """Whether each of two families has a partial more than a line width from every mode of the other.

    ``spans``: whose modes each family has.
    """
    tones, width = fit.tones, line_widths(fit, prepared.duration)
    for one, two in ((0, 1), (1, 0)):
        own = np.flatnonzero(tones.family == one)
        others = tones.scale[two] * prepared.factor * prepared.teeth[spans[two]]
        distance = np.abs(tones.frequency[own][:, None] - others).min(axis=1)
        if not np.any(distance > width[own]):
            return False
    return True


def has_tone_below(prepared: PreparedRecording, fit: TonesFit) -> bool:
    """Whether a family may be every second or third mode of a lower one, whose first is among other tones.

    Returns split partials of one frequency and two tensions look so where their first is not split.
    """
    tones = fit.tones
    free = tones.number == 0
    reach = ABOUT * line_widths(fit, prepared.duration)[free]
    for first in np.flatnonzero(tones.number == 1):
        loud = fit.amplitude[free] > BELOW * fit.amplitude[first]
        for whole in WHOLE:
            distance = np.abs(tones.frequency[free] - tones.frequency[first] / whole)
            if np.any(loud & (distance < reach)):
                return True
    return False


def label(prepared: PreparedRecording, fit: TonesFit, plucked: str | None) -> tuple[str, str] | None:
    """Which span each of two families belongs to.

    ``plucked``, {"upper", "lower"}.
    Returns none where the modes are the same and the loudness does not decide.
    """
    if not prepared.alike:
        return SPANS
    first, second = strength(fit, 0), strength(fit, 1)
    if plucked is None or max(first, second) < LOUDER * min(first, second):
        return None
    return SPANS if (plucked == "upper") == (first > second) else (SPANS[1], SPANS[0])
