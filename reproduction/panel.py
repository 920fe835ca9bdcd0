"""Curves of a figure: few enough points for a page, drawn one pair of axes under the other."""

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.report.blocks import Figure
from cabledrive.report.picture import SMALL, Hue, log_axis, picture

MOST_POINTS, DIGITS = 400, 6
HEIGHT, EXTRA, DECADES = 190.0, 40.0, 6
_COLOURS, _STYLES = (Hue.BLUE, Hue.ORANGE, Hue.GREEN, Hue.PURPLE, Hue.RED, Hue.INK), ("-", "--", "-.", ":")


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """One pair of axes; null where a curve is broken."""

    figure: str  # such as "Fig. 3.1"
    title: str  # what is shown, and what was chosen where the print is silent
    x: str  # axis with unit
    y: str
    curves: tuple[dict[str, Any], ...]  # name, x, y
    log_x: bool
    log_y: bool


def panel(
    figure: str, title: str, axes: str, *curves: tuple[str, ArrayLike, ArrayLike], log: str = ""
) -> Panel:
    """A panel of curves (name, x, y); `axes` in words, "time [s] | angle [deg]"; `log`: "x", "y", "xy"."""
    x, y = axes.split(" | ")
    kept = tuple(_curve(*one) for one in curves)
    return Panel(figure=figure, title=title, x=x, y=y, curves=kept, log_x="x" in log, log_y="y" in log)


def _curve(name: str, x: ArrayLike, y: ArrayLike) -> dict[str, Any]:
    """At most `MOST_POINTS` points; of more, smallest and largest of each stretch."""
    across, up = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if across.size > MOST_POINTS:
        edges = np.linspace(0, across.size, MOST_POINTS // 2 + 1).astype(int)
        kept: list[int] = []
        for first, last in itertools.pairwise(edges):
            part = up[first:last]
            if np.all(np.isfinite(part)):
                kept += sorted({first + int(np.argmin(part)), first + int(np.argmax(part))})
            else:
                kept.append(first)
        across, up = across[kept], up[kept]
    return {"name": name, "x": _rounded(across), "y": _rounded(up)}


def _rounded(values: np.ndarray) -> list[float | None]:
    return [float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None for value in values]


def panels_figure(name: str, panels: tuple[Panel, ...]) -> Figure:
    """Panels of one figure as a figure of the page; `name` is unique there."""

    def draw(drawing: Any) -> None:
        rows = drawing.subplots(len(panels), 1, squeeze=False)[:, 0]
        for axes, one in zip(rows, panels, strict=True):
            _fill(axes, one)

    height = HEIGHT * len(panels) + EXTRA
    titles = "; ".join(dict.fromkeys(one.title for one in panels))
    return Figure(
        name=name,
        alt=". ".join(_seen(one) for one in panels),
        caption=f"{panels[0].figure}: {titles}.",
        drawing=picture(name, draw, height=height),
    )


def _fill(axes: Any, panel: Panel) -> None:
    for number, one in enumerate(panel.curves):
        few, style = len(one["x"]) < 12, _STYLES[number % len(_STYLES)] if len(panel.curves) > 2 else "-"
        x, y = (np.array(one[axis], dtype=float) for axis in "xy")
        look: dict[str, Any] = (
            {"marker": "o", "linestyle": "", "markersize": 4} if few else {"linestyle": style}
        )
        axes.plot(x, y, color=_COLOURS[number % len(_COLOURS)], label=one["name"], linewidth=1.2, **look)
    axes.set(xlabel=panel.x, ylabel=panel.y)
    for axis, asked, size in (("x", panel.log_x, 600.0), ("y", panel.log_y, HEIGHT - 60.0)):
        if asked:
            axes.set(**{f"{axis}lim": _limits(panel, axis)})
            log_axis(axes, axis, size)
    if len(panel.curves) > 1:
        axes.legend(fontsize=SMALL - 1.0, frameon=False, ncols=2, loc="best")


def _finite(values: Iterable[float | None]) -> list[float]:
    return [value for value in values if value is not None]


def _limits(panel: Panel, axis: str) -> tuple[float, float]:
    """Ends of a logarithmic axis: what is positive, at most `DECADES`."""
    positive = [value for one in panel.curves for value in _finite(one[axis]) if value > 0.0]
    high = max(positive)
    return max(min(positive), high * 10.0**-DECADES), high * 1.05


def _seen(panel: Panel) -> str:
    """The panel in words: its curves and where they run."""
    ranges = [(one["name"], _finite(one["y"])) for one in panel.curves]
    words = [f"{name} from {min(y):.3g} to {max(y):.3g}" for name, y in ranges if y]
    return f"{panel.y} over {panel.x}: {', '.join(words)}"
