"""Figures of the internal resonance: surfaces, contours, map, forced, swept and free response."""

from typing import TYPE_CHECKING

import numpy as np

from cabledrive.modal.frequency_ratio import frequency_ratio, mass_ratios, resonant_load_ratio
from cabledrive.parameters import Drive
from cabledrive.report.numbers import number
from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import BLUE, GREEN, INK, ORANGE, PURPLE, QUIET, SPAN_COLOURS, label, log_axis
from cabledrive.studies.chapter_5 import ForcedResponse, FreeResponse, SweptResponse
from cabledrive.studies.resonance_map import GrowthMap
from cabledrive.studies.steady_motion import SteadyBranch

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HEIGHT = 320.0  # px
TENSIONS = (2.0, 5.0, 10.0)
LINES = (BLUE, ORANGE, GREEN)


def surfaces_picture(name: str, drive: Drive) -> Picture:
    """Frequency ratio over the mass ratio of the load pulley, for some tensions and drive pulleys: Fig. 5.2.

    ``name``: unique on the page; ``drive``: gives the cable.
    """
    chi2 = np.geomspace(0.1, 100.0, 200)

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes = figure.add_subplot()
        for tension, colour in zip(TENSIONS, LINES, strict=True):
            strain = tension / drive.cable.axial_rigidity
            for chi1, dashes in ((1.0, (1, 0)), (1000.0, (5, 3))):
                ratio = frequency_ratio(chi1, chi2, strain)
                axes.plot(chi2, ratio, color=colour, dashes=dashes, linewidth=1.4)
            place = int(np.argmin(np.abs(ratio - 1.6))) if ratio.max() > 1.6 else -1
            words = (chi2[place], ratio[place])
            label(axes, f"{number(tension)} N", words, (-6, 4), ha="right", color=colour)
        axes.axhline(0.5, color=INK, linewidth=1.0)
        axes.set_ylim(0.0, 2.0)
        axes.set_xlim(chi2[0], chi2[-1])
        log_axis(axes, "x", 230.0 if narrow else 560.0)
        axes.set_xlabel("load pulley over cable, χ₂")
        axes.set_ylabel("frequency ratio γ")

    return picture(name, _draw, wide=HEIGHT, narrow=HEIGHT)


def contours_picture(name: str, drive: Drive) -> Picture:
    """Pulleys that make the ratio one half, a contour for each tension: Fig. 5.3.

    ``name``: unique on the page; ``drive``: gives the cable, and a point.
    """
    own = mass_ratios(drive)
    chi1 = np.geomspace(1.0, 3000.0, 600)

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes = figure.add_subplot()
        for tension, colour in zip((2.0, 3.2838, 5.0), LINES, strict=True):
            chi2 = resonant_load_ratio(chi1, tension / drive.cable.axial_rigidity)
            shown = np.isfinite(chi2) & (chi2 < 100.0)
            axes.plot(chi1[shown], chi2[shown], color=colour)
            end = (chi1[shown][-1], chi2[shown][-1])
            label(axes, f"{number(tension)} N", end, (-4, 4), ha="right", color=colour)
        axes.plot(*own, "o", markersize=10, markerfacecolor="none", markeredgecolor=INK)
        label(axes, "this drive", own, (-8, -16), ha="right", color=INK)
        axes.set_xlim(chi1[0], chi1[-1])
        axes.set_ylim(1.0, 100.0)
        log_axis(axes, "x", 230.0 if narrow else 560.0)
        log_axis(axes, "y", HEIGHT - 60.0)
        axes.set_xlabel("drive pulley over cable, χ₁")
        axes.set_ylabel("load pulley over cable, χ₂")

    return picture(name, _draw, wide=HEIGHT, narrow=HEIGHT)


def forced_picture(name: str, forced: ForcedResponse) -> Picture:
    """Load angle and midpoint under the torque: Figs. 5.4 and 5.6.

    ``name``: unique on the page.
    """
    level = forced.load_angle - np.polyval(np.polyfit(forced.time, forced.load_angle, 1), forced.time)

    def _draw(figure: "Figure", narrow: bool) -> None:
        above, below = figure.subplots(2, 1, sharex=True)
        _band(above, forced.time, np.degrees(level), INK)
        _band(below, forced.time, 1e3 * forced.midpoint, SPAN_COLOURS["upper"])
        above.set_ylabel("load [deg]")
        below.set_ylabel("midpoint [mm]")
        below.set_xlabel("time [s]")

    return picture(name, _draw, wide=HEIGHT, narrow=HEIGHT)


def swept_picture(name: str, swept: SweptResponse) -> Picture:
    """Amplitude over the frequency ratio while the tension rises: Fig. 5.5.

    ``name``: unique on the page.
    """

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes = figure.add_subplot()
        axes.plot(swept.ratio, 1e3 * swept.amplitude, color=BLUE)
        foot = ("data", "axes fraction")
        beside = {"ha": "left"}, {"ha": "right"}
        marks = ((swept.edge, "edge", QUIET, 0.9, 0), (swept.predicted, "growth integral", ORANGE, 0.15, 0))
        for place, words, colour, height, side in (*marks, (swept.found, "onset", BLUE, 0.9, 1)):
            axes.axvline(place, color=colour, linewidth=1.0, dashes=(4, 3))
            offset = (-5 if side else 5, 0)
            label(axes, words, (place, height), offset, xycoords=foot, color=colour, **beside[side])
        axes.set_ylim(5e-3, 20.0)
        log_axis(axes, "y", HEIGHT - 60.0)
        axes.set_xlabel("frequency ratio γ")
        axes.set_ylabel("amplitude [mm]")

    return picture(name, _draw, wide=HEIGHT, narrow=HEIGHT)


def free_picture(name: str, free: FreeResponse) -> Picture:
    """Load angle, upper midpoint and shares of the energy after unequal plucks: Fig. 5.7.

    ``name``: unique on the page.
    """

    def _draw(figure: "Figure", narrow: bool) -> None:
        first, second, third = figure.subplots(3, 1, sharex=True)
        _band(first, free.time, np.degrees(free.load_angle), INK)
        _band(second, free.time, 1e3 * free.midpoints[0], SPAN_COLOURS["upper"])
        looks = ((*SPAN_COLOURS.values(), PURPLE), ("-", "--", "-."))
        for (words, share), colour, style in zip(free.shares.items(), *looks, strict=True):
            third.plot(free.share_time, 100 * share, style, color=colour, linewidth=1.5, label=words)
        first.set_ylabel("load [deg]")
        second.set_ylabel("upper [mm]")
        third.set_ylabel("energy [%]")
        third.set_xlabel("time [s]")
        third.set_ylim(0, 100)
        third.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False, ncols=1 if narrow else 3)

    return picture(name, _draw, wide=HEIGHT + 100, narrow=HEIGHT + 100)


def steady_picture(name: str, branches: tuple[SteadyBranch, ...]) -> Picture:
    """Steady amplitude over the torque: full where it is stable, dashed where not.

    ``name``: unique on the page.
    """
    kinds = {("upper",): ("one span alone", BLUE), ("upper", "lower"): ("each of both", ORANGE)}

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes = figure.add_subplot()
        for branch in branches:
            if branch.spans not in kinds:
                continue
            words, colour = kinds[branch.spans]
            size = 1e3 * branch.amplitude.max(axis=0)
            stable = branch.growth < 0.0
            torque = 1e3 * branch.torque
            axes.plot(torque, np.where(stable, size, np.nan), color=colour, linewidth=2.0)
            axes.plot(torque, np.where(stable, np.nan, size), color=colour, linewidth=1.2, dashes=(4, 3))
            place = int(np.argmin(np.abs(torque - 0.7 * torque.max())))
            label(axes, words, (torque[place], size[place]), (0, 6), ha="right", color=colour)
        axes.set_xlim(left=0.0)
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("torque [mN m]")
        axes.set_ylabel("amplitude [mm]")

    return picture(name, _draw, wide=HEIGHT, narrow=HEIGHT)


def map_picture(name: str, growth: GrowthMap) -> Picture:
    """Contours of growth over pretension and torque, with the threshold and the drive's own point.

    ``name``: unique on the page.
    """

    def _draw(figure: "Figure", narrow: bool) -> None:
        axes = figure.add_subplot()
        levels = ((1.5, GREEN), (3.0, ORANGE), (10.0, PURPLE))
        for level, colour in levels:
            axes.contour(
                growth.pretension,
                growth.torque,
                np.ma.masked_invalid(growth.growth),
                [level],
                colors=[colour],
            )
        if growth.slack.any():
            axes.contour(
                growth.pretension, growth.torque, growth.slack, [0.5], colors=[QUIET], linestyles=":"
            )
        axes.plot(growth.pretension, growth.threshold, color=INK, dashes=(5, 3), linewidth=1.2)
        axes.plot(
            growth.own_pretension,
            growth.own_torque,
            "o",
            markersize=10,
            markerfacecolor="none",
            markeredgecolor=INK,
        )
        axes.set_ylim(growth.torque[0], growth.torque[-1])
        axes.set_xlim(growth.pretension[0], growth.pretension[-1])
        axes.set_xlabel("pretension [N]")
        axes.set_ylabel("torque [N m]")

    return picture(name, _draw, wide=HEIGHT, narrow=HEIGHT)


def _band(axes: "Axes", time: np.ndarray, signal: np.ndarray, colour: str) -> None:
    """A fast oscillation as the band that it fills, a point for every 25 ms of it."""
    per = max(1, round(0.025 / (time[1] - time[0])))
    whole = time.size // per
    rows = signal[: whole * per].reshape(whole, per)
    middle = time[: whole * per].reshape(whole, per).mean(axis=1)
    axes.fill_between(middle, rows.min(axis=1), rows.max(axis=1), color=colour, linewidth=0)
    axes.set_xlim(time[0], time[-1])
