"""A machine from its coordinates, spans coloured by tension, with what a page needs to move a mode on it."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite
from typing import Any

import numpy as np
from markupsafe import Markup, escape

from cabledrive.mechanics.rest import rest_state
from cabledrive.modal import Mode
from cabledrive.modal.mode import TRANSVERSE
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route import RoutedDrive
from cabledrive.report.figures.machine import draw_machine
from cabledrive.report.figures.sheet import Point, Sheet, draw_route
from cabledrive.report.picture import CARD_WIDTH, WIDE
from cabledrive.report.typesetting import quantity

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
    positions: Array  # (p,): of the points, as `Mode.shape` takes them [m]
    tension: Array  # (p,) [N]


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawnPulley:
    """A pulley on the sheet that can turn; ``turn``: angle on the sheet for one unit of the joint."""

    joint: str
    centre: Point
    radius: float
    turn: float


def route_sketch(drive: RoutedDrive) -> Markup:
    """A machine with routes without words, for a card."""
    sheet = Sheet(wordless=True)
    size, spans, _ = _route(sheet, drive, CARD_WIDTH)
    for span in spans:
        sheet.line(*((float(x), float(y)) for x, y in span.points[[0, -1]]), colour="blue", width=2.6)
    return sheet.svg(size)


def moving_machine(drive: Drive | RoutedDrive, mode: Mode | None) -> Markup:
    """The machine, with the motion of a mode as data of the drawing."""
    sheet = Sheet()
    if isinstance(drive, RoutedDrive):
        size, spans, pulleys = _route(sheet, drive, WIDE)
    else:
        size, spans, pulleys = _loop(sheet, drive)
    tensions = np.concatenate([span.tension for span in spans])
    low, high = float(tensions.min()), float(tensions.max())
    for span in spans:
        _coloured(sheet, span, low, high)
    _key(sheet, low, high, size)
    drawing = str(sheet.svg(size))
    motion = "" if mode is None else json.dumps(_motion(mode, spans, pulleys), allow_nan=False)
    return Markup(drawing.replace("<svg ", f'<svg data-motion="{escape(motion)}" ', 1))


def _loop(sheet: Sheet, drive: Drive) -> tuple[Point, list[DrawnSpan], list[DrawnPulley]]:
    layout = draw_machine(sheet, drive, WIDE)
    shares = np.linspace(0.0, 1.0, POINTS)
    spans = []
    for name in drive.spans:
        positions = shares * drive.span_length
        points = np.array([layout.on_span(name, float(share)) for share in shares])
        spans.append(
            DrawnSpan(name=name, points=points, positions=positions, tension=_tension(drive, name, positions))
        )
    pulleys = [
        # the joint is the displacement of the rim along the upper span
        DrawnPulley(joint=joint, centre=centre, radius=radius, turn=1.0)
        for joint, centre, radius, pulley in zip(
            ("drive pulley", "load pulley"),
            (layout.drive, layout.load),
            layout.radii,
            drive.pulley,
            strict=True,
        )
        if not pulley.fixed
    ]
    return layout.size, spans, pulleys


def _tension(drive: Drive, span: str, positions: Array) -> Array:
    """Tension at rest along a span, shape (p,) [N]."""
    found = np.empty(positions.size)
    for stretch in rest_state(drive).stretches:
        if stretch.span == span:
            here = (positions >= stretch.start - 1e-12) & (positions <= stretch.end * (1 + 1e-12))
            found[here] = stretch.tension_at(positions[here])
    return found


def _route(
    sheet: Sheet, drive: RoutedDrive, width: float
) -> tuple[Point, list[DrawnSpan], list[DrawnPulley]]:
    size, place, shown = draw_route(sheet, drive, width)
    from cabledrive.mechanics.network import statics_of  # other machines do not wait for it

    statics, shares = statics_of(drive), np.linspace(0.0, 1.0, POINTS)
    spans = []
    for number, (span, drawn) in enumerate(zip(drive.free_spans, shown.free_spans, strict=True)):
        first, last = (np.array(place(end)) for end in drawn.contacts)
        spans.append(
            DrawnSpan(
                name=span.name,
                points=first + np.outer(shares, last - first),
                positions=shares * span.length,
                tension=np.interp(shares, (0.0, 1.0), (statics.start[number], statics.end[number])),
            )
        )
    scale = place((1.0, 0.0))[0] - place((0.0, 0.0))[0]
    pulleys = [
        # anticlockwise on the machine is clockwise where y points downwards
        DrawnPulley(joint=pulley.name, centre=place(pulley.at), radius=scale * pulley.radius, turn=-1.0)
        for pulley in shown.pulley
        if not pulley.fixed
    ]
    return size, spans, pulleys


def _coloured(sheet: Sheet, span: DrawnSpan, low: float, high: float) -> None:
    """The span in pieces, from blue at the lowest to orange at the highest tension."""
    ends = np.linspace(0, len(span.points) - 1, PIECES + 1).astype(int)
    for first, last in pairwise(ends):
        middle = float(span.tension[first : last + 1].mean())
        share = 0.0 if high - low <= EVEN * abs(high) else (middle - low) / (high - low)
        path = "M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in span.points[first : last + 1])
        sheet.elements.append(
            f'<path d="{path}" style="fill: none; stroke: {tension_colour(share)}; stroke-width: 3.2; '
            'stroke-linecap: round"><title>'
            f"{escape(span.name)}: {escape(quantity(middle, 'N', 4))}</title></path>"
        )


def tension_colour(share: float) -> str:
    """Colour of a tension: blue at the lowest (0), orange at the highest (1)."""
    return f"color-mix(in srgb, var(--orange) {100.0 * share:.0f}%, var(--blue))"


def _key(sheet: Sheet, low: float, high: float, size: Point) -> None:
    """What the colours are."""
    even = high - low <= EVEN * abs(high)
    words = f"tension {quantity(low, 'N', 4)}" + ("" if even else f" to {quantity(high, 'N', 4)}")
    sheet.line((2.0, 9.0), (16.0, 9.0), colour="blue", width=3.2)
    if not even:
        sheet.line((9.0, 9.0), (16.0, 9.0), colour="orange", width=3.2)
    sheet.words(words, (22.0, 13.0), anchor="start", colour="quiet")


def _motion(mode: Mode, spans: Sequence[DrawnSpan], pulleys: Sequence[DrawnPulley]) -> dict[str, Any]:
    """Points of the spans at rest and their displacement, pulleys and their turn, of the first shape."""
    shapes = [np.real(mode.shape(span.name, span.positions)[0]) for span in spans]
    across = mode.kind == TRANSVERSE
    largest = max((float(np.max(np.abs(shape))) for shape in shapes), default=0.0) or 1.0
    size = (ACROSS if across else ALONG) / largest
    turns = [
        pulley.turn * float(np.real(mode.joints.get(pulley.joint, np.zeros(1))[0])) for pulley in pulleys
    ]
    most = max((abs(turn) for turn in turns), default=0.0) or 1.0
    return {
        "spans": [
            {"points": _rounded(span.points + 0.0), "moved": _rounded(_moved(span, size * shape, across))}
            for span, shape in zip(spans, shapes, strict=True)
        ],
        "across": across,
        "pulleys": [
            {"centre": pulley.centre, "radius": round(pulley.radius, 1), "turn": round(TURN * turn / most, 4)}
            for pulley, turn in zip(pulleys, turns, strict=True)
            if isfinite(turn)
        ],
    }


def _moved(span: DrawnSpan, displacement: Array, across: bool) -> Array:
    """Displacement on the sheet of every point, shape (p, 2) [px]."""
    tangent = np.gradient(span.points, axis=0)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1), 1e-12)[:, None]
    normal = np.stack((tangent[:, 1], -tangent[:, 0]), axis=1)
    return displacement[:, None] * (normal if across else tangent)


def _rounded(values: Array) -> list[list[float]]:
    return [[round(float(x), 2), round(float(y), 2)] for x, y in values]
