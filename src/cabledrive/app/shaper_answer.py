"""What `cabledrive shaper` finds for a printer's axis: JSON in SI, text in the units of printers."""

from typing import Any

from cabledrive.answers.keys import Keys
from cabledrive.identification.estimates import Finding
from cabledrive.identification.printer import Belts, Printer, PrinterShaper
from cabledrive.identification.printer_spectrum import ShaperFit
from cabledrive.identification.spectrum_peaks import SpectrumPeak
from cabledrive.report.blocks import table_text
from cabledrive.report.printer_page import peaks_table, shapers_table, similar_words

NO_DAMPING, NO_BAND = "no peak has a damping ratio", "it leaves more than 5 % at its own frequency"
MEASURED = ("frequency_low_hz", "frequency_high_hz", "damping", "damping_low", "damping_high")
PEAK = Keys(
    "frequency_hz=frequency frequency_low_hz=frequency_low frequency_high_hz=frequency_high damping "
    "damping_low damping_high height log=source",
    dict.fromkeys(MEASURED, ".reason"),
    of=SpectrumPeak,
)
FIT = Keys(
    "type frequency_hz=frequency vibration smoothing max_acceleration score band_hz=band "
    "times=shaper.times amplitudes=shaper.amplitudes",
    {"band_hz": NO_BAND},
    of=ShaperFit,
)
SHAPER = Keys(
    "axis spread_hz=spread shapers findings "
    "recommended_vibration_at_measured_damping=measured_vibration damping "
    "corner_speed notes",
    {
        "axis": "neither given by --axis nor in the name of a log",
        "spread_hz": "no peak",
        "recommended_vibration_at_measured_damping": NO_DAMPING,
    },
    {"shapers": FIT, "findings": Keys("code message", of=Finding)},
    of=PrinterShaper,
)
ANSWER = Keys(
    "rows: peaks texts: logs note: recommended configuration object: recommended_shaper",
    {"recommended_shaper": "nothing is recommended"},
    {"peaks": Keys("number: kept", also=(PEAK,)), "recommended_shaper": FIT},
    (SHAPER,),
)
BELTS = Keys("similarity difference_hz=difference", {"difference_hz": "a belt has no peak"}, of=Belts)

PRINTER = Keys(
    "rows: axes object: belts",
    {"belts": "no files of both belts"},
    {"axes": ANSWER, "belts": Keys("texts: logs", also=(BELTS,))},
)


def shaper_data(found: PrinterShaper) -> dict[str, Any]:
    """The JSON object: frequencies in Hz, smoothing in m, acceleration in m/s^2."""
    best, refused = found.recommended, found.refused
    chosen = {"recommended": best.type, "recommended_shaper": FIT(best), "configuration": found.configuration}
    return SHAPER(found) | {
        "peaks": [PEAK(peak) | {"kept": found.kept(peak)} for peak in found.peaks],
        **(
            chosen
            if refused is None
            else dict.fromkeys(chosen) | {f"{key}_reason": refused for key in chosen}
        ),
        "logs": [spectrum.source for spectrum in found.spectra],
    }


def printer_data(found: Printer) -> dict[str, Any]:
    """The JSON object of a page: every axis as `shaper_data` has it, and the belts."""
    belts = None
    if found.belts is not None:
        belts = BELTS(found.belts) | {"logs": [found.belts.a.source, found.belts.b.source]}
    return PRINTER({"axes": [shaper_data(axis) for axis in found.axes], "belts": belts})


def printer_text(found: Printer) -> str:
    """The same for people."""
    parts = [shaper_text(axis) for axis in found.axes]
    return "\n\n".join(parts + ([] if found.belts is None else [similar_words(found.belts)]))


def shaper_text(found: PrinterShaper) -> str:
    """The same for people, in mm and mm/s^2 as printers' configurations have it."""
    best = found.recommended
    axis = f"Axis {found.axis}" if found.axis else "Axis not known"
    lines = [f"{axis}, {', '.join(spectrum.source for spectrum in found.spectra)}", ""]
    lines.append(table_text(peaks_table(found)) if found.peaks else "No peak stands out.")
    lines += ["", table_text(shapers_table(found))]
    if found.refused is not None:
        lines += ["", f"No shaper is recommended: {found.refused}."]
        return "\n".join([*lines, *_findings(found)])
    lines += ["", f"Recommended: {best.type} at {best.frequency:.1f} Hz."]
    if found.spread is not None and best.band is not None:
        low, high = found.spread
        lines.append(
            f"Peaks from {low:.1f} to {high:.1f} Hz; it leaves 5 % of the amplitude at most "
            f"from {best.band[0]:.1f} to {best.band[1]:.1f} Hz."
        )
    if found.measured_vibration is not None:
        lines.append(
            f"At the measured damping it leaves {100 * found.measured_vibration:.1f} % of the vibration."
        )
    return "\n".join([*lines, "", found.configuration, *_findings(found)])


def _findings(found: PrinterShaper) -> list[str]:
    """Findings and notes, each under an empty line."""
    lines = ["", *(f"finding: {finding}" for finding in found.findings)] if found.findings else []
    return lines + (["", *(f"note: {note}" for note in found.notes)] if found.notes else [])
