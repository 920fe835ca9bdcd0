"""Figures 3.1, 3.2 and 3.6: determinants and the measured spectrum; the entries of chapter 3."""

from dataclasses import replace

import numpy as np

from cabledrive.modal import natural_frequencies
from cabledrive.parameters import load_drive
from cabledrive.simulation import Pluck, Scheme, Start, simulate
from cabledrive.simulation.run import whole
from reproduction.chapter_3_shapes import SHAPE_DIFFERS, shapes
from reproduction.chapter_3_transporter import transporter
from reproduction.determinant import modal_determinant
from reproduction.item import ERRATUM, Entry, Outcome, outcome, place
from reproduction.judge import claimed, compared
from reproduction.panel import Panel, curve

RANGES = {"whole": (0.0, 3000.0), "zoomed": (0.0, 200.0)}
DAMPING = 5.0
"""Gamma of the spectrum [1/s]: a choice, none is printed."""

LOST = "the print's range is lost; this one is chosen"


def determinant(number: int) -> Outcome:
    """Determinant of (3.13): its zero-crossings are the natural frequencies.

    ``number``, {1, 2}: of the configuration.
    """
    drive = load_drive(f"dissertation-{number}")
    certified = natural_frequencies(drive, below=3000.0)
    panels, worst = [], 0.0
    for words, (low, high) in RANGES.items():
        data = modal_determinant(drive, np.linspace(low, high, 6001))
        x, y = data["frequency"].to_numpy(), data["determinant"].to_numpy()
        crossing = x[np.flatnonzero(y[:-1] * y[1:] < 0)]
        inside = certified[(certified > low) & (certified < high)]
        worst = max(worst, *(float(np.min(np.abs(crossing - f))) for f in inside)) if len(inside) else worst
        panels.append(
            Panel(
                figure=f"Fig. 3.{number}",
                title=f"Determinant of the modal matrix, {words}; {LOST}",
                x="frequency [Hz]",
                y="determinant",
                curves=(curve("determinant", x, y), curve("certified modes", inside, 0.0 * inside)),
            )
        )
    spacing = (RANGES["whole"][1] - RANGES["whole"][0]) / 6000
    item = claimed(
        f"figure-3-{number}",
        f"Fig. 3.{number}: zeros of the determinant of configuration {number}",
        "the zero-crossings indicate the natural frequencies",
        f"a crossing within {worst:.2g} Hz of each of {len(certified)} certified modes below 3 kHz "
        f"(grid {spacing:.2g} Hz)",
        worst <= spacing,
        otherwise=SHAPE_DIFFERS,
        note=(
            "two of the zeros near 750 Hz lie close together: the lower one is the in-phase mode that the "
            f"print passes over. {place('erratum-table-3-2-in-phase')}"
        ),
    )
    return outcome([item], panels)


def figure_3_1(quick: bool) -> Outcome:
    """Fig. 3.1.

    ``quick``: changes nothing here.
    """
    return determinant(1)


def figure_3_2(quick: bool) -> Outcome:
    """Fig. 3.2.

    ``quick``: changes nothing here.
    """
    return determinant(2)


def figure_3_6(quick: bool) -> Outcome:
    """Fig. 3.6: spectrum of the load pulley after plucks of both spans, by the exact loop.

    ``quick``: fewer segments and one second less.
    """
    drive = load_drive("dissertation-2")
    drive = replace(
        drive,
        cable=replace(drive.cable, transverse_damping=DAMPING),
        layout=replace(drive.layout, gravity=0.0),
    )
    plucks = (Pluck(height=2e-3), Pluck(height=1e-3, span="lower"))
    segments, duration = (40, 2.0) if quick else (100, 3.0)
    result = whole(simulate(drive, duration, start=Start(plucks=plucks), scheme=Scheme(segments=segments)))
    angle = result.load_angle - np.polyval(np.polyfit(result.time, result.load_angle, 1), result.time)
    size = 8 * angle.size
    spectrum = np.abs(np.fft.rfft(angle * np.hanning(angle.size), size))
    frequency = np.fft.rfftfreq(size, result.time[1])
    band = frequency < 200.0
    peak = float(frequency[band][np.argmax(spectrum[band])])
    mixed = "the print's theory, 81.55 Hz, mixes two conventions"
    item = compared(
        "figure-3-6-peak",
        "Fig. 3.6, Section 3.2.2: peak of the free load pulley's spectrum",
        "81.6",
        peak,
        "Hz",
        otherwise=(
            ERRATUM,
            f"{mixed}; the measured digits are those of the theory. {place('erratum-table-3-2-mixture')}",
        ),
    )
    panel = Panel(
        figure="Fig. 3.6",
        title="Spectrum of the load angle; plucks of 2 and 1 mm and Gamma = 5 1/s are chosen",
        x="frequency [Hz]",
        y="amplitude, relative",
        curves=(curve("load pulley", frequency[band], spectrum[band] / spectrum[band].max()),),
    )
    return outcome([item], [panel])


ENTRIES = (
    Entry(name="figure-3-1", chapter="3", covers=("Fig. 3.1",), compute=figure_3_1),
    Entry(name="figure-3-2", chapter="3", covers=("Fig. 3.2",), compute=figure_3_2),
    Entry(
        name="figures-3-3-to-3-5", chapter="3", covers=("Fig. 3.3", "Fig. 3.4", "Fig. 3.5"), compute=shapes
    ),
    Entry(name="figure-3-6", chapter="3", covers=("Fig. 3.6", "Section 3.2.2"), compute=figure_3_6),
    Entry(
        name="figures-3-8-to-3-10",
        chapter="3",
        covers=("Fig. 3.8", "Fig. 3.9", "Fig. 3.10"),
        compute=transporter,
    ),
)
