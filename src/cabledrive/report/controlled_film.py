"""A controlled run in motion on a page: pulleys turn as they did, spans are coloured by their tension."""

from math import cos, degrees, sin

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from cabledrive.parameters import Drive, InputRefused
from cabledrive.report.animation import framed, moving_page, switch
from cabledrive.report.figures.machine_layout import MachineLayout, machine_layout
from cabledrive.report.figures.moving_machine import tension_colour
from cabledrive.report.figures.sheet import Point, Sheet
from cabledrive.report.motion import FIRST_LINE, SECONDS_PER_FRAME
from cabledrive.report.numbers import number, quantity
from cabledrive.report.style import NARROW, WIDE
from cabledrive.rig import Tracking

FRAMES = 64
NAME = "controlled"


def controlled_film(drive: Drive, run: Tracking) -> str:
    """A run of the rig on a plant with two pulleys, as an HTML page that needs no other file.

    The motion plays to scale; short ticks show where the load pulley should be, and the words by how much it
    is not there. Refused: a plant without spans under tension, a run that ended at once.
    """
    if run.tensions is None:
        raise InputRefused("the film shows tensions: choose a plant with a flexible cable, such as `cable`")
    if run.time.size < 2:
        raise InputRefused(f"the run ended at once: {run.incomplete}")
    shown = np.unique(np.linspace(0, run.time.size - 1, FRAMES).astype(int))
    wide, narrow = (_drawn(drive, run, shown, width) for width in (WIDE, NARROW))
    plant = run.summary["plant"]
    return moving_page(
        f"{drive.title or drive.name}: {run.summary['controller']} on {plant}",
        switch(NAME, shown.size),
        wide,
        narrow,
        alt=f"The drive under control: the load pulley follows its reference, plant {plant}.",
    )


def _drawn(drive: Drive, run: Tracking, shown: NDArray[np.int64], width: float) -> Markup:
    """The film on a sheet of a width; ``shown``: samples of the run."""
    assert run.tensions is not None
    layout = machine_layout(drive, width, width == NARROW)
    low, high = float(run.tensions.min()), float(run.tensions.max())
    still = Sheet()
    for axle, radius in zip((layout.drive, layout.load), layout.radii, strict=True):
        still.circle(axle, radius, colour="quiet")
    slower = SECONDS_PER_FRAME * shown.size / float(run.time[-1] - run.time[0])
    words = f"tension {quantity(low, 'N', 4)} to {quantity(high, 'N', 4)}, {number(slower, 2)} times slower"
    still.words(words, (12.0, FIRST_LINE), anchor="start", colour="quiet")
    frames = [_frame(layout, run, int(sample), (low, high)) for sample in shown]
    still.elements.extend(framed(NAME, [frame.elements for frame in frames]))
    return still.svg(layout.size)


def _frame(layout: MachineLayout, run: Tracking, sample: int, tensions: tuple[float, float]) -> Sheet:
    """One picture; ``tensions``: least and largest of the run [N]."""
    assert run.tensions is not None
    drawn, (low, high) = Sheet(), tensions
    for row, span in enumerate(("upper", "lower")):
        share = (float(run.tensions[sample, row]) - low) / max(high - low, 1e-12)
        path = "M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in layout.curve(span))
        style = f"fill: none; stroke: {tension_colour(share)}; stroke-width: 3.2; stroke-linecap: round"
        drawn.elements.append(f'<path d="{path}" style="{style}"/>')
    turned = float(run.angles[sample, -2]), float(run.load_angle[sample])  # each at its own shaft
    for axle, radius, angle in zip((layout.drive, layout.load), layout.radii, turned, strict=True):
        drawn.line(_rim(layout, axle, radius, angle), _rim(layout, axle, -radius, angle), width=2.0)
    wanted = float(run.reference[sample])
    for end in (-1.0, 1.0):
        drawn.line(
            _rim(layout, layout.load, end * (layout.radii[1] + 2.0), wanted),
            _rim(layout, layout.load, end * (layout.radii[1] + 9.0), wanted),
            colour="green",
            width=2.0,
        )
    words = f"{run.time[sample]:.3f} s, error {degrees(float(run.error[sample])):.4f} deg"
    drawn.words(words, (layout.size[0] - 12.0, layout.size[1] - 10.0), anchor="end", colour="quiet")
    return drawn


def _rim(layout: MachineLayout, axle: Point, radius: float, angle: float) -> Point:
    """A point at a distance from an axle, upright at angle zero; ``radius`` [px], ``angle`` [rad]."""
    return layout.off(axle, radius * sin(angle), radius * cos(angle))
