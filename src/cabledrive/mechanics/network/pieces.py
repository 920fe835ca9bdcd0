r"""Free spans cut at carriages, and pieces that are no straight string of even tension.

A rope of bending stiffness EI leaves a pulley of radius r where its curvature has grown to 1/r. With
:math:`e = \sqrt{EI/T}` that is e before the tangent point of a string, since the curvature decays as
:math:`e^{-x/e}/r` and turns the rope by e/r in all. Linearised about this state, displacement and slope of
the rope are those of the pulley at the point of lift-off; that the point moves enters to second order. So
the beam is clamped there, and longer than the string by e at each pulley that it wraps so far, else by half
the wrap. An anchor clamps it, and a guided carriage; a hanging carriage turns with it.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.motion import ACROSS, ALONG, OUT_OF_PLANE, Motion
from cabledrive.mechanics.network.rest_forces import RestingStretch, irvine_parameter
from cabledrive.mechanics.network.statics import Statics
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.cable import Rope
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.route import FreeSpan, Place, Route, RoutedDrive


@dataclass(frozen=True, eq=False, kw_only=True)
class Piece:
    """A length of rope between two neighbouring joints of a span."""

    span: int  # number of the free span
    start: float  # pretensioned, from the start of the span [m]
    end: float  # the same [m]
    rest: RestingStretch  # one rope
    rows: dict[str, tuple[Array, Array]]  # motion of its start and its end by direction, each shape (n,)
    where: FreeSpan
    route: Route
    rope: Rope

    @property
    def length(self) -> float:
        """Length under tension [m]."""
        return self.end - self.start

    @property
    def start_tension(self) -> float:
        """Tension at its start [N]."""
        return self.rest.tensions[0]

    @property
    def end_tension(self) -> float:
        """Tension at its end [N]."""
        return self.rest.tensions[1]

    def slope(self, x: NDArray[np.float64]) -> Array:
        """Slope against the chord; ``x`` [m] from its start, any shape."""
        along, across = self.rest.force_at(self._place(x)).reshape(2, *np.shape(x))
        return np.asarray(across / along)

    def tension(self, x: NDArray[np.float64]) -> Array:
        """Tension [N]; ``x`` [m] from its start, any shape."""
        return self.rest.tension_at(self._place(x)).reshape(np.shape(x))

    def _place(self, x: NDArray[np.float64]) -> Array:
        return self.rest.start + np.ravel(x) / self.length * self.rest.length

    @property
    def end_slopes(self) -> Array:
        """Slope against the chord at its start and its end, the steepest of a piece, shape (2,)."""
        return self.slope(np.array([0.0, self.length]))

    @property
    def irvine(self) -> float:
        r"""Irvine's :math:`\lambda^2` of its slopes."""
        if self.rest.straight:
            return 0.0
        tension = 0.5 * (self.start_tension + self.end_tension)
        square = float(0.5 * _WEIGHTS @ self.slope(0.5 * self.length * (1.0 + _POINTS)) ** 2)
        return irvine_parameter(self.rope.axial_rigidity, tension, tension**2 * square)

    def place(self, start: bool) -> Place | None:
        """Anchor or pulley at one end; None: a carriage."""
        if start:
            return self.where.start if self.start == 0.0 else None
        return self.where.end if self.end == self.where.length else None


def pieces_of(motion: Motion, statics: Statics) -> list[Piece]:
    """Pieces of all free spans in order; refused: two carriages at one place, a slack piece."""
    drive = motion.drive
    found = []
    for number, span in enumerate(drive.free_spans):
        u, w = zip(
            *(motion.end_rows(place, span.along, span.across) for place in (span.start, span.end)),
            strict=True,
        )
        rest = np.zeros(len(motion.names))
        joints = [(0.0, {ALONG: u[0], ACROSS: w[0], OUT_OF_PLANE: rest})]
        own = [(place, i) for i, (at, place) in enumerate(drive.carriage_places) if at == number]
        for place, i in sorted(own):
            name = motion.carriage_name(i)
            joints.append(
                (place, {way: motion.unit(f"{name} {way}") for way in (ALONG, ACROSS, OUT_OF_PLANE)})
            )
        joints.append((span.length, {ALONG: u[1], ACROSS: w[1], OUT_OF_PLANE: rest}))
        for own_rest, ((start, near), (end, far)) in zip(
            statics.stretches[number], pairwise(joints), strict=True
        ):
            if end - start <= 1e-9 * span.length:
                raise InputRefused(
                    f"two carriages share a place on span {span.name}: add the masses or move one"
                )
            if own_rest.lowest_tension <= 0.0:
                said = f"span {span.name}: its tension at rest falls to {own_rest.lowest_tension:.4g} N"
                raise InputRefused(f"{said}: raise pretension")
            found.append(
                Piece(
                    span=number,
                    start=start,
                    end=end,
                    rest=own_rest,
                    rows={way: (near[way], far[way]) for way in (ALONG, ACROSS, OUT_OF_PLANE)},
                    where=span,
                    route=drive.route[span.route],
                    rope=drive.ropes[span.route],
                )
            )
    return found


EVEN = 5e-6
"""Change of the tension along a piece, relative, below which it is even: (EVEN)^2/300 of a frequency."""


_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(24)


@dataclass(frozen=True, slots=True, kw_only=True)
class Element:
    """One rope across: a string whose tension changes along it, a tensioned beam, a rope that hangs."""

    start_tension: float  # [N]
    end_tension: float  # [N]
    length: float  # under tension, lift-off from pulleys included [m]
    before: float  # part of it before the tangent point at the start [m]
    density: float  # mass per unstretched length [kg/m]
    axial_rigidity: float  # EA [N]
    bending: float  # EI [N m^2]; 0: a string
    # its piece at rest, from tangent point to tangent point of a straight rope
    hanging: Piece | None = None
    along: float = 0.0  # length where it is stretched, of one that hangs, lift-off by bending left out [m]

    @property
    def tension(self) -> float:
        """Tension of the even string with the same travel time [N]."""
        return (0.5 * (sqrt(self.start_tension) + sqrt(self.end_tension))) ** 2

    @property
    def stretch(self) -> float:
        """Length under tension over the unstretched one."""
        return 1.0 + self.tension / self.axial_rigidity

    def tension_at(self, x: NDArray[np.float64]) -> Array:
        """Tension [N]; ``x`` [m] from its start, any shape."""
        if self.hanging is not None:
            return self.hanging.tension(x - self.before)
        return np.asarray(self.start_tension + (self.end_tension - self.start_tension) * x / self.length)


def element_of(drive: RoutedDrive, piece: Piece, direction: str) -> Element | None:
    """The element of a piece in one direction; None: a straight string of even tension, as running ropes."""
    change = abs(piece.end_tension - piece.start_tension) / piece.start_tension
    even = change <= EVEN and not piece.rope.bending_stiffness
    return None if direction == ALONG or piece.route.speed or even else straight_element(drive, piece)


def straight_element(drive: RoutedDrive, piece: Piece) -> Element:
    """One rope of a piece across, from lift-off to lift-off."""
    bending = piece.rope.bending_stiffness or 0.0
    before, after = (lift_off(drive, piece, start=own) if bending else 0.0 for own in (True, False))
    return Element(
        start_tension=piece.start_tension,
        end_tension=piece.end_tension,
        length=before + piece.length + after,
        before=before,
        density=piece.rope.density,
        axial_rigidity=piece.rope.axial_rigidity,
        bending=bending,
    )


def lift_off(drive: RoutedDrive, piece: Piece, *, start: bool) -> float:
    """How far beyond the tangent point the rope leaves its pulley [m]; 0 at anchors and carriages."""
    place = piece.place(start)
    if place is None or place.sense == 0:
        return 0.0
    bending = piece.rope.bending_stiffness or 0.0
    free = sqrt(bending / (piece.start_tension if start else piece.end_tension))
    wrap = wrap_at(drive, piece.span, start)
    return free if wrap is None else min(free, 0.5 * wrap[1] * place.radius)


def carriage_at(drive: RoutedDrive, span: int, place: float) -> int:
    """Number of the carriage at a place inside a span; ``place`` [m] from its start."""
    places = drive.carriage_places
    return next(number for number, (own, at) in enumerate(places) if own == span and at == place)


def wrap_at(drive: RoutedDrive, span: int, start: bool) -> tuple[int, float] | None:
    """The span that ends at the pulley at one end of a span, and the wrap there [rad]; None on a drum."""
    route = drive.free_spans[span].route
    own = [number for number, other in enumerate(drive.free_spans) if other.route == route]
    if start and span == own[0] and not drive.route[route].closed:
        return None
    number = own[own.index(span) - 1] if start else span
    wrap = drive.free_spans[number].wrap
    return None if wrap is None else (number, wrap)
