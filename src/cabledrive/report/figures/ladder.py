"""The staircase that counts the modes, and the ladder on which they stand, whole or fast for a slider."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor, log10, pi
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from cabledrive.answers.figures import number
from cabledrive.modal import Modes
from cabledrive.modal.mode import BOTH, LONGITUDINAL
from cabledrive.modal.mode_rows import ModeRow
from cabledrive.modal.natural import spectrum_of
from cabledrive.parameters import Machine
from cabledrive.parameters.arrays import Array
from cabledrive.report.figures.sheet import Sheet
from cabledrive.report.picture import (
    COLOURS,
    SMALL,
    WIDE,
    Hue,
    family_colour,
    label,
    log_axis,
    picture,
    text_width,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_STEP, _LANE, _AXIS = 25.0, 21.0, 52.0  # heights [px]
_BESIDE = 105.0  # what stands left of the axes [px]
MOST_LANES = 2
"""Spans that have a lane of their own."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Staircase:
    """The count of longitudinal modes at many frequencies, by the counter alone."""

    frequency: Array  # (n,): ascending [Hz]
    count: Array  # (n,): modes below, without the rigid-body mode


def staircase(drive: Machine, modes: Modes) -> Staircase:
    """Count the longitudinal modes below many frequencies, up to the bound of the certificate.

    The frequencies are spread evenly, and beside each listed mode one lies just below and one just above. The
    counter knows nothing of the list; the transverse modes that it counts as well are taken off.

    ``modes``: modes of this drive.
    """
    below = modes.certificate.below
    listed = np.array([mode.frequency for mode in modes.longitudinal if mode.frequency < below])
    start = min(mode.frequency for mode in modes.modes) / 2.0
    beside = np.concatenate((listed * (1 - 1e-9), listed * (1 + 1e-9)))
    frequency = np.sort(np.concatenate((np.geomspace(start, below, 40), beside)))
    spectrum, _ = spectrum_of(drive, modes.motor, modes.hold, modes.at_torque)
    across = np.repeat(
        [mode.frequency for mode in modes.transverse], [mode.multiplicity for mode in modes.transverse]
    )
    count = [spectrum.count(2 * pi * f) - int(np.sum(across < f)) for f in frequency]
    return Staircase(frequency=frequency, count=np.array(count))


def ladder_picture(name: str, drive: Machine, modes: Modes) -> Markup:
    """Draw the staircase of the count with the listed modes on it, and every mode of both kinds as a rung."""
    steps, lanes = staircase(drive, modes), _lanes(modes)
    stairs = max(int(steps.count[-1]), 4) + 1.2

    def _draw(figure: "Figure") -> None:
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[_STEP * stairs, _LANE * len(lanes)])
        left, right = steps.frequency[0], modes.certificate.below * 1.06
        length = WIDE - _BESIDE
        _draw_staircase(top, steps, modes, length / log10(right / left))
        _draw_rungs(bottom, lanes, modes.certificate.below)
        bottom.set_xlim(left, right)
        log_axis(bottom, "x", length)
        bottom.set_xlabel("frequency [Hz]")

    height = _STEP * stairs + _LANE * len(lanes) + _AXIS
    return picture(name, _draw, height=height)


def _draw_staircase(axes: "Axes", steps: Staircase, modes: Modes, decade: float) -> None:
    from matplotlib.ticker import MaxNLocator

    below = modes.certificate.below
    axes.step(steps.frequency, steps.count, where="pre", color=Hue.INK, linewidth=1.3)
    height = 0
    for mode in modes.longitudinal:
        if mode.frequency < below:
            height += mode.multiplicity
            room = decade * log10(mode.frequency / steps.frequency[0])
            colour = family_colour(mode.family)
            times = f" ×{mode.multiplicity}" if mode.multiplicity > 1 else ""
            words = f"{mode.family}, {number(mode.frequency, 5)} Hz{times}"
            axes.plot(mode.frequency, height, "o", color=colour, markersize=6.5, clip_on=False)
            # left above the stairs, or right below them where there is no room
            side, beside = ("right", (-9, 0)) if text_width(words) + 12 < room else ("left", (8, -11))
            label(axes, words, (mode.frequency, height), beside, ha=side, va="center", color=colour)
    axes.axvline(below, color=Hue.QUIET, linewidth=1.0, dashes=(2, 3))
    label(axes, f"counted to {number(below)} Hz", (below, 0.0), (-5, 5), ha="right", color=Hue.QUIET)
    axes.set(ylim=(-0.15, max(steps.count[-1], 2) + 0.6), ylabel="longitudinal modes\nbelow f")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.tick_params(axis="x", which="both", length=0)
    axes.spines["bottom"].set_visible(False)


def _lanes(modes: Modes) -> dict[str, list[tuple[float, str]]]:
    """Frequency and colour of each rung: along, and across each span, or all where they are many."""
    across = [(mode.span, (mode.frequency, Hue.INK)) for mode in modes.transverse if mode.plane == "w"]
    spans = sorted({span for span, _ in across if span and span != BOTH}, reverse=True)
    lanes = {f"across, {span}": [rung for own, rung in across if own in (span, BOTH)] for span in spans}
    if len(lanes) > MOST_LANES:
        lanes = {"across": [rung for _, rung in across]}
    return {"along": [(mode.frequency, family_colour(mode.family)) for mode in modes.longitudinal], **lanes}


def _draw_rungs(axes: "Axes", lanes: dict[str, list[tuple[float, str]]], below: float) -> None:
    for row, rungs in enumerate(lanes.values()):
        axes.axhspan(-row - 0.36, -row + 0.36, color=Hue.FAINT, linewidth=0, zorder=0)
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
    axes.spines["bottom"].set_color(Hue.LINE)


LANE, TOP, LEFT, RIGHT, FOOT = 46.0, 22.0, 92.0, 24.0, 40.0  # px
_NAMES = {light: name for name, (light, _) in COLOURS.items()}


def rungs(rows: Sequence[ModeRow], chosen: int, width: float) -> Markup:
    """The ladder of a table of modes; ``chosen``: number of the row that is animated."""
    sheet = Sheet()
    low, high = _limits([row.frequency for row in rows])
    lanes = {"longitudinal": TOP + 0.5 * LANE, "transverse": TOP + 1.5 * LANE}
    foot = TOP + 2 * LANE
    for name, y in lanes.items():
        sheet.elements.append(
            f'<rect x="{LEFT - 6:g}" y="{y - 0.5 * LANE + 6:.1f}" width="{width - LEFT - RIGHT + 12:g}" '
            f'height="{LANE - 12:g}" rx="4" style="fill: var(--faint)"/>'
        )
        sheet.words(name, (LEFT - 12, y + 4), anchor="end", colour="quiet", size=SMALL)
    _axis(sheet, low, high, width, foot)
    for place, row in enumerate(rows):
        x = _across(row.frequency, low, high, width)
        y = lanes["longitudinal" if row.kind == LONGITUDINAL else "transverse"]
        colour = _NAMES[family_colour(row.family)] if row.kind == LONGITUDINAL else "ink"
        half = 0.5 * LANE - (4 if place == chosen else 9)
        sheet.elements.append(f'<g class="rung" data-row="{place}">')
        sheet.path(
            f"M{x:.2f} {y - half:.1f} V{y + half:.1f}", colour=colour, width=4 if place == chosen else 2
        )
        sheet.elements.append(  # a finger is wider than a rung
            f'<rect x="{x - 7:.2f}" y="{y - 0.5 * LANE:.1f}" width="14" height="{LANE:g}" '
            'style="fill: transparent"/>'
        )
        sheet.elements.append("</g>")
        if place == chosen:
            anchor = "end" if x > 0.8 * width else "start" if x < 0.2 * width else "middle"
            sheet.words(f"{number(row.frequency, 6)} Hz", (x, 13.0), anchor=anchor, colour=colour)
    return sheet.svg((width, foot + FOOT))


def _limits(frequencies: Sequence[float]) -> tuple[float, float]:
    """Ends of the axis [Hz]: round numbers, so that the axis rests while a slider moves."""
    low, high = min(frequencies), max(frequencies)

    def round_numbers(value: float) -> list[float]:
        return [10.0 ** floor(log10(value)) * step for step in (1.0, 2.0, 5.0, 10.0)]

    low, high = low / 1.05, high * 1.05
    first = max(step for step in round_numbers(low) if step <= low * (1 + 1e-12))
    return first, min(step for step in round_numbers(high) if step >= high * (1 - 1e-12))


def _across(frequency: float, low: float, high: float, width: float) -> float:
    return LEFT + (width - LEFT - RIGHT) * log10(frequency / low) / log10(high / low)


def _axis(sheet: Sheet, low: float, high: float, width: float, foot: float) -> None:
    sheet.line((LEFT, foot), (width - RIGHT, foot), colour="line")
    steps = (1.0, 2.0, 5.0) if log10(high / low) * 130.0 < width - LEFT else (1.0,)
    decades = range(floor(log10(low) + 1e-9), ceil(log10(high) - 1e-9) + 1)
    for value in (step * 10.0**ten for ten in decades for step in steps):
        if low * (1 - 1e-9) <= value <= high * (1 + 1e-9):
            x = _across(value, low, high, width)
            sheet.line((x, foot), (x, foot + 4), colour="line")
            sheet.words(number(value, 3), (x, foot + 17), colour="quiet", size=SMALL)
    sheet.words("natural frequency [Hz]", ((LEFT + width - RIGHT) / 2, foot + 34), colour="quiet", size=SMALL)
