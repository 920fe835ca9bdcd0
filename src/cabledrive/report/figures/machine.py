"""A drawing of the machine, and where its parts stand on the sheet."""

from dataclasses import dataclass
from math import asin, cos, degrees, hypot, pi, sin, sqrt

import numpy as np
from markupsafe import Markup

from cabledrive.parameters import Carriage, Drive
from cabledrive.parameters.arrays import Array
from cabledrive.report.figures.sheet import Point, Sheet
from cabledrive.report.machine.rest import sag_of
from cabledrive.report.picture import CARD_WIDTH, SMALL
from cabledrive.report.typesetting import number, quantity

SEEN = 1.5  # px
LEVEL = 0.1  # sine of the slope up to which sag is drawn
SMALLEST_PULLEY, PULLEY = 15.0, 24.0  # px
MOTOR_ROOM = 112.0


@dataclass(frozen=True, slots=True, kw_only=True)
class MachineLayout:
    """Places on the sheet [px]."""

    size: Point  # of the sheet
    drive: Point  # axle
    load: Point  # axle
    radii: Point  # of the two pulleys as drawn
    enlarged: float  # how many times too large the pulleys are drawn; 1 where everything is to scale
    slope: float  # of the line from drive to load pulley [rad]
    hanging: float  # room below the lower span that hanging carriages and its sag take [px]
    sags: dict[str, tuple[Array, Array]]
    """By span: shares of its length, sag there [px]; straight if not named."""

    @property
    def level(self) -> bool:
        """Whether the machine lies rather than stands."""
        return abs(self.slope) < pi / 4

    def rightwards(self, across: float) -> float:
        """1 where a side, 1 that of the upper span, -1 the other, lies to the right on the sheet, else -1."""
        return 1.0 if self.off((0.0, 0.0), 0.0, across)[0] > 0.0 else -1.0

    def off(self, point: Point, along: float, across: float) -> Point:
        """A point moved towards the load pulley and to the side of the upper span [px]."""
        c, s = cos(self.slope), sin(self.slope)
        return point[0] + along * c - across * s, point[1] - along * s - across * c

    def tangent(self, span: str) -> tuple[Point, Point]:
        """Where a span leaves the drive pulley and where it leaves the load pulley."""
        side = 1.0 if span == "upper" else -1.0
        distance = sqrt((self.load[0] - self.drive[0]) ** 2 + (self.load[1] - self.drive[1]) ** 2)
        tilt = asin(max(-1.0, min(1.0, (self.radii[0] - self.radii[1]) / distance)))
        first, second = (
            self.off(axle, radius * sin(tilt), side * radius * cos(tilt))
            for axle, radius in zip((self.drive, self.load), self.radii, strict=True)
        )
        return first, second

    def on_span(self, span: str, share: float) -> Point:
        """A point at a share of a span's length, from the pulley where it starts."""
        a, b = self.tangent(span)
        fallen = float(np.interp(share, *self.sags[span])) if span in self.sags else 0.0
        share = share if span == "upper" else 1.0 - share
        return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]) + fallen

    def curve(self, span: str) -> list[Point]:
        """Points of a span as it hangs, its two ends alone where it is straight."""
        shares = np.linspace(0.0, 1.0, 61) if span in self.sags else (0.0, 1.0)
        return [self.on_span(span, float(share)) for share in shares]


def machine_layout(drive: Drive, width: float) -> MachineLayout:
    """Lay out a machine on a sheet of given width [px]."""
    slope = drive.layout.inclination
    c, s = abs(cos(slope)), abs(sin(slope))
    ends = (MOTOR_ROOM if drive.motor else 36.0, 36.0)
    side = 62.0 if c > s else 120.0
    room = (width - sum(ends) * c - 2 * side * s, 330.0 - sum(ends) * s)
    true = [pulley.radius for pulley in drive.pulley]
    length = drive.span_length
    whole = min(room[0] / c if c > 1e-6 else 1e9, room[1] / s if s > 1e-6 else 1e9)
    scale = whole / (length + sum(true))
    enlarged = 1.0
    if max(true) * scale < SMALLEST_PULLEY:
        scale = (whole - PULLEY * sum(true) / max(true)) / length
        enlarged = PULLEY / (max(true) * scale)
    radii = (max(true[0] * scale * enlarged, 5.0), max(true[1] * scale * enlarged, 5.0))
    sags = _sags(drive, scale)
    hanging = 22.0 if any(not carriage.guided for carriage in drive.carriages_on("lower")) else 0.0
    hanging += max((float(depth.max()) for _, depth in sags.values()), default=0.0)
    return _placed(slope, length * scale, radii, enlarged, ends, width, hanging, sags)


def _sags(drive: Drive, scale: float) -> dict[str, tuple[Array, Array]]:
    """Sag of the spans of a lying machine where it can be seen; ``scale`` [px/m]."""
    if abs(sin(drive.layout.inclination)) > LEVEL:
        return {}
    found = {}
    for span in drive.spans:
        places, depth = sag_of(drive, span)
        if scale * float(depth.max()) >= SEEN:
            found[span] = (places / drive.span_length, scale * depth)
    return found


def _placed(
    slope: float,
    distance: float,
    radii: Point,
    enlarged: float,
    ends: Point,
    width: float,
    hanging: float,
    sags: dict[str, tuple[Array, Array]],
) -> MachineLayout:
    """Put the machine in the middle of the sheet, with room for words above and below."""
    dx, dy = distance * cos(slope), -distance * sin(slope)
    reach = max(radii)
    level = abs(slope) < pi / 4
    above = (46.0 if abs(slope) < 0.1 else 66.0) + reach if level else ends[0] + reach
    below = (80.0 if enlarged > 1.0 else 58.0) + hanging + reach if level else ends[1] + reach
    below += 26.0 * sin(abs(slope)) if level else 0.0
    if not level and slope > 0:
        above, below = below, above
    height = above + abs(dy) + below
    left = ends[0] + radii[0] if level else (width - dx) / 2 if abs(dx) > 1 else width / 2
    drive = (left, above if dy >= 0 else above - dy)
    return MachineLayout(
        size=(width, height),
        drive=drive,
        load=(drive[0] + dx, drive[1] + dy),
        radii=radii,
        enlarged=enlarged,
        slope=slope,
        hanging=hanging,
        sags=sags,
    )


SPAN_COLOURS = {"upper": "blue", "lower": "orange"}
FEW, MANY = 4, 80
UPRIGHT = 1.5  # rad
NAME_PLACES = (0.5, 0.62, 0.38, 0.72, 0.28, 0.8, 0.2)


def machine_sketch(drive: Drive) -> Markup:
    """The machine without words, for a card."""
    sheet = Sheet(wordless=True)
    return sheet.svg(draw_machine(sheet, drive, CARD_WIDTH).size)


def draw_machine(sheet: Sheet, drive: Drive, width: float) -> MachineLayout:
    """Draw a machine on a sheet of a width [px]; returns where its parts stand."""
    layout = machine_layout(drive, width)
    _cable(sheet, drive, layout)
    _pulleys(sheet, drive, layout)
    if drive.motor is not None:
        _motor(sheet, drive, layout)
    for span in drive.spans:
        _carriages(sheet, drive.carriages_on(span), drive.span_length, span, layout)
        if not sheet.wordless:
            _span_name(sheet, drive, span, layout)
    if not sheet.wordless:
        _length(sheet, drive, layout)
        _gravity(sheet, drive, layout)
    return layout


def _cable(sheet: Sheet, drive: Drive, layout: MachineLayout) -> None:
    """The spans in their colours, the cable on the pulleys in ink; of a line, both ends on the drums."""
    r1, r2 = layout.radii
    (u1, u2), (l1, l2) = layout.tangent("upper"), layout.tangent("lower")
    if drive.kind == "loop":
        _arc(sheet, l1, u1, r1, r1 > r2)
        _arc(sheet, u2, l2, r2, r2 > r1)
        sheet.line(*layout.curve("lower"), colour=SPAN_COLOURS["lower"], width=2.6)
    else:
        for axle, r, side, tangent in ((layout.drive, r1, -1, u1), (layout.load, r2, 1, u2)):
            end = layout.off(axle, side * r * sin(4.2), r * cos(4.2))
            _arc(sheet, *((end, tangent) if side < 0 else (tangent, end)), r, True)
            sheet.circle(end, 2.6, fill="ink")
    sheet.line(*layout.curve("upper"), colour=SPAN_COLOURS["upper"], width=2.6)


def _arc(sheet: Sheet, start: Point, end: Point, radius: float, large: bool) -> None:
    sheet.path(
        f"M{start[0]:.1f} {start[1]:.1f} A{radius:.2f} {radius:.2f} 0 {int(large)} 1 {end[0]:.1f} "
        f"{end[1]:.1f}",
        width=2.6,
    )


def _pulleys(sheet: Sheet, drive: Drive, layout: MachineLayout) -> None:
    names = ("drive pulley", "load pulley") if drive.kind == "loop" else ("drive drum", "load drum")
    for axle, r, pulley, name in zip(
        (layout.drive, layout.load), layout.radii, drive.pulley, names, strict=True
    ):
        if pulley.fixed:
            _support(sheet, axle, r)
        else:
            sheet.circle(axle, r - 2.2, colour="quiet", width=1, fill="card")
            sheet.circle(axle, 2.2, fill="ink")
        words = (f"{name}, fixed" if pulley.fixed else name, f"r = {quantity(pulley.radius, 'm')}")
        for line, text in enumerate(words):
            at, anchor = _beside(layout, axle, r, line)
            sheet.words(text, at, anchor=anchor, colour="quiet" if line else "ink")


def _beside(layout: MachineLayout, axle: Point, radius: float, line: int) -> tuple[Point, str]:
    """Where the words about a pulley stand: right of it in a standing machine; else below or above."""
    if layout.level and abs(layout.slope) > 0.1 and axle[1] == min(layout.drive[1], layout.load[1]):
        return (axle[0], axle[1] - radius - 24 + 15 * line), "middle"
    if layout.level:
        return (axle[0], axle[1] + radius + layout.hanging + 20 + 15 * line), "middle"
    return (axle[0] + radius + 12, axle[1] + 15 * line - 4), "start"


def _support(sheet: Sheet, axle: Point, radius: float) -> None:
    """A rigid support: a hatched block instead of a pulley."""
    sheet.box(axle, (2 * radius - 4, 2 * radius - 4))
    x, y, a = axle[0], axle[1], radius - 2
    for step in (-1.0, -0.5, 0.0, 0.5, 1.0):
        first, last = max(-1.0, step - 1), min(1.0, step + 1)
        sheet.line((x + a * first, y + a * (step - first)), (x + a * last, y + a * (step - last)), width=0.8)


def _motor(sheet: Sheet, drive: Drive, layout: MachineLayout) -> None:
    """The motor on the drive pulley's shaft, behind a zigzag where the joint is flexible."""
    assert drive.motor is not None
    r, reach = layout.radii[0], 62.0
    place = layout.off(layout.drive, -(r + reach), 0.0)
    rim = layout.off(layout.drive, -(r + 4), 0.0)
    if drive.motor.joint_stiffness is None:
        sheet.line(layout.drive, place, width=2)
    else:
        steps = [layout.off(rim, -(reach - 20) * k / 8, 5 * sin(pi * k / 2)) for k in range(9)]
        sheet.line(layout.drive, *steps, place, width=1.4)
        stiffness = quantity(drive.motor.joint_stiffness, "N m/rad", 3)
        sheet.words(stiffness, (place[0] + 8, place[1] - 22), colour="quiet", size=SMALL)
    sheet.box(place, (30, 26))
    sheet.words("M", (place[0], place[1] + 4.5), size=13)
    at = (place[0], place[1] + 29) if layout.level else (place[0] + 22, place[1] + 4)
    sheet.words("motor", at, anchor="middle" if layout.level else "start")


def _carriages(
    sheet: Sheet, carriages: tuple[Carriage, ...], length: float, span: str, layout: MachineLayout
) -> None:
    """Boxes on the cable: on rails where guided, on hangers where they hang."""
    few = len(carriages) <= FEW
    outward = 1.0 if span == "upper" else -1.0
    if len(carriages) > MANY:
        ends = [layout.on_span(span, carriages[end].position / length) for end in (0, -1)]
        sheet.line(*((x, y + 7) for x, y in ends), colour="green", width=6)
        return
    for carriage in carriages:
        at = layout.on_span(span, carriage.position / length)
        box = ((28, 16) if layout.level else (16, 28)) if few else (8, 8)
        if carriage.guided:
            rail = [layout.off(at, along, -outward * 12) for along in (-28, 28)] if few else []
            if rail:
                sheet.line(*rail, colour="quiet")
            middle = at
        else:
            drop = 20.0 if few else 13.0
            sheet.line(at, (at[0], at[1] + drop - box[1] / 2))
            middle = (at[0], at[1] + drop)
        sheet.box(middle, box, colour="green")
        if few:
            _mass(sheet, carriage, middle, at, outward, layout)


def _mass(
    sheet: Sheet, carriage: Carriage, middle: Point, at: Point, outward: float, layout: MachineLayout
) -> None:
    text = quantity(carriage.mass, "kg")
    if not layout.level:
        right = layout.rightwards(outward)
        anchor = "start" if right > 0 else "end"
        sheet.words(text, (middle[0] + right * 14, middle[1] + 4), anchor=anchor, colour="green")
    elif outward > 0:
        sheet.words(text, (at[0], at[1] - 14), colour="green")
    else:
        sheet.words(text, (at[0], middle[1] + 22), colour="green")


def _span_name(sheet: Sheet, drive: Drive, span: str, layout: MachineLayout) -> None:
    """Name of a span where no carriage is in the way; an arrow in the direction of its coordinate."""
    carriages = drive.carriages_on(span)
    taken = [9.0, *(carriage.position / drive.span_length for carriage in carriages)]
    (x1, y1), (x2, y2) = layout.drive, layout.load
    enough = (90.0 if layout.level else 36.0) / max(hypot(x2 - x1, y2 - y1), 1.0)
    places = sorted(NAME_PLACES, key=lambda place: -min(enough, *(abs(place - t) for t in taken)))
    share = places[0] if len(carriages) <= FEW else 0.5
    a, b = (layout.on_span(span, share + step) for step in (-0.02, 0.03))
    gap = max(hypot(b[0] - a[0], b[1] - a[1]), 1e-9)
    tip = (a[0] + (b[0] - a[0]) * 14 / gap, a[1] + (b[1] - a[1]) * 14 / gap)
    sheet.arrow(a, tip, colour=SPAN_COLOURS[span], width=2.6)
    text = f"{span} span, {len(carriages)} carriages"
    if len(carriages) <= FEW or enough > 0.3:
        text = f"{span} span"
    outward = 1.0 if span == "upper" else -1.0
    if layout.level:
        below = 20.0 + layout.hanging
        aslant = 40.0 * abs(sin(layout.slope))  # level words beside a slanting line
        at = layout.off(
            layout.on_span(span, share), 0.0, (11.0 if outward > 0 else -below) + outward * aslant
        )
        sheet.words(text, at, colour=SPAN_COLOURS[span])
    else:
        at = layout.off(layout.on_span(span, share), 0.0, outward * 12)
        anchor = "start" if layout.rightwards(outward) > 0 else "end"
        sheet.words(text, at, anchor=anchor, colour=SPAN_COLOURS[span])


def _length(sheet: Sheet, drive: Drive, layout: MachineLayout) -> None:
    """The length of the spans, and how much too large the pulleys are."""
    below = -1.0 if layout.level else -layout.rightwards(1.0)  # on the left of a standing machine
    aslant = 30.0 * abs(sin(layout.slope)) if layout.level else 0.0
    gap = below * (max(layout.radii) + (50.0 + layout.hanging + aslant if layout.level else 96.0))
    ends = [layout.off(axle, 0.0, gap) for axle in (layout.drive, layout.load)]
    middle = ((ends[0][0] + ends[1][0]) / 2, (ends[0][1] + ends[1][1]) / 2)
    text = f"L = {quantity(drive.span_length, 'm')}"
    slanting = not layout.level and abs(layout.slope) < UPRIGHT
    if not slanting:
        for end in ends:
            sheet.line(layout.off(end, 0, 5), layout.off(end, 0, -5), colour="line")
        sheet.line(*ends, colour="line")
    if slanting:
        sheet.words(text, (layout.size[0], 66), anchor="end", colour="quiet")
    elif layout.level:
        sheet.words(text, (middle[0], middle[1] - 6), colour="quiet")
    else:
        sheet.words(text, (ends[0][0], min(end[1] for end in ends) - 9), colour="quiet")
    if layout.enlarged > 1.0:
        note = f"Pulleys drawn {number(layout.enlarged, 2)} times too large."
        sheet.words(note, (0, layout.size[1] - 3), anchor="start", colour="quiet", size=SMALL)


def _gravity(sheet: Sheet, drive: Drive, layout: MachineLayout) -> None:
    """The direction of gravity, and the slope of a machine that neither lies nor stands."""
    if drive.layout.gravity > 0.0:
        x = layout.size[0] - 12
        sheet.arrow((x, 4), (x, 34), colour="quiet")
        sheet.words("g", (x - 8, 20), anchor="end", colour="quiet")
    if 0.01 < abs(layout.slope) < UPRIGHT:
        slope = f"slope {number(degrees(layout.slope), 3)}°"
        sheet.words(slope, (layout.size[0], 50), anchor="end", colour="quiet")
