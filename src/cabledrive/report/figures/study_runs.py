"""Pictures of a study: intervals, bounds over bandwidth, responses, errors of many plants."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from markupsafe import Markup

from cabledrive.answers.figures import number
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.quality import distributed_response, model_response
from cabledrive.report.picture import Hue, label, log_axis, picture
from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study.acceptance_stage import AcceptanceResult, WorstCase
from cabledrive.studies.study.bandwidth_cost import CarriageController
from cabledrive.studies.study.machine import LOG, WORDS, Quantity
from cabledrive.studies.study.plants import ControllerResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Errors(NamedTuple):
    """How errors are shown: their unit and its size in SI, the whole of an estimate and its parts."""

    unit: str
    size: float
    whole: str  # name of the field
    parts: Mapping[str, str]  # words by the name of the field

    def shown(self, error: float | None) -> str:
        """An error in its unit; empty where there is none."""
        return "" if error is None else number(error / self.size, 3)

    def usable(self, found: ControllerResult | CarriageController) -> list[Any]:
        """Candidates of the chosen model that have an estimate."""
        model = getattr(found, "model", None)
        own = [one for one in found.candidates if getattr(one, "model", None) == model]
        return [one for one in own if getattr(one, self.whole) is not None]


LOAD = Errors("deg", DEGREE, "bound", {"theorem": "theorem", "unmatched": "unmatched", "sensors": "encoders"})
CARRIAGE = Errors(
    "mm", 1e-3, "estimate", {"nominal": "best values", "uncertain": "uncertain", "sensors": "encoders"}
)
PART_LOOKS = ((Hue.BLUE, "-"), (Hue.PURPLE, "--"), (Hue.GREEN, "-."))
LOOKS = ((Hue.BLUE, "-"), (Hue.ORANGE, "--"))
MARK_LOOKS = ((Hue.INK, ":"), (Hue.RED, "-."))
WIDEST = 2.0


def intervals_picture(name: str, known: Mapping[str, Quantity], sheet: Mapping[str, Quantity]) -> Markup:
    """Every number over its data sheet value, beside what the data sheet leaves open."""
    shown = [key for key in known if key in sheet and sheet[key].value > 0.0 and key != "offset_torque"]

    def _draw(figure: "Figure") -> None:
        axes = figure.subplots()
        for row, key in enumerate(shown):
            stated, now = sheet[key], known[key]
            ends = np.array([stated.low, stated.high]) / stated.value
            axes.plot(ends, [row, row], color=Hue.FAINT, linewidth=11.0)
            low, high, value = np.clip(np.array([now.low, now.high, now.value]) / stated.value, 0.0, WIDEST)
            colour = Hue.BLUE if now.source == LOG else Hue.QUIET
            axes.plot([low, high], [row, row], color=colour, linewidth=2.0)
            axes.plot(value, row, "o", color=colour, markersize=5)
        axes.axvline(1.0, color=Hue.LINE, linewidth=1.0, zorder=0)
        axes.set_yticks(range(len(shown)), [WORDS[key] for key in shown])
        axes.invert_yaxis()
        axes.set_xlabel("over the data sheet's value")

    return picture(name, _draw, height=26.0 * len(shown) + 70.0)


def bandwidths_picture(found: ControllerResult | CarriageController, errors: Errors) -> Markup:
    """The bound or estimate and its parts over the bandwidth."""
    usable = errors.usable(found)
    hertz = np.array([one.bandwidth for one in usable])

    def values(part: str) -> Array:
        return np.array([getattr(one, part) or 0.0 for one in usable]) / errors.size

    def _draw(figure: "Figure") -> None:
        axes, whole = figure.subplots(), values(errors.whole)
        axes.plot(hertz, whole, color=Hue.INK, linewidth=2.4)
        label(axes, errors.whole, (hertz[0], whole[0]), (4, 6), color=Hue.INK)
        ends, least = [], 0.3 * whole.min() / 30.0
        for (part, words), (colour, style) in zip(errors.parts.items(), PART_LOOKS, strict=True):
            axes.plot(hertz, values(part), style, color=colour, linewidth=1.5)
            ends.append((max(values(part)[-1], least), words, colour))
        chosen = [i for i, one in enumerate(usable) if one.bandwidth == found.bandwidth]
        axes.plot(hertz[chosen], whole[chosen], "o", markersize=9, fillstyle="none", color=Hue.RED)
        axes.set_ylim(max(1e-4, least), 2.0 * whole.max())
        log_axis(axes, "y", 230.0)
        low, high = axes.get_ylim()
        decade, floor = 230.0 / np.log10(high / low), -np.inf  # px
        for value, words, colour in sorted(ends):  # moved up where they would lie on one another
            place = decade * np.log10(value / low)
            floor = max(place, floor + 13.0)
            beside = (5, floor - place - 4)
            label(axes, words, (hertz[-1], value), beside, color=colour, annotation_clip=False)
        axes.set(xlabel="bandwidth [Hz]", ylabel=f"error [{errors.unit}]")

    return picture("bandwidths", _draw, height=280.0)


def peaks_picture(
    runs: Sequence[AcceptanceResult], marks: Mapping[str, float | None], errors: Errors
) -> Markup:
    """Share of the runs below an error, of laws with lasting runs, with the bound and goal in SI."""
    curves = [(one.plant, one.peaks, one.draws) for one in runs]
    curves += [("at rest", one.rests, one.draws) for one in runs if one.rests]
    limit = max(value or 0.0 for value in marks.values())
    largest = max(peaks[-1] for _, peaks, _ in curves)
    right = 1.15 * (max(limit, min(largest, 4.0 * limit)) if limit else largest) / errors.size

    def _draw(figure: "Figure") -> None:
        axes = figure.subplots()
        furthest = max(curves, key=lambda one: one[1][len(one[1]) // 2])
        for one, (colour, style) in zip(curves, LOOKS, strict=False):
            words, peaks, draws = one
            # below 100 % where runs ended early
            shown, share = np.append(0.0, peaks) / errors.size, 100.0 * np.arange(len(peaks) + 1) / draws
            axes.step(shown, share, style, where="post", color=colour, linewidth=1.8)
            seen = int(np.count_nonzero(shown <= right)) - 1
            middle = max(seen // 2, min(seen, 1))
            far = one is furthest
            looks: dict[str, Any] = {"color": colour, "ha": "left" if far else "right"}
            place = float(shown[middle]), float(share[middle])
            label(axes, words, place, (8, -10) if far else (-8, 6), **looks)
        for (words, value), (colour, style) in zip(marks.items(), MARK_LOOKS, strict=True):
            if value is not None:
                axes.axvline(value / errors.size, color=colour, linestyle=style, linewidth=1.4)
                label(axes, words, (value / errors.size, 6.0), (-5, 0), color=colour, ha="right")
        axes.set(
            xlim=(0.0, right),
            ylim=(0.0, 103.0),
            xlabel=f"largest error in a run [{errors.unit}]",
            ylabel="runs below [%]",
        )

    return picture("peaks", _draw, height=280.0)


def worst_picture(worst: WorstCase, motion: str, errors: Errors) -> Markup:
    """Motion, whose word is given, error and torque of the worst run over the time."""

    def _draw(figure: "Figure") -> None:
        panels = figure.subplots(3, 1, sharex=True)
        rows = (
            (f"{motion} [{errors.unit}]", np.array(worst.reference) / errors.size, Hue.QUIET),
            (f"error [{errors.unit}]", np.array(worst.error) / errors.size, Hue.BLUE),
            ("torque [N m]", np.array(worst.torque), Hue.GREEN),
        )
        for axes, (words, values, colour) in zip(panels, rows, strict=True):
            axes.axhline(0.0, color=Hue.LINE, linewidth=1.0)
            axes.plot(worst.time, values, color=colour, linewidth=1.3)
            axes.set_ylabel(words)
        panels[-1].set_xlabel("time [s]")

    return picture("worst", _draw, height=380.0)


MODEL_COLOURS = {1: Hue.QUIET, 2: Hue.ORANGE, 3: Hue.GREEN, 4: Hue.BLUE}
STYLES = ("-", "--", "-.", ":")


def responses_picture(name: str, drive: Drive, models: Sequence[int]) -> Markup:
    """Magnitude from motor torque to load angle: the distributed cable and the models."""
    hertz = np.geomspace(0.5, 500.0, 700)
    omega = 2.0 * np.pi * hertz

    def _draw(figure: "Figure") -> None:
        axes = figure.subplots()
        axes.plot(hertz, np.abs(distributed_response(drive, omega)), color=Hue.INK, linewidth=3.0, alpha=0.35)
        for model in models:
            size = np.abs(model_response(drive, model, omega))
            axes.plot(hertz, size, STYLES[model - 1], color=MODEL_COLOURS[model], linewidth=1.4)
            end = (hertz[-1], size[-1])
            label(axes, str(model), end, (4, -4), color=MODEL_COLOURS[model], annotation_clip=False)
        axes.set(xlim=(0.5, 500.0), ylim=(np.abs(distributed_response(drive, omega)).min(), 1e3))
        log_axis(axes, "x", 600.0)
        log_axis(axes, "y", 200.0)
        axes.set(xlabel="frequency [Hz]", ylabel="load angle per torque [rad/(N m)]")

    return picture(name, _draw, height=300.0)
