"""What a printer's axes and belts show: JSON in SI, tables and text in the units of printers."""

from dataclasses import replace
from typing import Any

import numpy as np

from cabledrive.answers.figures import Row, fixed
from cabledrive.answers.keys import Keys
from cabledrive.identification.estimates import Finding
from cabledrive.identification.printer import ALIKE, Belts, Printer, PrinterShaper
from cabledrive.identification.printer_spectrum import ShaperFit
from cabledrive.identification.spectrum_peaks import SpectrumPeak
from cabledrive.modal import modes
from cabledrive.parameters import Machine
from cabledrive.report.blocks import RowGroup, Table, listed, table_text
from cabledrive.studies.mode_map import coordinates_of, frequency_of_coordinate

NO_DAMPING, NO_BAND = "no peak has a damping ratio", "it leaves more than 5 % at its own frequency"
MEASURED = ("frequency_low_hz", "frequency_high_hz", "damping", "damping_low", "damping_high")
PEAK = Keys(
    "frequency_hz=frequency frequency_low_hz=frequency_low frequency_high_hz=frequency_high damping "
    "damping_low damping_high height log=source",
    dict.fromkeys(MEASURED, ".reason"),
    of=SpectrumPeak,
)
PEAKS = (
    Row("log", "log", kind="text"),
    Row("near", "frequency", "Hz"),
    Row("damped", "damping ratio", "%", none="not known"),
    Row("height", "height", "%", ".0f", 100.0),
    Row("kept", "kept", "%", ".1f", 100.0),
    Row("reason", "", kind="text"),
)
FIT = Keys(
    "type frequency_hz=frequency vibration smoothing max_acceleration score band_hz=band "
    "times=shaper.times amplitudes=shaper.amplitudes",
    {"band_hz": NO_BAND},
    of=ShaperFit,
)
FITS = (
    Row("type", "type", kind="text"),
    Row("frequency", "frequency", "Hz", ".1f"),
    Row("vibration", "left", "%", ".1f", 100.0),
    Row("smoothing", "smoothing", "mm", ".3f", 1e3),
    Row("max_acceleration", "max_accel", "mm/s^2", lambda value: f"{100 * round(10 * value)}"),
    Row("band", "within 5 %", "Hz", lambda ends: f"{ends[0]:.1f} to {ends[1]:.1f}", none="nowhere"),
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
COUNT = 4  # modes of each kind beside measured peaks


def shaper_data(found: PrinterShaper) -> dict[str, Any]:
    """The JSON object: frequencies in Hz, smoothing in m, acceleration in m/s^2."""
    best, refused = found.recommended, found.refused
    chosen: dict[str, Any] = {"recommended": best.type, "recommended_shaper": FIT(best)}
    chosen |= {"configuration": found.configuration}
    if refused is not None:
        chosen = dict.fromkeys(chosen) | {f"{key}_reason": refused for key in chosen}
    peaks = [PEAK(peak) | {"kept": found.kept(peak)} for peak in found.peaks]
    logs = [spectrum.source for spectrum in found.spectra]
    return SHAPER(found) | {"peaks": peaks, **chosen, "logs": logs}


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
    lines += ["", table_text(shapers_table(found)), ""]
    if found.refused is not None:
        return "\n".join([*lines, f"No shaper is recommended: {found.refused}.", *_findings(found)])
    lines.append(f"Recommended: {best.type} at {best.frequency:.1f} Hz.")
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


def computed(machine: Machine, axis: str) -> dict[str, float]:
    """Frequency of the mode of each body's move along an axis, and of each carriage along its rope [Hz]."""
    found, moves = modes(machine, count=COUNT), coordinates_of(machine)
    along = replace(found, modes=found.longitudinal)
    carried = (name for mode in along.modes for name in mode.kinetic_shares if name.startswith("carriage"))
    values = {name: frequency_of_coordinate(found, name) for name in moves if name.endswith(f".{axis}")}
    values |= {name: frequency_of_coordinate(along, name) for name in sorted(set(carried))}
    return {name: hertz for name, hertz in values.items() if np.isfinite(hertz)}


def peaks_table(axis: PrinterShaper, machine: Machine | None = None) -> Table:
    """Peaks of all logs with their intervals, beside computed frequencies where there is a machine."""
    rows = [
        PEAK(peak) | {"kept": axis.kept(peak), "reason": peak.reason} | _near(peak) for peak in axis.peaks
    ]
    caption = f"Peaks of axis {axis.axis or 'unknown'}, and what the shaper keeps"
    if machine is None:
        return listed(caption, PEAKS, rows)
    columns = (PEAKS[0]._replace(words="log, or what moves"), *PEAKS[1:])
    made = listed(f"{caption}, beside computed", columns, rows)
    own = computed(machine, axis.axis or "x").items()
    lines = tuple((key, fixed(hertz, 1), "", "", "", "") for key, hertz in own)
    groups = (RowGroup(title="measured", rows=made.groups[0].rows), RowGroup(title="computed", rows=lines))
    return replace(made, groups=groups[: 2 if lines else 1])


def _near(peak: SpectrumPeak) -> dict[str, str | None]:
    """Frequency and damping of a peak with their intervals."""
    off = "" if peak.frequency_low is None else f" +- {peak.frequency - peak.frequency_low:.2f}"
    damped = None
    if peak.damping is not None and peak.damping_low is not None and peak.damping_high is not None:
        low, high = 100 * peak.damping_low, 100 * peak.damping_high
        damped = f"{100 * peak.damping:.2f} ({low:.2f} to {high:.2f})"
    return {"near": f"{peak.frequency:.1f}{off}", "damped": damped}


def fits_of(axis: PrinterShaper) -> tuple[ShaperFit, ...]:
    """The best shaper of each type, and the recommended one where it is none of them."""
    best = axis.recommended
    return axis.shapers if best in axis.shapers else (*axis.shapers, best)


def shapers_table(axis: PrinterShaper) -> Table:
    """The best shaper of each type, and the recommended one, with what each costs."""
    best, judged = axis.recommended, axis.refused is None
    rows = [
        {row.key: row.of(fit) for row in FITS}
        | {"type": fit.type + (" (recommended)" if fit is best and judged else "")}
        for fit in fits_of(axis)
    ]
    return listed(f"Shapers for axis {axis.axis or 'unknown'}", FITS, rows)


def similar_words(belts: Belts) -> str:
    """The comparison of the belts in a sentence."""
    shape = f"The spectra of the belts are {100 * belts.similarity:.0f} % alike"
    if belts.difference is None:
        return f"{shape}; a belt without a peak was not excited, or hangs loose."
    tighter = "A" if belts.difference > 0.0 else "B"
    words = f"{shape}; the highest peak of belt {tighter} lies {abs(belts.difference):.1f} Hz above the other"
    different = belts.similarity < ALIKE
    return f"{words}: {f'loosen belt {tighter}, or tighten the other' if different else 'equally tight'}."
