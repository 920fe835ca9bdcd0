r"""Where a cable leaves one pulley and meets the next: tangents, wraps and lengths of a route's spans.

The tangent between circles of centres :math:`c_1, c_2`, radii r and senses s (1: anticlockwise), with
:math:`d = c_2 - c_1`, :math:`D = |d|`, :math:`\sin a = -(s_2 r_2 - s_1 r_1)/D`, runs along

.. math:: t = \cos a\,\frac{d}{D} + \sin a\,e_z \times \frac{d}{D}, \qquad n = e_z \times t

from :math:`c_1 - s_1 r_1 n` to :math:`c_2 - s_2 r_2 n`; its length is :math:`D \cos a`, Eq. (N.1).
"""

from dataclasses import dataclass
from itertools import combinations
from math import atan2, degrees, hypot, pi, sqrt

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import described, meaning

Point = tuple[float, float]

LARGEST_WRAP = 315.0 * pi / 180.0
"""A larger angle is a negative one: the cable has left the pulley."""

_ROUND_OFF = 1e-9


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """One place of a path: an anchor, or a pulley with the sense in which the cable goes round it."""

    name: str = meaning("as the path has it")
    pulley: int | None = meaning("number in the file; None of an anchor")
    anchor: int | None = meaning("number in the file; None of a pulley")
    sense: int = meaning("one of 1, -1, 0; 1: anticlockwise; 0: an anchor")
    centre: Point = meaning("[m]")
    radius: float = meaning("[m]; 0 of an anchor")
    turns: int = meaning("full turns of the cable beyond the angle", 0)
    wrap: float | None = meaning("angle of wrap that is stated, beside the drawing [rad]", None)

    @property
    def rim(self) -> float:
        """Motion of a rope per turn of its pulley [m/rad]."""
        return self.sense * self.radius


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class FreeSpan:
    """A free length of cable between two neighbouring places of a route."""

    name: str = meaning('"motor to idler"')
    route: int = meaning("number of its route in the file")
    start: Place = meaning("where it begins")
    end: Place = meaning("where it ends")
    along: Point = meaning("unit vector t in the direction of travel")
    length: float = meaning("free length under tension [m]")
    wrap: float | None = meaning(
        "angle of wrap at the pulley where it ends [rad]; None at an anchor or a drum", None
    )

    @property
    def across(self) -> Point:
        """Unit vector n, to the left of travel."""
        return -self.along[1], self.along[0]

    @property
    def contacts(self) -> tuple[Point, Point]:
        """Points where it leaves its start and meets its end [m]."""
        nx, ny = self.across
        first, last = (
            (
                place.centre[0] - place.sense * place.radius * nx,
                place.centre[1] - place.sense * place.radius * ny,
            )
            for place in (self.start, self.end)
        )
        return first, last


def tangent(start: Place, end: Place, route: str) -> tuple[Point, float]:
    """Unit vector and length [m] of the free span between two places, Eq. (N.1); refused if none."""
    dx, dy = end.centre[0] - start.centre[0], end.centre[1] - start.centre[1]
    distance = hypot(dx, dy)
    offset = end.sense * end.radius - start.sense * start.radius
    where = f'route "{route}": {start.name} to {end.name}'
    if not abs(offset) < distance * (1.0 - _ROUND_OFF):
        crossing = "cross" if start.sense != end.sense else "enclose each other"
        raise InputRefused(
            f"{where}: no free span, {distance:.4g} m between centres do not exceed {abs(offset):.4g} m, so "
            f"the circles {crossing}: move one apart, or turn the other way round it (+ or -)"
        )
    sine = -offset / distance
    cosine = sqrt(1.0 - sine**2)
    ex, ey = dx / distance, dy / distance
    return (cosine * ex - sine * ey, cosine * ey + sine * ex), distance * cosine


def spans_of_route(
    number: int, name: str, places: list[Place], closed: bool, crossed: bool
) -> list[FreeSpan]:
    """Free spans of one route in order of travel; refused where they do not run, or cross and may not."""
    following = places[1:] + places[:1] if closed else places[1:]
    pairs = list(zip(places, following, strict=False))
    lines = [tangent(start, end, name) for start, end in pairs]
    spans = []
    for i, ((start, end), (along, length)) in enumerate(zip(pairs, lines, strict=True)):
        leaving = lines[(i + 1) % len(lines)][0] if closed or i + 1 < len(lines) else None
        wrap = None
        if leaving is not None and end.sense:
            wrap = end.wrap or _wrap(end, along, leaving, name, sure=closed and len(places) == 2)
        words = f"{start.name} to {end.name}"
        spans.append(
            FreeSpan(name=words, route=number, start=start, end=end, along=along, length=length, wrap=wrap)
        )
    for one, other in combinations(spans, 2) if not crossed else ():
        if _cross(*one.contacts, *other.contacts):
            raise InputRefused(
                f'route "{name}": the spans {one.name} and {other.name} cross: check the signs + and - of '
                "its path, or write crossed = true where they pass each other"
            )
    return spans


def _wrap(place: Place, coming: Point, leaving: Point, route: str, *, sure: bool) -> float:
    """Angle from the direction of arrival to that of leaving, in the sense of the pulley.

    ``sure``: a loop round two pulleys lies on both, however far it is wrapped.
    """
    cross = coming[0] * leaving[1] - coming[1] * leaving[0]
    turned = atan2(cross, coming[0] * leaving[0] + coming[1] * leaving[1])
    wrap = (place.sense * turned) % (2.0 * pi)
    if 2.0 * pi - wrap < _ROUND_OFF:
        wrap = 0.0
    if wrap > LARGEST_WRAP and not place.turns and not sure:
        raise InputRefused(
            f'route "{route}": the wrap at {place.name} is {degrees(wrap) - 360.0:.4g} deg, the '
            "cable has left the pulley: move it, turn the other way round it (+ or -), or give its turns"
        )
    return wrap + 2.0 * pi * place.turns


def _cross(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Whether two segments meet at a point inside both."""

    def side(p: Point, q: Point, r: Point) -> float:
        """Twice the signed area over the length of pq: distance of r from the line [m]."""
        area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        return area / hypot(q[0] - p[0], q[1] - p[1])

    clear = _ROUND_OFF * (hypot(b[0] - a[0], b[1] - a[1]) + hypot(d[0] - c[0], d[1] - c[1]))
    first, second = (side(a, b, c), side(a, b, d)), (side(c, d, a), side(c, d, b))
    return all(min(pair) < -clear and max(pair) > clear for pair in (first, second))
