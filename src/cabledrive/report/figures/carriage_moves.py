"""Pictures of the transporter: a move under several laws, and frequencies and stability along the way."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import BLUE, GREEN, INK, LINE, ORANGE, PURPLE, QUIET, RED, label
from cabledrive.rig.carriage.carriage_move import CarriageRun
from cabledrive.studies.transporter_moves import AlongTheWay

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STYLES = {"scheduled": "-", "pd-flat": "--", "pd": "-.", "shaper": ":", "frozen": (0, (6, 2))}
COLOURS = {"scheduled": BLUE, "pd-flat": GREEN, "pd": RED, "shaper": ORANGE, "frozen": PURPLE}


def moves_picture(name: str, runs: Sequence[CarriageRun], gusty: Sequence[CarriageRun]) -> Picture:
    """Distance of the payload from the end of its way, in still air and after a gust.

    ``name``: unique on the page; ``runs``, ``gusty``: the same laws without and with wind.
    """

    def _draw(figure: "Figure", narrow: bool) -> None:
        panels = figure.subplots(2, 1, sharex=True)
        for axes, shown, words in zip(panels, (runs, gusty), ("still air", "gust, 1 to 1.5 s"), strict=True):
            axes.axhline(0.0, color=LINE, linewidth=1.0)
            for run in shown:
                left = 1e3 * (run.payload - run.wanted[-1])
                axes.plot(run.time, left, ls=STYLES[run.law], color=COLOURS[run.law], lw=1.5, label=run.law)
            axes.set_ylim(-110.0, 155.0)
            axes.set_title(words)
            axes.set_ylabel("from rest [mm]")
            axes.axvline(shown[0].arrival, color=QUIET, linewidth=1.0, linestyle=":")
        names = {"ncols": 4, "handlelength": 1.8, "columnspacing": 1.0, "borderpad": 0.0}
        panels[0].legend(loc="upper right", frameon=False, fontsize=10, **names)
        panels[-1].set_xlabel("time [s]")
        panels[-1].set_xlim(2.0, runs[0].time[-1])

    return picture(name, _draw, wide=340.0, narrow=340.0)


def way_picture(name: str, way: AlongTheWay) -> Picture:
    """Natural frequencies, and the slowest closed-loop pole of each law, over the place of the carriage.

    ``name``: unique on the page.
    """

    def _draw(figure: "Figure", narrow: bool) -> None:
        above, below = figure.subplots(2, 1, sharex=True)
        for column, words in ((0, "swing"), (1, "carriage on the cable")):
            above.plot(way.position, way.frequency[:, column], color=INK, linewidth=1.4)
            middle = len(way.position) // 2
            label(above, words, (way.position[middle], way.frequency[middle, column]), (0, 6))
        above.set_ylim(0.0, 1.15 * way.frequency[:, 1].max())
        above.set_ylabel("frequency [Hz]")
        below.axhline(0.0, color=QUIET, linewidth=1.0)
        for law, growth in way.growth.items():
            below.plot(way.position, growth, ls=STYLES[law], color=COLOURS[law], linewidth=1.4)
            place = int(np.argmax(growth)) if law == "frozen" else len(growth) // 3
            shift = (-42, -2) if law == "frozen" else (0, -13) if law == "scheduled" else (0, 5)
            label(below, law, (way.position[place], growth[place]), shift, color=COLOURS[law])
        below.set_ylabel("growth [1/s]")
        below.set_xlabel("place of the carriage [m]")

    return picture(name, _draw, wide=320.0, narrow=320.0)
