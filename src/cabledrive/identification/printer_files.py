"""Files of a printer's resonance tests, sorted by their names: tests of axes, and of belts a and b.

Names are those of Klipper (``resonances_x_*``, ``calibration_data_x_*``, ``raw_data_x_*``,
``raw_data_axis=1.000,-1.000_*``) and of Shake&Tune (``belt_*_A``, ``belts_*_B``, ``inputshaper_*_X``). Belt A
is the one that moves along (1, -1), belt B along (1, 1).
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cabledrive.identification.printer_shaper import PrinterShaper, shaper
from cabledrive.identification.printer_spectrum import PrinterSpectrum, read_printer_spectrum
from cabledrive.identification.spectrum_peaks import SpectrumPeak, spectrum_peaks
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

_BELT = re.compile(r"(?:^|[_-])belts?[_-](?:.*[_-])?([ab])$|(?:^|[_-])belt([ab])(?=[_-]|$)", re.IGNORECASE)
_DIAGONAL = re.compile(r"axis=1(?:\.0*)?,(-?)1(?:\.0*)?", re.IGNORECASE)
_TEST = re.compile(r"(resonances|calibration_data|raw_data|inputshaper)_", re.IGNORECASE)
ALIKE = 0.9
"""Similarity of two belts' spectra below which they are called different."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Belts:
    """The spectra of both belts of a CoreXY, each excited along its own diagonal."""

    a: PrinterSpectrum
    b: PrinterSpectrum
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
    """Input shapers of every axis and the comparison of the belts, from the files of a printer.

    ``design``: of `shaper`: damping, corner_speed [m/s], max_smoothing [m].
    Raises `InputRefused` if one belt has two files, or only one belt has any.
    """
    paths = {Path(log).name: Path(log) for log in logs}
    belts: dict[str, Path] = {}
    axes: dict[str, list[Path]] = {}
    for path in paths.values():
        belt = belt_of(path.name)
        if belt is None:
            axes.setdefault(read_printer_spectrum(path).axis or "", []).append(path)
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
        a, b = (read_printer_spectrum(belts[name]) for name in "ab")
        both = Belts(a=a, b=b, peaks_a=tuple(spectrum_peaks(a)), peaks_b=tuple(spectrum_peaks(b)))
    return Printer(axes=found, belts=both, paths=paths)


def similar_words(belts: Belts) -> str:
    """The comparison of the belts in a sentence."""
    shape = f"The spectra of the belts are {100 * belts.similarity:.0f} % alike"
    if belts.difference is None:
        return f"{shape}; a belt without a peak was not excited, or hangs loose."
    tighter = "A" if belts.difference > 0.0 else "B"
    words = f"{shape}; the highest peak of belt {tighter} lies {abs(belts.difference):.1f} Hz above the other"
    different = belts.similarity < ALIKE
    return f"{words}: {f'loosen belt {tighter}, or tighten the other' if different else 'equally tight'}."


def spectrogram(path: Path) -> tuple[Array, Array, Array] | None:
    """Time (m,) [s], frequency (n,) [Hz], level (n, m) [dB of the largest]; None of a spectrum."""
    from scipy import signal

    from cabledrive.identification.printer_spectrum import HIGHEST, KAISER, even_samples

    found = even_samples(path)
    if found is None:
        return None
    rate, values = found
    length = 1 << int(rate * 0.5 - 1.0).bit_length()
    total: Array | None = None
    for column in values:
        frequency, time, power = signal.spectrogram(
            column, rate, ("kaiser", KAISER), nperseg=length, noverlap=length // 2, detrend="constant"
        )
        total = power if total is None else total + power
    assert total is not None
    used = frequency <= HIGHEST
    level = 10.0 * np.log10(np.maximum(total[used] / total[used].max(), 1e-6))
    return np.asarray(time), np.asarray(frequency[used]), np.asarray(level)
