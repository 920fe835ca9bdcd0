"""Pictures of peak errors over rise time, angle and bandwidth of the laws."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cabledrive.report.figures.clear_labels import label_lines
from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import BLUE, GREEN, ORANGE, PURPLE, QUIET, log_axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = (ORANGE, BLUE, PURPLE, GREEN)
STYLES = ("-", "--", "-.", ":")


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """Peak errors of the laws over one quantity.

    Attributes
    ----------
    words : str
        What it is over, with its unit.
    values : sequence of float
    errors : dict of str to sequence of float
        Of each law [deg].
    """

    words: str
    values: Sequence[float]
    errors: Mapping[str, Sequence[float]]


def curves_picture(name: str, curves: Sequence[Curve], printed: Mapping[str, float]) -> Picture:
    """One panel for each quantity; printed errors as horizontal lines.

    ``name``: unique on the page; ``printed``: errors of the print [deg].
    """

    def _draw(figure: "Figure", narrow: bool) -> None:
        rows, columns = (len(curves), 1) if narrow else (1, len(curves))
        panels = figure.subplots(rows, columns, sharey=True, squeeze=False).ravel()
        for axes, curve in zip(panels, curves, strict=True):
            for value in printed.values():
                axes.axhline(value, color=QUIET, linewidth=0.8, linestyle=":")
            for number, errors in enumerate(curve.errors.values()):
                colour = COLOURS[number]
                axes.plot(
                    curve.values,
                    errors,
                    STYLES[number],
                    color=colour,
                    linewidth=1.5,
                    marker="o",
                    markersize=3,
                )
            axes.set_xlim(min(curve.values), max(curve.values))
            axes.set_ylim(*_limits(curves))
            log_axis(axes, "y", 220.0)
            axes.set_xlabel(curve.words)
        for axes in panels if narrow else panels[:1]:
            axes.set_ylabel("peak error [deg]")
        figure.draw_without_rendering()
        for axes in panels if narrow else panels[:1]:
            label_lines(axes, tuple(printed.items()), color=QUIET)

    return picture(name, _draw, wide=290.0, narrow=230.0 * len(curves))


def _limits(curves: Sequence[Curve]) -> tuple[float, float]:
    every = np.concatenate([np.asarray(e) for curve in curves for e in curve.errors.values()])
    return 0.7 * float(np.nanmin(every)), 1.4 * float(np.nanmax(every))
