"""Partials of a ping, and the spectrum in which they are found."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_COUNT = 0.5
"""Counts of a pulley's encoder that a tone must have: rounding makes tones of its own."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Partial:
    """One tone of a ping.

    Attributes
    ----------
    number : int
        Which mode of the span, from 1.
    frequency : float
        At vanishing amplitude where ``decays``, else at its own [Hz].
    standard_error : float
        [Hz].
    peak : float
        Where the spectrum of the whole record has its peak [Hz].
    amplitude : float
        Largest envelope, in the channel's unit.
    rise : float
        By how much the frequency was higher at that envelope [Hz]; 0 where it cannot be determined.
    decays : bool
        Whether the envelope falls enough to identify the effect of amplitude.
    """

    number: int
    frequency: float
    standard_error: float
    peak: float
    amplitude: float
    rise: float
    decays: bool

    def as_dict(self) -> dict[str, Any]:
        """The partial as JSON has it."""
        return {
            "number": self.number,
            "frequency_hz": self.frequency,
            "standard_error_hz": self.standard_error,
            "rise_with_amplitude_hz": self.rise,
        }


def count_of(values: Array) -> float:
    """Step between the levels of a channel.

    ``values``, shape (samples,).
    Returns in the channel's unit; 0 where it has no levels.
    """
    levels = np.unique(values)
    return float(np.diff(levels).min()) if 1 < levels.size < 0.1 * values.size else 0.0


def amplitude_spectrum(values: Array, interval: float) -> tuple[Array, Array]:
    """Amplitude over frequency, Hann window, four times padded.

    ``values``, shape (samples,); ``interval`` [s].
    Returns ``frequency, amplitude`` [Hz], unit of the values.
    """
    window = np.hanning(values.size)
    padded = 4 * values.size
    spectrum = np.abs(np.fft.rfft((values - values.mean()) * window, padded)) * 2 / window.sum()
    return np.asarray(np.fft.rfftfreq(padded, interval), dtype=float), spectrum
