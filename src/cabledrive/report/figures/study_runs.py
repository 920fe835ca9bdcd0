"""Pictures of a study: intervals, bounds over bandwidth, responses, errors of many plants."""

from collections.abc import Mapping, Sequence
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.quality import distributed_response, model_response
from cabledrive.report.picture import (
    BLUE,
    FAINT,
    GREEN,
    INK,
    LINE,
    ORANGE,
    PURPLE,
    QUIET,
    RED,
    label,
    log_axis,
    picture,
)
from cabledrive.rig import Tracking
from cabledrive.studies.study.acceptance_stage import AcceptanceResult, WorstCase
from cabledrive.studies.study.bandwidth_cost import CarriageController
from cabledrive.studies.study.controller_stage import ControllerResult
from cabledrive.studies.study.machine import LOG, WORDS, Quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


PARTS = (("theorem", BLUE, "-"), ("unmatched", PURPLE, "--"), ("sensors", GREEN, "-."))
PART_WORDS = {"theorem": "theorem", "unmatched": "unmatched", "sensors": "encoders"}
PLANT_LOOKS = {"lumped": (BLUE, "-"), "cable": (ORANGE, "--")}
WIDEST = 2.0


def intervals_picture(name: str, known: Mapping[str, Quantity], sheet: Mapping[str, Quantity]) -> Markup:
    """Every number over its data sheet value, beside what the data sheet leaves open."""
    shown = [key for key in known if sheet[key].value > 0.0 and key != "offset_torque"]

    def _draw(figure: "Figure") -> None:
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
        axes.set_yticks(range(len(shown)), [WORDS[key] for key in shown])
        axes.invert_yaxis()
        axes.set_xlabel("over the data sheet's value")

    height = 26.0 * len(shown) + 70.0
    return picture(name, _draw, height=height)


def bandwidths_picture(name: str, found: ControllerResult) -> Markup:
    """The bound and its parts over the bandwidth. ``name``: unique on the page."""
    usable = [one for one in found.candidates if one.model == found.model and one.bound is not None]
    hertz = np.array([one.bandwidth for one in usable])

    def _draw(figure: "Figure") -> None:
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

    return picture(name, _draw, height=280.0)


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
) -> Markup:
    """Share of the runs below an error, of laws with lasting runs, with bound and wanted error [rad]."""

    def _draw(figure: "Figure") -> None:
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

    return picture(name, _draw, height=280.0)


def shares_below(one: AcceptanceResult) -> tuple[Array, Array]:
    """Error [deg] and share of all runs below it [%]; it ends below 100 % where runs ended early."""
    errors = np.degrees(np.append(0.0, one.peaks))
    return errors, 100.0 * np.arange(len(errors)) / one.draws


def _end_of_axis(runs: Sequence[AcceptanceResult], limit: float) -> float:
    """Beyond the limit, if any, and beyond errors up to four times as large [deg]."""
    largest = max(one.peaks[-1] for one in runs)
    shown = max(limit, min(largest, 4.0 * limit)) if limit else largest
    return 1.15 * float(np.degrees(shown))


def worst_picture(name: str, worst: WorstCase) -> Markup:
    """Motion, error and torque of the worst run. ``name``: unique on the page."""
    return _run_picture(name, worst, "motion [deg]", "error [deg]", 180.0 / pi)


def carriage_worst_picture(name: str, worst: WorstCase) -> Markup:
    """Position, error and torque of the worst run. ``name``: unique on the page."""
    return _run_picture(name, worst, "position [mm]", "error [mm]", 1e3)


def _run_picture(name: str, worst: WorstCase, motion: str, error: str, scale: float) -> Markup:
    """Motion and error times a scale, and torque, over the time."""

    def _draw(figure: "Figure") -> None:
        panels = figure.subplots(3, 1, sharex=True)
        rows = (
            (motion, scale * np.array(worst.reference), QUIET),
            (error, scale * np.array(worst.error), BLUE),
            ("torque [N m]", np.array(worst.torque), GREEN),
        )
        for axes, (words, values, colour) in zip(panels, rows, strict=True):
            axes.axhline(0.0, color=LINE, linewidth=1.0)
            axes.plot(worst.time, values, color=colour, linewidth=1.3)
            axes.set_ylabel(words)
        panels[-1].set_xlabel("time [s]")

    return picture(name, _draw, height=380.0)


CARRIAGE_PARTS = (
    ("nominal", "best values", BLUE, "-", 0, 5),
    ("uncertain", "uncertain", PURPLE, "--", 0, -13),
    ("sensors", "encoders", GREEN, "-.", 0, 5),
)
"""Name, words, look, and where the words stand: by which bandwidth, and how far above."""


def carriage_bandwidths_picture(name: str, found: CarriageController) -> Markup:
    """The estimated error and its parts over the bandwidth. ``name``: unique on the page."""
    usable = [one for one in found.candidates if one.estimate is not None]
    hertz = np.array([one.bandwidth for one in usable])
    whole = 1e3 * np.array([one.estimate or 0.0 for one in usable])

    def _draw(figure: "Figure") -> None:
        axes, least = figure.subplots(), whole.min()
        axes.plot(hertz, whole, color=INK, linewidth=2.4)
        label(axes, "estimate", (hertz[0], whole[0]), (6, 5), color=INK)
        for part, words, colour, style, beside, above in CARRIAGE_PARTS:
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

    return picture(name, _draw, height=280.0)


def carriage_peaks_picture(name: str, runs: AcceptanceResult, goal: float | None) -> Markup:
    """Share of the runs below an error, all the way and at rest, with the goal [m]."""
    looks = ((runs.peaks, "all the way", BLUE, "-"), (runs.rests, "at rest", ORANGE, "--"))

    def _draw(figure: "Figure") -> None:
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

    return picture(name, _draw, height=280.0)


MODEL_COLOURS = {1: QUIET, 2: ORANGE, 3: GREEN, 4: BLUE}
STYLES = ("-", "--", "-.", ":")


def responses_picture(name: str, drive: Drive, models: Sequence[int]) -> Markup:
    """Magnitude from motor torque to load angle: the distributed cable and the models."""
    hertz = np.geomspace(0.5, 500.0, 700)
    omega = 2.0 * np.pi * hertz

    def _draw(figure: "Figure") -> None:
        axes = figure.subplots()
        axes.plot(hertz, np.abs(distributed_response(drive, omega)), color=INK, linewidth=3.0, alpha=0.35)
        for number in models:
            size = np.abs(model_response(drive, number, omega))
            axes.plot(hertz, size, STYLES[number - 1], color=MODEL_COLOURS[number], linewidth=1.4)
            end = (hertz[-1], size[-1])
            label(axes, str(number), end, (4, -4), color=MODEL_COLOURS[number], annotation_clip=False)
        axes.set_xlim(0.5, 500.0)
        axes.set_ylim(np.abs(distributed_response(drive, omega)).min(), 1e3)
        log_axis(axes, "x", 600.0)
        log_axis(axes, "y", 200.0)
        axes.set_xlabel("frequency [Hz]")
        axes.set_ylabel("load angle per torque [rad/(N m)]")

    return picture(name, _draw, height=300.0)


def spectrum(run: Tracking, *, lowest: float = 2.0) -> tuple[np.ndarray, np.ndarray]:
    """Frequency [Hz] and amplitude [deg] of the error of the load in the last dwell."""
    interval = run.time[1] - run.time[0]
    still = run.time > run.time[-1] - run.summary["motion"]["dwell"]
    signal = np.degrees(run.error[still])
    window = np.hanning(signal.size)
    amplitude = 2.0 * np.abs(np.fft.rfft((signal - signal.mean()) * window, 8 * signal.size)) / window.sum()
    frequency = np.fft.rfftfreq(8 * signal.size, interval)
    kept = (frequency >= lowest) & (frequency <= 200.0)
    return frequency[kept], amplitude[kept]
