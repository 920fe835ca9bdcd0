r"""Free spans cut at carriages.

A rope of bending stiffness EI leaves a pulley of radius r where its curvature has grown to 1/r. With
:math:`e = \sqrt{EI/T}`, T what is left of the tension of a rope that runs, that is e before the tangent
point of a string, since the curvature decays as :math:`e^{-x/e}/r` and turns the rope by e/r in all.
Linearised about this state, displacement and slope of the rope are those of the pulley at the point of
lift-off; that the point moves enters to second order, as what runs carries along within so short a length. So
the beam is clamped there, and longer than the string by e at each pulley that it wraps so far, else by half
the wrap. An anchor clamps it, and a guided carriage; a hanging carriage turns with it.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import copysign, hypot, sqrt

from cabledrive.mechanics.network.motion import ACROSS, ALONG, OUT_OF_PLANE, Motion, Row
from cabledrive.mechanics.network.rest_forces import RestingStretch
from cabledrive.mechanics.network.statics import Statics
from cabledrive.parameters.cable import Rope
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.route import FreeSpan, Machine, Place, Route


@dataclass(frozen=True, eq=False, kw_only=True)
class Piece:
    """A length of rope between two neighbouring joints of a span."""

    span: int  # number of the free span
    start: float  # pretensioned, from the start of the span [m]
    end: float  # the same [m]
    rest: RestingStretch  # one rope
    rows: dict[str, tuple[Row, Row]]  # motion of its start and its end by direction, of a straight rope
    rims: tuple[Row, Row]  # what rims add to those along
    carriages: tuple[int, int]  # their numbers at its start and its end; -1: an anchor or a pulley
    where: FreeSpan
    route: Route
    rope: Rope

    @property
    def length(self) -> float:
        """Length under tension [m]."""
        return self.end - self.start

    @property
    def unstretched(self) -> tuple[float, float]:
        """Places of its ends on the rope of the straight machine, from the start of the span [m]."""
        tension = self.rope.pretension or 0.5 * sum(self.rest.tensions)
        stretch = 1.0 + tension / self.rope.axial_rigidity
        return self.start / stretch, self.end / stretch

    @property
    def speed(self) -> float:
        """Unstretched length of rope that passes, the same all along a route [m/s]."""
        return copysign(sqrt(self.rest.flow / self.rope.density), self.route.speed)

    @property
    def start_tension(self) -> float:
        """Tension at its start [N]."""
        return self.rest.tensions[0]

    @property
    def end_tension(self) -> float:
        """Tension at its end [N]."""
        return self.rest.tensions[1]

    def direction(self, start: bool) -> tuple[float, float]:
        """Cosine and sine of the rope at one end against its chord."""
        along, across = self.rest.force if start else self.rest.end_force
        size = hypot(along, across)
        return (1.0, 0.0) if self.rest.straight or not size else (along / size, across / size)

    def moves(self, start: bool, *, along_itself: bool = False) -> tuple[Row, Row]:
        """Motion of one end along and across the chord, where a rim moves the rope along its own direction.

        ``along_itself``: along and across that direction.
        """
        (u, w), rim = (self.rows[way][not start] for way in (ALONG, ACROSS)), self.rims[not start]
        (cosine, sine), u = self.direction(start), u - rim
        if along_itself:
            return cosine * u + sine * w + rim, cosine * w - sine * u
        return u + cosine * rim, w + sine * rim

    def place(self, start: bool) -> Place | None:
        """Anchor or pulley at one end; None: a carriage."""
        if start:
            return self.where.start if self.start == 0.0 else None
        return self.where.end if self.end == self.where.length else None


def pieces_of(motion: Motion, statics: Statics) -> list[Piece]:
    """Pieces of all free spans in order; refused: two carriages at one place."""
    drive = motion.drive
    found = []
    carried: list[list[tuple[float, int]]] = [[] for _ in drive.free_spans]
    for i, (at, place) in enumerate(drive.carriage_places):
        carried[at].append((place, i))
    for number, span in enumerate(drive.free_spans):
        u, w = zip(
            *(motion.end_rows(place, span.along, span.across) for place in (span.start, span.end)),
            strict=True,
        )
        joints = [(0.0, -1, {ALONG: u[0], ACROSS: w[0], OUT_OF_PLANE: Row()})]
        for place, i in sorted(carried[number]):
            name = motion.carriage_name(i)
            moves = {way: motion.unit(f"{name} {way}") for way in (ALONG, ACROSS, OUT_OF_PLANE)}
            joints.append((place, i, moves))
        joints.append((span.length, -1, {ALONG: u[1], ACROSS: w[1], OUT_OF_PLANE: Row()}))
        for own_rest, ((start, first, near), (end, last, far)) in zip(
            statics.stretches[number], pairwise(joints), strict=True
        ):
            if end <= start:
                raise InputRefused(
                    f"two carriages share a place on span {span.name}: add the masses or move one"
                )
            found.append(
                Piece(
                    span=number,
                    start=start,
                    end=end,
                    rest=own_rest,
                    rims=(
                        motion.rim(span.start) if start == 0.0 else Row(),
                        motion.rim(span.end) if end == span.length else Row(),
                    ),
                    rows={way: (near[way], far[way]) for way in (ALONG, ACROSS, OUT_OF_PLANE)},
                    carriages=(first, last),
                    where=span,
                    route=drive.route[span.route],
                    rope=drive.ropes[span.route],
                )
            )
    return found


def lift_off(drive: Machine, piece: Piece, *, start: bool) -> float:
    """How far beyond the tangent point the rope leaves its pulley [m]; 0 elsewhere, and where it is slack."""
    place = piece.place(start)
    if place is None or place.sense == 0 or piece.rest.lowest_tension <= 0.0:
        return 0.0
    bending, force = piece.rope.bending_stiffness or 0.0, piece.rest.force if start else piece.rest.end_force
    free = sqrt(bending / hypot(*force))
    wrap = wrap_at(drive, piece.span, start)
    return free if wrap is None else min(free, 0.5 * wrap[1] * place.radius)


def wrap_at(drive: Machine, span: int, start: bool) -> tuple[int, float] | None:
    """The span that ends at the pulley at one end of a span, and the wrap there [rad]; None on a drum."""
    route = drive.free_spans[span].route
    own = [number for number, other in enumerate(drive.free_spans) if other.route == route]
    if start and span == own[0] and not drive.route[route].closed:
        return None
    number = own[own.index(span) - 1] if start else span
    wrap = drive.free_spans[number].wrap
    return None if wrap is None else (number, wrap)
