"""Fundamental mode shapes of the dissertation's configurations, Figs. 3.3, 3.4 and 3.9."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cabledrive.report.numbers import number
from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import GREEN, LINE, SPAN_COLOURS, label

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def fundamentals_picture(name: str, shapes: Sequence[tuple[str, "xr.Dataset"]]) -> Picture:
    """Draw the fundamental shape of several drives, both spans over their own coordinates as in the print.

    ``name``: unique on the page; ``shapes``: title, and what `cabledrive.studies.mode_shapes` returns.
    """

    def _draw(figure: "Figure", narrow: bool) -> None:
        rows, columns = (len(shapes), 1) if narrow else (1, len(shapes))
        grid = figure.subplots(rows, columns, squeeze=False, sharey=True).flat
        for axes, (title, data) in zip(grid, shapes, strict=True):
            _draw_fundamental(axes, title, data)

    return picture(name, _draw, wide=230.0, narrow=190.0 * len(shapes))


def _draw_fundamental(axes: "Axes", title: str, data: "xr.Dataset") -> None:
    position = data["position"].to_numpy() / float(data["position"][-1])
    axes.axhline(0.0, color=LINE, linewidth=1.0)
    for span in data["span"].to_numpy():
        shape = data["displacement"].sel(mode=0, span=span).to_numpy()
        axes.plot(position, shape, color=SPAN_COLOURS[span])
        at = int(0.22 * position.size)
        side = 1 if shape[at] >= 0.0 else -1
        look = {"ha": "center", "va": "bottom" if side > 0 else "top", "color": SPAN_COLOURS[span]}
        rising = shape[at + 1] > shape[at]
        label(axes, span, (position[at], shape[at]), (-16 if rising == (side > 0) else 16, 4 * side), **look)
    carried = data["carriage_displacement"].sel(mode=0).to_numpy()
    places = data["carriage_position"].to_numpy() / float(data["position"][-1])
    axes.plot(places, carried, "s", color=GREEN, markersize=6)
    for place, value in zip(places, carried, strict=True):
        label(axes, "carriage", (place, value), (6, -12), color=GREEN)
    axes.set_title(f"{title}: {number(float(data['frequency'][0]), 5)} Hz")
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(-1.15, 1.25)
    axes.set_yticks([-1, 0, 1])
    axes.set_xticks(np.array([0.0, 0.5, 1.0]), ["0", "x / Lₑ", "1"])
