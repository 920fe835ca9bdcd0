"""Mode shapes along the unrolled ropes of a machine."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from cabledrive.answers.figures import number
from cabledrive.modal import Mode
from cabledrive.parameters import Machine
from cabledrive.parameters.arrays import Array
from cabledrive.report.picture import Hue, picture, text_width

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


POINTS, FEWEST = 240, 13
"""Along all ropes, shared by length, and of a short piece at least."""
_PANEL, _FOOT = 96.0, 16.0  # heights [px]
_WIDTH = 320.0  # of a panel [px]
_GAP = 0.06
"""Between two ropes, of the length of all."""
_COLOURS = (Hue.BLUE, Hue.ORANGE)
"""Of neighbouring spans."""
FEW, MANY = 4, 80
"""Marks up to which they are large, and beyond which there are none."""


def unrolled(mode: Mode) -> dict[str, tuple[Array, Array]]:
    """A mode shape along each span, its largest displacement scaled to one; the first of a multiple mode.

    Positions from where the span starts [m], at every carriage, too, where a shape has its kinks, and
    displacements, positive in the direction of the span; shape (p,) each.
    """
    positions, pieces = dict[str, Array](), mode.network.pieces
    whole = sum(piece.end - piece.start for piece in pieces)
    for piece in pieces:
        number = max(FEWEST, round(POINTS * (piece.end - piece.start) / whole) + 1)
        even = np.linspace(piece.start, piece.end, number)
        positions[piece.span] = np.append(positions.get(piece.span, even[:0]), even)
    shapes = {span: np.real(mode.shape(span, at)[0]) for span, at in positions.items()}
    values = np.concatenate(list(shapes.values()))
    size = np.max(np.abs(values))
    largest = size * np.sign(values[np.argmax(np.abs(values) > (1 - 1e-9) * size)])
    return {span: (at, shapes[span] / largest) for span, at in positions.items()}


def shapes_picture(name: str, drive: Machine, modes: Sequence[Mode]) -> Markup:
    """Draw modes, one panel each; ``name``: unique on the page."""
    rows = -(-len(modes) // 2)

    def _draw(figure: "Figure") -> None:
        for place, mode in enumerate(modes):
            axes = figure.add_subplot(rows, 2, place + 1)
            draw_mode(axes, drive, mode, last=place + 2 >= len(modes))

    return picture(name, _draw, height=_PANEL * rows + _FOOT)


def draw_mode(axes: "Axes", machine: Machine, mode: Mode, *, last: bool = False) -> None:
    """One mode along the unrolled ropes, one behind the other; the last panel names the places."""
    shapes = unrolled(mode)
    whole = sum(float(at[-1]) for at, _ in shapes.values())
    carried = sorted({(p.span, p.start) for p in mode.network.pieces if p.start > 0.0})
    sizes = [5.0 if many <= FEW else 3.0 if many <= MANY else 0.0 for many in (len(carried), len(shapes))]
    start, places, ropes = 0.0, list[tuple[float, str]](), dict[int, tuple[float, float]]()
    spans = list[tuple[float, float, str, str]]()
    for place, (span, (name, (at, u))) in enumerate(zip(machine.free_spans, shapes.items(), strict=True)):
        if place and span.route not in ropes:
            start += _GAP * whole
        x, colour = (start + at) / whole, _COLOURS[place % len(_COLOURS)]
        axes.vlines(x[[0, -1]], -1.15, 1.15, color=Hue.LINE, linewidth=1.0)
        axes.hlines(0.0, x[0], x[-1], color=Hue.LINE, linewidth=1.0)
        axes.fill_between(x, u, color=colour, alpha=0.10, linewidth=0)
        axes.plot(x, u, color=colour)
        on = np.array([position for own, position in carried if own == name])
        looks: dict[str, Any] = {"markersize": sizes[0], "linestyle": "none"}
        axes.plot((start + on) / whole, np.interp(on, at, u), "s", color=Hue.GREEN, **looks)
        axes.plot(x[[0, -1]], u[[0, -1]], "o", color=Hue.INK, markersize=sizes[1], linestyle="none")
        start += float(at[-1])
        places += [(float(x[0]), span.start.name), (float(x[-1]), span.end.name)]
        ropes[span.route] = ropes.get(span.route, (float(x[0]), 0.0))[0], float(x[-1])
        spans.append((float(x[0]), float(x[-1]), name, colour))
    end = start / whole
    axes.set(title=mode_title(mode), ylim=(-1.25, 1.25), xlim=(-0.03 * end, 1.03 * end))
    axes.set_axis_off()
    if last:
        _name_places(
            axes, places, spans, [(machine.route[route].name, ends) for route, ends in ropes.items()]
        )


def _name_places(
    axes: "Axes",
    places: list[tuple[float, str]],
    spans: list[tuple[float, float, str, str]],
    ropes: list[tuple[str, tuple[float, float]]],
) -> None:
    """Names below the last panel: of pulleys, anchors and spans where there is room, else of the ropes."""
    below: dict[str, Any] = {
        "va": "top",
        "ha": "center",
        "transform": axes.get_xaxis_transform(),
        "fontsize": 11,
    }
    named = {at: name.removesuffix(" pulley") for at, name in places}
    if sum(map(text_width, named.values())) > _WIDTH:
        for name, ends in ropes:
            axes.text(sum(ends) / 2.0, 0.0, name, color=Hue.QUIET, **below)
        return
    for at, name in named.items():
        axes.text(at, 0.0, name, color=Hue.QUIET, **below)
    room = _WIDTH - sum(map(text_width, named.values()))
    for first, last, name, colour in spans if sum(text_width(own[2]) for own in spans) < room else ():
        axes.text(0.5 * (first + last), 0.0, name, color=colour, **below)


def mode_title(mode: Mode) -> str:
    """Frequency, multiplicity and what moves."""
    times = f" ×{mode.multiplicity}" if mode.multiplicity > 1 else ""
    if mode.span is None:
        return f"{number(mode.frequency, 5)} Hz{times}, along: {mode.family}"
    plane = "out of plane" if mode.plane == "v" else "across"
    return f"{number(mode.frequency, 5)} Hz{times}, {plane}: {mode.span}"
