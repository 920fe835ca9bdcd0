"""Amplitude spectrum of a record, and where it has its peaks."""

from dataclasses import dataclass

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters import InputRefused

PADDING = 8
FEWEST_SAMPLES = 16


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Spectrum:
    """Amplitudes of the sines in a record."""

    frequency: Array  # (p,): equally spaced from zero [Hz]
    amplitude: Array  # (p,): in the unit of the record; a steady sine shows with its own amplitude
    resolution: float  # one over the length of the record [Hz]: half of a peak's width at its foot

    def peak(self, low: float, high: float) -> tuple[float, float]:
        """The largest peak of a band, its place by a parabola through the logarithm.

        ``low``, ``high``: ends of the band [Hz]. Returns ``frequency`` [Hz]; ``amplitude``: in the unit of
        the record.
        """
        inside = np.flatnonzero((self.frequency > low) & (self.frequency < high))
        inside = inside[(inside > 0) & (inside < self.frequency.size - 1)]
        if inside.size < 3:
            raise InputRefused(
                f"band from {low:.6g} to {high:.6g} Hz has no 3 points of a spectrum: widen it"
            )
        top = int(inside[np.argmax(self.amplitude[inside])])
        before, at, after = np.log(self.amplitude[top - 1 : top + 2] + 1e-300)
        bend = before - 2.0 * at + after
        shift = float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend < 0.0 else 0.0
        return float((top + shift) * self.frequency[1]), float(self.amplitude[top])


def amplitude_spectrum(time: Array, signal: Array) -> Spectrum:
    """Amplitude spectrum through a Hann window of a record, shape (n,), without its straight line."""
    if signal.size < FEWEST_SAMPLES:
        raise InputRefused(
            f"spectrum of {signal.size} samples, at least {FEWEST_SAMPLES} are needed: record more of the run"
        )
    interval = float(time[1] - time[0])
    window = np.hanning(signal.size)
    level = np.polynomial.Polynomial.fit(time, signal, 1)(time)
    padded = PADDING * signal.size
    amplitude = 2.0 * np.abs(np.fft.rfft((signal - level) * window, padded)) / window.sum()
    return Spectrum(
        frequency=np.arange(amplitude.size, dtype=np.float64) / (padded * interval),
        amplitude=amplitude,
        resolution=1.0 / (signal.size * interval),
    )
