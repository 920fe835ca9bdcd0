"""Campbell picture of a map: modes over speed, orders of excitation over them, zones to avoid shaded."""

from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.report.mode_figure import file_style
from cabledrive.report.style import BLUE, GREEN, OCHRE, ORANGE, PURPLE, QUIET, RED
from cabledrive.studies.excitation_orders import Branch, Campbell

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LINES = (RED, GREEN, PURPLE, OCHRE)
MOST_NAMES = 8


def campbell_drawing(found: Campbell, form: str) -> bytes:
    """The picture as the content of a file; ``form``, {"svg", "png", "pdf"}."""
    from matplotlib.figure import Figure

    undated: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with file_style(), BytesIO() as file:
        figure = Figure(figsize=(8.4, 5.2), layout="constrained")
        draw_campbell(figure, found)
        figure.savefig(file, format=form, dpi=150, metadata=undated.get(form))
        return file.getvalue()


def draw_campbell(figure: "Figure", found: Campbell) -> None:
    """Put the axes on an empty figure: a mode is the band of its frequencies over all places."""
    axes = figure.add_subplot()
    top, reached = found.covered, found.low
    for low, high in (*found.clear, (found.high, found.high)):
        axes.axvspan(reached, low, color=ORANGE, alpha=0.15, linewidth=0.0)
        axes.axvspan(low, high, ymax=0.02, color=GREEN, linewidth=0.0)
        reached = high
    for branch in found.branches:
        _band(axes, branch, top, found)
    speeds = np.array([found.low, found.high])
    for number, (name, rate) in enumerate(found.orders.items()):
        colour = LINES[number % len(LINES)]
        axes.plot(speeds, rate * speeds, color=colour, linewidth=2.0, label=f"order {name}")
    axes.set_xlim(found.low, found.high)
    axes.set_ylim(0.0, top)
    unit = "m/s" if found.coordinate.endswith((".x", ".y")) else "rad/s"
    axes.set_xlabel(f"speed of {found.coordinate} [{unit}]; green: clear of all modes")
    axes.set_ylabel("frequency [Hz]")
    axes.legend(frameon=False, loc="upper left")
    _names(axes, found, top)


def _band(axes: "Axes", branch: Branch, top: float, found: Campbell) -> None:
    own = branch.hertz[~np.isnan(branch.hertz)]
    low, high = own.min(), min(own.max(), top)
    colour = BLUE if branch.kind == "longitudinal" else QUIET
    axes.fill_between([found.low, found.high], low, high, color=colour, alpha=0.05, linewidth=0.0)
    for edge in {low, high} - {top}:
        axes.plot([found.low, found.high], [edge, edge], color=colour, linewidth=0.7)


def _names(axes: "Axes", found: Campbell, top: float) -> None:
    """Names of the heaviest modes at the right edge, pushed apart where they would overlap."""
    heaviest = sorted(found.branches, key=lambda own: -own.weight)[:MOST_NAMES]
    placed = sorted((float(np.nanmin(branch.hertz)), branch.name) for branch in heaviest)
    gap, last = 0.045 * top, -np.inf
    for hertz, name in placed:
        last = max(hertz, last + gap)
        axes.annotate(
            name,
            (found.high, hertz),
            (1.04, last / top),
            textcoords="axes fraction",
            fontsize=7,
            va="center",
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "relpos": (0.0, 0.5)},
        )
