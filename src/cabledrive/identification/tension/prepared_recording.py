"""A recording of both spans made ready: begun after the last pluck, thinned, its peaks found."""

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from cabledrive.identification.filters import zero_phase
from cabledrive.identification.logs.log import Log
from cabledrive.identification.tension.families import ALIKE, Peaks, peaks_of
from cabledrive.identification.tension.from_ping import PARTIALS, section_modes
from cabledrive.identification.tension.partials import LEAST_COUNT, amplitude_spectrum, count_of
from cabledrive.identification.tension.pinged_string import SEARCHED, SQUARED, without_pulley_modes
from cabledrive.modal import longitudinal_modes
from cabledrive.parameters import Drive, InputRefused

Array = NDArray[np.float64]

LOUDEST = 0.9
"""Share of the largest energy that marks the last pluck."""
TEETH = 16
"""Modes of a span that a peak may belong to; tones are searched up to the `PARTIALS`-th."""
SAMPLES_PER_PERIOD = 2.6
"""Of the highest tone, down to which a recording is thinned."""


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
    section : int
    """

    channel: str
    values: Array
    interval: float
    factor: float
    teeth: dict[str, Array]
    band: tuple[float, float]
    peaks: Peaks
    section: int

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


def prepared_recording(log: Log, drive: Drive, name: str, section: int) -> PreparedRecording:
    """Make a recording of both spans ready.

    ``name``: channel.
    Raises `InputRefused` if the channel is constant, too slow or too short.
    """
    values = log.channel(name)
    if np.ptp(values) == 0.0:
        raise InputRefused(f"{log.source}: {name} is constant: record the ping")
    factor = 2.0 if name.rpartition("_")[2] in SQUARED else 1.0
    teeth = {span: modes_of(drive, span, section) for span in drive.spans}
    top, limit = 0.45 * log.sample_rate, sqrt(SEARCHED)
    lowest = min(row[0] for row in teeth.values())
    low, high = (
        factor * lowest / limit,
        min(top, factor * limit * max(row[PARTIALS - 1] for row in teeth.values())),
    )
    if low >= high:
        raise InputRefused(
            f"{log.source}: {log.sample_rate:.4g} samples per second are too few for tones about "
            f"{factor * lowest:.4g} Hz: record faster"
        )
    clear = values - values.mean() - zero_phase(values - values.mean(), log.interval, 0.4 * low)
    clear = clear[_last_pluck(clear, round(8.0 / (low * log.interval))) :]
    if clear.size < 200:
        raise InputRefused(f"{log.source}: {name} ends {clear.size} samples after the pluck: record longer")
    frequency, amplitude = amplitude_spectrum(clear, log.interval)
    if factor == 2.0:
        amplitude = without_pulley_modes(frequency, amplitude, drive, top)
        amplitude = np.where(amplitude > LEAST_COUNT * count_of(values), amplitude, 0.0)
    peaks = peaks_of(frequency, amplitude, (0.9 * low, high), clear.size * log.interval)
    peaks = _without_sidebands(peaks, drive, high)
    highest = float(peaks.frequency.max()) if peaks.frequency.size else high
    every = max(1, int(log.sample_rate / (SAMPLES_PER_PERIOD * highest)))
    thinned = np.asarray(signal.resample_poly(clear, 1, every) if every > 1 else clear, dtype=float)
    return PreparedRecording(
        channel=name,
        values=thinned,
        interval=every * log.interval,
        factor=factor,
        teeth=teeth,
        band=(low, high),
        peaks=peaks,
        section=section,
    )


def modes_of(drive: Drive, span: str, section: int) -> Array:
    """Certified modes of a section of a span.

    ``span``, {"upper", "lower"}; ``section``: of a span that guided carriages part; one in a single piece has
    one.
    Returns shape (TEETH,) [Hz].
    """
    parted = any(carriage.guided for carriage in drive.carriages_on(span))
    return section_modes(drive, span, section if parted else 0, TEETH)


def _last_pluck(values: Array, width: int) -> int:
    """Just after the last time at which the recording was about as loud as ever."""
    width = max(4, min(width, values.size // 4))
    energy = signal.convolve(values**2, np.ones(width), mode="valid")
    return int(np.flatnonzero(energy >= LOUDEST * energy.max())[-1]) + max(1, width // 4)


def _without_sidebands(peaks: Peaks, drive: Drive, high: float) -> Peaks:
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
    return Peaks(
        frequency=peaks.frequency[kept],
        amplitude=peaks.amplitude[kept],
        weight=peaks.weight[kept],
        reach=peaks.reach[kept],
    )
