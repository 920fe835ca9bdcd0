"""From the logs of a printer's resonance tests to the input shaper of each axis; its belts compared.

Files are sorted by their names: those of Klipper (``resonances_x_*``, ``calibration_data_x_*``,
``raw_data_x_*``, ``raw_data_axis=1.000,-1.000_*``) and of Shake&Tune (``belt_*_A``, ``belts_*_B``,
``inputshaper_*_X``). Belt A is the one that moves along (1, -1), belt B along (1, 1).
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path

import numpy as np
from scipy import signal

from cabledrive.answers.figures import Row
from cabledrive.answers.result import Result
from cabledrive.identification import printer_spectrum as shaping
from cabledrive.identification.estimates import Finding
from cabledrive.identification.spectrum_peaks import SpectrumPeak, spectrum_peaks
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.trajectories.input_shaping import (
    CORNER_SPEED,
    LARGEST_DAMPING,
    input_shaper,
    residual_vibration,
)

DAMPING = 0.1
"""Damping ratio of the design, where none is given: that of the firmware."""
MOST_LOGS = 100
AXES = ("x", "y", "z")
REFUSING = ("no-peak", "test-broken-off")
"""Findings with which nothing is recommended."""
SHORTEST_TEST = 10.0
"""Duration below which samples are no whole test [s]: 5 to 133 Hz at 2 Hz/s take 64."""
LOWEST_PEAK = 15.0
"""Frequency of the largest vibration below which a test was broken off, or the frame rocks [Hz]."""
TOO_MUCH = 0.1
"""Remaining vibration, of all or of one peak, above which a shaper is not called sufficient."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class PrinterShaper(Result):
    """Input shapers for one axis of a printer."""

    _table = "shapers"
    _shown = (
        Row("recommended.type", "recommended"),
        Row("recommended.frequency", "at", "Hz", ".1f"),
        Row("refused", "none recommended"),
    )

    axis: str | None  # "x", "y" or "z"; None: neither given nor in the names of the logs
    spectra: tuple[shaping.PrinterSpectrum, ...]  # one of each log
    peaks: tuple[SpectrumPeak, ...]  # of every log
    shapers: tuple[shaping.ShaperFit, ...]  # the best of each type
    # with the least score; it is no recommendation where `refused` says why
    recommended: shaping.ShaperFit
    # remaining vibration of the recommended one at the damping ratios that were measured
    measured_vibration: float | None
    # damping, corner_speed: of the design [-], [m/s]
    damping: float
    corner_speed: float
    findings: tuple[Finding, ...]  # what a user must act on
    notes: tuple[str, ...]

    @property
    def spread(self) -> tuple[float, float] | None:
        """Lowest and highest frequency of the peaks [Hz]."""
        places = [peak.frequency for peak in self.peaks]
        return (min(places), max(places)) if places else None

    @property
    def refused(self) -> str | None:
        """Why the logs are no ground for a shaper; None where they are."""
        return next((str(finding) for finding in self.findings if finding.code in REFUSING), None)

    @property
    def configuration(self) -> str:
        """Lines for the printer's configuration, "AXIS" for an axis not known; empty where `refused`."""
        if self.refused is not None:
            return ""
        axis = self.axis or "AXIS"
        lines = [
            "[input_shaper]",
            f"shaper_type_{axis}: {self.recommended.type}",
            f"shaper_freq_{axis}: {self.recommended.frequency:.1f}",
        ]
        if self.damping != DAMPING:
            lines.append(f"damping_ratio_{axis}: {self.damping:g}")
        return "\n".join(lines)

    def kept(self, peak: SpectrumPeak) -> float:
        """Amplitude that the mode of a peak keeps behind the recommended shaper, over that without one."""
        ratio = self.damping if peak.damping is None else peak.damping
        return float(residual_vibration(self.recommended.shaper, np.array([peak.frequency]), ratio)[0])


def shaper(
    logs: str | Path | Sequence[str | Path],
    *,
    axis: str | None = None,
    damping: float = DAMPING,
    corner_speed: float = CORNER_SPEED,
    max_smoothing: float | None = None,
) -> PrinterShaper:
    """Choose the input shaper of a printer's axis from logs of Klipper's resonance test.

    Types, remaining vibration, smoothing and choice follow Klipper's documentation; see `input_shaper` and
    `smoothing` of `cabledrive.trajectories`. With several logs of one axis, at several places of the bed, the
    worst of them counts.

    Parameters
    ----------
    logs : path or sequence of paths
        ``resonances_x_*.csv``, ``calibration_data_x_*.csv``, or accelerometer samples.
    axis : {"x", "y", "z"}, optional
        Default: that in the names of the logs.
    damping : float, default 0.1
        Damping ratio that the shapers are made for.
    corner_speed : float, default 0.005
        Square-corner speed of the printer [m/s].
    max_smoothing : float, optional
        Shapers of larger smoothing at 5 m/s^2 are left out [m].

    Returns
    -------
    PrinterShaper

    Raises
    ------
    InputRefused
        If a log cannot be read, the logs are of several axes, or no shaper is as smooth as asked.
    """
    paths, smooth = [logs] if isinstance(logs, str | Path) else list(logs), max_smoothing
    if not 1 <= len(paths) <= MOST_LOGS:
        raise InputRefused(f"{len(paths)} logs, not from 1 to {MOST_LOGS}: give those of one axis")
    if axis is not None and axis not in AXES:
        raise InputRefused(f'axis = "{axis}" must be x, y or z')
    if not 0.0 <= damping <= max(LARGEST_DAMPING.values()):
        raise InputRefused(f"damping = {damping:.4g} must lie from 0 to 0.99: 0.1 is a damping ratio of 10 %")
    if not 0.0 <= corner_speed <= 1.0:
        raise InputRefused(f"corner-speed = {corner_speed:.4g} m/s must lie from 0 to 1 m/s: 5 mm/s is usual")
    if smooth is not None and not (smooth > 0.0 and isfinite(smooth)):
        raise InputRefused(f"max-smoothing = {smooth:.4g} m must be above 0: 0.2 mm is usual")
    spectra = tuple(shaping.read_printer_spectrum(path) for path in paths)
    axis, findings = _axis(spectra, axis)
    peaks = tuple(peak for spectrum in spectra for peak in spectrum_peaks(spectrum))
    fits, best = shaping.fit_shapers(
        spectra, damping=damping, corner_speed=corner_speed, max_smoothing=smooth
    )
    ratios = np.array([peak.damping for peak in peaks if peak.damping is not None])
    left = None
    if ratios.size:
        unit = input_shaper(best.type, 1.0, damping)
        left = float(shaping.remaining_vibration(unit, np.array([best.frequency]), spectra, ratios)[0])
    notes = [f"{spectrum.source}: {note}" for spectrum in spectra for note in spectrum.notes]
    if len(spectra) == 1:
        notes.append("one log, one place on the bed: peaks move with the head; give logs of several places")
    missing = [t for t in ("ei", "2hump_ei", "3hump_ei") if t not in {fit.type for fit in fits}]
    if missing:
        notes.append(f"left out: {', '.join(missing)} (damping ratio or smoothing out of range)")
    found = PrinterShaper(
        axis=axis,
        spectra=spectra,
        peaks=peaks,
        shapers=fits,
        recommended=best,
        measured_vibration=left,
        damping=damping,
        corner_speed=corner_speed,
        findings=(),
        notes=tuple(notes),
    )
    return replace(found, findings=(*findings, *_doubts_of(found)))


def _axis(spectra: Sequence[shaping.PrinterSpectrum], given: str | None) -> tuple[str | None, list[Finding]]:
    """The axis of all logs, given or after their names, and what contradicts it."""
    named = {spectrum.axis for spectrum in spectra if spectrum.axis is not None}
    if given is not None:
        words = "{0.source} is named after axis {0.axis}, and is taken for axis {1}"
        others = [spectrum for spectrum in spectra if spectrum.axis not in (None, given)]
        return given, [Finding("axis-contradicts", words.format(other, given)) for other in others]
    if len(named) > 1:
        raise InputRefused(f"logs of the axes {', '.join(sorted(named))}: give those of one, or --axis")
    if named:
        return named.pop(), []
    words = "the name of the log does not say which axis was excited: give --axis x or --axis y"
    return None, [Finding("axis-unknown", words)]


def _doubts_of(found: PrinterShaper) -> Iterator[Finding]:
    """What a user must act on."""
    best = found.recommended
    for spectrum in found.spectra:
        if spectrum.duration is not None and spectrum.duration < SHORTEST_TEST:
            words = f"{spectrum.source}: {spectrum.duration:.3g} s of samples are no whole test, which takes "
            yield Finding("test-broken-off", f"{words}{SHORTEST_TEST:g} s or more: record it to its end")
        largest = float(spectrum.frequency[np.argmax(spectrum.measured)])
        if largest < LOWEST_PEAK:
            words = f"{spectrum.source}: the largest vibration is at {largest:.3g} Hz, where a test only "
            words += "begins: record it to its end, or look for a frame that rocks"
            yield Finding("test-broken-off", words)
    for peak in found.peaks:
        if peak.frequency > shaping.HIGHEST_FREQUENCY:
            words = (
                f"{peak.source}: the peak at {peak.frequency:.1f} Hz is above {shaping.HIGHEST_FREQUENCY:g} "
            )
            yield Finding(
                "peak-above-shapers", f"{words}Hz, the highest frequency of a shaper in the firmware"
            )
    if not found.peaks:
        yield Finding("no-peak", "no peak stands out of the spectrum: check that the axis was excited")
    for peak in found.peaks:
        kept = found.kept(peak)
        if kept * peak.height > TOO_MUCH:
            words = f"{peak.source}: the peak at {peak.frequency:.1f} Hz ({100 * peak.height:.0f} % of the "
            words += f"largest) keeps {100 * kept:.0f} % of it behind {best.type} {best.frequency:.1f} Hz"
            yield Finding("peak-remains", words)
    worst = max(best.vibration, found.measured_vibration or 0.0)
    if worst > TOO_MUCH:
        words = f"the recommended shaper leaves {100 * worst:.0f} % of the vibration: look for loose belts, "
        yield Finding("much-remains", f"{words}worn bearings or a soft frame first")


_BELT = re.compile(r"(?:^|[_-])belts?[_-](?:.*[_-])?([ab])$|(?:^|[_-])belt([ab])(?=[_-]|$)", re.IGNORECASE)
_DIAGONAL = re.compile(r"axis=1(?:\.0*)?,(-?)1(?:\.0*)?", re.IGNORECASE)
_TEST = re.compile(r"(resonances|calibration_data|raw_data|inputshaper)_", re.IGNORECASE)
ALIKE = 0.9
"""Similarity of two belts' spectra below which they are called different."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Belts:
    """The spectra of both belts of a CoreXY, each excited along its own diagonal."""

    a: shaping.PrinterSpectrum
    b: shaping.PrinterSpectrum
    peaks_a: tuple[SpectrumPeak, ...]
    peaks_b: tuple[SpectrumPeak, ...]

    @property
    def similarity(self) -> float:
        """Cosine of the angle between the two densities over frequency; 1 where they have one shape."""
        a = self.a.density
        b = np.interp(self.a.frequency, self.b.frequency, self.b.density)
        return float(a @ b / np.sqrt((a @ a) * (b @ b)))

    @property
    def difference(self) -> float | None:
        """Highest peak of belt a less that of belt b [Hz]; None: one of them has none."""
        highest = [max(own, key=lambda p: p.height, default=None) for own in (self.peaks_a, self.peaks_b)]
        return None if None in highest else highest[0].frequency - highest[1].frequency  # type: ignore[union-attr]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Printer:
    """All that the files of a printer show."""

    axes: tuple[PrinterShaper, ...]
    belts: Belts | None
    paths: dict[str, Path]  # of each spectrum, by the name of its file


def belt_of(name: str) -> str | None:
    """Belt "a" or "b" that a file is named after."""
    diagonal = _DIAGONAL.search(name)
    if diagonal:
        return "a" if diagonal[1] else "b"
    found = _BELT.search(Path(name).stem)
    return (found[1] or found[2]).lower() if found else None


def is_printer_file(name: str) -> bool:
    """Whether a file is named as Klipper or Shake&Tune name the tests of a printer."""
    return name.lower().endswith(".csv") and (belt_of(name) is not None or bool(_TEST.match(name)))


def printer(logs: Sequence[str | Path], **design: float | None) -> Printer:
    """Input shapers of every axis and the comparison of the belts, two or none; ``design``: of `shaper`."""
    paths = {Path(log).name: Path(log) for log in logs}
    belts: dict[str, Path] = {}
    axes: dict[str, list[Path]] = {}
    for path in paths.values():
        belt = belt_of(path.name)
        if belt is None:
            axes.setdefault(shaping.read_printer_spectrum(path).axis or "", []).append(path)
        elif belt in belts:
            raise InputRefused(f"{path.name}: belt {belt} has {belts[belt].name} already: give one of them")
        else:
            belts[belt] = path
    if len(belts) == 1:
        (belt,) = belts
        raise InputRefused(f"{belts[belt].name}: belt {belt} alone: give the file of the other belt as well")
    found = tuple(shaper(own, axis=name or None, **design) for name, own in sorted(axes.items()))  # type: ignore[arg-type]
    both = None
    if belts:
        a, b = (shaping.read_printer_spectrum(belts[name]) for name in "ab")
        both = Belts(a=a, b=b, peaks_a=tuple(spectrum_peaks(a)), peaks_b=tuple(spectrum_peaks(b)))
    return Printer(axes=found, belts=both, paths=paths)


def spectrogram(path: Path) -> tuple[Array, Array, Array] | None:
    """Time (m,) [s], frequency (n,) [Hz], level (n, m) [dB of the largest]; None of a spectrum."""
    found = shaping.even_samples(path)
    if found is None:
        return None
    rate, values = found
    length, window = shaping.window_length(rate), ("kaiser", shaping.KAISER)
    frequency, time, power = signal.spectrogram(
        np.array(values), rate, window, nperseg=length, noverlap=length // 2, detrend="constant"
    )
    total = power.sum(axis=0)
    used = frequency <= shaping.HIGHEST
    level = 10.0 * np.log10(np.maximum(total[used] / total[used].max(), 1e-6))
    return np.asarray(time), np.asarray(frequency[used]), np.asarray(level)
