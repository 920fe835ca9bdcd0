"""Pictures of a study: intervals, bound over bandwidth, errors of many plants, the worst run."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.parameters.arrays import Array
from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import BLUE, FAINT, GREEN, INK, LINE, ORANGE, PURPLE, QUIET, RED, label, log_axis
from cabledrive.studies.study.acceptance_stage import AcceptanceResult, WorstCase
from cabledrive.studies.study.controller_stage import ControllerResult
from cabledrive.studies.study.machine import LOG, WORDS, Quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PARTS = (("theorem", BLUE, "-"), ("unmatched", PURPLE, "--"), ("sensors", GREEN, "-."))
PART_WORDS = {"theorem": "theorem", "unmatched": "unmatched", "sensors": "encoders"}
PLANT_LOOKS = {"lumped": (BLUE, "-"), "cable": (ORANGE, "--")}
WIDEST = 2.0


def intervals_picture(name: str, known: Mapping[str, Quantity], sheet: Mapping[str, Quantity]) -> Picture:
    """Every number over its data sheet value, beside what the data sheet leaves open."""
    shown = [key for key in known if sheet[key].value > 0.0 and key != "offset_torque"]

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes = figure.subplots()
        for row, key in enumerate(shown):
            unit, now = sheet[key].value, known[key]
            axes.plot(
                [sheet[key].low / unit, sheet[key].high / unit], [row, row], color=FAINT, linewidth=11.0
            )
            ends = np.clip([now.low / unit, now.high / unit], 0.0, WIDEST)
            axes.plot(ends, [row, row], color=BLUE if now.source == LOG else QUIET, linewidth=2.0)
            axes.plot(
                min(now.value / unit, WIDEST),
                row,
                "o",
                color=BLUE if now.source == LOG else QUIET,
                markersize=5,
            )
        axes.axvline(1.0, color=LINE, linewidth=1.0, zorder=0)
        axes.set_yticks(range(len(shown)), [_short(key) if narrow else WORDS[key] for key in shown])
        axes.invert_yaxis()
        axes.set_xlabel("over the data sheet's value")

    height = 26.0 * len(shown) + 70.0
    return picture(name, _draw, wide=height, narrow=height)


def _short(key: str) -> str:
    return key.replace("_", " ").replace("stiffness", "k").replace("damping", "b").replace("inertia", "J")


def bandwidths_picture(name: str, found: ControllerResult) -> Picture:
    """The bound and its parts over the bandwidth. ``name``: unique on the page."""
    usable = [one for one in found.candidates if one.model == found.model and one.bound is not None]
    hertz = np.array([one.bandwidth for one in usable])

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes = figure.subplots()
        bound = np.degrees([one.bound or 0.0 for one in usable])
        axes.plot(hertz, bound, color=INK, linewidth=2.4)
        label(axes, "bound", (hertz[0], bound[0]), (4, 6), color=INK)
        ends = []
        for part, colour, style in PARTS:
            values = np.degrees([getattr(one, part) or 0.0 for one in usable])
            axes.plot(hertz, values, style, color=colour, linewidth=1.5)
            ends.append((values[-1], PART_WORDS[part], colour))
        chosen = [i for i, one in enumerate(usable) if one.bandwidth == found.bandwidth]
        axes.plot(hertz[chosen], bound[chosen], "o", markersize=9, fillstyle="none", color=RED)
        axes.set_ylim(max(1e-4, 0.3 * bound.min() / 30.0), 2.0 * bound.max())
        log_axis(axes, "y", 230.0)
        _name_the_ends(axes, hertz[-1], ends)
        axes.set_xlabel("bandwidth [Hz]")
        axes.set_ylabel("error [deg]")

    return picture(name, _draw, wide=280.0, narrow=260.0)


def _name_the_ends(axes: "Axes", right: float, ends: list[tuple[float, str, str]]) -> None:
    """Names to the right of curves that end at these values, moved up where they would lie on one another."""
    low, high = axes.get_ylim()
    height = 230.0 / np.log10(high / low)  # px of a decade
    floor = -np.inf
    for value, words, colour in sorted(ends):
        place = height * np.log10(value / low)
        lifted = max(place, floor + 13.0)
        label(axes, words, (right, value), (5, lifted - place - 4), color=colour, annotation_clip=False)
        floor = lifted


def peaks_picture(
    name: str, runs: Sequence[AcceptanceResult], bound: float | None, error: float | None
) -> Picture:
    """Share of the runs below an error, of laws with lasting runs, with bound and wanted error [rad]."""

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes = figure.subplots()
        right = _end_of_axis(runs, max(bound or 0.0, error or 0.0))
        furthest = max(runs, key=lambda one: one.peaks[len(one.peaks) // 2])
        for one in runs:
            colour, style = PLANT_LOOKS[one.plant]
            looks: dict[str, Any] = {"color": colour, "ha": "left" if one is furthest else "right"}
            peaks, share = shares_below(one)
            axes.step(peaks, share, style, where="post", color=colour, linewidth=1.8)
            seen = int(np.count_nonzero(peaks <= right)) - 1
            middle = max(seen // 2, min(seen, 1))
            aside = (8, -10) if one is furthest else (-8, 6)
            label(axes, one.plant, (float(peaks[middle]), float(share[middle])), aside, **looks)
        for words, value, colour, style in (("bound", bound, INK, ":"), ("goal", error, RED, "-.")):
            if value is None:
                continue
            axes.axvline(np.degrees(value), color=colour, linestyle=style, linewidth=1.4)
            label(axes, words, (float(np.degrees(value)), 6.0), (-5, 0), color=colour, ha="right")
        axes.set_xlim(0.0, right)
        axes.set_ylim(0.0, 103.0)
        axes.set_xlabel("largest error of the load in a run [deg]")
        axes.set_ylabel("runs below [%]")

    return picture(name, _draw, wide=280.0, narrow=260.0)


def shares_below(one: AcceptanceResult) -> tuple[Array, Array]:
    """Error [deg] and share of all runs below it [%]; it ends below 100 % where runs ended early."""
    errors = np.degrees(np.append(0.0, one.peaks))
    return errors, 100.0 * np.arange(len(errors)) / one.draws


def _end_of_axis(runs: Sequence[AcceptanceResult], limit: float) -> float:
    """Beyond the limit, if any, and beyond errors up to four times as large [deg]."""
    largest = max(one.peaks[-1] for one in runs)
    shown = max(limit, min(largest, 4.0 * limit)) if limit else largest
    return 1.15 * float(np.degrees(shown))


def worst_picture(name: str, worst: WorstCase) -> Picture:
    """Motion, error and torque of the worst run. ``name``: unique on the page."""

    def _draw(figure: "Figure", narrow: bool) -> None:
        panels = figure.subplots(3, 1, sharex=True)
        rows = (
            ("motion [deg]", np.degrees(worst.reference), QUIET),
            ("error [deg]", np.degrees(worst.error), BLUE),
            ("torque [N m]", np.array(worst.torque), GREEN),
        )
        for axes, (words, values, colour) in zip(panels, rows, strict=True):
            axes.axhline(0.0, color=LINE, linewidth=1.0)
            axes.plot(worst.time, values, color=colour, linewidth=1.3)
            axes.set_ylabel(words)
        panels[-1].set_xlabel("time [s]")

    return picture(name, _draw, wide=380.0, narrow=380.0)
