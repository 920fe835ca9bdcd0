"""Where the parts of a machine stand on the sheet: lengths to one scale, pulleys enlarged where too small."""

from dataclasses import dataclass
from math import asin, cos, pi, sin, sqrt

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.report.figures.sheet import Point
from cabledrive.report.machine.rest import sag_of

SEEN = 1.5  # px
LEVEL = 0.1  # sine of the slope up to which sag is drawn
SMALLEST_PULLEY, PULLEY = 15.0, 24.0  # px
MOTOR_ROOM = {False: 112.0, True: 84.0}


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


def machine_layout(drive: Drive, width: float, narrow: bool) -> MachineLayout:
    """Lay out a machine on a sheet of given width [px], with small margins on a narrow one."""
    slope = drive.layout.inclination
    c, s = abs(cos(slope)), abs(sin(slope))
    ends = (MOTOR_ROOM[narrow] if drive.motor else 36.0, 36.0)
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
