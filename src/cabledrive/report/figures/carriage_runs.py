"""Pictures of a carriage's study: estimate over bandwidth, errors of many plants, the worst run."""

from typing import TYPE_CHECKING

import numpy as np

from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import BLUE, GREEN, INK, LINE, ORANGE, PURPLE, QUIET, RED, label, log_axis
from cabledrive.studies.study.acceptance_stage import AcceptanceResult, WorstCase
from cabledrive.studies.study.carriage_controller import CarriageController

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PARTS = (
    ("nominal", "best values", BLUE, "-", 0, 5),
    ("uncertain", "uncertain", PURPLE, "--", 0, -13),
    ("sensors", "encoders", GREEN, "-.", 0, 5),
)
"""Name, words, look, and where the words stand: by which bandwidth, and how far above."""


def carriage_bandwidths_picture(name: str, found: CarriageController) -> Picture:
    """The estimated error and its parts over the bandwidth. ``name``: unique on the page."""
    usable = [one for one in found.candidates if one.estimate is not None]
    hertz = np.array([one.bandwidth for one in usable])
    whole = 1e3 * np.array([one.estimate or 0.0 for one in usable])

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes, least = figure.subplots(), whole.min()
        axes.plot(hertz, whole, color=INK, linewidth=2.4)
        label(axes, "estimate", (hertz[0], whole[0]), (6, 5), color=INK)
        for part, words, colour, style, beside, above in PARTS:
            values = 1e3 * np.array([getattr(one, part) for one in usable])
            least = min(least, values.min())
            axes.plot(hertz, values, style, color=colour, linewidth=1.5)
            label(axes, words, (hertz[beside], values[beside]), (4, above), color=colour)
        chosen = [i for i, one in enumerate(usable) if one.bandwidth == found.bandwidth]
        axes.plot(hertz[chosen], whole[chosen], "o", markersize=9, fillstyle="none", color=RED)
        axes.set_ylim(max(0.5 * least, 1e-4 * whole.max()), 2.5 * whole.max())
        log_axis(axes, "y", 230.0)
        axes.set_xlabel("bandwidth [Hz]")
        axes.set_ylabel("mm")

    return picture(name, _draw, wide=280.0, narrow=260.0)


def carriage_peaks_picture(name: str, runs: AcceptanceResult, goal: float | None) -> Picture:
    """Share of the runs below an error, all the way and at rest, with the goal [m]."""
    looks = ((runs.peaks, "all the way", BLUE, "-"), (runs.rests, "at rest", ORANGE, "--"))

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes, right = figure.subplots(), 1.15e3 * max(runs.peaks[-1], min(goal or 0.0, 4.0 * runs.peaks[-1]))
        for errors, words, colour, style in looks:
            shown = 1e3 * np.append(0.0, errors)
            share = 100.0 * np.arange(len(shown)) / runs.draws
            axes.step(shown, share, style, where="post", color=colour, linewidth=1.8)
            middle = (len(shown) * (3 if words == "at rest" else 1)) // 4
            label(axes, words, (float(shown[middle]), float(share[middle])), (8, -6), color=colour)
        if goal is not None and 1e3 * goal <= right:
            axes.axvline(1e3 * goal, color=RED, linestyle="-.", linewidth=1.4)
            label(axes, "goal", (1e3 * goal, 6.0), (-5, 0), color=RED, ha="right")
        axes.set_xlim(0.0, right)
        axes.set_ylim(0.0, 103.0)
        axes.set_xlabel("largest error in a run [mm]")
        axes.set_ylabel("runs below [%]")

    return picture(name, _draw, wide=280.0, narrow=260.0)


def carriage_worst_picture(name: str, worst: WorstCase) -> Picture:
    """Position, error and torque of the worst run. ``name``: unique on the page."""

    def _draw(figure: "Figure", narrow: bool) -> None:
        panels = figure.subplots(3, 1, sharex=True)
        rows = (
            ("position [mm]", 1e3 * np.array(worst.reference), QUIET),
            ("error [mm]", 1e3 * np.array(worst.error), BLUE),
            ("torque [N m]", np.array(worst.torque), GREEN),
        )
        for axes, (words, values, colour) in zip(panels, rows, strict=True):
            axes.axhline(0.0, color=LINE, linewidth=1.0)
            axes.plot(worst.time, values, color=colour, linewidth=1.3)
            axes.set_ylabel(words)
        panels[-1].set_xlabel("time [s]")

    return picture(name, _draw, wide=380.0, narrow=380.0)
