"""The loop in motion as a GIF."""

from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.report.figures.machine_layout import machine_layout
from cabledrive.report.motion import (
    FIRST_LINE,
    SECONDS_PER_FRAME,
    Motion,
    motion_of,
    motion_words,
    span_curve,
    spokes,
)
from cabledrive.report.style import INK, PAPER, QUIET, SPAN_COLOURS, house_style
from cabledrive.simulation import SimulationResult

if TYPE_CHECKING:
    from PIL.Image import Image

_COLOURS = 32
_WIDTH = 560  # px


def animation_gif(drive: Drive, result: SimulationResult) -> bytes:
    """The loop in motion as a GIF; refused with less than two whole fields."""
    from PIL.Image import Dither

    motion = motion_of(result)
    frames = _painted(drive, motion, _WIDTH)
    palette = frames[len(frames) // 4].quantize(_COLOURS)
    reduced = [frame.quantize(palette=palette, dither=Dither.NONE) for frame in frames]
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
        axes.text(12.0, FIRST_LINE, motion_words(layout, drive, motion), color=QUIET)
        clock = axes.text(layout.size[0] - 12.0, layout.size[1] - 10.0, "", color=QUIET, ha="right")
        diameters = [axes.plot([], [], color=INK, linewidth=2.0)[0] for _ in range(2)]
        cables = {span: axes.plot([], [], color=SPAN_COLOURS[span])[0] for span in motion.across}
        frames = []
        for frame in range(motion.time.size):
            for line, ends in zip(diameters, spokes(layout, motion, frame), strict=True):
                line.set_data(*zip(*ends, strict=True))
            for span, cable in cables.items():
                cable.set_data(*zip(*span_curve(layout, motion, span, frame), strict=True))
            clock.set_text(f"{1e3 * (motion.time[frame] - motion.time[0]):.1f} ms")
            canvas.draw()
            frames.append(Image.fromarray(np.asarray(canvas.buffer_rgba())[:, :, :3]))
    return frames
