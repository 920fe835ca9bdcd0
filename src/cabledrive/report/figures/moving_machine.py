"""A machine from its coordinates, spans coloured by tension, with what a page needs to move a mode on it."""

import json
from dataclasses import dataclass, replace
from itertools import pairwise
from math import cos, isfinite, pi, sin
from typing import Any

import numpy as np
from markupsafe import Markup, escape

from cabledrive.answers.figures import quantity
from cabledrive.mechanics.network import statics_of
from cabledrive.mechanics.rest import sag_of
from cabledrive.modal import Mode
from cabledrive.modal.mode import TRANSVERSE
from cabledrive.parameters import Machine
from cabledrive.parameters.arrays import Array
from cabledrive.report.figures.sheet import Placer, Point, Sheet, draw_route
from cabledrive.report.machine.rest import tension_at
from cabledrive.report.picture import CARD_WIDTH, WIDE

POINTS = 49
PIECES = 8
"""Pieces of a span, each of one colour."""
ACROSS, ALONG, TURN = 26.0, 14.0, 0.5
"""Largest displacement on the sheet across and along a span [px], largest turn of a pulley [rad]."""
EVEN = 1e-6
"""Relative difference of tensions below which all spans have one colour."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DrawnSpan:
    """A span on the sheet."""

    name: str  # as modes name it
    points: Array  # (p, 2): along it [px]
    tension: Array  # (p,) at rest [N]

    def moved(self, displacement: Array, across: bool = True) -> Array:
        """Points displaced across the span, to its left, or along it [px], shape (p, 2)."""
        tangent = np.gradient(self.points, axis=0)
        tangent /= np.maximum(np.linalg.norm(tangent, axis=1), 1e-12)[:, None]
        normal = np.stack((tangent[:, 1], -tangent[:, 0]), axis=1)
        return np.asarray(self.points + displacement[:, None] * (normal if across else tangent))

    def along(self, start: Array, end: Array) -> Array:
        """What ends that move, (2,) each, y upwards, add along the span, even between them, (p, 2)."""
        chord = self.points[-1] - self.points[0]
        chord = chord / np.hypot(*chord)
        first, last = (float(way @ (chord * (1.0, -1.0))) for way in (start, end))
        return np.linspace(first, last, len(self.points))[:, None] * chord


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawnPulley:
    """A pulley on the sheet that can turn."""

    joint: str
    centre: Point
    radius: float

    def rim(self, angle: float, further: float = 0.0) -> Point:
        """A point of the rim, or further out [px], upright at angle zero, clockwise [rad]."""
        reach = self.radius + further
        return self.centre[0] + reach * sin(angle), self.centre[1] - reach * cos(angle)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DrawnMachine:
    """Size of the sheet [px], and what can move on it."""

    size: Point
    spans: list[DrawnSpan]
    pulleys: list[DrawnPulley]
    carriages: list[tuple[int, float, bool]]  # span of each, share of its way, whether it is guided
    place: Placer  # of a point [m] on the sheet [px]
    shown: Machine  # the machine in the coordinates of the drawing
    scale: float  # pixels of a metre

    def draw_carriage(self, sheet: Sheet, number: int, points: Array) -> None:
        """A carriage where its rope is; ``points``: of its span, (p, 2) [px]."""
        _, share, guided = self.carriages[number]
        x, y = (float(np.interp(share, np.linspace(0.0, 1.0, len(way)), way)) for way in points.T)
        sheet.box((x, y) if guided else (x, y + 9.0), (14.0, 12.0), colour="green")


def moving_machine(drive: Machine, mode: Mode | None) -> Markup:
    """The machine, with the motion of a mode as data of the drawing."""
    sheet = Sheet()
    drawn = draw_machine(sheet, drive)
    tensions = np.concatenate([span.tension for span in drawn.spans])
    low, high = float(tensions.min()), float(tensions.max())
    for span in drawn.spans:
        _coloured(sheet, span, low, high)
    _key(sheet, low, high)
    drawing = str(sheet.svg(drawn.size))
    motion = "" if mode is None else json.dumps(_motion(mode, drawn), allow_nan=False)
    return Markup(drawing.replace("<svg ", f'<svg data-motion="{escape(motion)}" ', 1))


def sketch(drive: Machine) -> Markup:
    """A machine without words, for a card."""
    sheet = Sheet(wordless=True)
    machine = coordinates(drive)
    size, place, shown = draw_route(sheet, machine, CARD_WIDTH)
    for span in shown.free_spans:
        sheet.line(*map(place, span.contacts), colour="blue", width=2.6)
    return sheet.svg(size)


def coordinates(machine: Machine) -> Machine:
    """A machine in coordinates; one of pulleys alone level or upright as it mostly stands."""
    if machine.body or machine.anchor or abs(machine.layout.inclination) < pi / 4:
        return machine
    up = 1.0 if machine.layout.inclination > 0.0 else -1.0
    turned = (replace(own, at=(-up * own.at[1], up * own.at[0])) for own in machine.pulley)
    return replace(machine, pulley=tuple(turned))


def draw_machine(sheet: Sheet, machine: Machine, *, moves: bool = False) -> DrawnMachine:
    """Draw all but the spans, which sag to the scale of their length, with carriages where they hang.

    ``moves``: without what can move: carriages, bodies and what these carry.
    """
    (width, height), place, shown = draw_route(
        sheet, coordinates(machine), WIDE, carriages=False, bodies=not moves
    )
    spans, shares = list[DrawnSpan](), np.linspace(0.0, 1.0, POINTS)
    stretches = statics_of(machine, held=machine.turned).stretches
    for drawn, own in zip(shown.free_spans, stretches, strict=True):
        length = own[-1].end - own[0].start
        at = own[0].start + length * shares
        chord = DrawnSpan(
            name=drawn.name,
            points=np.linspace(place(drawn.contacts[0]), place(drawn.contacts[1]), POINTS),
            tension=tension_at(own, at),
        )
        scale = float(np.linalg.norm(chord.points[-1] - chord.points[0])) / length
        spans.append(replace(chord, points=chord.moved(scale * np.interp(at, *sag_of(own)))))
    scale = place((1.0, 0.0))[0] - place((0.0, 0.0))[0]  # pixels of a metre
    pulleys = [
        DrawnPulley(joint=own.name, centre=place(own.at), radius=scale * own.radius) for own in shown.pulley
    ]
    deepest = max(float(span.points[:, 1].max()) for span in spans)
    carried = zip(machine.carriage_places, machine.carriage, strict=True)
    found = DrawnMachine(
        size=(width, max(height, deepest + 12.0)),
        spans=spans,
        pulleys=pulleys,
        carriages=[(i, along / machine.free_spans[i].length, one.guided) for (i, along), one in carried],
        place=place,
        shown=shown,
        scale=scale,
    )
    for number, (span, *_) in enumerate(() if moves else found.carriages):
        found.draw_carriage(sheet, number, spans[span].points)
    return found


def _coloured(sheet: Sheet, span: DrawnSpan, low: float, high: float) -> None:
    """The span in pieces, from blue at the lowest to orange at the highest tension."""
    ends = np.linspace(0, len(span.points) - 1, PIECES + 1).astype(int)
    for first, last in pairwise(ends):
        middle = float(span.tension[first : last + 1].mean())
        share = 0.0 if high - low <= EVEN * abs(high) else (middle - low) / (high - low)
        words = f"{span.name}: {quantity(middle, 'N', 4)}"
        sheet.elements.append(tense(span.points[first : last + 1], share, words))


def tense(points: Array, share: float, words: str = "") -> str:
    """A piece of rope in the colour of its tension, blue at the lowest (0), orange at the highest (1)."""
    path = "M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in points)
    colour = f"color-mix(in srgb, var(--orange) {100.0 * share:.0f}%, var(--blue))"
    style = f"fill: none; stroke: {colour}; stroke-width: 3.2; stroke-linecap: round"
    title = f"><title>{escape(words)}</title></path>" if words else "/>"
    return f'<path d="{path}" style="{style}"{title}'


def _key(sheet: Sheet, low: float, high: float) -> None:
    """What the colours are."""
    even = high - low <= EVEN * abs(high)
    words = f"tension {quantity(low, 'N', 4)}" + ("" if even else f" to {quantity(high, 'N', 4)}")
    sheet.line((2.0, 9.0), (16.0, 9.0), colour="blue", width=3.2)
    if not even:
        sheet.line((9.0, 9.0), (16.0, 9.0), colour="orange", width=3.2)
    sheet.words(words, (22.0, 13.0), anchor="start", colour="quiet")


def _motion(mode: Mode, drawn: DrawnMachine) -> dict[str, Any]:
    """Points of the spans at rest and their displacement, pulleys and their turn, of the first shape."""
    lengths = {piece.span: piece.end for piece in mode.network.pieces}
    places = {name: np.linspace(0.0, length, POINTS) for name, length in lengths.items()}
    shapes = [np.real(mode.shape(span.name, places[span.name])[0]) for span in drawn.spans]
    pulleys = [pulley for pulley in drawn.pulleys if pulley.joint in mode.joints]
    across = mode.kind == TRANSVERSE
    largest = max((float(np.max(np.abs(shape))) for shape in shapes), default=0.0) or 1.0
    size = (ACROSS if across else ALONG) / largest
    # a joint is a rim's way along the upper span, or an angle anticlockwise; on the sheet clockwise
    units = (1.0 / own.radius if own.joint in mode.network.rims else -1.0 for own in pulleys)
    turns = [
        unit * float(np.real(mode.joints[own.joint][0])) for unit, own in zip(units, pulleys, strict=True)
    ]
    most = max((abs(turn) for turn in turns), default=0.0) or 1.0
    return {
        "spans": [
            {
                "points": _rounded(span.points),
                "moved": _rounded(span.moved(size * shape, across) - span.points),
            }
            for span, shape in zip(drawn.spans, shapes, strict=True)
        ],
        "across": across,
        "pulleys": [
            {"centre": own.centre, "radius": round(own.radius, 1), "turn": round(TURN * turn / most, 4)}
            for own, turn in zip(pulleys, turns, strict=True)
            if isfinite(turn)
        ],
    }


def _rounded(values: Array) -> list[list[float]]:
    return [[round(float(x), 2), round(float(y), 2)] for x, y in values]
