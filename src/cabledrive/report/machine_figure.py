"""A machine drawn to scale from its coordinates: pulleys, spans, anchors, bodies, carriages, motors."""

from math import atan2, degrees
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.parameters import Machine
from cabledrive.parameters.route.geometry import FreeSpan
from cabledrive.report.figures.moving_machine import coordinates
from cabledrive.report.figures.sheet import body_points, neighbours
from cabledrive.report.picture import file_figure, file_picture, label

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_COLOURS = ("#1f5fa8", "#c8641b", "#2f7d4f", "#8a3f8f", "#8c6d1f", "#555555")
_INK, _BODY = "#222222", "#dfe6ee"
SIZE = (8.0, 6.0)  # inch


def machine_drawing(drive: Machine, form: str) -> bytes:
    """The drawing as the content of a file; ``form``, {"svg", "png", "pdf"}."""
    machine = coordinates(drive)
    return file_picture(file_figure(lambda figure: _draw(figure.add_subplot(), machine), SIZE), form)


def _draw(axes: "Axes", drive: Machine) -> None:
    """A machine to scale, each rope in its colour with an arrow along its path."""
    from matplotlib.patches import Circle

    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.08)
    axes.set(xlabel="x [m]", ylabel="y [m]")
    axes.set_title(drive.title or drive.name, wrap=True)
    for number, body in enumerate(drive.body):
        band = np.array(body_points(drive, number))
        axes.plot(*band.T, color=_BODY, linewidth=9, solid_capstyle="round", zorder=1)
        label(axes, body.name, body.at, (4, -9), fontsize=7, style="italic", zorder=7)
    for index, span in enumerate(drive.free_spans):
        _draw_span(axes, span, _COLOURS[span.route % len(_COLOURS)])
        for (own, place), carriage in zip(drive.carriage_places, drive.carriage, strict=True):
            if own == index:
                (x, y), _ = span.contacts
                at = x + place * span.along[0], y + place * span.along[1]
                axes.plot(*at, "s" if carriage.guided else "v", color=_INK, markersize=6, zorder=5)
    for here, after in neighbours(drive):
        _draw_arc(axes, here, after, _COLOURS[here.route % len(_COLOURS)])
    for number, pulley in enumerate(drive.pulley):
        motor, (x, y) = number in drive.driven, pulley.at
        looks: dict[str, Any] = {"facecolor": "#bbbbbb", "edgecolor": _INK, "linewidth": 0.8, "zorder": 2}
        axes.add_patch(Circle((x, y), pulley.radius, fill=pulley.fixed, **looks))
        axes.plot(x, y, "x" if motor else "+", color=_INK, markersize=5, zorder=5)
        words = f"{pulley.name} (motor)" if motor else pulley.name
        label(axes, words, (x, y + pulley.radius), (0, 3), fontsize=6, ha="center", zorder=7)
    for anchor in drive.anchor:
        axes.plot(*anchor.at, "o", color=_INK, markersize=4, zorder=6)


def _draw_span(axes: "Axes", span: FreeSpan, colour: str) -> None:
    (x1, y1), (x2, y2) = span.contacts
    axes.plot([x1, x2], [y1, y2], color=colour, linewidth=1.6, zorder=3)
    middle = 0.5 * (x1 + x2), 0.5 * (y1 + y2)
    ahead = middle[0] + 1e-3 * (x2 - x1), middle[1] + 1e-3 * (y2 - y1)
    axes.annotate("", xy=ahead, xytext=middle, arrowprops={"arrowstyle": "-|>", "color": colour}, zorder=4)


def _draw_arc(axes: "Axes", here: FreeSpan, after: FreeSpan, colour: str) -> None:
    """The rope on a pulley, from where it arrives to where it leaves."""
    place = here.end
    start, end = (
        degrees(atan2(point[1] - place.centre[1], point[0] - place.centre[0]))
        for point in (here.contacts[1], after.contacts[0])
    )
    if place.sense < 0:
        start, end = end, start
    turned = np.radians(np.linspace(start, start + (end - start) % 360.0, 60))
    x = place.centre[0] + place.radius * np.cos(turned)
    y = place.centre[1] + place.radius * np.sin(turned)
    axes.plot(x, y, color=colour, linewidth=1.6, zorder=3)
