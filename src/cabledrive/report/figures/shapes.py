"""Mode shapes along the unrolled machine, and drawn on a machine with routes."""

from collections.abc import Sequence
from math import cos, sin
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from cabledrive.answers.figures import number
from cabledrive.modal import Mode
from cabledrive.modal.mode import TRANSVERSE
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route import Machine, RoutedDrive
from cabledrive.report.figures.sheet import drawn_machine
from cabledrive.report.picture import SPAN_COLOURS, Hue, picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


POINTS = 121
_PANEL, _FOOT = {False: 96.0, True: 210.0}, 16.0  # heights [px]


def unrolled(mode: Mode, drive: Drive) -> dict[str, tuple[Array, Array]]:
    """A mode shape along both spans, its largest displacement scaled to one; the first of a multiple mode.

    For each span: unstretched distance from the drive pulley along the unrolled cable, in spans (0 to 1 on
    the upper, 1 to 2 on the lower one), and displacement, positive in the direction of the span; shape (p,)
    each.
    """
    even, positions = np.linspace(0.0, drive.span_length, POINTS), {}
    for span in drive.spans:  # also exactly at every carriage, where a shape has its kinks
        carried = [carriage.position for carriage in drive.carriages_on(span)]
        positions[span] = np.unique(np.concatenate((even, carried)))
    shapes = {span: mode.shape(span, at)[0] for span, at in positions.items()}
    values = np.concatenate(list(shapes.values()))
    size = np.max(np.abs(values))
    largest = size * np.sign(values[np.argmax(np.abs(values) > (1 - 1e-9) * size)])
    return {
        span: (start + positions[span] / drive.span_length, shapes[span] / largest)
        for start, span in enumerate(drive.spans)
    }


def shapes_picture(name: str, drive: Machine, modes: Sequence[Mode]) -> Markup:
    """Draw modes, one panel each; ``name``: unique on the page."""
    rows = -(-len(modes) // 2)

    def _draw(figure: "Figure") -> None:
        for place, mode in enumerate(modes):
            axes = figure.add_subplot(rows, 2, place + 1)
            draw_mode(axes, drive, mode, last=place + 2 >= len(modes))

    return picture(name, _draw, height=_PANEL[drive.kind == "route"] * rows + _FOOT)


def _draw_shape(axes: "Axes", mode: Mode, drive: Drive) -> None:
    axes.vlines(range(1 + len(drive.spans)), -1.15, 1.15, color=Hue.LINE, linewidth=1.0)
    axes.hlines(0.0, 0.0, len(drive.spans), color=Hue.LINE, linewidth=1.0)
    for start, (span, (x, u)) in enumerate(unrolled(mode, drive).items()):
        axes.fill_between(x, u, color=SPAN_COLOURS[span], alpha=0.10, linewidth=0)
        axes.plot(x, u, color=SPAN_COLOURS[span])
        places = np.array([start + c.position / drive.span_length for c in drive.carriages_on(span)])
        size = 5.0 if places.size <= 4 else 3.0 if places.size <= 80 else 0.0
        axes.plot(places, np.interp(places, x, u), "s", color=Hue.GREEN, markersize=size, linestyle="none")
        axes.plot(x[[0, -1]], u[[0, -1]], "o", color=Hue.INK, markersize=5.5, linestyle="none")
    axes.set(title=mode_title(mode), ylim=(-1.25, 1.25), xlim=(-0.06, len(drive.spans) + 0.06))
    axes.set_axis_off()


def _name_places(axes: "Axes", drive: Drive) -> None:
    """Names of pulleys and spans below a panel of the unrolled cable."""
    below: dict[str, Any] = {"va": "top", "transform": axes.get_xaxis_transform(), "fontsize": 11}
    for place in range(1 + len(drive.spans)):
        axes.text(place, 0.0, "load" if place == 1 else "drive", ha="center", color=Hue.QUIET, **below)
    for place, span in enumerate(drive.spans):
        axes.text(place + 0.5, 0.0, span, ha="center", color=SPAN_COLOURS[span], **below)


SIZE = 0.08
"""Largest displacement as drawn, of the machine's larger side."""
DOTS = 9
"""Of a span as long as the machine."""
TURN = 0.6
"""Largest turn of a pulley as drawn [rad]."""
MOVES = {"x": (1.0, 0.0), "y": (0.0, 1.0)}


def draw_mode(axes: "Axes", drive: Machine, mode: Mode, *, last: bool = False) -> None:
    """One mode: at rest, or along the unrolled cable of a loop or line, whose last panel names the places."""
    if isinstance(drive, RoutedDrive):
        _draw_on_machine(axes, drive, mode)
    else:
        _draw_shape(axes, mode, drive)
        if last:
            _name_places(axes, drive)


def _draw_on_machine(axes: "Axes", drive: RoutedDrive, mode: Mode) -> None:
    """Displacements of transverse modes across the spans; a longitudinal one moves dots along them."""
    across = mode.kind == TRANSVERSE
    colour = Hue.ORANGE if across else Hue.BLUE
    places = [np.linspace(0.0, span.length, POINTS) for span in drive.free_spans]
    shapes = [
        np.real(mode.shape(span.name, at)[0]) for span, at in zip(drive.free_spans, places, strict=True)
    ]
    drive, axis, factor = drawn_machine(drive)
    largest = max(float(np.abs(shape).max()) for shape in shapes) or 1.0
    size = SIZE * machine_size(drive) / largest
    for span, shape in zip(drive.free_spans, shapes, strict=True):
        ends = np.array(span.contacts)
        axes.plot(*ends.T, color=Hue.LINE, linewidth=1.0, zorder=1)
        if not across:
            _draw_along(axes, ends, size * shape / span.length, machine_size(drive) / span.length)
            continue
        line = ends[0] + np.outer(np.linspace(0.0, 1.0, POINTS), ends[1] - ends[0])
        normal = np.array((-span.along[1], span.along[0]))
        moved = line + size * np.outer(shape, normal)
        axes.plot(*moved.T, color=colour, linewidth=1.5, zorder=3)
    _draw_pulleys(axes, drive, mode, colour)
    _draw_bodies(axes, drive, mode)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.04)
    axes.set_axis_off()
    axes.set_title(mode_title(mode) + (f"; {axis} × {factor:.3g}" if axis else ""))


def _draw_along(axes: "Axes", ends: Array, shape: Array, shorter: float) -> None:
    """Dots of a span, evenly spaced at rest, where its motion along takes them, each with its way.

    ``shape``, shape (POINTS,), over the length; ``shorter``: the machine's side over it.
    """
    rest = (np.arange(count := max(2, round(DOTS / shorter))) + 0.5) / count
    moved = np.clip(rest + np.interp(rest, np.linspace(0.0, 1.0, POINTS), shape), 0.0, 1.0)
    first, way = ends[0], ends[1] - ends[0]
    for start, end in zip(rest, moved, strict=True):
        axes.plot(*(first + np.outer((start, end), way)).T, color=Hue.BLUE, linewidth=2.2, zorder=2)
    axes.plot(*(first + np.outer(moved, way)).T, "o", color=Hue.BLUE, markersize=3.0, zorder=3)


def mode_title(mode: Mode) -> str:
    """Frequency, multiplicity and what moves."""
    times = f" ×{mode.multiplicity}" if mode.multiplicity > 1 else ""
    if mode.span is None:
        return f"{number(mode.frequency, 5)} Hz{times}, along: {mode.family}"
    plane = "out of plane" if mode.plane == "v" else "across"
    return f"{number(mode.frequency, 5)} Hz{times}, {plane}: {mode.span}"


def machine_size(drive: RoutedDrive) -> float:
    """Larger side of the box round all contacts [m]."""
    points = np.array([end for span in drive.free_spans for end in span.contacts])
    return float(np.ptp(points, axis=0).max())


def _joint(mode: Mode, name: str) -> float:
    values = mode.joints.get(name)
    return 0.0 if values is None else float(np.real(values[0]))


def _draw_pulleys(axes: "Axes", drive: RoutedDrive, mode: Mode, colour: str) -> None:
    """Circles with a radius at rest and, where the pulley turns, one turned."""
    from matplotlib.patches import Circle

    turns = [_joint(mode, pulley.name) for pulley in drive.pulley]
    rims = [abs(turn * p.radius) for turn, p in zip(turns, drive.pulley, strict=True)]
    most = max(rims, default=0.0) or 1.0
    for pulley, turn, rim in zip(drive.pulley, turns, rims, strict=True):
        looks: dict[str, Any] = {"edgecolor": Hue.QUIET, "linewidth": 0.8, "zorder": 2}
        axes.add_patch(Circle(pulley.at, pulley.radius, fill=False, **looks))
        for angle, drawn in ((0.0, Hue.QUIET), (TURN * float(np.sign(turn)) * rim / most, colour)):
            tip = pulley.at[0] + pulley.radius * sin(-angle), pulley.at[1] + pulley.radius * cos(angle)
            axes.plot((pulley.at[0], tip[0]), (pulley.at[1], tip[1]), color=drawn, linewidth=0.9, zorder=2)


def _draw_bodies(axes: "Axes", drive: RoutedDrive, mode: Mode) -> None:
    """A square at each body, with an arrow where it slides and a ring where it turns."""
    moves = {
        (body.name, move): _joint(mode, f"{body.name}.{move}") for body in drive.body for move in body.moves
    }
    most = max((abs(value) for (_, move), value in moves.items() if move in MOVES), default=0.0) or 1.0
    length = 1.5 * SIZE * machine_size(drive)
    for place, body in enumerate(drive.body):
        turning = any(moves[body.name, move] for move in body.moves if move not in MOVES)
        looks: dict[str, Any] = {"color": Hue.GREEN, "markersize": 9 if turning else 5, "zorder": 4}
        axes.plot(*body.at, "o" if turning else "s", fillstyle="none" if turning else "full", **looks)
        for move in body.moves:
            share = moves[body.name, move] / most
            if move not in MOVES or abs(share) < 0.02:
                continue
            way = MOVES[move]
            tip = body.at[0] + length * share * way[0], body.at[1] + length * share * way[1]
            arrow = {"arrowstyle": "-|>", "color": Hue.GREEN, "shrinkA": 0, "shrinkB": 0}
            axes.annotate("", xy=tip, xytext=body.at, arrowprops=arrow, zorder=4, annotation_clip=False)
        if len(drive.body) <= 4:
            beside = (5, 5 - 18 * (place % 2))  # neighbours apart
            axes.annotate(body.name, body.at, beside, textcoords="offset points", fontsize=10, color=Hue.INK)
