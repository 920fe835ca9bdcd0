"""The spectrum of a printer's axis with its peaks, and what every shaper lets through, in one picture."""

from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.identification.printer import PrinterShaper
from cabledrive.report.mode_figure import file_style
from cabledrive.report.picture import BLUE, FAINT, GREEN, INK, OCHRE, ORANGE, PURPLE, QUIET, TEXT, label
from cabledrive.trajectories.input_shaping import TOLERANCE, residual_vibration

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOOKS = {
    "zv": (BLUE, "-"),
    "mzv": (ORANGE, "--"),
    "ei": (GREEN, "-."),
    "2hump_ei": (PURPLE, ":"),
    "3hump_ei": (OCHRE, (0, (6, 2, 1, 2, 1, 2))),
}
SIZE = (7.2, 5.6)  # inch
POINTS = 800


def shaper_figure(found: PrinterShaper) -> "Figure":
    """Draw the densities of all logs above, the residual amplitude behind every shaper below.

    Peaks are marked with their frequency and damping ratio; the band in which the recommended shaper leaves
    5 % of the amplitude at most is shaded.
    """
    from matplotlib.figure import Figure

    best = found.recommended
    with file_style():
        figure = Figure(figsize=SIZE, layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True)
        axis = f"Axis {found.axis}: " if found.axis else ""
        figure.suptitle(f"{axis}{best.type} at {best.frequency:.1f} Hz", fontsize=TEXT + 1)
        for spectrum in found.spectra:
            above.plot(spectrum.frequency, spectrum.density, color=INK, linewidth=1.2)
        for peak in found.peaks:
            ratio = "" if peak.damping is None else f", {100 * peak.damping:.1f} %"
            above.plot(peak.frequency, peak.height, "o", color=ORANGE, markersize=4)
            words = f"{peak.frequency:.1f} Hz{ratio}"
            label(above, words, (peak.frequency, peak.height), (6, 2), color=QUIET, fontsize=9)
        frequency = np.linspace(1.0, float(max(s.frequency[-1] for s in found.spectra)), POINTS)
        for fit in (*found.shapers, *(() if best in found.shapers else (best,))):
            colour, dashes = LOOKS[fit.type]
            left = 100 * residual_vibration(fit.shaper, frequency, found.damping)
            wide = 2.2 if fit is best else 1.1
            words = f"{fit.type} {fit.frequency:.1f} Hz"
            below.plot(frequency, left, color=colour, linestyle=dashes, linewidth=wide, label=words)
        if best.band is not None:
            for axes in (above, below):
                axes.axvspan(*best.band, color=FAINT, zorder=0)
        below.axhline(100 * TOLERANCE, color=QUIET, linewidth=0.8, dashes=(4, 3))
        above.set_ylim(0.0, 1.15)
        above.set_ylabel("density over frequency [1]")
        below.set_ylim(0.0, 105.0)
        below.set_xlim(0.0, frequency[-1])
        below.set_ylabel("amplitude kept [%]")
        below.set_xlabel("frequency [Hz]")
        below.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=5, frameon=False, fontsize=8)
    return figure


def shaper_picture(found: PrinterShaper, form: str) -> bytes:
    """The picture of `shaper_figure` as "svg", "png" or "pdf", the same for the same result."""
    undated: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with file_style(), BytesIO() as file:
        shaper_figure(found).savefig(file, format=form, dpi=150, metadata=undated.get(form))
        return file.getvalue()
