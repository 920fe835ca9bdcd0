r"""Partials of a ping: frequency of each at vanishing amplitude, with its standard error.

Each partial is shifted to zero frequency and filtered; its phase is then fitted by

.. math:: \varphi(t) = \varphi_0 + 2\pi\,\delta f\,t + c\int_0^t A^p\,dt,

weighted with the envelope A. A taut string sounds higher the larger it swings, in proportion to the square
of its amplitude (p = 2); a pulley answers with the square of that swing, so its own amplitude enters once
(p = 1).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.filters import zero_phase
from cabledrive.identification.regression import factor, solve

Array = NDArray[np.float64]

AUDIBLE = 3.0
"""Envelope over the noise in its band down to which a partial is followed."""
LEAST_ONSET = 10.0
"""The same at its loudest, without which it is not taken for a tone."""
FADED = 0.03
"""Share of its largest envelope at which a partial is left, noise or not."""
LEAST_DECAY = 2.0
"""Factor by which the envelope must fall before its effect on the frequency can be determined."""
SEGMENTS = 24
USUAL_RISE = 0.01
"""Rise of the frequency with amplitude that is expected, relative; a soft bound where noise hides it."""
FEWEST_PERIODS = 8.0
LEAST_COUNT = 0.5
"""Counts of a pulley's encoder that a tone must have: rounding makes tones of its own."""
LOUD = 0.3
"""Share of the first partial above which another tone near it is resolved."""


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


def fundamental(frequency: Array, amplitude: Array, ratios: Array, low: float, high: float) -> float:
    """Frequency of the first partial whose whole row stands out most.

    ``frequency``, ``amplitude``: spectrum; ``ratios``, shape (partials,): of each partial to the first;
    ``low``, ``high``: where the first may lie [Hz].
    Returns [Hz].
    """
    step = frequency[1] - frequency[0]
    tried = np.arange(low, high, step, dtype=np.float64)
    weights = 1.0 / np.arange(1, ratios.size + 1, dtype=np.float64)
    rows = [
        weight * np.sqrt(np.interp(ratio * tried, frequency, amplitude, right=0.0))
        for ratio, weight in zip(ratios, weights, strict=True)
    ]
    return float(tried[int(np.argmax(np.sum(rows, axis=0)))])


def peak_near(frequency: Array, amplitude: Array, wanted: float, reach: float) -> float | None:
    """Frequency of the largest peak near a frequency, if it stands out of the spectrum around it.

    ``frequency``, ``amplitude``: spectrum; ``wanted``, ``reach`` [Hz].
    Returns [Hz].
    """
    near = np.flatnonzero(np.abs(frequency - wanted) <= reach)
    if near.size < 3:
        return None
    top = near[int(np.argmax(amplitude[near]))]
    ends = amplitude[max(top - 1, 0)], amplitude[min(top + 1, amplitude.size - 1)]
    if top in (near[0], near[-1]) or 0.0 in ends:
        return None
    if amplitude[top] <= 5.0 * noise_level(amplitude):
        return None
    low, middle, high = np.log([ends[0], amplitude[top], ends[1]])  # a parabola through the three
    shift = 0.5 * (low - high) / (low - 2.0 * middle + high)
    return float(frequency[top] + shift * (frequency[1] - frequency[0]))


def other_tone(
    frequency: Array, amplitude: Array, peak: float, band: tuple[float, float], apart: float
) -> float | None:
    """A second tone beside the first partial, half an octave around it: another span, or none.

    ``frequency``, ``amplitude``: spectrum; ``peak``: frequency of the first partial [Hz]; ``band``: where to
    look [Hz]; ``apart``: how far from the first another one can be resolved [Hz].
    Returns [Hz]; None where nothing is `LOUD` beside the first.
    """
    inside = (frequency > band[0]) & (frequency < band[1]) & (np.abs(frequency - peak) > apart)
    tops = inside[1:-1] & (amplitude[1:-1] > amplitude[:-2]) & (amplitude[1:-1] > amplitude[2:])
    places = np.flatnonzero(tops) + 1
    if places.size == 0:
        return None
    best = places[int(np.argmax(amplitude[places]))]
    own = float(np.interp(peak, frequency, amplitude))
    return float(frequency[best]) if amplitude[best] > LOUD * own else None


def noise_level(amplitude: Array) -> float:
    """Level of the amplitude spectrum between the tones.

    Returns median of what is not cut out.
    """
    return float(np.median(amplitude[amplitude > 0.0]))


def partial_at(
    values: Array, interval: float, number: int, frequency: float, width: float, power: int, noise: float
) -> Partial | None:
    """Follow one partial through a ping.

    ``values``, shape (samples,); ``interval`` [s]; ``frequency``: about where it is [Hz]; ``width``: half of
    the band that belongs to it [Hz]; ``power``, {1, 2}: power of the envelope that shifts the frequency;
    ``noise``: level of the amplitude spectrum between the tones.
    Returns none where it does not sound long enough.
    """
    time = interval * np.arange(values.size, dtype=np.float64)
    shifted = (values - values.mean()) * np.exp(-2j * np.pi * frequency * time)
    parts = zero_phase(np.column_stack([shifted.real, shifted.imag]), interval, width)
    tone = 2.0 * (parts[:, 0] + 1j * parts[:, 1])
    envelope = np.abs(tone)
    floor = _noise_in_band(noise, values.size, width * interval)
    part = _sounding(envelope, interval, width, floor)
    if part is None or (part.stop - part.start) * interval * frequency < FEWEST_PERIODS:
        return None
    size, phase, lasting = envelope[part], np.unwrap(np.angle(tone[part])), time[part]
    falling = bool(size.max() >= LEAST_DECAY * size[-1])
    grown = interval * np.cumsum((size / size.max()) ** power)
    regressors = np.column_stack([np.ones(size.size), 2 * np.pi * (lasting - lasting[0]), 2 * np.pi * grown])
    rows, left = size[:, None] * regressors, size * phase
    if falling:
        soft = floor / np.sqrt(4.0 * width * interval) / (USUAL_RISE * frequency)
        rows, left = np.vstack([rows, [0.0, 0.0, soft]]), np.append(left, 0.0)
    names = ("phase", "frequency", "amplitude")[: 3 if falling else 2]
    fit = solve(factor(rows[:, : len(names)], left, names, min(SEGMENTS, size.size // 12)))
    return Partial(
        number=number,
        frequency=frequency + float(fit.values[1]),
        standard_error=float(np.sqrt(fit.covariance[1, 1])),
        peak=frequency,
        amplitude=float(size.max()),
        rise=float(fit.values[2]) if falling else 0.0,
        decays=falling,
    )


def _noise_in_band(level: float, samples: int, share: float) -> float:
    """Noise of an envelope, from the median of the amplitude spectrum: Rayleigh, Hann window."""
    deviation = level * np.sqrt(samples / (6.0 * np.log(2.0)))
    return float(2.0 * deviation * np.sqrt(2.0 * share))


def _sounding(envelope: Array, interval: float, width: float, noise: float) -> slice | None:
    """From just after the pluck until the tone sinks into the noise."""
    settled = int(np.ceil(0.7 / (width * interval)))
    if envelope.size < 4 * settled:
        return None
    start = settled + int(np.argmax(envelope[settled:-settled]))
    floor = max(AUDIBLE * noise, FADED * float(envelope[start]))
    silent = np.flatnonzero(envelope[start:-settled] < floor)
    end = start + int(silent[0]) if silent.size else envelope.size - settled
    return slice(start, end) if envelope[start] > LEAST_ONSET * noise and end - start >= 40 else None
