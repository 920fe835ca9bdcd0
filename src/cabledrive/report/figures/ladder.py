"""The staircase that counts the modes, and below it the ladder on which each of them is a rung."""

from dataclasses import dataclass
from math import log10, pi
from typing import TYPE_CHECKING

import numpy as np

from cabledrive.modal import Mode, Modes
from cabledrive.modal.mode import BOTH
from cabledrive.modal.networks import network_of_drive
from cabledrive.modal.spectrum import Spectrum
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.report.numbers import number
from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import (
    FAINT,
    INK,
    LINE,
    NARROW,
    QUIET,
    WIDE,
    family_colour,
    label,
    log_axis,
    short_family,
    text_width,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STEP, _LANE, _AXIS = 25.0, 21.0, 52.0  # heights [px]
_BESIDE = {False: 105.0, True: 52.0}  # what stands left of the axes [px], on a wide and on a narrow page


@dataclass(frozen=True, slots=True, kw_only=True)
class Staircase:
    """The count of longitudinal modes at many frequencies, by the counter alone."""

    frequency: Array  # (n,): ascending [Hz]
    count: Array  # (n,): modes below, without the rigid-body mode


def staircase(drive: Drive, modes: Modes) -> Staircase:
    """Count the longitudinal modes below many frequencies, up to the bound of the certificate.

    The frequencies are spread evenly, and beside each listed mode one lies just below and one just above. The
    counter knows nothing of the list; the transverse modes that it counts as well are taken off.

    ``modes``: modes of this drive.
    """
    below = modes.certificate.below
    listed = np.array([mode.frequency for mode in modes.longitudinal if mode.frequency < below])
    start = min(mode.frequency for mode in modes.modes) / 2.0
    beside = np.concatenate((listed * (1 - 1e-9), listed * (1 + 1e-9)))
    frequency = np.sort(np.concatenate((np.geomspace(start, below, 100), beside)))
    spectrum = Spectrum(
        network_of_drive(drive, motor=modes.motor, hold=modes.hold, at_torque=modes.at_torque)
    )
    across = np.repeat(
        [mode.frequency for mode in modes.transverse], [mode.multiplicity for mode in modes.transverse]
    )
    count = [spectrum.count(2 * pi * f) - int(np.sum(across < f)) for f in frequency]
    return Staircase(frequency=frequency, count=np.array(count))


def ladder_picture(name: str, drive: Drive, modes: Modes) -> Picture:
    """Draw the staircase of the count with the listed modes on it, and every mode of both kinds as a rung."""
    steps = staircase(drive, modes)
    stairs, lanes = max(int(steps.count[-1]), 4) + 1.2, 1 + len(drive.spans)

    def _draw(figure: "Figure", narrow: bool) -> None:
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[_STEP * stairs, _LANE * lanes])
        left, right = steps.frequency[0], modes.certificate.below * 1.06
        length = (NARROW if narrow else WIDE) - _BESIDE[narrow]
        _draw_staircase(top, steps, modes, narrow, length / log10(right / left))
        _draw_rungs(bottom, modes, drive.spans, "" if narrow else "across, ")
        bottom.set_xlim(left, right)
        log_axis(bottom, "x", length)
        bottom.set_xlabel("frequency [Hz]")

    height = _STEP * stairs + _LANE * lanes + _AXIS
    return picture(name, _draw, wide=height, narrow=height)


def _draw_staircase(axes: "Axes", steps: Staircase, modes: Modes, narrow: bool, decade: float) -> None:
    from matplotlib.ticker import MaxNLocator

    below = modes.certificate.below
    axes.step(steps.frequency, steps.count, where="pre", color=INK, linewidth=1.3)
    height = 0
    for mode in modes.longitudinal:
        if mode.frequency < below:
            height += mode.multiplicity
            _label_step(axes, mode, height, narrow, decade * log10(mode.frequency / steps.frequency[0]))
    axes.axvline(below, color=QUIET, linewidth=1.0, dashes=(2, 3))
    if not narrow:
        label(axes, f"counted to {number(below)} Hz", (below, 0.0), (-5, 5), ha="right", color=QUIET)
    axes.set_ylim(-0.15, max(steps.count[-1], 2) + 0.6)
    axes.set_ylabel("modes below f" if narrow else "longitudinal modes\nbelow f")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.tick_params(axis="x", which="both", length=0)
    axes.spines["bottom"].set_visible(False)


def _label_step(axes: "Axes", mode: Mode, height: int, narrow: bool, room: float) -> None:
    """A dot on the step and its words: left above the stairs, or right below them where there is no room."""
    colour = family_colour(mode.family)
    times = f" ×{mode.multiplicity}" if mode.multiplicity > 1 else ""
    family = short_family(mode.family) if narrow else mode.family
    words = f"{family}, {number(mode.frequency, 4 if narrow else 5)} Hz{times}"
    axes.plot(mode.frequency, height, "o", color=colour, markersize=6.5, clip_on=False)
    left = text_width(words) + 12 < room
    label(
        axes,
        words,
        (mode.frequency, height),
        (-9, 0) if left else (8, -11),
        ha="right" if left else "left",
        va="center",
        color=colour,
    )


def _draw_rungs(axes: "Axes", modes: Modes, spans: tuple[str, ...], prefix: str) -> None:
    below = modes.certificate.below
    lanes = {"along": [(m.frequency, family_colour(m.family)) for m in modes.longitudinal]}
    for span in spans:
        across = [m.frequency for m in modes.transverse if m.span in (span, BOTH) and m.plane == "w"]
        lanes[f"{prefix}{span}"] = [(frequency, INK) for frequency in across]
    for row, rungs in enumerate(lanes.values()):
        axes.axhspan(-row - 0.36, -row + 0.36, color=FAINT, linewidth=0, zorder=0)
        shown = [(frequency, colour) for frequency, colour in rungs if frequency < below]
        axes.vlines(
            [frequency for frequency, _ in shown],
            -row - 0.36,
            -row + 0.36,
            colors=[colour for _, colour in shown],
            linewidth=1.3,
        )
    axes.set_yticks([-row for row in range(len(lanes))], list(lanes))
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(-len(lanes) + 0.5, 0.5)
    axes.spines["left"].set_visible(False)
    axes.spines["bottom"].set_color(LINE)
