"""The loop in motion: frames of a run as a GIF, and as an SVG that plays on a page without a script.

Deflections across the cable and turns of the pulleys are drawn larger than they are, by factors that are
said; the spokes turn with the pulleys, clockwise where the cable of the upper span moves to the right.
"""

from dataclasses import dataclass
from io import BytesIO
from math import cos, hypot, sin
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters import Drive
from cabledrive.report.figures.machine_layout import MachineLayout, machine_layout
from cabledrive.report.figures.run_fields import span_field
from cabledrive.report.figures.sheet import Point, Sheet
from cabledrive.report.numbers import number
from cabledrive.report.style import INK, NARROW, PAPER, QUIET, SPAN_COLOURS, WIDE, house_style, theme_css
from cabledrive.simulation import SimulationResult

if TYPE_CHECKING:
    from PIL.Image import Image

MOST_FRAMES = 72
SECONDS_PER_FRAME = 1.0 / 16.0
POINTS = 41
_DEFLECTION, _TURN, _LARGEST_FACTOR = 26.0, 0.6, 1e6  # px, rad
_FIRST_LINE = 18.0  # px
_COLOURS = 32


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Motion:
    """Frames of a run.

    Attributes
    ----------
    time : ndarray, shape (frames,)
        [s].
    place : ndarray, shape (points,)
        Shares of the span, from the pulley where it starts.
    across : dict of str to ndarray, shape (frames, points)
        Displacement w of each span, outwards [m].
    angles : ndarray, shape (frames, 2)
        Of drive and load pulley [rad].
    """

    time: Array
    place: Array
    across: dict[str, Array]
    angles: Array


def motion_of(result: SimulationResult, most: int = MOST_FRAMES) -> Motion:
    """Frames from the whole fields of a run, every field up to the largest number of frames.

    Parameters
    ----------
    result : SimulationResult
        With whole fields, close enough in time to follow the motion.
    most : int, default 72
        Largest number of frames; what comes later is left out.

    Returns
    -------
    Motion

    Raises
    ------
    InputRefused
        If the run kept less than two whole fields.
    """
    place = np.linspace(0.0, 1.0, POINTS)
    across = {}
    for row, span in enumerate(result.spans):
        at = result.position[row] / result.position[row, -1]
        across[span] = np.array([np.interp(place, at, field) for field in span_field(result, span)[:most]])
    time = result.field_time[:most]
    angles = [np.interp(time, result.time, angle) for angle in (result.drive_angle, result.load_angle)]
    return Motion(time=time, place=place, across=across, angles=np.column_stack(angles))


def frame_interval(drive: Drive) -> float:
    """Time between frames that shows the lowest transverse mode in eighteen pictures.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    float
        [s].
    """
    speed = (drive.cable.pretension / drive.cable.stretched_mass_per_length) ** 0.5
    return 2.0 * drive.pulley_distance / speed / 18.0


def animation_gif(drive: Drive, result: SimulationResult, width: int = 560) -> bytes:
    """The loop in motion as the content of a GIF that plays for ever.

    Parameters
    ----------
    drive : Drive
        The one of the run.
    result : SimulationResult
        With whole fields.
    width : int, default 560
        [px].

    Returns
    -------
    bytes

    Raises
    ------
    InputRefused
        If the run kept less than two whole fields.
    """
    motion = motion_of(result)
    frames = _painted(drive, motion, width)
    palette = frames[len(frames) // 4].quantize(_COLOURS)
    reduced = [frame.quantize(palette=palette, dither=0) for frame in frames]
    with BytesIO() as file:
        reduced[0].save(
            file,
            "GIF",
            save_all=True,
            append_images=reduced[1:],
            duration=round(1000 * SECONDS_PER_FRAME / 10) * 10,
            loop=0,
            optimize=True,
        )
        return file.getvalue()


def animation_svg(name: str, drive: Drive, result: SimulationResult) -> tuple[Markup, Markup, Markup]:
    """The loop in motion for a page: a switch, and the drawing for wide and for narrow pages.

    The switch pauses both drawings and stands before them, all three beside one another in one element.
    Whoever asks for less motion gets a drawing at rest, and starts it with the switch.

    Parameters
    ----------
    name : str
        Unique on the page.
    drive : Drive
        The one of the run.
    result : SimulationResult
        With whole fields.

    Returns
    -------
    switch, wide, narrow : Markup

    Raises
    ------
    InputRefused
        If the run kept less than two whole fields.
    """
    motion = motion_of(result)
    drawings = [_moving_svg(name, drive, motion, width, width == NARROW) for width in (WIDE, NARROW)]
    return _switch(name, motion.time.size), drawings[0], drawings[1]


def animation_page(drive: Drive, result: SimulationResult) -> str:
    """The loop in motion as a page of its own, which needs no other file.

    Parameters
    ----------
    drive : Drive
        The one of the run.
    result : SimulationResult
        With whole fields.

    Returns
    -------
    str
        HTML.

    Raises
    ------
    InputRefused
        If the run kept less than two whole fields.
    """
    switch, wide, _ = animation_svg("loop", drive, result)
    frame = Markup(
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        "<title>{title}</title>\n<style>{css}\nbody {{ margin: 2rem auto; max-width: 47rem; padding: 0 1rem; "
        "--sans: system-ui, sans-serif; font: 1rem/1.5 var(--sans); background: var(--paper); "
        'color: var(--ink); }}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n<figure style="margin: 0">'
        '\n{switch}\n<div class="drawing" role="img" aria-label="{alt}">{wide}</div>\n'
        "</figure>\n</main>\n</body>\n</html>\n"
    )
    return str(
        frame.format(
            title=drive.title or drive.name,
            css=Markup(theme_css()),
            switch=switch,
            wide=wide,
            alt="The cable loop in motion: both spans swing, the pulleys turn to and fro.",
        )
    )


def _factors(motion: Motion) -> tuple[float, float]:
    """How many pixels a metre of deflection has, and how many times too far the pulleys turn."""
    deflection = max(float(np.max(np.abs(field))) for field in motion.across.values())
    turn = float(np.max(np.abs(motion.angles - motion.angles[:1])))
    return (
        _DEFLECTION / deflection if deflection > 0.0 else 0.0,
        _two_digits(min(_TURN / turn, _LARGEST_FACTOR)) if turn > _TURN / _LARGEST_FACTOR else 1.0,
    )


def _two_digits(value: float) -> float:
    return float(f"{value:.1e}")


def _words(layout: MachineLayout, drive: Drive, motion: Motion) -> str:
    """What is drawn too large, and how slow it plays."""
    pixels, turn = _factors(motion)
    distance = hypot(layout.load[0] - layout.drive[0], layout.load[1] - layout.drive[1])
    larger = pixels * drive.pulley_distance / distance
    slower = SECONDS_PER_FRAME / float(motion.time[1] - motion.time[0])
    return f"w × {number(larger, 2)}, angles × {number(turn, 2)}, {number(slower, 2)} times slower"


def _curve(layout: MachineLayout, motion: Motion, span: str, frame: int) -> list[Point]:
    """A span as drawn in a frame; w points out of the loop."""
    pixels, _ = _factors(motion)
    side = 1.0 if span == "upper" else -1.0
    return [
        layout.off(layout.on_span(span, float(share)), 0.0, side * pixels * float(w))
        for share, w in zip(motion.place, motion.across[span][frame], strict=True)
    ]


def _spokes(layout: MachineLayout, motion: Motion, frame: int) -> list[tuple[Point, Point]]:
    """A diameter of each pulley as drawn in a frame, upright at the start."""
    _, larger = _factors(motion)
    spokes = []
    turned = larger * (motion.angles[frame] - motion.angles[0])
    for axle, radius, angle in zip((layout.drive, layout.load), layout.radii, turned, strict=True):
        along, across = radius * sin(angle), radius * cos(angle)
        spokes.append((layout.off(axle, along, across), layout.off(axle, -along, -across)))
    return spokes


def _moving_svg(name: str, drive: Drive, motion: Motion, width: float, narrow: bool) -> Markup:
    layout = machine_layout(drive, width, narrow)
    still = Sheet()
    for axle, radius in zip((layout.drive, layout.load), layout.radii, strict=True):
        still.circle(axle, radius, colour="quiet")
    for span in motion.across:
        still.line(layout.on_span(span, 0.0), layout.on_span(span, 1.0), colour="line", dashes="4 4")
    still.words(_words(layout, drive, motion), (12.0, _FIRST_LINE), anchor="start", colour="quiet")
    period = motion.time.size * SECONDS_PER_FRAME
    groups = []
    for frame in range(motion.time.size):
        drawn = Sheet()
        for ends in _spokes(layout, motion, frame):
            drawn.line(*ends, colour="ink", width=2.0)
        drawn.words(
            f"{1e3 * (motion.time[frame] - motion.time[0]):.1f} ms",
            (layout.size[0] - 12.0, layout.size[1] - 10.0),
            anchor="end",
            colour="quiet",
        )
        for span in motion.across:
            colour = "blue" if span == "upper" else "orange"
            drawn.line(*_curve(layout, motion, span, frame), colour=colour, width=2.0)
        delay = (frame / motion.time.size - 1.0) * period
        inside = "\n".join(drawn.elements)
        groups.append(f'<g class="{name}-frame" style="animation-delay: {delay:.4f}s">{inside}</g>')
    still.elements.extend(groups)
    return still.svg(layout.size)


def _switch(name: str, frames: int) -> Markup:
    """Style and check box: ticked means paused, or playing where less motion is asked for."""
    share = 100.0 / frames
    period = frames * SECONDS_PER_FRAME
    return Markup(
        f"<style>\n@keyframes {name}-show {{ 0% {{ visibility: visible }} "
        f"{share:.5f}% {{ visibility: hidden }} 100% {{ visibility: hidden }} }}\n"
        f".{name}-frame {{ visibility: hidden; animation: {name}-show {period:.4f}s step-end infinite; }}\n"
        f"#{name}-switch {{ position: absolute; opacity: 0; }}\n"
        f"#{name}-switch + label {{ display: inline-block; cursor: pointer; border: 1px solid var(--line); "
        "border-radius: 4px; padding: 0.15rem 0.8rem; margin-bottom: 0.6rem; font-size: 0.9rem; }\n"
        f"#{name}-switch:focus-visible + label {{ outline: 2px solid var(--blue); outline-offset: 2px; }}\n"
        f"#{name}-switch + label::before {{ content: 'Pause'; }}\n"
        f"#{name}-switch:checked + label::before {{ content: 'Play'; }}\n"
        f"#{name}-switch:checked ~ .drawing .{name}-frame {{ animation-play-state: paused; }}\n"
        "@media (prefers-reduced-motion: reduce) {\n"
        f"#{name}-switch + label::before {{ content: 'Play'; }}\n"
        f"#{name}-switch:checked + label::before {{ content: 'Pause'; }}\n"
        f".{name}-frame {{ animation-play-state: paused; }}\n"
        f"#{name}-switch:checked ~ .drawing .{name}-frame {{ animation-play-state: running; }}\n}}\n"
        f"@media print {{ #{name}-switch + label {{ display: none; }} "
        f".{name}-frame {{ animation-play-state: paused; }} }}\n"
        f'</style>\n<input type="checkbox" id="{name}-switch" aria-label="Pause or play the animation">'
        f'<label for="{name}-switch"></label>'
    )


def _painted(drive: Drive, motion: Motion, width: int) -> "list[Image]":
    """Frames as pictures of colours."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Circle
    from PIL import Image

    layout = machine_layout(drive, width, False)
    with house_style():
        figure = Figure(figsize=(width / 72, layout.size[1] / 72), facecolor=PAPER)
        canvas = FigureCanvasAgg(figure)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set(xlim=(0.0, layout.size[0]), ylim=(layout.size[1], 0.0), aspect="equal")
        axes.set_axis_off()
        for axle, radius in zip((layout.drive, layout.load), layout.radii, strict=True):
            axes.add_patch(Circle(axle, radius, fill=False, edgecolor=QUIET, linewidth=1.2))
        axes.text(12.0, _FIRST_LINE, _words(layout, drive, motion), color=QUIET)
        clock = axes.text(layout.size[0] - 12.0, layout.size[1] - 10.0, "", color=QUIET, ha="right")
        spokes = [axes.plot([], [], color=INK, linewidth=2.0)[0] for _ in range(2)]
        cables = {span: axes.plot([], [], color=SPAN_COLOURS[span])[0] for span in motion.across}
        frames = []
        for frame in range(motion.time.size):
            for line, ends in zip(spokes, _spokes(layout, motion, frame), strict=True):
                line.set_data(*zip(*ends, strict=True))
            for span, cable in cables.items():
                cable.set_data(*zip(*_curve(layout, motion, span, frame), strict=True))
            clock.set_text(f"{1e3 * (motion.time[frame] - motion.time[0]):.1f} ms")
            canvas.draw()
            frames.append(Image.fromarray(np.asarray(canvas.buffer_rgba())[:, :, :3]))
    return frames
