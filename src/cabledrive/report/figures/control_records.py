"""The pulse and its derivatives."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import BLUE, GREEN, INK, OCHRE, ORANGE, PURPLE, RED, label
from cabledrive.rig import Motion

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, OCHRE, RED, INK)
STYLES = ("-", "--", "-.", ":", "-", "--", "-.")
POWERS = ("angle", "speed", "acceleration", "3rd derivative", "4th derivative", "5th derivative")


def pulse_picture(name: str, motion: Motion) -> Picture:
    """A pulse and its first five derivatives, each over its largest value.

    ``name``: unique on the page.
    """
    trajectory = motion.trajectory
    time = np.linspace(0.0, trajectory.duration, 601)
    rows = np.atleast_2d(trajectory(time, 5))

    def _draw(figure: "Figure", narrow: bool) -> None:
        panels = figure.subplots(2, 1, sharex=True)
        panels[0].plot(time, np.degrees(rows[0]), color=BLUE)
        panels[0].set_ylabel("deg")
        panels[0].set_title(POWERS[0])
        for power in range(1, 6):
            line = rows[power] / np.abs(rows[power]).max()
            panels[1].plot(time, line, STYLES[power - 1], color=COLOURS[power - 1], linewidth=1.2)
            at = int(np.argmax(line))
            label(panels[1], str(power), (time[at], line[at]), (2, 2), color=COLOURS[power - 1])
        panels[1].set_title("derivatives 1 to 5 over their largest values")
        panels[1].set_ylim(-1.15, 1.3)
        panels[1].set_xlabel("time [s]")

    return picture(name, _draw, wide=300.0, narrow=320.0)
