"""Recordings of pings, from a sound file or any log, made ready; whether they hold a ping at all."""

import warnings
from dataclasses import dataclass, replace
from math import sqrt
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from cabledrive.identification.logs.log import ColumnMap, Log, log_of
from cabledrive.identification.logs.reading import read_log
from cabledrive.identification.signals import zero_phase
from cabledrive.identification.tension.families import ALIKE, Peaks, falling, peaks_of
from cabledrive.modal.natural import longitudinal_modes
from cabledrive.parameters import InputRefused, Machine, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.files import require_regular

PARTIALS = 6
"""Tones are searched up to this mode of a span."""
SQUARED = ("angle", "torque", "tension", "force", "current")
"""Channels that measure the stretch of a vibrating span, which has twice its frequency."""
SEARCHED = 4.0
"""Tensions are searched from the drive's over this to the drive's times this."""
LEAST_COUNT = 0.5
"""Counts of a pulley's encoder that a tone must have: rounding makes tones of its own."""
LOUDEST = 0.9
"""Share of the largest energy that marks the last pluck."""
SAMPLES_PER_PERIOD = 2.6
"""Of the highest tone, down to which a recording is thinned."""
SOUNDING = 0.9
"""Share of the energy over what remains at the end, within which a ping is taken to sound."""
LASTING = 4
"""Times that span, which are fitted."""
FEWEST, MOST_SAMPLES = 50, 60_000
"""Of the thinned recording that are fitted, from the pluck on: up to thousands of periods."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PreparedRecording:
    """A recording made ready."""

    log: Log
    channel: str
    least: float  # amplitude at the pluck below which a tone may be one of rounding
    values: Array  # (samples,): from the last pluck on, without what lies below the lowest tone
    interval: float  # [s]
    factor: float  # 2 where the stretch is recorded, else 1
    teeth: dict[str, Array]  # certified modes of each span at the drive's own tension [Hz]
    band: tuple[float, float]  # where tones are searched [Hz]
    peaks: Peaks
    falling: NDArray[np.bool_]  # (peaks,): which peaks are no hum; all where every one is

    @property
    def no_tone(self) -> NotComputed:
        """The refusal where nothing sounds."""
        between = "between {:.4g} and {:.4g} Hz".format(*self.band)
        return NotComputed(
            f"{self.log.source}: {self.channel}: no tone {between}: pluck again, or correct the drive's "
            "length and tension"
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


def prepared_recording(log: Log, drive: Machine, name: str, teeth: dict[str, Array]) -> PreparedRecording:
    """Make a channel of a recording ready; ``teeth``: certified modes of each span [Hz]."""
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
    if factor == 1.0:  # else a pulley's own motion may be louder later than the pluck
        width = max(4, min(round(8.0 / (low * log.interval)), clear.size // 4))
        energy = signal.convolve(clear**2, np.ones(width), mode="valid")
        clear = clear[int(np.flatnonzero(energy >= LOUDEST * energy.max())[-1]) + max(1, width // 4) :]
    short = InputRefused(f"{log.source}: {name} ends {clear.size} samples after the pluck: record longer")
    if clear.size < 200:
        raise short
    least, levels = 0.0, np.unique(values)
    if factor == 2.0 and 1 < levels.size < 0.1 * values.size:
        least = LEAST_COUNT * float(np.diff(levels).min())
    # spectra of all, and of what sounds, half of all at most
    width, peaks = round(3.0 / (low * log.interval)), None
    power = signal.convolve(clear**2, np.full(width, 1.0 / width), mode="valid")
    energy = np.cumsum(power - float(np.median(power[-max(1, power.size // 5) :])))
    early = max(int(1.5 * np.argmax(energy > SOUNDING * energy.max())), 3 * width)
    lengths = [clear.size, min(early, clear.size // 2)]
    for size in lengths:
        window = np.hanning(size)
        part = (clear[:size] - clear[:size].mean()) * window
        amplitude = np.abs(np.fft.rfft(part, 4 * size)) * 2 / window.sum()
        frequency = np.asarray(np.fft.rfftfreq(4 * size, log.interval), dtype=float)
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
    if clear.size < FEWEST:
        raise short
    return PreparedRecording(
        log=log,
        channel=name,
        least=least,
        values=np.asarray(clear[:MOST_SAMPLES], dtype=float),
        interval=every * log.interval,
        factor=factor,
        teeth=teeth,
        band=(low, high),
        peaks=peaks,
        falling=falling(peaks, clear, every * log.interval),
    )


def _without_pulley_modes(frequency: Array, amplitude: Array, drive: Machine, top: float) -> Array:
    """The spectrum without longitudinal modes and the harmonics that rounding and stretch make of them."""
    cleared = amplitude.copy()
    for mode in longitudinal_modes(drive, below=top):
        for harmonic, share in ((1, 0.06), (2, 0.02), (3, 0.02)):
            reach = max(share * harmonic * mode.frequency, 3.0 * (frequency[4] - frequency[0]))
            cleared[np.abs(frequency - harmonic * mode.frequency) < reach] = 0.0
    return cleared


def _without_sidebands(peaks: Peaks, drive: Machine, high: float) -> Peaks:
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


PERIODS = 3.0
"""Of the first tone, over which the loudness is averaged."""
QUIET, LOUD = 0.35, 0.9
"""Shares of the greatest loudness between which the onset is measured."""
LONGEST_ONSET = 12.0
"""Periods of the first tone that an onset may take, the averaging included."""
FADED = 0.8
"""Share of the greatest loudness to which a ping falls before the recording ends."""


def require_ping(values: Array, interval: float, frequency: float, name: str) -> None:
    """Refuse a recording whose loudness rises slowly or does not fall about a first tone [Hz]."""
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
        said = f"{name}: no ping: the tone at {frequency:.4g} Hz does not decay, as a hum"
        raise NotComputed(f"{said}: pluck the span, record longer")


LARGEST_SOUND = 512 * 2**20
"""Bytes of a sound file that are read; a minute in stereo at 192 kHz has 92 MB."""


def read_ping(path: str | Path, columns: ColumnMap | None = None) -> Log:
    """Read a recording of a ping: a WAV file, or a log of any format that `identify` reads."""
    path = Path(path)
    return read_wav(path) if path.suffix.lower() == ".wav" else read_log(path, columns)


def read_wav(path: str | Path) -> Log:
    """Read a WAV file of plain samples as a log with channels "sound", "sound_2", ..., full scale being 1."""
    from scipy.io import wavfile

    path = Path(path)
    require_regular(path, "give the path of a recording")
    if (size := path.stat().st_size / 2**20) > LARGEST_SOUND / 2**20:
        raise InputRefused(f"{path.name}: has {size:.0f} MB, at most 512 MB are read: cut out the ping")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", wavfile.WavFileWarning)
            rate, values = wavfile.read(path)
    except Exception as error:
        raise InputRefused(f"{path.name}: is no plain sound file ({error}): export it as WAV, PCM") from None
    if values.shape[0] < 3 or rate <= 0:
        raise InputRefused(f"{path.name}: holds {values.shape[0]} samples: record again")
    rows = values.reshape(values.shape[0], -1).astype(float)
    if not np.isfinite(rows).all():
        count = rows.size - int(np.isfinite(rows).sum())
        raise InputRefused(f"{path.name}: {count} samples are no numbers: export it again, or cut them out")
    if values.dtype.kind in "iu":
        full = float(np.iinfo(values.dtype).max) + 1.0
        rows = rows / full if values.dtype.kind == "i" else 2.0 * rows / full - 1.0
    channels = {("sound" if k == 0 else f"sound_{k + 1}"): row for k, row in enumerate(rows.T)}
    time = np.arange(rows.shape[0], dtype=np.float64) / rate
    log = log_of(time, channels, dict.fromkeys(channels, "full scale"), source=path.name)
    clipped = [name for name, row in channels.items() if np.mean(np.abs(row) >= 0.999) > 1e-3]
    findings = tuple(f"{name} is clipped: record it less loud" for name in clipped)
    return replace(log, report=replace(log.report, findings=findings))
