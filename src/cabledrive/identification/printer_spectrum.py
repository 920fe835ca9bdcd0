r"""Vibration of a printer's head against frequency, and the input shaper that it asks for by Klipper's rules.

Three kinds of file are read: ``resonances_x_*.csv`` (power spectral densities psd_x, psd_y, psd_z, psd_xyz),
``calibration_data_x_*.csv`` (the same, already normalised to the excitation, with columns of shapers), and
accelerometer samples (``#time,accel_x,accel_y,accel_z``). Spectra of samples are made as in Klipper's
documentation: Welch's method, windows of half a second or more, a Kaiser window of shape 6, half overlapped.

Of a shaper, the remaining vibration is the part of the density, above 5 % of its largest, that passes it:
:math:`\sum\max(V\,S - S_{max}/20, 0) / \sum\max(S - S_{max}/20, 0)`, the worst of the damping
ratios 0.075, 0.1 and 0.15, as the printer's is not known to the firmware. See "Measuring resonances" of
Klipper's documentation, https://www.klipper3d.org/Measuring_Resonances.html; the weights of the score are
Klipper's, without a meaning of their own.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import signal

from cabledrive.identification.logs.log import Table
from cabledrive.identification.logs.reading import open_table
from cabledrive.identification.logs.time_check import check_time
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.trajectories.input_shaping import (
    LARGEST_DAMPING,
    TOLERANCE,
    InputShaper,
    highest_acceleration,
    input_shaper,
    insensitive_band,
    residual_vibration,
    smoothing,
)

WINDOW = 0.5
"""Shortest window of a spectrum [s]."""
KAISER = 6.0
"""Shape of the Kaiser window."""
LOWEST, HIGHEST = 5.0, 200.0
"""Frequencies of a resonance test [Hz]; what lies above is not used."""
LOWEST_RATE = 50.0  # Hz
MOST_SAMPLES, MOST_LINES = 10_000_000, 5_000
FEWEST_LINES = 8
_DIRECTIONS = ("x", "y", "z")
_NAMED = re.compile(r"(?:^|[_-])([xyz])(?=[_.-]|$)", re.IGNORECASE)
_LISTED = 90


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PrinterSpectrum:
    """Power spectral density of a head's acceleration while one axis is excited."""

    source: str  # name of the file
    axis: str | None  # "x", "y" or "z" after the name of the file
    frequency: Array  # (n,): from 0 to 200 Hz at most [Hz]
    # (n,): sum over the directions, over the frequency, with which a test excites more; the largest is 1
    density: Array
    even: bool  # whether the frequencies are those of a Fourier transform
    duration: float | None = None  # of the samples [s]; None: the file holds a spectrum
    notes: tuple[str, ...] = ()

    @property
    def measured(self) -> Array:
        """The density before its division by the frequency, shape (n,); of use from 10 Hz on."""
        return self.density * (self.frequency + 0.1)

    @property
    def interval(self) -> float:
        """Distance of neighbouring frequencies [Hz]."""
        return float(np.median(np.diff(self.frequency)))


def read_printer_spectrum(path: str | Path) -> PrinterSpectrum:
    """Read a spectrum, or make it from samples of an accelerometer, in any format of logs."""
    table = open_table(path)
    heads = {name.lower().strip(): name for name in table.names}
    if "freq" in heads and any(f"psd_{name}" in heads for name in (*_DIRECTIONS, "xyz")):
        frequency, density, even, notes = _of_densities(table, heads)
        duration = None
    elif "time" in heads and any(f"accel_{name}" in heads for name in _DIRECTIONS):
        rate, parts, remarks = _even(table, heads)
        length, window = window_length(rate), ("kaiser", KAISER)
        frequency, powers = signal.welch(
            np.array(parts), rate, window, nperseg=length, noverlap=length // 2, detrend="constant"
        )
        density = normalized(frequency, powers.sum(axis=0))
        even, duration, notes = True, parts[0].size / rate, tuple(remarks)
    else:
        raise InputRefused(
            f"{table.source}: no columns freq and psd_xyz, nor time and accel_x, accel_y, accel_z (found: "
            f"{', '.join(table.names)[:_LISTED]}): give a file of Klipper's TEST_RESONANCES"
        )
    used = frequency <= HIGHEST
    frequency, density = frequency[used], density[used]
    if not FEWEST_LINES <= frequency.size <= MOST_LINES:
        raise InputRefused(
            f"{table.source}: {frequency.size} frequencies up to {HIGHEST:g} Hz, not from {FEWEST_LINES} to "
            f"{MOST_LINES}: give a spectrum as Klipper writes it"
        )
    largest = float(density.max())
    if not 1e-290 < largest < 1e290:
        raise InputRefused(f"{table.source}: the largest density is {largest:.3g}: no vibration was measured")
    named = {name.lower() for name in _NAMED.findall(table.source.rpartition(".")[0] or table.source)}
    return PrinterSpectrum(
        source=table.source,
        axis=named.pop() if len(named) == 1 else None,
        frequency=frequency,
        density=density / largest,
        even=even,
        duration=duration,
        notes=notes,
    )


def normalized(frequency: Array, density: Array) -> Array:
    """A measured density over the frequency, and little of it below 10 Hz, as Klipper normalises it."""
    low = np.minimum(0.0, 1.0 - (2.0 * LOWEST / (frequency + 0.1)) ** 2)
    return density / (frequency + 0.1) * np.exp(low)


def _columns(table: Table, names: list[str]) -> list[Array]:
    """Whole columns; refused where they are no test."""
    columns = table.whole(tuple(names), MOST_SAMPLES)
    if (rows := columns[0].size) < FEWEST_LINES:
        raise InputRefused(f"{table.source}: only {rows} rows of numbers: a test has {FEWEST_LINES} or more")
    return columns


def _of_densities(table: Table, heads: dict[str, str]) -> tuple[Array, Array, bool, tuple[str, ...]]:
    """Frequency, normalised density, whether the grid is even, notes."""
    if "psd_xyz" in heads:
        names = ["psd_xyz"]
    else:
        names = [f"psd_{name}" for name in _DIRECTIONS if f"psd_{name}" in heads]
    frequency, *parts = _columns(table, [heads["freq"], *(heads[name] for name in names)])
    for name, values in (("freq", frequency), *zip(names, parts, strict=True)):
        wrong = ~np.isfinite(values) | (values < 0.0)
        if wrong.any():
            row = int(np.argmax(wrong))
            raise InputRefused(f"{table.source}: row {row + 1}: {name} = {values[row]:.4g} must be from 0")
    frequency, even = _put_back(frequency, table.source)
    with np.errstate(over="ignore"):  # an infinite sum is refused as a density
        density = np.sum(parts, axis=0)
    notes = () if names == ["psd_xyz"] else (f"no psd_xyz: the sum of {', '.join(names)} is used",)
    if any("shapers" in head for head in heads):  # written after the normalisation
        return frequency, density, even, notes
    return frequency, normalized(frequency, density), even, notes


def _put_back(frequency: Array, source: str) -> tuple[Array, bool]:
    """The even grid of a Fourier transform, of which one decimal was written; others as they are."""
    steps, even = np.diff(frequency), np.linspace(frequency[0], frequency[-1], frequency.size)
    if np.abs(frequency - even).max() < min(0.101, 0.3 * (even[1] - even[0])):
        return even, True
    if (steps <= 0.0).any():
        row = int(np.argmax(steps <= 0.0))
        raise InputRefused(
            f"{source}: row {row + 2}: freq = {frequency[row + 1]:.4g} Hz does not follow "
            f"{frequency[row]:.4g} Hz: sort the rows, or give the file of one test"
        )
    return frequency, False


def window_length(rate: float) -> int:
    """Samples of a window of a spectrum, a power of 2; ``rate`` [Hz]."""
    return 1 << int(rate * WINDOW - 1.0).bit_length()


def even_samples(path: str | Path) -> tuple[float, list[Array]] | None:
    """Samples per second and the acceleration of each direction (samples,); None of a file of a spectrum."""
    table = open_table(path)
    heads = {name.lower().strip(): name for name in table.names}
    return _even(table, heads)[:2] if "time" in heads else None


def _even(table: Table, heads: dict[str, str]) -> tuple[float, list[Array], list[str]]:
    """Samples per second, the acceleration of each direction on an even grid, notes."""
    names = [f"accel_{name}" for name in _DIRECTIONS if f"accel_{name}" in heads]
    time, *parts = _columns(table, [heads["time"], *(heads[name] for name in names)])
    check = check_time(time, table.source)
    if check.uneven:  # the clock of the sensor drifts against that of the host
        check = check_time(time, table.source, resample=True)
    rate = 1.0 / check.interval
    if rate < LOWEST_RATE:
        raise InputRefused(f"{table.source}: sampled at {rate:.4g} Hz, below {LOWEST_RATE:g}: check the time")
    grid = check.grid
    length = window_length(rate)
    if grid.size <= length:
        said = f"{table.source}: {grid.size / rate:.3g} s are shorter than a window of {length / rate:.3g} s"
        raise InputRefused(f"{said}: record the whole test")
    if grid.size > 2 * MOST_SAMPLES:
        raise InputRefused(f"{table.source}: has gaps longer than its samples: record it again")
    for name, values in zip(names, parts, strict=True):
        if not np.isfinite(values).all() or np.abs(values).max() > 1e100:
            raise InputRefused(f"{table.source}: {name} has values missing or beyond 1e100: record it again")
    notes = [*check.repaired]
    if rate < 2.0 * HIGHEST:
        notes.append(f"{rate:.4g} samples per second show nothing above {rate / 2:.4g} Hz")
    if len(names) < len(_DIRECTIONS):
        notes.append(f"the sum of {', '.join(names)} is used")
    return rate, [np.interp(grid, check.stamps, values[check.keep]) for values in parts], notes


HIGHEST_FREQUENCY = 150.0
"""Highest frequency of a shaper, as in the firmware [Hz]."""
LOWEST_FREQUENCY = {"zv": 21.0, "mzv": 23.0, "ei": 29.0, "2hump_ei": 39.0, "3hump_ei": 48.0}
"""Types that are compared, and the frequency [Hz] below which each would allow about 1.5 m/s^2 only."""
STEP = 0.2
"""Between the frequencies that are tried [Hz]."""
DAMPING_RATIOS = np.array([0.075, 0.1, 0.15])
"""Of the mode, for the worst of which the remaining vibration is stated."""

CELLS = 50_000
"""Designs times lines of a spectrum that are computed at a time."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShaperFit:
    """A shaper at the frequency that suits a vibration best."""

    shaper: InputShaper
    vibration: float  # remaining vibration, from 0 to about 1
    smoothing: float  # at 5 m/s^2 [m]
    max_acceleration: float  # up to which the smoothing stays within 0.12 mm [m/s^2]
    score: float  # by which types are compared, the smaller the better; in the unit of the smoothing [m]

    @property
    def type(self) -> str:
        """Name of the type, as the printer's configuration calls it."""
        return self.shaper.type

    @property
    def frequency(self) -> float:
        """Frequency of the design [Hz]."""
        return self.shaper.frequency

    @property
    def band(self) -> tuple[float, float] | None:
        """Frequencies between which it leaves 5 % of the amplitude at most [Hz]."""
        return insensitive_band(self.shaper)


def remaining_vibration(
    unit: InputShaper,
    frequencies: Array,
    spectra: Sequence[PrinterSpectrum],
    ratios: Array = DAMPING_RATIOS,
) -> Array:
    """Worst share (n,) of vibration above 5 % of its largest behind a ``unit`` (1 Hz) at n frequencies."""
    worst = np.zeros(frequencies.size)
    for spectrum in spectra:
        floor = TOLERANCE * spectrum.density.max()
        counts = spectrum.density > floor  # no shaper raises an amplitude: the others remain below
        lines, density = spectrum.frequency[counts], spectrum.density[counts]
        whole = (density - floor).sum()
        parts = -(-frequencies.size * density.size // CELLS)
        start = 0
        for designs in np.array_split(frequencies, parts):
            # Residual vibration depends on the frequency of the mode over that of the design only.
            passed = residual_vibration(unit, lines / designs[:, None], ratios[:, None, None])
            kept = np.maximum(passed * density - floor, 0.0).sum(axis=2).max(axis=0) / whole
            place = slice(start, start + designs.size)
            worst[place] = np.maximum(worst[place], kept)
            start += designs.size
    return worst


def fit_shapers(
    spectra: Sequence[PrinterSpectrum],
    *,
    damping: float,
    corner_speed: float,
    max_smoothing: float | None = None,
) -> tuple[tuple[ShaperFit, ...], ShaperFit]:
    """Fit every type, and choose one, which may have another frequency; ``max_smoothing`` [m]."""

    def better(fit: ShaperFit, than: ShaperFit) -> bool:
        """By 5 % in the score with a smoothing better by 10 %."""
        return 1.05 * fit.score < than.score and 1.1 * fit.smoothing < than.smoothing

    fits: list[ShaperFit] = []
    best: ShaperFit | None = None
    for type in LOWEST_FREQUENCY:
        if damping > LARGEST_DAMPING[type]:
            continue
        tried = _tried(type, spectra, damping, corner_speed, max_smoothing)
        if not tried:
            continue
        # At equal vibration the higher frequency counts as least, which is the smoother one.
        least = min(reversed(tried), key=lambda fit: fit.vibration)
        near = [fit for fit in tried if fit.vibration < 1.1 * least.vibration + 5e-4]
        fit = min([least, *near], key=lambda fit: fit.score)
        if best is None or 1.2 * fit.score < best.score or better(fit, best):
            best = fit
        for other in tried:  # from the lowest frequency up
            if other.vibration < best.vibration and other.smoothing < best.smoothing:
                best = fit = other
        fits.append(fit)
    if best is None:
        raise InputRefused(
            f"no shaper is smooth within {1e3 * (max_smoothing or 0.0):.3g} mm at 5 m/s^2: allow more"
        )
    if best.type == "zv":
        best = next((fit for fit in fits[1:] if 1.1 * fit.vibration < best.vibration), best)
    return tuple(fits), best


def _tried(
    type: str, spectra: Sequence[PrinterSpectrum], damping: float, corner_speed: float, most: float | None
) -> list[ShaperFit]:
    """A type at every frequency, upwards."""
    frequencies = np.round(np.arange(LOWEST_FREQUENCY[type], HIGHEST_FREQUENCY, STEP), 6)
    shapers = [input_shaper(type, float(frequency), damping) for frequency in frequencies]
    rounding = np.array([smoothing(shaper, corner_speed=corner_speed) for shaper in shapers])
    allowed = np.flatnonzero(rounding <= (np.inf if most is None else most))
    if allowed.size == 0:
        return []
    left = remaining_vibration(input_shaper(type, 1.0, damping), frequencies[allowed], spectra)
    return [
        ShaperFit(
            shaper=shapers[k],
            vibration=float(passed),
            smoothing=float(rounding[k]),
            max_acceleration=highest_acceleration(shapers[k], corner_speed),
            score=float(rounding[k] * (passed**1.5 + 0.2 * passed + 0.01)),
        )
        for k, passed in zip(allowed, left, strict=True)
    ]
