"""A machine in motion: frames of a run, on a page without a script, and a loop under control.

Deflections of ropes and ways of bodies are drawn larger than they are, by one factor, turns of pulleys by
another, both said; the spokes turn with the pulleys.
"""

from cmath import exp
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import degrees, pi

import numpy as np
from markupsafe import Markup

from cabledrive.answers.figures import number, quantity
from cabledrive.mechanics.network import network_of
from cabledrive.parameters import Drive, InputRefused, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route import Place
from cabledrive.parameters.route.drive import body_number, carried_by
from cabledrive.report.figures.moving_machine import (
    POINTS,
    DrawnMachine,
    DrawnPulley,
    draw_machine,
    tense,
)
from cabledrive.report.figures.sheet import Point, Sheet, body_points, draw_pulley
from cabledrive.report.picture import theme_css
from cabledrive.rig import Tracking
from cabledrive.rig.setting import CABLE
from cabledrive.simulation import SimulationResult

MOST_FRAMES = 72
SECONDS_PER_FRAME = 1.0 / 16.0
FIRST_LINE = 18.0  # px
_DEFLECTION, _TURN, _LARGEST_FACTOR = 26.0, 0.6, 1e6  # px, rad
MOST_POINTS = 400
"""Points of all ropes in a frame, beside a few of each."""
ANGLES = {"drive pulley": "drive_angle", "load pulley": "load_angle"}
"""What records of loops and lines call the turns of their pulleys."""


def frame_interval(drive: Machine) -> float:
    """Time between frames that shows the slowest piece of rope, as a string, in eighteen pictures [s]."""
    return 2.0 * float(network_of(drive).time.max()) / 18.0


def animation_svg(name: str, machine: Machine, result: SimulationResult) -> tuple[Markup, Markup]:
    """A machine in motion for a page: a switch that pauses it, and the drawing, which stands beside it.

    Whoever asks for less motion gets a drawing at rest, and starts it with the switch. Less than two whole
    fields are refused.
    """
    if len(result.fields) < 2:
        raise InputRefused(
            f"{len(result.fields)} whole fields kept, at least 2 are needed: run with Recording(fields=...)"
        )
    time = result.field_time[:MOST_FRAMES]
    still = Sheet()
    drawn = draw_machine(still, machine, moves=True)
    turns = np.column_stack([_turn(pulley.joint, result, time) for pulley in drawn.pulleys])
    fields, bodies = _deflections(machine, result), range(len(machine.body))
    ways = [[_way(machine, result, time, at, i) for at in body_points(machine, i)] for i in bodies]
    pulleys, anchors = (
        [_way(machine, result, time, own.at, body_number(machine, own.on, "")) for own in parts]
        for parts in (machine.pulley, machine.anchor)
    )

    def way_of(place: Place) -> Array:
        """Way of the pulley or anchor of an end of a span, (2, frames) [m]."""
        return anchors[place.anchor or 0] if place.pulley is None else pulleys[place.pulley]

    places = [list(map(drawn.place, body_points(drawn.shown, i))) for i in bodies]
    held = [drawn.place(own.at) for own in drawn.shown.anchor]
    furthest = float(np.max(np.abs(turns), initial=0.0))
    moved = max(float(np.max(np.abs(own), initial=0.0)) for own in (fields, *(one[0] for one in ways)))
    least = _DEFLECTION / _LARGEST_FACTOR / drawn.scale
    pixels = max(_DEFLECTION / moved, drawn.scale) if moved > least else 0.0  # of a metre
    larger = min(_TURN / furthest, _LARGEST_FACTOR) if furthest > _TURN / _LARGEST_FACTOR else 1.0
    for span in drawn.spans:
        still.line(*span.points, colour="line", dashes="4 4")
    speed = float(time[1] - time[0]) / SECONDS_PER_FRAME
    words = f"w × {number(pixels / drawn.scale, 2)}, " if pixels else ""
    words += f"angles × {number(larger, 2)}, at {number(speed, 2)} times its speed"
    few = np.unique(np.linspace(0, POINTS - 1, max(5, MOST_POINTS // len(drawn.spans))).astype(int))

    def draw(one: Sheet, frame: int) -> str:
        def there(at: Point, way: Array) -> Point:
            """A place on the sheet after a way [m] of the frame."""
            return at[0] + pixels * float(way[0, frame]), at[1] - pixels * float(way[1, frame])

        skeletons = [list(map(there, *own)) for own in zip(places, ways, strict=True)]
        centres = map(there, (own.centre for own in drawn.pulleys), pulleys)
        wheels = [replace(own, centre=at) for own, at in zip(drawn.pulleys, centres, strict=True)]
        clamps = list(map(there, held, anchors))
        _draw_moved(one, machine, skeletons, wheels, clamps)
        _spokes(
            one, wheels, {own.joint: larger * turn for own, turn in zip(wheels, turns[frame], strict=True)}
        )
        ropes = list[Array]()
        for row, (span, own) in enumerate(zip(drawn.spans, machine.free_spans, strict=True)):
            start, end = (way_of(place)[:, frame] for place in (own.start, own.end))
            ropes.append(span.moved(pixels * fields[frame, row]) + pixels * span.along(start, end))
            one.line(*ropes[-1][few], colour=("blue", "orange")[row % 2], width=2.0)
        for i, (row, *_) in enumerate(drawn.carriages):
            drawn.draw_carriage(one, i, ropes[row])
        for skeleton in skeletons:
            one.box(skeleton[0], (10.0, 10.0), colour="green")
        return f"{1e3 * (time[frame] - time[0]):.1f} ms"

    return switch(name, time.size), _film(name, still, drawn, words, draw, range(time.size))


def _draw_moved(
    sheet: Sheet,
    machine: Machine,
    skeletons: list[list[Point]],
    pulleys: list[DrawnPulley],
    anchors: list[Point],
) -> None:
    """Bodies, each a line through all that it carries, with their pulleys and anchors, where they are."""
    for skeleton in skeletons:
        sheet.line(*skeleton, colour="faint", width=11.0)
    for i, (own, part) in enumerate(zip(pulleys, machine.pulley, strict=True)):
        if part.on:
            draw_pulley(sheet, own.centre, own.radius, fixed=part.fixed, driven=i in machine.driven)
    for at, anchor in zip(anchors, machine.anchor, strict=True):
        if anchor.on:
            sheet.circle(at, 3.0, fill="ink")


def _turn(pulley: str, result: SimulationResult, time: Array) -> Array:
    """Turn of a pulley from the first frame on, clockwise, (frames,) [rad]; 0 of what is no coordinate."""
    angle = ANGLES.get(pulley, pulley)  # of a loop counted as its upper span runs, of others anticlockwise
    if angle not in result.names:
        return np.zeros(time.size)
    turned = np.interp(time, result.time, result.channel(angle))
    return (turned - turned[0]) * (1.0 if angle in ANGLES.values() else -1.0)


def _way(
    machine: Machine, result: SimulationResult, time: Array, at: tuple[float, float], body: int | None
) -> Array:
    """Way of a point of a body from the first frame on, carried along, (2, frames) [m]; 0 of the frame's."""
    found = np.zeros((2, time.size))
    for own in map(machine.body.__getitem__, carried_by(machine, body)):
        x, y = own.pivot or at
        arms = {"x": (1.0, 0.0), "y": (0.0, 1.0), "turn": (y - at[1], at[0] - x)}
        for move in (one for one in own.moves if f"{own.name}.{one}" in result.names):
            place = np.interp(time, result.time, result.channel(f"{own.name}.{move}"))
            found += np.outer(arms[move], place - place[0])
    return found


def _parts(machine: Machine, pieces: int) -> list[int]:
    """Pieces of rope in each span, of so many in all: whole spans, or cut at carriages."""
    spans = range(len(machine.free_spans))
    cut = pieces > len(spans)
    return [1 + cut * sum(span == own for span, _ in machine.carriage_places) for own in spans]


def _deflections(machine: Machine, result: SimulationResult) -> Array:
    """Motion across from rest of points of each span, (frames, spans, points) [m]."""
    w, share, found = result.fields[:MOST_FRAMES, 2] - result.resting[2], np.linspace(0.0, 1.0, POINTS), []
    pieces, first = np.split(w, np.cumsum([len(own) for own in result.positions])[:-1], axis=1), 0
    for count in _parts(machine, len(result.positions)):
        own, first = slice(first, first + count), first + count
        begun = np.cumsum([0.0, *(at[-1] for at in result.positions[own])])
        at = np.concatenate([start + at for start, at in zip(begun, result.positions[own], strict=False)])
        field = np.hstack(pieces[own])
        found.append(np.array([np.interp(share, at / begun[-1], frame) for frame in field]))
    return np.stack(found, axis=1)


def animation_page(drive: Machine, result: SimulationResult) -> str:
    """A machine in motion as HTML that needs no other file; refused with less than two whole fields."""
    alt = "The machine in motion: ropes vibrate, pulleys oscillate, bodies move."
    return moving_page(drive.title or drive.name, *animation_svg("machine", drive, result), alt=alt)


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


def _spokes(sheet: Sheet, pulleys: Sequence[DrawnPulley], angles: Mapping[str, float]) -> None:
    """A diameter of each pulley of a name, turned clockwise [rad]."""
    for pulley in pulleys:
        if (angle := angles.get(pulley.joint)) is not None:
            sheet.line(pulley.rim(angle), pulley.rim(angle + pi), width=2.0)


def _draw_load(
    sheet: Sheet, drawn: DrawnMachine, machine: Machine, load: tuple[str, float], *, wanted: bool
) -> None:
    """A load by its name at a place [m], [rad]: of a pulley a diameter, of a body or a carriage a box.

    If ``wanted``, in green, ticks outside the rim or a larger box.
    """
    (name, _, move), place = load[0].partition("."), load[1]
    colour, size = ("green", 16.0) if wanted else ("ink", 9.0)
    for pulley in drawn.pulleys:
        if pulley.joint == load[0]:
            for turn in (-place, pi - place):
                start = pulley.rim(turn, 2.0) if wanted else pulley.centre
                sheet.line(start, pulley.rim(turn, 9.0 * wanted), colour=colour, width=2.0)
            return
    names = [body.name for body in machine.body]
    if name in names:
        number = names.index(name)
        body, (x, y) = machine.body[number], drawn.place(drawn.shown.body[number].at)
        way = (place * (move == "x"), place * (move == "y"))
        if body.pivot is not None:
            arm = complex(body.at[0] - body.pivot[0], body.at[1] - body.pivot[1])
            turned = arm * exp(1j * place) - arm
            way = turned.real, turned.imag
        at = x + drawn.scale * way[0], y - drawn.scale * way[1]
    else:
        number = next(
            i for i, own in enumerate(machine.carriage) if load[0].startswith(own.name or f"carriage {i}")
        )
        span, along = machine.carriage_places[number]
        share = (along + place) / machine.free_spans[span].length
        points = drawn.spans[span].points
        at = tuple(float(np.interp(share, np.linspace(0.0, 1.0, POINTS), way)) for way in points.T)  # type: ignore[assignment]
    sheet.box(at, (size, size), colour=colour)


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
    still.elements.sort(key=lambda own: own.startswith("<text"))  # names stay above what moves over them
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
    """A run of the rig on an axis, as an HTML page that needs no other file.

    The motion of motors and load plays to scale, ropes have the colour of their tension where the plant has
    the machine's; green shows where the load should be, and the words by how much it is not there. Refused: a
    run that ended at once.
    """
    if run.time.size < 2:
        raise InputRefused(f"the run ended at once: {run.incomplete}")
    axis, machine = drive.axis, drive.axis.machine
    shown = np.unique(np.linspace(0, run.time.size - 1, FRAMES).astype(int))
    still = Sheet()
    drawn = draw_machine(still, machine)
    ours = run.tensions is not None and (drive.chain_of is None or run.summary["plant"] == CABLE)
    tensions = run.tensions if ours else None  # a lumped plant's are those of its chain
    parts = _parts(machine, 0 if tensions is None else tensions.shape[1])
    low = high = 0.0
    speed = float(run.time[-1] - run.time[0]) / (SECONDS_PER_FRAME * shown.size)
    words = f"at {number(speed, 2)} times its speed"
    if tensions is not None:
        low, high = float(tensions.min()), float(tensions.max())
        words = f"tension {quantity(low, 'N', 4)} to {quantity(high, 'N', 4)}, {words}"
    turned = run.angles[:, max(run.angles.shape[1] - 2, 0)]
    unit, size = ("mm", 1e3 * abs(axis.per_angle)) if axis.slides else ("deg", degrees(1.0))

    def draw(one: Sheet, sample: int) -> str:
        for row, span in enumerate(drawn.spans):
            if tensions is None:
                one.line(*span.points, colour="quiet", width=2.0)
            else:
                pull = float(tensions[sample, sum(parts[:row]) : sum(parts[: row + 1])].mean())
                one.elements.append(tense(span.points, (pull - low) / max(high - low, 1e-12)))
        motors = {name: -sign * float(turned[sample]) for name, sign in axis.words["motors"].items()}
        _spokes(one, drawn.pulleys, motors)
        for angle in (run.reference, run.load_angle):
            place = axis.per_angle * float(angle[sample])
            _draw_load(one, drawn, machine, (axis.load, place), wanted=angle is run.reference)
        return f"{run.time[sample]:.3f} s, error {size * float(run.error[sample]):.4f} {unit}"

    plant = run.summary["plant"]
    return moving_page(
        f"{drive.title or drive.name}: {run.summary['controller']} on {plant}",
        switch(NAME, shown.size),
        _film(NAME, still, drawn, words, draw, shown.tolist()),
        alt=f"The drive under control: the load follows its reference, plant {plant}.",
    )
