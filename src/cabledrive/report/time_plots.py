"""Time histories that answer to the pointer: logs with their modelling error."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.regressor_curves import RegressorCurves
from cabledrive.parameters.arrays import Array
from cabledrive.report.blocks import Text
from cabledrive.report.plot import Panel, Plot, Series

BINS = 250
COLOURS = ("blue", "orange", "green", "purple", "ochre", "red", "ink")


def time_plot(name: str, time: Array, panels: Sequence[Panel], *, alt: str, caption: Text) -> Plot:
    """A plot over time of as few instants as keep every peak of every curve. ``time``, shape (p,) [s]."""
    curves = [series.values for panel in panels for series in panel.series]
    kept = instants(curves, time.size)
    thin = [
        Panel(
            title=panel.title,
            unit=panel.unit,
            series=tuple(
                Series(name=s.name, values=s.values[kept], colour=s.colour, dashed=s.dashed)
                for s in panel.series
            ),
        )
        for panel in panels
    ]
    return Plot(
        name=name, alt=alt, caption=caption, points=time[kept], along="time", unit="s", panels=tuple(thin)
    )


def instants(curves: Sequence[Array], count: int, bins: int = BINS) -> NDArray[np.intp]:
    """Which of ``count`` instants to show: both ends, and in each bin the extremes of each curve."""
    if count <= 2 * bins:
        return np.arange(count)
    kept = {0, count - 1}
    for first, last in pairwise(np.linspace(0, count, bins + 1).astype(int)):
        for curve in curves:
            part = curve[first:last]
            kept |= {first + int(np.argmin(part)), first + int(np.argmax(part))}
    return np.array(sorted(kept))


def regressors_plot(
    name: str, curves: RegressorCurves, *, linear: bool = False, alt: str, caption: Text
) -> Plot:
    """Acceleration, speed and friction regressor, filtered and not; torque and modelling error."""
    length = "m" if linear else "rad"
    rows = (("Acceleration", f"{length}/s^2"), ("Speed", f"{length}/s"), ("Friction regressor", "1"))
    panels = [
        Panel(
            title=title,
            unit=unit,
            series=(
                Series(name="unfiltered", values=curves.unfiltered[k], colour="quiet"),
                Series(name="filtered", values=curves.filtered[k]),
            ),
        )
        for k, (title, unit) in enumerate(rows)
    ]
    pushed = (
        Series(name="measured", values=curves.torque, colour="quiet"),
        Series(name="modelling error", values=curves.error, colour="orange"),
    )
    panels.append(Panel(title="Force" if linear else "Torque", unit="N" if linear else "N m", series=pushed))
    return time_plot(name, curves.time, panels, alt=alt, caption=caption)
