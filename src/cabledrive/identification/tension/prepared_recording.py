"""A recording of pings made ready: begun after the last pluck, thinned, its peaks found."""

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from cabledrive.identification.filters import zero_phase
from cabledrive.identification.logs.log import Log
from cabledrive.identification.tension.families import ALIKE, Peaks, falling, peaks_of
from cabledrive.identification.tension.partials import LEAST_COUNT, amplitude_spectrum, count_of
from cabledrive.modal import longitudinal_modes
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.route import RoutedDrive

Array = NDArray[np.float64]

PARTIALS = 6
"""Tones are searched up to this mode of a span."""
SQUARED = ("angle", "torque", "tension", "force", "current")
"""Channels that measure the stretch of a vibrating span, which has twice its frequency."""
SEARCHED = 4.0
"""Tensions are searched from the drive's over this to the drive's times this."""
LOUDEST = 0.9
"""Share of the largest energy that marks the last pluck."""
SAMPLES_PER_PERIOD = 2.6
"""Of the highest tone, down to which a recording is thinned."""
SOUNDING = 0.9
"""Share of the energy over what remains at the end, within which a ping is taken to sound."""
LASTING = 4
"""Times that span, which are fitted."""
MOST_SAMPLES = 60_000
"""Of the thinned recording that are fitted, from the pluck on: thousands of periods of the first tone."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PreparedRecording:
    """A recording made ready.

    Attributes
    ----------
    channel : str
    values : ndarray, shape (samples,)
        From the last pluck on, without what lies below the lowest tone.
    interval : float
        [s].
    factor : float
        2 where the stretch is recorded, else 1.
    teeth : mapping of str to ndarray
        Certified modes of each span at the drive's own tension [Hz].
    band : (float, float)
        Where tones are searched [Hz].
    peaks : Peaks
    falling : ndarray of bool, shape (peaks,)
        Which peaks are no hum; all where every one is.
    source : str
    least : float
        Amplitude at the pluck below which a tone may be one of rounding.
    section : int
    """

    channel: str
    source: str
    least: float
    section: int
    values: Array
    interval: float
    factor: float
    teeth: dict[str, Array]
    band: tuple[float, float]
    peaks: Peaks
    falling: NDArray[np.bool_]

    @property
    def no_tone(self) -> NotComputed:
        """The refusal where nothing sounds."""
        low, high = self.band
        return NotComputed(
            f"{self.source}: {self.channel}: no tone between {low:.4g} and {high:.4g} Hz: pluck again, or "
            "correct the drive's length and tension"
        )

    @property
    def alike(self) -> bool:
        """Whether both spans have the same modes, so that no frequency says which is which."""
        return bool(np.allclose(self.teeth["upper"], self.teeth["lower"], rtol=ALIKE))

    @property
    def duration(self) -> float:
        """Length of the fitted part [s]."""
        return self.interval * self.values.size

    @property
    def power(self) -> int:
        """Power of the envelope that shifts a frequency."""
        return 1 if self.factor == 2.0 else 2


def prepared_recording(
    log: Log, drive: Drive | RoutedDrive, name: str, teeth: dict[str, Array], section: int = 0
) -> PreparedRecording:
    """Make a recording ready.

    ``name``: channel; ``teeth``: certified modes of the ``section`` of each span [Hz].
    Raises `InputRefused` if the channel is constant, too slow or too short.
    """
    values = log.channel(name)
    if np.ptp(values) == 0.0:
        raise InputRefused(f"{log.source}: {name} is constant: record the ping")
    factor = 2.0 if name.rpartition("_")[2] in SQUARED else 1.0
    top, limit = 0.45 * log.sample_rate, sqrt(SEARCHED)
    lowest = min(row[0] for row in teeth.values())
    low = factor * lowest / limit
    high = min(top, factor * limit * max(row[:PARTIALS][-1] for row in teeth.values()))
    if low >= high:
        raise InputRefused(
            f"{log.source}: {log.sample_rate:.4g} samples per second are too few for tones about "
            f"{factor * lowest:.4g} Hz: record faster"
        )
    clear = values - values.mean() - zero_phase(values - values.mean(), log.interval, 0.4 * low)
    if factor == 1.0:  # a pulley's own motion may be louder later than the pluck
        clear = clear[_last_pluck(clear, round(8.0 / (low * log.interval))) :]
    if clear.size < 200:
        raise InputRefused(f"{log.source}: {name} ends {clear.size} samples after the pluck: record longer")
    least = LEAST_COUNT * count_of(values) if factor == 2.0 else 0.0
    peaks: Peaks | None = None
    lengths = _lengths(clear, round(3.0 / (low * log.interval)))
    for size in lengths:
        frequency, amplitude = amplitude_spectrum(clear[:size], log.interval)
        if factor == 2.0:
            amplitude = _without_pulley_modes(frequency, amplitude, drive, top)
            amplitude = np.where(amplitude > 0.5 * least, amplitude, 0.0)  # it decays
        found = peaks_of(frequency, amplitude, (0.9 * low, high), size * log.interval)
        peaks = found if peaks is None else peaks.joined(found)
    assert peaks is not None
    peaks = _without_sidebands(peaks, drive, high)
    clear = clear[: LASTING * lengths[-1]]
    highest = min(high, 2.0 * float(peaks.frequency.max())) if peaks.frequency.size else high
    every = max(1, int(log.sample_rate / (SAMPLES_PER_PERIOD * highest)))
    if every > 1:
        clear = signal.resample_poly(clear, 1, every)[10:-10]  # without the ends of its filter
    return PreparedRecording(
        channel=name,
        source=log.source,
        least=least,
        section=section,
        values=np.asarray(clear[:MOST_SAMPLES], dtype=float),
        interval=every * log.interval,
        factor=factor,
        teeth=teeth,
        band=(low, high),
        peaks=peaks,
        falling=falling(peaks, clear, every * log.interval),
    )


def _without_pulley_modes(
    frequency: Array, amplitude: Array, drive: Drive | RoutedDrive, top: float
) -> Array:
    """The spectrum without the drive's longitudinal modes, which do not depend on the tension.

    Their second and third harmonics are cut out as well: rounding and stretch make them.
    """
    cleared = amplitude.copy()
    for mode in longitudinal_modes(drive, below=top):
        for harmonic, share in ((1, 0.06), (2, 0.02), (3, 0.02)):
            reach = max(share * harmonic * mode.frequency, 3.0 * (frequency[4] - frequency[0]))
            cleared[np.abs(frequency - harmonic * mode.frequency) < reach] = 0.0
    return cleared


def _last_pluck(values: Array, width: int) -> int:
    """Just after the last time at which the recording was about as loud as ever."""
    width = max(4, min(width, values.size // 4))
    energy = signal.convolve(values**2, np.ones(width), mode="valid")
    return int(np.flatnonzero(energy >= LOUDEST * energy.max())[-1]) + max(1, width // 4)


def _lengths(values: Array, width: int) -> list[int]:
    """Samples whose spectra are searched: all, and those in which the ping sounds, half of all at most."""
    power = signal.convolve(values**2, np.full(width, 1.0 / width), mode="valid")
    floor = float(np.median(power[-max(1, power.size // 5) :]))
    energy = np.cumsum(power - floor)
    early = max(int(1.5 * np.argmax(energy > SOUNDING * energy.max())), 3 * width)
    return [values.size, min(early, values.size // 2)]


def _without_sidebands(peaks: Peaks, drive: Drive | RoutedDrive, high: float) -> Peaks:
    """Peaks without pairs that a turning pulley puts on both sides of a louder one."""
    turning = np.array([mode.frequency for mode in longitudinal_modes(drive, below=high)])
    kept = np.ones(peaks.frequency.size, dtype=bool)
    for place, (f, a) in enumerate(zip(peaks.frequency, peaks.amplitude, strict=True)):
        for loud in np.flatnonzero(peaks.amplitude > 3.0 * a):
            shift = f - peaks.frequency[loud]
            reach = 2.0 * peaks.reach[place]
            orders = np.abs(np.outer(turning, [1.0, 2.0]) - abs(shift)) < reach
            mirrored = np.abs(peaks.frequency - (peaks.frequency[loud] - shift)) < reach
            alike = mirrored & (peaks.amplitude < 2.5 * a) & (peaks.amplitude > a / 2.5)
            kept[place] &= not (orders.any() and alike.any())
    return peaks.only(kept)
