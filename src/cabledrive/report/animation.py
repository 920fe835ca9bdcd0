"""The loop in motion: frames of a run, on a page without a script, and under control.

Deflections across the cable and turns of the pulleys are drawn larger than they are, by factors that are
said; the spokes turn with the pulleys, clockwise where the upper span moves on to the load pulley.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees, pi

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters import Drive, InputRefused
from cabledrive.report.figures.moving_machine import DrawnMachine, drawn_loop, tension_colour
from cabledrive.report.figures.sheet import Point, Sheet
from cabledrive.report.picture import theme_css
from cabledrive.report.typesetting import number, quantity
from cabledrive.rig import Tracking
from cabledrive.simulation import SimulationResult

MOST_FRAMES = 72
SECONDS_PER_FRAME = 1.0 / 16.0
POINTS = 41
FIRST_LINE = 18.0  # px
_DEFLECTION, _TURN, _LARGEST_FACTOR = 26.0, 0.6, 1e6  # px, rad


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Motion:
    """Frames of a run."""

    time: Array  # (frames,) [s]
    place: Array  # (points,): shares of the span, from the pulley where it starts
    across: dict[str, Array]  # (frames, points): displacement w of each span, outwards [m]
    angles: Array  # (frames, 2): of drive and load pulley [rad]


def motion_of(result: SimulationResult, most: int = MOST_FRAMES) -> Motion:
    """Frames from the whole fields of a run, the first ``most``; less than two are refused."""
    if len(result.fields) < 2:
        raise InputRefused(
            f"{len(result.fields)} whole fields kept, at least 2 are needed: run with Recording(fields=...)"
        )
    place = np.linspace(0.0, 1.0, POINTS)
    across = {}
    for row, span in enumerate(result.spans):
        at = result.position[row] / result.position[row, -1]
        first = row * (at.size - 1)
        w = result.fields[:most, 2, first : first + at.size]
        across[span] = np.array([np.interp(place, at, field) for field in w])
    time = result.field_time[:most]
    angles = [np.interp(time, result.time, angle) for angle in (result.drive_angle, result.load_angle)]
    return Motion(time=time, place=place, across=across, angles=np.column_stack(angles))


def frame_interval(drive: Drive) -> float:
    """Time between frames that shows the lowest transverse mode in eighteen pictures. Returns [s]."""
    speed = (drive.cable.pretension / drive.cable.stretched_mass_per_length) ** 0.5
    return 2.0 * drive.pulley_distance / speed / 18.0


def factors(motion: Motion) -> tuple[float, float]:
    """How many pixels a metre of deflection has, and how many times too far the pulleys turn."""
    deflection = max(float(np.max(np.abs(field))) for field in motion.across.values())
    turn = float(np.max(np.abs(motion.angles - motion.angles[:1])))
    larger = min(_TURN / turn, _LARGEST_FACTOR) if turn > _TURN / _LARGEST_FACTOR else 1.0
    return _DEFLECTION / deflection if deflection > 0.0 else 0.0, float(f"{larger:.1e}")


def motion_words(drawn: DrawnMachine, drive: Drive, motion: Motion) -> str:
    """What is drawn too large, and how slow it plays."""
    pixels, turn = factors(motion)
    ends = drawn.spans[0].points[[0, -1]]
    larger = pixels * drive.pulley_distance / float(np.linalg.norm(ends[1] - ends[0]))
    slower = SECONDS_PER_FRAME / float(motion.time[1] - motion.time[0])
    return f"w × {number(larger, 2)}, angles × {number(turn, 2)}, {number(slower, 2)} times slower"


def animation_svg(name: str, drive: Drive, result: SimulationResult) -> tuple[Markup, Markup]:
    """The loop in motion for a page: a switch that pauses it, and the drawing, which stands beside it.

    Whoever asks for less motion gets a drawing at rest, and starts it with the switch. Less than two whole
    fields are refused.
    """
    motion = motion_of(result)
    return switch(name, motion.time.size), _moving_svg(name, drive, motion)


def animation_page(drive: Drive, result: SimulationResult) -> str:
    """The loop in motion as HTML that needs no other file; refused with less than two whole fields."""
    alt = "The cable loop in motion: both spans vibrate, the pulleys oscillate."
    return moving_page(drive.title or drive.name, *animation_svg("loop", drive, result), alt=alt)


def moving_page(title: str, control: Markup, drawing: Markup, *, alt: str) -> str:
    """Drawings that move as a page of their own; ``control``: their switch, ``alt``: what is seen."""
    frame = Markup(
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        "<title>{title}</title>\n<style>{css}\nbody {{ margin: 2rem auto; max-width: 47rem; padding: 0 1rem; "
        "--sans: system-ui, sans-serif; font: 1rem/1.5 var(--sans); background: var(--paper); "
        "color: var(--ink); }}\nh1 {{ font-size: 1.5rem; line-height: 1.25; }}\n"
        ".drawing svg {{ display: block; width: 100%; height: auto; }}\n"
        '</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n<figure style="margin: 0">'
        '\n{control}\n<div class="drawing" role="img" aria-label="{alt}">{drawing}</div>\n'
        "</figure>\n</main>\n</body>\n</html>\n"
    )
    return str(frame.format(title=title, css=Markup(theme_css()), control=control, drawing=drawing, alt=alt))


def _moving_svg(name: str, drive: Drive, motion: Motion) -> Markup:
    still = Sheet()
    drawn = drawn_loop(still, drive)
    pixels, larger = factors(motion)
    for span in drawn.spans:
        still.line(*_line(span.points), colour="line", dashes="4 4")
    still.words(motion_words(drawn, drive, motion), (12.0, FIRST_LINE), anchor="start", colour="quiet")
    frames = []
    for frame in range(motion.time.size):
        one = Sheet()
        turned = larger * (motion.angles[frame] - motion.angles[0])
        for pulley, angle in zip(drawn.pulleys, turned, strict=True):
            one.line(pulley.rim(angle), pulley.rim(angle + pi), width=2.0)
        _clock(one, drawn.size, f"{1e3 * (motion.time[frame] - motion.time[0]):.1f} ms")
        for span, colour in zip(drawn.spans, ("blue", "orange"), strict=False):
            shares = span.positions / span.positions[-1]
            w = np.interp(shares, motion.place, motion.across[span.name][frame])
            one.line(*_line(span.moved(pixels * w)), colour=colour, width=2.0)
        frames.append(one.elements)
    still.elements.extend(framed(name, frames))
    return still.svg(drawn.size)


def _line(points: Array) -> list[Point]:
    return [(float(x), float(y)) for x, y in points]


def _clock(sheet: Sheet, size: Point, words: str) -> None:
    sheet.words(words, (size[0] - 12.0, size[1] - 10.0), anchor="end", colour="quiet")


def framed(name: str, frames: Sequence[Sequence[str]]) -> list[str]:
    """Elements of each frame as a group that is seen in its turn; ``name``: as the switch has it."""
    period = len(frames) * SECONDS_PER_FRAME
    groups = []
    for place, elements in enumerate(frames):
        # half a frame early, so that a drawing that never starts shows the first frame and no other
        delay = ((place - 0.5) / len(frames) - 1.0) * period
        inside = "\n".join(elements)
        groups.append(f'<g class="{name}-frame" style="animation-delay: {delay:.4f}s">{inside}</g>')
    return groups


def switch(name: str, frames: int) -> Markup:
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
    plant = run.summary["plant"]
    return moving_page(
        f"{drive.title or drive.name}: {run.summary['controller']} on {plant}",
        switch(NAME, shown.size),
        _drawn(drive, run, shown),
        alt=f"The drive under control: the load pulley follows its reference, plant {plant}.",
    )


def _drawn(drive: Drive, run: Tracking, shown: NDArray[np.int64]) -> Markup:
    """The film; ``shown``: samples of the run."""
    assert run.tensions is not None
    low, high = float(run.tensions.min()), float(run.tensions.max())
    still = Sheet()
    drawn = drawn_loop(still, drive)
    slower = SECONDS_PER_FRAME * shown.size / float(run.time[-1] - run.time[0])
    words = f"tension {quantity(low, 'N', 4)} to {quantity(high, 'N', 4)}, {number(slower, 2)} times slower"
    still.words(words, (12.0, FIRST_LINE), anchor="start", colour="quiet")
    frames = [_frame(drawn, run, int(sample), (low, high)) for sample in shown]
    still.elements.extend(framed(NAME, [frame.elements for frame in frames]))
    return still.svg(drawn.size)


def _frame(drawn: DrawnMachine, run: Tracking, sample: int, tensions: tuple[float, float]) -> Sheet:
    """One picture; ``tensions``: least and largest of the run [N]."""
    assert run.tensions is not None
    one, (low, high) = Sheet(), tensions
    for row, span in enumerate(drawn.spans):
        share = (float(run.tensions[sample, row]) - low) / max(high - low, 1e-12)
        path = "M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in span.points)
        style = f"fill: none; stroke: {tension_colour(share)}; stroke-width: 3.2; stroke-linecap: round"
        one.elements.append(f'<path d="{path}" style="{style}"/>')
    turned = float(run.angles[sample, -2]), float(run.load_angle[sample])  # each at its own shaft
    for pulley, angle in zip(drawn.pulleys, turned, strict=True):
        one.line(pulley.rim(angle), pulley.rim(angle + pi), width=2.0)
    load, wanted = drawn.pulleys[1], float(run.reference[sample])
    for end in (wanted, wanted + pi):
        one.line(load.rim(end, 2.0), load.rim(end, 9.0), colour="green", width=2.0)
    _clock(one, drawn.size, f"{run.time[sample]:.3f} s, error {degrees(float(run.error[sample])):.4f} deg")
    return one
