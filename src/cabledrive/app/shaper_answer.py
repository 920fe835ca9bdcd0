"""What `cabledrive shaper` finds for a printer's axis: JSON in SI, text in the units of printers."""

from typing import Any

from cabledrive.app.results import Absent, known, row
from cabledrive.identification.printer import Printer, PrinterShaper, similar_words
from cabledrive.identification.printer_spectrum import ShaperFit
from cabledrive.identification.spectrum_peaks import SpectrumPeak
from cabledrive.report.blocks import table_text
from cabledrive.report.printer_page import peaks_table, shapers_table

NO_NAME = "neither given by --axis nor in the name of a log"
NO_DAMPING = "no peak has a damping ratio"
NO_BAND = "it leaves more than 5 % at its own frequency"


def shaper_data(found: PrinterShaper) -> dict[str, Any]:
    """The JSON object: frequencies in Hz, smoothing in m, acceleration in m/s^2."""
    best, refused = found.recommended, found.refused
    none = Absent(reason=refused or "")
    return {
        "axis": known(found.axis or None, NO_NAME),
        "peaks": [_peak_data(found, peak) for peak in found.peaks],
        "spread_hz": known(found.spread, "no peak"),
        "shapers": [_fit_data(fit) for fit in found.shapers],
        "recommended": best.type if refused is None else none,
        "recommended_shaper": _fit_data(best) if refused is None else none,
        "recommended_vibration_at_measured_damping": known(found.measured_vibration, NO_DAMPING),
        "configuration": found.configuration if refused is None else none,
        "damping": found.damping,
        "corner_speed": found.corner_speed,
        "logs": [spectrum.source for spectrum in found.spectra],
        "findings": [finding.as_dict() for finding in found.findings],
        "notes": list(found.notes),
    }


def printer_data(found: Printer) -> dict[str, Any]:
    """The JSON object of a page: every axis as `shaper_data` has it, and the belts."""
    belts: Any = Absent(reason="no files of both belts")
    if found.belts is not None:
        belts = {
            "similarity": found.belts.similarity,
            "difference_hz": known(found.belts.difference, "a belt has no peak"),
            "logs": [found.belts.a.source, found.belts.b.source],
        }
    return {"axes": [shaper_data(axis) for axis in found.axes], "belts": belts}


def printer_text(found: Printer) -> str:
    """The same for people."""
    parts = [shaper_text(axis) for axis in found.axes]
    return "\n\n".join(parts + ([] if found.belts is None else [similar_words(found.belts)]))


def _peak_data(found: PrinterShaper, peak: SpectrumPeak) -> dict[str, Any]:
    measured = (
        "frequency_low_hz=frequency_low frequency_high_hz=frequency_high damping damping_low damping_high"
    )
    whys = dict.fromkeys((word.partition("=")[0] for word in measured.split()), peak.reason or "")
    names = f"frequency_hz=frequency {measured} height log=source"
    return row(peak, names, **whys) | {"kept": found.kept(peak)}


def _fit_data(fit: ShaperFit) -> dict[str, Any]:
    names = "type frequency_hz=frequency vibration smoothing max_acceleration score band_hz=band"
    times = {"times": fit.shaper.times, "amplitudes": fit.shaper.amplitudes}
    return row(fit, names, band_hz=NO_BAND) | times


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
