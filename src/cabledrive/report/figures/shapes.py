"""Mode shapes along the unrolled machine: drive pulley, upper span, load pulley, lower span, drive pulley."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.modal import Mode
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.report.numbers import number
from cabledrive.report.picture import Picture, picture
from cabledrive.report.style import GREEN, INK, LINE, QUIET, SPAN_COLOURS, short_family

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POINTS = 121
_PANEL, _FOOT = 96.0, 24.0  # heights [px]


def unrolled(mode: Mode, drive: Drive) -> dict[str, tuple[Array, Array]]:
    """A mode shape along both spans, its largest displacement scaled to one; the first of a multiple mode.

    For each span: unstretched distance from the drive pulley along the unrolled cable, in spans (0 to 1 on
    the upper, 1 to 2 on the lower one), and displacement, positive in the direction of the span; shape (p,)
    each.
    """
    positions = {span: _positions(drive, span) for span in drive.spans}
    shapes = {span: mode.shape(span, at)[0] for span, at in positions.items()}
    values = np.concatenate(list(shapes.values()))
    size = np.max(np.abs(values))
    largest = size * np.sign(values[np.argmax(np.abs(values) > (1 - 1e-9) * size)])
    return {
        span: (start + positions[span] / drive.span_length, shapes[span] / largest)
        for start, span in enumerate(drive.spans)
    }


def _positions(drive: Drive, span: str) -> Array:
    """Evenly spread, and exactly at every carriage, where a shape has its kinks."""
    carried = [carriage.position for carriage in drive.carriages_on(span)]
    return np.unique(np.concatenate((np.linspace(0.0, drive.span_length, POINTS), carried)))


def shapes_picture(name: str, drive: Drive, modes: Sequence[Mode]) -> Picture:
    """Draw mode shapes, one panel each, with the pulleys' rims and the carriages marked on them."""

    def _draw(figure: "Figure", narrow: bool) -> None:
        columns = 1 if narrow else 2
        rows = -(-len(modes) // columns)
        height = _PANEL * rows + _FOOT
        sides = {"left": 0.02, "right": 0.98, "bottom": _FOOT / height, "top": 1.0 - 18.0 / height}
        figure.set_layout_engine("none")  # equal panels: nothing to negotiate
        grid = figure.subplots(
            rows, columns, squeeze=False, gridspec_kw={**sides, "wspace": 0.06, "hspace": 0.3}
        )
        for panel, axes in enumerate(grid.flat):
            if panel < len(modes):
                _draw_shape(axes, modes[panel], drive)
            else:
                axes.set_visible(False)
            if panel + columns >= len(modes):
                _name_places(axes, drive)

    rows = -(-len(modes) // 2)
    return picture(name, _draw, wide=_PANEL * rows + _FOOT, narrow=_PANEL * len(modes) + _FOOT)


def _draw_shape(axes: "Axes", mode: Mode, drive: Drive) -> None:
    axes.vlines(range(1 + len(drive.spans)), -1.15, 1.15, color=LINE, linewidth=1.0)
    axes.hlines(0.0, 0.0, len(drive.spans), color=LINE, linewidth=1.0)
    for start, (span, (x, u)) in enumerate(unrolled(mode, drive).items()):
        axes.fill_between(x, u, color=SPAN_COLOURS[span], alpha=0.10, linewidth=0)
        axes.plot(x, u, color=SPAN_COLOURS[span])
        places = np.array([start + c.position / drive.span_length for c in drive.carriages_on(span)])
        size = 5.0 if places.size <= 4 else 3.0 if places.size <= 80 else 0.0
        axes.plot(places, np.interp(places, x, u), "s", color=GREEN, markersize=size, linestyle="none")
        axes.plot(x[[0, -1]], u[[0, -1]], "o", color=INK, markersize=5.5, linestyle="none")
    axes.set_title(_title(mode))
    axes.set_ylim(-1.25, 1.25)
    axes.set_xlim(-0.06, len(drive.spans) + 0.06)
    axes.set_axis_off()


def _title(mode: Mode) -> str:
    times = f" ×{mode.multiplicity}" if mode.multiplicity > 1 else ""
    what = f"along, {short_family(mode.family)}" if mode.span is None else f"across, {mode.span} span"
    return f"{number(mode.frequency, 5)} Hz{times}, {what}"


def _name_places(axes: "Axes", drive: Drive) -> None:
    below: dict[str, Any] = {"va": "top", "transform": axes.get_xaxis_transform(), "fontsize": 11}
    for place in range(1 + len(drive.spans)):
        axes.text(place, 0.0, "load" if place == 1 else "drive", ha="center", color=QUIET, **below)
    for place, span in enumerate(drive.spans):
        axes.text(place + 0.5, 0.0, span, ha="center", color=SPAN_COLOURS[span], **below)
