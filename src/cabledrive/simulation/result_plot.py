"""The quick picture of a run: load angle and midpoints over time."""

from typing import TYPE_CHECKING

import numpy as np

from cabledrive.simulation.result import SimulationResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def result_figure(result: SimulationResult) -> "Figure":
    """Load angle, and w of the midpoint of each span, over time."""
    from matplotlib import pyplot

    figure, (above, below) = pyplot.subplots(2, 1, sharex=True, layout="constrained")
    above.plot(result.time, np.degrees(result.load_angle))
    above.set_ylabel("load angle [deg]")
    above.set_title(result.provenance["drive"])
    for span in result.spans:
        below.plot(result.time, 1e3 * result.midpoint(span)[:, 2], label=f"{span} span")
    below.set_xlabel("time [s]")
    below.set_ylabel("w at midspan [mm]")
    below.legend()
    return figure
