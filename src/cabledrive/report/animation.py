"""The loop in motion on a page: an SVG that plays without a script."""

from collections.abc import Sequence

from markupsafe import Markup

from cabledrive.parameters import Drive
from cabledrive.report.figures.machine_layout import machine_layout
from cabledrive.report.figures.sheet import Sheet
from cabledrive.report.motion import (
    FIRST_LINE,
    SECONDS_PER_FRAME,
    Motion,
    motion_of,
    motion_words,
    span_curve,
    spokes,
)
from cabledrive.report.style import NARROW, WIDE, theme_css
from cabledrive.simulation import SimulationResult


def animation_svg(name: str, drive: Drive, result: SimulationResult) -> tuple[Markup, Markup, Markup]:
    """The loop in motion for a page: a switch, and the drawing for wide and for narrow pages.

    The switch pauses both drawings and stands before them, all three beside one another in one element.
    Whoever asks for less motion gets a drawing at rest, and starts it with the switch. Less than two whole
    fields are refused.
    """
    motion = motion_of(result)
    drawings = [_moving_svg(name, drive, motion, width, width == NARROW) for width in (WIDE, NARROW)]
    return switch(name, motion.time.size), drawings[0], drawings[1]


def animation_page(drive: Drive, result: SimulationResult) -> str:
    """The loop in motion as HTML that needs no other file; refused with less than two whole fields."""
    alt = "The cable loop in motion: both spans vibrate, the pulleys oscillate."
    return moving_page(drive.title or drive.name, *animation_svg("loop", drive, result), alt=alt)


def moving_page(title: str, control: Markup, wide: Markup, narrow: Markup, *, alt: str) -> str:
    """Drawings that move as a page of their own; ``control``: their switch, ``alt``: what is seen."""
    frame = Markup(
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        "<title>{title}</title>\n<style>{css}\nbody {{ margin: 2rem auto; max-width: 47rem; padding: 0 1rem; "
        "--sans: system-ui, sans-serif; font: 1rem/1.5 var(--sans); background: var(--paper); "
        "color: var(--ink); }}\nh1 {{ font-size: 1.5rem; line-height: 1.25; }}\n"
        ".drawing svg {{ display: block; width: 100%; height: auto; }}\n"
        "@media (max-width: 40rem) {{ .wide {{ display: none; }} }}\n"
        "@media (min-width: 40.01rem) {{ .narrow {{ display: none; }} }}"
        '</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n<figure style="margin: 0">'
        '\n{control}\n<div class="drawing wide" role="img" aria-label="{alt}">{wide}</div>\n'
        '<div class="drawing narrow" role="img" aria-label="{alt}">{narrow}</div>\n'
        "</figure>\n</main>\n</body>\n</html>\n"
    )
    return str(
        frame.format(title=title, css=Markup(theme_css()), control=control, wide=wide, narrow=narrow, alt=alt)
    )


def _moving_svg(name: str, drive: Drive, motion: Motion, width: float, narrow: bool) -> Markup:
    layout = machine_layout(drive, width, narrow)
    still = Sheet()
    for axle, radius in zip((layout.drive, layout.load), layout.radii, strict=True):
        still.circle(axle, radius, colour="quiet")
    for span in motion.across:
        still.line(layout.on_span(span, 0.0), layout.on_span(span, 1.0), colour="line", dashes="4 4")
    still.words(motion_words(layout, drive, motion), (12.0, FIRST_LINE), anchor="start", colour="quiet")
    frames = []
    for frame in range(motion.time.size):
        drawn = Sheet()
        for ends in spokes(layout, motion, frame):
            drawn.line(*ends, colour="ink", width=2.0)
        drawn.words(
            f"{1e3 * (motion.time[frame] - motion.time[0]):.1f} ms",
            (layout.size[0] - 12.0, layout.size[1] - 10.0),
            anchor="end",
            colour="quiet",
        )
        for span in motion.across:
            colour = "blue" if span == "upper" else "orange"
            drawn.line(*span_curve(layout, motion, span, frame), colour=colour, width=2.0)
        frames.append(drawn.elements)
    still.elements.extend(framed(name, frames))
    return still.svg(layout.size)


def framed(name: str, frames: Sequence[Sequence[str]]) -> list[str]:
    """Elements of each frame as a group that is seen in its turn; ``name``: as the switch has it."""
    period = len(frames) * SECONDS_PER_FRAME
    groups = []
    for number, elements in enumerate(frames):
        # half a frame early, so that a drawing that never starts shows the first frame and no other
        delay = ((number - 0.5) / len(frames) - 1.0) * period
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
