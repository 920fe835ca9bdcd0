"""The loop in motion: frames of a run, on a page without a script, and under control.

Deflections across the cable and turns of the pulleys are drawn larger than they are, by factors that are
said; the spokes turn with the pulleys, clockwise where the upper span moves on to the load pulley.
"""

from collections.abc import Callable, Iterable, Sequence
from math import degrees, pi

import numpy as np
from markupsafe import Markup

from cabledrive.answers.figures import number, quantity
from cabledrive.parameters import Drive, InputRefused
from cabledrive.report.figures.moving_machine import DrawnMachine, draw_machine, tense
from cabledrive.report.figures.sheet import Sheet
from cabledrive.report.picture import theme_css
from cabledrive.rig import Tracking
from cabledrive.simulation import SimulationResult

MOST_FRAMES = 72
SECONDS_PER_FRAME = 1.0 / 16.0
FIRST_LINE = 18.0  # px
_DEFLECTION, _TURN, _LARGEST_FACTOR = 26.0, 0.6, 1e6  # px, rad


def frame_interval(drive: Drive) -> float:
    """Time between frames that shows the lowest transverse mode in eighteen pictures. Returns [s]."""
    speed = (drive.cable.pretension / drive.cable.stretched_mass_per_length) ** 0.5
    return 2.0 * drive.pulley_distance / speed / 18.0


def animation_svg(name: str, drive: Drive, result: SimulationResult) -> tuple[Markup, Markup]:
    """The loop in motion for a page: a switch that pauses it, and the drawing, which stands beside it.

    Whoever asks for less motion gets a drawing at rest, and starts it with the switch. Less than two whole
    fields are refused.
    """
    if len(result.fields) < 2:
        raise InputRefused(
            f"{len(result.fields)} whole fields kept, at least 2 are needed: run with Recording(fields=...)"
        )
    fields, time = result.fields[:MOST_FRAMES, 2], result.field_time[:MOST_FRAMES]
    angles = (result.drive_angle, result.load_angle)
    turns = np.column_stack([np.interp(time, result.time, angle) for angle in angles])
    turns -= turns[0]
    deepest, furthest = float(np.max(np.abs(fields))), float(np.max(np.abs(turns)))
    pixels = _DEFLECTION / deepest if deepest > 0.0 else 0.0  # of a metre of deflection
    larger = min(_TURN / furthest, _LARGEST_FACTOR) if furthest > _TURN / _LARGEST_FACTOR else 1.0
    larger = float(f"{larger:.1e}")
    still = Sheet()
    drawn = draw_machine(still, drive)
    for span in drawn.spans:
        still.line(*span.points, colour="line", dashes="4 4")
    ends = drawn.spans[0].points[[0, -1]]
    scale = pixels * drive.pulley_distance / float(np.linalg.norm(ends[1] - ends[0]))
    speed = float(time[1] - time[0]) / SECONDS_PER_FRAME
    words = f"w × {number(scale, 2)}, angles × {number(larger, 2)}, at {number(speed, 2)} times its speed"

    def draw(one: Sheet, frame: int) -> str:
        _spokes(one, drawn, larger * turns[frame])
        for row, (span, colour) in enumerate(zip(drawn.spans, ("blue", "orange"), strict=False)):
            at = result.positions[row] / result.positions[row][-1]
            field = fields[frame, row * at.size :][: at.size]
            w = np.interp(np.linspace(0.0, 1.0, len(span.points)), at, field)
            one.line(*span.moved(pixels * w), colour=colour, width=2.0)
        return f"{1e3 * (time[frame] - time[0]):.1f} ms"

    return switch(name, time.size), _film(name, still, drawn, words, draw, range(time.size))


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


def _spokes(sheet: Sheet, drawn: DrawnMachine, angles: Iterable[float]) -> None:
    """A diameter of each pulley, turned [rad]."""
    for pulley, angle in zip(drawn.pulleys, angles, strict=True):
        sheet.line(pulley.rim(angle), pulley.rim(angle + pi), width=2.0)


def _film(
    name: str,
    still: Sheet,
    drawn: DrawnMachine,
    words: str,
    draw: Callable[[Sheet, int], str],
    frames: Sequence[int],
) -> Markup:
    """What does not move, its words, and each frame as a group that is seen in its turn.

    ``name``: as the switch has it; ``draw(sheet, frame)`` draws one and returns its time in words.
    """
    still.words(words, (12.0, FIRST_LINE), anchor="start", colour="quiet")
    period, (width, height) = len(frames) * SECONDS_PER_FRAME, drawn.size
    for place, frame in enumerate(frames):
        # half a frame early, so that a drawing that never starts shows the first frame and no other
        delay = ((place - 0.5) / len(frames) - 1.0) * period
        one = Sheet()
        clock = draw(one, frame)
        one.words(clock, (width - 12.0, height - 10.0), anchor="end", colour="quiet")
        inside = "\n".join(one.elements)
        still.elements.append(f'<g class="{name}-frame" style="animation-delay: {delay:.4f}s">{inside}</g>')
    return still.svg(drawn.size)


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
    tensions = run.tensions
    if tensions is None:
        raise InputRefused("the film shows tensions: choose a plant with a flexible cable, such as `cable`")
    if run.time.size < 2:
        raise InputRefused(f"the run ended at once: {run.incomplete}")
    shown = np.unique(np.linspace(0, run.time.size - 1, FRAMES).astype(int))
    low, high = float(tensions.min()), float(tensions.max())
    still = Sheet()
    drawn = draw_machine(still, drive)
    speed = float(run.time[-1] - run.time[0]) / (SECONDS_PER_FRAME * shown.size)
    words = (
        f"tension {quantity(low, 'N', 4)} to {quantity(high, 'N', 4)}, at {number(speed, 2)} times its speed"
    )

    def draw(one: Sheet, sample: int) -> str:
        for row, span in enumerate(drawn.spans):
            share = (float(tensions[sample, row]) - low) / max(high - low, 1e-12)
            one.elements.append(tense(span.points, share))
        turned = float(run.angles[sample, -2]), float(run.load_angle[sample])  # each at its own shaft
        _spokes(one, drawn, turned)
        load, wanted = drawn.pulleys[1], float(run.reference[sample])
        for end in (wanted, wanted + pi):
            one.line(load.rim(end, 2.0), load.rim(end, 9.0), colour="green", width=2.0)
        return f"{run.time[sample]:.3f} s, error {degrees(float(run.error[sample])):.4f} deg"

    plant = run.summary["plant"]
    return moving_page(
        f"{drive.title or drive.name}: {run.summary['controller']} on {plant}",
        switch(NAME, shown.size),
        _film(NAME, still, drawn, words, draw, shown.tolist()),
        alt=f"The drive under control: the load pulley follows its reference, plant {plant}.",
    )
