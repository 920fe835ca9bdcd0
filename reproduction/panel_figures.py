"""Curves that come as data, one pair of axes under the other."""

from typing import TYPE_CHECKING

from cabledrive.report.blocks import Figure
from cabledrive.report.picture import BLUE, GREEN, INK, ORANGE, PURPLE, RED, SMALL, log_axis, picture
from reproduction.panel import Panel

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing

HEIGHT, EXTRA = 190.0, 40.0
DECADES = 6
_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, RED, INK)
_STYLES = ("-", "--", "-.", ":")


def panels_figure(name: str, panels: tuple[Panel, ...]) -> Figure:
    """Panels of one figure as a figure of the page.

    ``name``: unique on the page.
    """

    def _draw(drawing: "Drawing", narrow: bool) -> None:
        rows = drawing.subplots(len(panels), 1, squeeze=False)[:, 0]
        for axes, panel in zip(rows, panels, strict=True):
            _fill(axes, panel, narrow)

    height = HEIGHT * len(panels) + EXTRA
    drawn = picture(name, _draw, wide=height, narrow=height)
    titles = "; ".join(dict.fromkeys(panel.title for panel in panels))
    return drawn.figure(
        name=name,
        alt=". ".join(_seen(panel) for panel in panels),
        caption=f"{panels[0].figure}: {titles}.",
    )


def _fill(axes: "Axes", panel: Panel, narrow: bool) -> None:
    for number, one in enumerate(panel.curves):
        style = _STYLES[number % len(_STYLES)] if len(panel.curves) > 2 else "-"
        marks = "o" if len(one.x) < 12 else ""
        axes.plot(
            one.x,
            one.y,
            linestyle="" if marks else style,
            marker=marks,
            markersize=4,
            color=_COLOURS[number % len(_COLOURS)],
            linewidth=1.2,
            label=one.name,
        )
    axes.set_xlabel(panel.x)
    axes.set_ylabel(panel.y)
    if panel.log_x:
        axes.set_xlim(*_limits([value for one in panel.curves for value in one.x]))
        log_axis(axes, "x", 250.0 if narrow else 600.0)
    if panel.log_y:
        axes.set_ylim(*_limits([value for one in panel.curves for value in one.y]))
        log_axis(axes, "y", HEIGHT - 60.0)
    if len(panel.curves) > 1:
        axes.legend(fontsize=SMALL - 1.0, frameon=False, ncols=1 if narrow else 2, loc="best")


def _limits(values: list[float]) -> tuple[float, float]:
    """Ends of a logarithmic axis: what is positive, at most `DECADES`."""
    positive = [value for value in values if value > 0.0]
    high = max(positive)
    return max(min(positive), high * 10.0**-DECADES), high * 1.05


def _seen(panel: Panel) -> str:
    """The panel in words: its curves and where they run."""
    words = []
    for one in panel.curves:
        finite = [value for value in one.y if value == value]
        if finite:
            words.append(f"{one.name} from {min(finite):.3g} to {max(finite):.3g}")
    return f"{panel.y} over {panel.x}: {', '.join(words)}"
