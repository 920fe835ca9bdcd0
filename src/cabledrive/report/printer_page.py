"""One page for a printer: shaper, spectrum and sweep of each axis, belt against belt, computed peaks."""

from dataclasses import replace
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from cabledrive.answers.figures import fixed, number
from cabledrive.identification.printer import Belts, Printer, PrinterShaper, spectrogram
from cabledrive.identification.printer_spectrum import PrinterSpectrum
from cabledrive.identification.spectrum_peaks import SpectrumPeak
from cabledrive.parameters import Machine, content_hash
from cabledrive.report import blocks
from cabledrive.report.blocks import Block, Chapter, Note, Panel, Paragraph, Plot, in_turn, table
from cabledrive.report.page import page_of
from cabledrive.report.picture import TEXT, Hue, file_figure, file_picture, label, picture
from cabledrive.report.printer_tables import fits_of, peaks_table, shapers_table, similar_words
from cabledrive.trajectories.input_shaping import TOLERANCE, residual_vibration

if TYPE_CHECKING:
    from matplotlib.figure import Figure

METHOD = (
    "types, remaining vibration and score as Klipper defines them; partial fractions of modes for damping"
)


def printer_html(found: Printer, machine: Machine | None = None) -> str:
    """The page of a printer; ``machine``: whose computed frequencies stand beside the measured peaks."""
    chapters = [_axis_chapter(axis, found, machine) for axis in found.axes]
    if found.belts is not None:
        chapters.append(_belts_chapter(found.belts))
    hashes = () if machine is None else ((machine.name, content_hash(machine)),)
    title = "Printer" if machine is None else machine.title or machine.name
    return page_of(title, "Input shapers, belts and resonances", chapters, hashes)


def _axis_chapter(axis: PrinterShaper, found: Printer, machine: Machine | None) -> Chapter:
    name = axis.axis or "unknown"
    best, blocks = axis.recommended, list[Block]()
    if axis.refused is None:
        headline = f"{best.type} at {best.frequency:.1f} Hz"
        lines = Markup("Lines for the configuration of the printer:<br><pre>{}</pre>")
        blocks.append(Paragraph(text=lines.format(axis.configuration)))
    else:
        headline = f"No shaper is recommended: {axis.refused}"
    blocks += [Note(text=str(finding), tone="warning") for finding in axis.findings]
    blocks += [peaks_table(axis, machine), _spectra(axis, name), shapers_table(axis)]
    for number_, spectrum in enumerate(axis.spectra):
        sweep = _sweep(f"sweep-{name}-{number_}", spectrum, found)
        blocks += [] if sweep is None else [sweep]
    blocks += [Note(text=note) for note in axis.notes]
    return Chapter(f"Axis {name}", f"axis-{name}", tuple(blocks), headline=headline, methods=(METHOD,))


def _spectra(axis: PrinterShaper, name: str) -> Plot:
    """Densities of all logs, and the amplitude that each shaper keeps, over one axis of frequency."""
    points = max((s.frequency for s in axis.spectra), key=len)
    density = in_turn((s.source, _on(points, s)) for s in axis.spectra)
    fits = fits_of(axis)
    left = [residual_vibration(fit.shaper, np.maximum(points, 0.1), axis.damping) for fit in fits]
    curves = in_turn(
        (f"{fit.type} {fit.frequency:.1f} Hz", 100 * kept) for fit, kept in zip(fits, left, strict=True)
    )
    kept = tuple(
        replace(own, dashed=fit is not axis.recommended) for own, fit in zip(curves, fits, strict=True)
    )
    return Plot(
        name=f"spectrum-{name}",
        alt=f"Density of the head's acceleration over frequency on axis {name}, and what each shaper keeps.",
        caption=f"Spectrum of axis {name}, and the amplitude kept behind each shaper, the recommended solid.",
        points=points,
        along="frequency",
        unit="Hz",
        panels=(Panel("density over frequency", "1", density), Panel("amplitude kept", "%", kept)),
    )


def _on(points: np.ndarray, spectrum: PrinterSpectrum) -> np.ndarray:
    return np.interp(points, spectrum.frequency, spectrum.density, right=np.nan)


def _sweep(name: str, spectrum: PrinterSpectrum, found: Printer) -> Block | None:
    """Level over time and frequency; none of a file that holds a spectrum."""
    seen = spectrogram(found.paths[spectrum.source])
    if seen is None:
        return None
    time, frequency, level = seen

    def draw(figure: "Figure") -> None:
        axes = figure.add_subplot()
        mesh = axes.pcolormesh(
            time, frequency, level, cmap="viridis", vmin=-50.0, vmax=0.0, shading="nearest", rasterized=True
        )
        axes.set(xlabel="time [s]", ylabel="frequency [Hz]")
        figure.colorbar(mesh, ax=axes).set_label("level [dB]")

    return blocks.Figure(
        drawing=picture(name, draw, height=320),
        name=name,
        alt=f"Level of the head's acceleration over time and frequency in {spectrum.source}.",
        caption=(
            f"The sweep of {spectrum.source}: the rising line is the excitation, its harmonics stand above "
            "it; a level line is a vibration that does not follow it."
        ),
    )


def _belts_chapter(belts: Belts) -> Chapter:
    points = belts.a.frequency
    densities = {"belt A": belts.a.density, "belt B": _on(points, belts.b)}
    both = Plot(
        name="belts",
        alt="Densities of the acceleration with belt A and belt B excited, over frequency.",
        caption="Belt A (along 1, -1) against belt B (along 1, 1), each relative to its largest value.",
        points=points,
        along="frequency",
        unit="Hz",
        panels=(Panel("density over frequency", "1", in_turn(densities.items())),),
    )
    highest_first = (sorted(own, key=lambda peak: -peak.height) for own in (belts.peaks_a, belts.peaks_b))
    rows = (_belt_row(a, b) for a, b in zip_longest(*highest_first))
    heads = "peak | belt A [Hz] | belt B [Hz] | difference [Hz]"
    peaks = table("Peaks of the belts, the highest first", heads, rows)
    return Chapter("Belts", "belts-chapter", (both, peaks), headline=similar_words(belts))


def _belt_row(a: SpectrumPeak | None, b: SpectrumPeak | None) -> tuple[str, str, str, str]:
    """The peaks of one height of both belts; None where a belt has fewer."""
    height = (a or b).height  # type: ignore[union-attr]  # one of them is there
    off = "" if a is None or b is None else number(round(a.frequency - b.frequency, 1))
    one, other = ("" if peak is None else fixed(peak.frequency, 1) for peak in (a, b))
    return f"{100 * height:.0f} %", one, other, off


LOOKS = {
    "zv": (Hue.BLUE, "-"),
    "mzv": (Hue.ORANGE, "--"),
    "ei": (Hue.GREEN, "-."),
    "2hump_ei": (Hue.PURPLE, ":"),
    "3hump_ei": (Hue.OCHRE, (0, (6, 2, 1, 2, 1, 2))),
}
SIZE = (7.2, 5.6)  # inch
POINTS = 800


def shaper_picture(found: PrinterShaper, form: str) -> bytes:
    """Densities of all logs above, the residual amplitude behind every shaper below, as "svg", "png", "pdf".

    Peaks are marked with their frequency and damping ratio; the band in which the recommended shaper leaves
    5 % of the amplitude at most is shaded.
    """
    best = found.recommended

    def draw(figure: "Figure") -> None:
        above, below = figure.subplots(2, 1, sharex=True)
        axis = f"Axis {found.axis}: " if found.axis else ""
        figure.suptitle(f"{axis}{best.type} at {best.frequency:.1f} Hz", fontsize=TEXT + 1)
        for spectrum in found.spectra:
            above.plot(spectrum.frequency, spectrum.density, color=Hue.INK, linewidth=1.2)
        for peak in found.peaks:
            ratio = "" if peak.damping is None else f", {100 * peak.damping:.1f} %"
            above.plot(peak.frequency, peak.height, "o", color=Hue.ORANGE, markersize=4)
            words = f"{peak.frequency:.1f} Hz{ratio}"
            label(above, words, (peak.frequency, peak.height), (6, 2), color=Hue.QUIET, fontsize=9)
        frequency = np.linspace(1.0, float(max(s.frequency[-1] for s in found.spectra)), POINTS)
        for fit in fits_of(found):
            colour, dashes = LOOKS[fit.type]
            left = 100 * residual_vibration(fit.shaper, frequency, found.damping)
            wide = 2.2 if fit is best else 1.1
            words = f"{fit.type} {fit.frequency:.1f} Hz"
            below.plot(frequency, left, color=colour, linestyle=dashes, linewidth=wide, label=words)
        if best.band is not None:
            for axes in (above, below):
                axes.axvspan(*best.band, color=Hue.FAINT, zorder=0)
        below.axhline(100 * TOLERANCE, color=Hue.QUIET, linewidth=0.8, dashes=(4, 3))
        above.set(ylim=(0.0, 1.15), ylabel="density over frequency [1]")
        below.set(
            ylim=(0.0, 105.0), xlim=(0.0, frequency[-1]), ylabel="amplitude kept [%]", xlabel="frequency [Hz]"
        )
        below.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=5, frameon=False, fontsize=8)

    return file_picture(file_figure(draw, SIZE), form)
