"""From the logs of a resonance test to the input shaper of an axis, with what it leaves and what it costs."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path

import numpy as np

from cabledrive.identification.estimates import Finding
from cabledrive.identification.printer_spectrum import PrinterSpectrum, read_printer_spectrum
from cabledrive.identification.shaper_choice import (
    HIGHEST_FREQUENCY,
    ShaperFit,
    fit_shapers,
    remaining_vibration,
)
from cabledrive.identification.spectrum_peaks import SpectrumPeak, spectrum_peaks
from cabledrive.parameters import InputRefused
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PrinterShaper:
    """Input shapers for one axis of a printer."""

    axis: str | None  # "x", "y" or "z"; None: neither given nor in the names of the logs
    spectra: tuple[PrinterSpectrum, ...]  # one of each log
    peaks: tuple[SpectrumPeak, ...]  # of every log
    shapers: tuple[ShaperFit, ...]  # the best of each type
    recommended: ShaperFit  # with the least score; it is no recommendation where `refused` says why
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
    paths = [logs] if isinstance(logs, str | Path) else list(logs)
    _check(paths, axis, damping, corner_speed, max_smoothing)
    spectra = tuple(read_printer_spectrum(path) for path in paths)
    findings: list[Finding] = []
    axis = _axis(spectra, axis, findings)
    peaks = tuple(peak for spectrum in spectra for peak in spectrum_peaks(spectrum))
    fits, best = fit_shapers(spectra, damping=damping, corner_speed=corner_speed, max_smoothing=max_smoothing)
    ratios = np.array([peak.damping for peak in peaks if peak.damping is not None])
    left = None
    if ratios.size:
        unit = input_shaper(best.type, 1.0, damping)
        left = float(remaining_vibration(unit, np.array([best.frequency]), spectra, ratios)[0])
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
        notes=tuple(f"{spectrum.source}: {note}" for spectrum in spectra for note in spectrum.notes),
    )
    return _judged(found, findings)


def _check(
    paths: list[str | Path], axis: str | None, damping: float, corner_speed: float, smooth: float | None
) -> None:
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


def _axis(spectra: Sequence[PrinterSpectrum], given: str | None, findings: list[Finding]) -> str | None:
    """The axis of all logs, given or after their names."""
    named = {spectrum.axis for spectrum in spectra if spectrum.axis is not None}
    if given is not None:
        for spectrum in spectra:
            if spectrum.axis not in (None, given):
                message = (
                    f"{spectrum.source} is named after axis {spectrum.axis}, and is taken for axis {given}"
                )
                findings.append(Finding("axis-contradicts", message))
        return given
    if len(named) > 1:
        raise InputRefused(
            f"logs of the axes {', '.join(sorted(named))}: give those of one axis, or name it by --axis"
        )
    if not named:
        message = "the name of the log does not say which axis was excited: give --axis x or --axis y"
        findings.append(Finding("axis-unknown", message))
    return named.pop() if named else None


def _judged(found: PrinterShaper, findings: list[Finding]) -> PrinterShaper:
    """The result with what a user must act on."""
    best = found.recommended
    for spectrum in found.spectra:
        if spectrum.duration is not None and spectrum.duration < SHORTEST_TEST:
            message = (
                f"{spectrum.source}: {spectrum.duration:.3g} s of samples are no whole test, which takes "
                f"{SHORTEST_TEST:g} s or more: record it to its end"
            )
            findings.append(Finding("test-broken-off", message))
        largest = float(spectrum.frequency[np.argmax(spectrum.measured)])
        if largest < LOWEST_PEAK:
            message = (
                f"{spectrum.source}: the largest vibration is at {largest:.3g} Hz, where a test only begins: "
                "record it to its end, or look for a frame that rocks"
            )
            findings.append(Finding("test-broken-off", message))
    for peak in found.peaks:
        if peak.frequency > HIGHEST_FREQUENCY:
            message = (
                f"{peak.source}: the peak at {peak.frequency:.1f} Hz is above {HIGHEST_FREQUENCY:g} Hz, the "
                "highest frequency of a shaper in the firmware"
            )
            findings.append(Finding("peak-above-shapers", message))
    if not found.peaks:
        message = "no peak stands out of the spectrum: check that the axis was excited"
        findings.append(Finding("no-peak", message))
    for peak in found.peaks:
        kept = found.kept(peak)
        if kept * peak.height > TOO_MUCH:
            message = (
                f"{peak.source}: the peak at {peak.frequency:.1f} Hz ({100 * peak.height:.0f} % of the "
                f"largest) keeps {100 * kept:.0f} % of it behind {best.type} {best.frequency:.1f} Hz"
            )
            findings.append(Finding("peak-remains", message))
    worst = max(best.vibration, found.measured_vibration or 0.0)
    if worst > TOO_MUCH:
        message = (
            f"the recommended shaper leaves {100 * worst:.0f} % of the vibration: look for loose belts, worn "
            "bearings or a soft frame first"
        )
        findings.append(Finding("much-remains", message))
    notes = list(found.notes)
    if len(found.spectra) == 1:
        notes.append("one log, one place on the bed: peaks move with the head; give logs of several places")
    missing = [t for t in ("ei", "2hump_ei", "3hump_ei") if t not in {fit.type for fit in found.shapers}]
    if missing:
        notes.append(f"left out: {', '.join(missing)} (damping ratio or smoothing out of range)")
    return replace(found, findings=tuple(findings), notes=tuple(notes))
