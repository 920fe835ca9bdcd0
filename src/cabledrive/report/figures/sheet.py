"""Elements of a line drawing in SVG, and a machine with routes drawn with them."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import atan2, hypot, pi
from typing import NamedTuple

from markupsafe import Markup, escape

from cabledrive.parameters import InputRefused, Machine
from cabledrive.parameters.route.geometry import FreeSpan
from cabledrive.parameters.route.geometry import Point as Metres
from cabledrive.report.picture import CARD_WIDTH, SMALL, text_width

Point = tuple[float, float]


@dataclass(slots=True)
class Sheet:
    """A sheet on which lines, circles and words are drawn, y downwards, in pixels."""

    elements: list[str] = field(default_factory=list)  # what has been drawn so far
    wordless: bool = False  # whether words are left out

    def line(self, *points: Point, colour: str = "ink", width: float = 1.2, dashes: str = "") -> None:
        """A line through points; width and dashes with gaps [px]."""
        path = "M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in points)
        self.path(path, colour=colour, width=width, dashes=dashes)

    def path(
        self, path: str, *, colour: str = "ink", width: float = 1.2, fill: str = "none", dashes: str = ""
    ) -> None:
        """A path in the language of SVG; width and dashes with gaps [px]."""
        inside = fill if fill == "none" else f"var(--{fill})"
        dashed = f"; stroke-dasharray: {dashes}" if dashes else ""
        self.elements.append(
            f'<path d="{path}" style="fill: {inside}; stroke: var(--{colour}); stroke-width: {width:g}; '
            f'stroke-linecap: round; stroke-linejoin: round{dashed}"/>'
        )

    def circle(
        self, centre: Point, radius: float, *, colour: str = "ink", width: float = 1.2, fill: str = "none"
    ) -> None:
        """A circle; radius and width of its line [px]."""
        inside = fill if fill == "none" else f"var(--{fill})"
        self.elements.append(
            f'<circle cx="{centre[0]:.1f}" cy="{centre[1]:.1f}" r="{radius:.1f}" '
            f'style="fill: {inside}; stroke: var(--{colour}); stroke-width: {width:g}"/>'
        )

    def box(self, centre: Point, size: Point, *, colour: str = "ink", fill: str = "card") -> None:
        """An upright box with rounded corners, width and height [px]."""
        x, y = centre[0] - size[0] / 2, centre[1] - size[1] / 2
        self.elements.append(
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{size[0]:.1f}" height="{size[1]:.1f}" rx="2" '
            f'style="fill: var(--{fill}); stroke: var(--{colour}); stroke-width: 1.2"/>'
        )

    def words(
        self, text: str, at: Point, *, anchor: str = "middle", colour: str = "ink", size: float = 12.0
    ) -> None:
        """Words, one line, that start, are centred ("middle") or end at a point; size of the letters [px]."""
        if self.wordless:
            return
        self.elements.append(
            f'<text x="{at[0]:.1f}" y="{at[1]:.1f}" style="font: {size:g}px var(--sans); '
            f'text-anchor: {anchor}; fill: var(--{colour})">{escape(text)}</text>'
        )

    def svg(self, size: Point) -> Markup:
        """The sheet as part of a page. ``size``: width and height [px]. Returns an ``svg`` element."""
        width, height = size
        return Markup(
            f'<svg viewBox="0 0 {width:g} {height:g}" style="max-width: {width:g}px" aria-hidden="true">'
            + "\n".join(self.elements)
            + "</svg>"
        )


MARGIN, HEAD = 46.0, 34.0  # px
TALLEST = 520.0  # px
SMALLEST = 2.5  # px, of a pulley as drawn
SLIM, SHOWN = 6.0, 3.0
"""Longer side over the shorter one beyond which a machine is not drawn to scale, and that of the drawing."""
FEW = 14
"""Pulleys that are all named."""

LINE, STEPS = 3.0, 6
"""Width of a drawn line [px]; distances at which a name is tried."""

_Box = tuple[float, float, float, float]
Placer = Callable[[Metres], Point]


def draw_route(
    sheet: Sheet, drive: Machine, width: float, *, carriages: bool = True, bodies: bool = True
) -> tuple[Point, Placer, Machine]:
    """Draw all but the free spans on a sheet of a width [px].

    Names leave room for carriages that are not drawn; of bodies that are not, what they carry is not either.

    Returns its size, the map of places, and the machine as it is drawn, whose spans are those of the machine.
    """
    real, (drive, axis, factor) = drive, drawn_machine(drive)
    size, place, scale = _placer(drive, width)
    if factor > 1.0:
        sheet.words(
            f"{axis} drawn {factor:.3g} times as large", (size[0] - 2.0, 13.0), anchor="end", colour="quiet"
        )
    words: list[_Words] = []
    for number, body in enumerate(drive.body):
        if bodies:
            sheet.line(*map(place, body_points(drive, number)), colour="faint", width=11.0)
            sheet.box(place(body.at), (10.0, 10.0), colour="green")
        words.append(_Words(body.name, place(body.at), 10.0, "green"))
    for here, after in neighbours(drive):
        if bodies or not (here.end.pulley is not None and drive.pulley[here.end.pulley].on):
            _arc(sheet, here, after, place, scale)
    few = len(drive.pulley) <= FEW and width > CARD_WIDTH
    for number, pulley in enumerate(drive.pulley):
        driven = number in drive.driven
        centre, radius = place(pulley.at), max(scale * pulley.radius, SMALLEST)
        if bodies or not pulley.on:
            draw_pulley(sheet, centre, radius, fixed=pulley.fixed, driven=driven)
        if few or driven:
            name = f"{pulley.name}, motor" if driven else pulley.name
            words.append(_Words(name, centre, radius + 4.0, "ink" if driven else "quiet"))
    for anchor in drive.anchor:
        if bodies or not anchor.on:
            sheet.circle(place(anchor.at), 3.0, fill="ink")
    boxes: list[_Box] = []
    for (span, along), carriage in zip(real.carriage_places, real.carriage, strict=True):
        share = along / real.free_spans[span].length
        first, last = drive.free_spans[span].contacts
        at = place((first[0] + share * (last[0] - first[0]), first[1] + share * (last[1] - first[1])))
        x, y = at if carriage.guided else (at[0], at[1] + 9.0)
        boxes.append((x - 7.0, y - 6.0, x + 7.0, y + 6.0))
        if carriages:
            sheet.box((x, y), (14.0, 12.0), colour="green")
    spans = [(place(first), place(last)) for first, last in (span.contacts for span in drive.free_spans)]
    _write(sheet, words, spans, boxes, size)
    return size, place, drive


def draw_pulley(sheet: Sheet, centre: Point, radius: float, *, fixed: bool, driven: bool) -> None:
    """A pulley of a radius [px]; one that a motor drives with a dot."""
    sheet.circle(centre, max(radius - 1.5, 1.5), colour="quiet", width=1.0, fill="line" if fixed else "card")
    if driven:
        sheet.circle(centre, 3.0, fill="ink")


class _Words(NamedTuple):
    """A name beside a point [px], clear of what is drawn within ``gap`` of it."""

    text: str
    at: Point
    gap: float
    colour: str


def _write(
    sheet: Sheet, words: list[_Words], spans: list[tuple[Point, Point]], boxes: list[_Box], size: Point
) -> None:
    """Write names where they cover no other name, part or span, or the least of them."""
    parts = boxes + [(w.at[0] - w.gap, w.at[1] - w.gap, w.at[0] + w.gap, w.at[1] + w.gap) for w in words]
    taken: list[_Box] = []
    for own in words:
        wide = text_width(own.text)
        best: tuple[float, Point, _Box] | None = None
        for step in range(STEPS):
            away = own.gap + step * 1.2 * SMALL
            aside = away + 0.5 * wide
            inward = max(0.5 * wide - own.gap, 0.0)
            near = [(x, y) for y in (-away, away + SMALL) for x in (0.0, -inward, inward)]
            for x, y in (*near, (aside, 0.35 * SMALL), (-aside, 0.35 * SMALL)):
                at = own.at[0] + x, own.at[1] + y
                box = at[0] - 0.5 * wide, at[1] - SMALL, at[0] + 0.5 * wide, at[1] + 0.25 * SMALL
                cost = sum(4.0 * _common(box, other) for other in taken) + sum(_common(box, p) for p in parts)
                cost += sum(_crossed(box, *span) for span in spans) + step
                cost += 1e4 * (box[0] < 0.0 or box[2] > size[0] or box[1] < HEAD / 2 or box[3] > size[1])
                if best is None or cost < best[0]:
                    best = cost, at, box
        assert best is not None
        taken.append(best[2])
        sheet.words(own.text, best[1], colour=own.colour, size=SMALL)


def _common(one: _Box, other: _Box) -> float:
    """Area that two boxes share [px^2]."""
    wide, tall = (min(one[i + 2], other[i + 2]) - max(one[i], other[i]) for i in (0, 1))
    return max(wide, 0.0) * max(tall, 0.0)


def _crossed(box: _Box, start: Point, end: Point) -> float:
    """Length of a line inside a box, times the width of a line [px^2]."""
    low, high = 0.0, 1.0
    for i in (0, 1):
        way = end[i] - start[i]
        if abs(way) < 1e-9:
            if not box[i] <= start[i] <= box[i + 2]:
                return 0.0
            continue
        first, last = sorted(((box[i] - start[i]) / way, (box[i + 2] - start[i]) / way))
        low, high = max(low, first), min(high, last)
    return LINE * hypot(end[0] - start[0], end[1] - start[1]) * max(high - low, 0.0)


def drawn_machine(drive: Machine) -> tuple[Machine, str, float]:
    """A machine that can be drawn: of a slim one its width, or its height, is stretched, pulleys with it.

    Returns the machine, without carriages, the direction that is stretched and by how much; 1 where it is to
    scale, also where its ropes could not run as they do.
    """
    bare = replace(drive, carriage=())
    wide, tall = (max(ends) - min(ends) for ends in zip(*_points(drive), strict=True))
    slim = max(wide, tall) / max(min(wide, tall), 1e-9 * max(wide, tall))
    if slim <= SLIM:
        return bare, "", 1.0
    axis, factor = ("x", 0) if wide < tall else ("y", 1), slim / SHOWN

    def stretched(at: Metres) -> Metres:
        return (factor * at[0], at[1]) if axis[1] == 0 else (at[0], factor * at[1])

    try:
        shown = replace(
            bare,
            body=tuple(
                replace(
                    body,
                    at=stretched(body.at),
                    pivot=stretched(body.pivot) if body.pivot else None,
                    travel=None,
                )
                for body in drive.body
            ),
            pulley=tuple(
                replace(part, at=stretched(part.at), radius=factor * part.radius) for part in drive.pulley
            ),
            anchor=tuple(replace(part, at=stretched(part.at)) for part in drive.anchor),
        )
    except InputRefused:
        return bare, "", 1.0
    return shown, axis[0], factor


def _points(drive: Machine) -> list[Metres]:
    """Points that a drawing has to hold [m]."""
    points = [(p.at[0] + s * p.radius, p.at[1] + s * p.radius) for p in drive.pulley for s in (-1.0, 1.0)]
    return points + [anchor.at for anchor in drive.anchor] + [body.at for body in drive.body]


def _placer(drive: Machine, width: float) -> tuple[Point, Placer, float]:
    """Size of the sheet [px], the map from m, and its scale [px/m]."""
    margin = MARGIN / 2 if width == CARD_WIDTH else MARGIN
    xs, ys = zip(*_points(drive), strict=True)
    wide, tall = max(max(xs) - min(xs), 1e-9), max(max(ys) - min(ys), 1e-9)
    scale = min((width - 2 * margin) / wide, TALLEST / tall)
    left = (width - scale * wide) / 2
    height = scale * tall + 2 * MARGIN + HEAD

    def _place(at: Metres) -> Point:
        return left + scale * (at[0] - min(xs)), height - MARGIN - scale * (at[1] - min(ys))

    return (width, height), _place, scale


def body_points(drive: Machine, number: int) -> list[Metres]:
    """Places of a body and of all that it carries [m]."""
    body = drive.body[number]
    groups = (drive.pulley, drive.anchor, drive.body)
    carried = [part.at for group in groups for part in group if part.on == body.name]
    return [body.at, *([body.pivot] if body.pivot else []), *carried]


def neighbours(drive: Machine) -> list[tuple[FreeSpan, FreeSpan]]:
    """Neighbouring spans of a route with a pulley between them."""
    found = []
    for route in range(len(drive.route)):
        own = [span for span in drive.free_spans if span.route == route]
        pairs = zip(own, own[1:] + own[:1], strict=True)
        found += [(here, after) for here, after in pairs if here.wrap is not None and here.end == after.start]
    return found


def _arc(sheet: Sheet, here: FreeSpan, after: FreeSpan, place: Placer, scale: float) -> None:
    """The rope on a pulley, from where it arrives to where it leaves."""
    centre, sense, radius = here.end.centre, here.end.sense, scale * here.end.radius
    first, last = (
        atan2(point[1] - centre[1], point[0] - centre[0]) for point in (here.contacts[1], after.contacts[0])
    )
    turned = (sense * (last - first)) % (2 * pi)
    start, end = place(here.contacts[1]), place(after.contacts[0])
    sweep = int(sense < 0)  # y points downwards on the sheet
    sheet.path(
        f"M{start[0]:.1f} {start[1]:.1f} A{radius:.2f} {radius:.2f} 0 {int(turned > pi)} {sweep} "
        f"{end[0]:.1f} {end[1]:.1f}",
        colour="quiet",
        width=2.4,
    )
