r"""Spans of a network that hang under their weight and their carriages', as elements of shallow sag.

With y the height of the rope at rest over the chord of its tangent points, :math:`\theta = y'`, and u, w the
motion along and across the chord, the rope is stretched by :math:`u' + \theta w'`, so that

.. math::
    2 V = \int EA\,(u' + \theta w')^2 + T\,w'^2 + EI\,w''^2\,dx, \qquad
    \theta = \frac{V_0 - \int q\,dx}{T}, \qquad \int\theta\,dx = 0, \qquad \text{Eq. (N.13)}

where q is the weight across it and the shear :math:`V_0` follows from the ends that lie on the chord. A rope
that is fed round strains nothing. What is left out is of second order in :math:`\theta`.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.network.motion import gravity
from cabledrive.mechanics.network.pieces import Element, carriage_at, end_place, straight_element
from cabledrive.mechanics.sag import irvine_parameter
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.geometry import Place

STRAIGHT = 5e-7
r"""Irvine's :math:`\lambda^2` up to which a rope is straight: it moves no frequency by more than 1e-4."""

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(24)


@dataclass(frozen=True, slots=True, kw_only=True)
class Hanging:
    """A piece of rope at rest that hangs."""

    shear: float  # force across the chord at its start [N]
    load: float  # weight across the chord per metre [N/m]
    start_tension: float  # as of its `Piece` [N]
    end_tension: float  # [N]
    length: float  # [m]

    def tension(self, x: NDArray[np.float64]) -> Array:
        """Tension [N]; ``x`` [m] from its start, any shape."""
        return np.asarray(self.start_tension + (self.end_tension - self.start_tension) * x / self.length)

    def slope(self, x: NDArray[np.float64]) -> Array:
        """Slope against the chord; ``x`` [m] from its start, any shape."""
        return np.asarray((self.shear - self.load * x) / self.tension(x))

    @property
    def end_slopes(self) -> Array:
        """Slope against the chord at its start and its end, the steepest of a piece, shape (2,)."""
        return self.slope(np.array([0.0, self.length]))

    def mean(self, power: int) -> float:
        """Mean of a power of the slope."""
        x = 0.5 * self.length * (1.0 + _POINTS)
        return float(0.5 * _WEIGHTS @ self.slope(x) ** power)

    def irvine(self, rigidity: float) -> float:
        r"""Irvine's :math:`\lambda^2` of its slopes; ``rigidity``: EA [N]."""
        tension = 0.5 * (self.start_tension + self.end_tension)
        return irvine_parameter(rigidity, tension, tension**2 * self.mean(2))


def hanging_pieces(network: Network) -> list[Hanging]:
    """How pieces of spans hang at rest, in order; a guided carriage on the chord bears them, others hang."""
    drive, g = network.drive, gravity(network.drive)
    found: list[Hanging] = []
    run: list[Hanging] = []
    for piece in network.pieces:
        span = drive.free_spans[piece.span]
        across = np.array(span.across)
        end = run[-1].shear - run[-1].load * run[-1].length if run else 0.0
        if run:
            end -= drive.carriage[carriage_at(drive, piece.span, piece.start)].mass * float(g @ across)
        run.append(
            Hanging(
                shear=end,
                load=float(network.statics.line_load[piece.span] @ across),
                start_tension=piece.start_tension,
                end_tension=piece.end_tension,
                length=piece.length,
            )
        )
        if piece.end == span.length or drive.carriage[carriage_at(drive, piece.span, piece.end)].guided:
            # the shear that brings the ends of what hangs between two places of the chord there
            rise = sum(own.mean(1) * own.length for own in run)
            unit = sum(replace(own, shear=1.0, load=0.0).mean(1) * own.length for own in run)
            found += [replace(own, shear=own.shear - rise / unit) for own in run]
            run = []
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class HangingElement(Element):
    """One rope that hangs, along and across its chord together."""

    hanging: Hanging  # its piece at rest, from tangent point to tangent point of a straight rope
    along: float  # its length where it is stretched, lift-off by bending left out [m]

    def slope(self, x: NDArray[np.float64]) -> Array:
        """Slope against the chord; ``x`` [m] from its start, any shape."""
        return self.hanging.slope(x - self.before)

    def tension_at(self, x: NDArray[np.float64]) -> Array:
        """Tension [N]; ``x`` [m] from its start, any shape."""
        return self.hanging.tension(x - self.before)


def irvine_parameters(network: Network) -> Array:
    r"""Irvine's :math:`\lambda^2` of all free spans at rest, the largest of their pieces, shape (spans,).

    Of a span without carriages it is :math:`(q L/T)^2\,EA/T`.
    """
    return _at_rest(network)[1]


def hanging_elements(network: Network) -> dict[int, HangingElement]:
    """Elements of the pieces that hang, Eq. (N.13), by the number of the piece; none of ropes that run."""
    drive = network.drive
    hanging, irvine = _at_rest(network)
    found: dict[int, HangingElement] = {}
    for number, (piece, own) in enumerate(zip(network.pieces, hanging, strict=False)):
        if irvine[piece.span] <= STRAIGHT or drive.route[drive.free_spans[piece.span].route].speed:
            continue
        straight = straight_element(drive, piece)
        near, far = own.end_slopes.tolist()
        before = _shift(end_place(drive, piece, True), near)
        after = -_shift(end_place(drive, piece, False), far)
        same = {one.name: getattr(straight, one.name) for one in fields(straight)}
        same |= {"length": straight.length + before + after, "before": straight.before + before}
        found[number] = HangingElement(**same, hanging=own, along=piece.length + before + after)
    return found


def _at_rest(network: Network) -> tuple[list[Hanging], Array]:
    """How the pieces of all spans hang, none without gravity, and Irvine's parameter of each span."""
    drive, irvine = network.drive, np.zeros(len(network.drive.free_spans))
    if drive.layout.gravity == 0.0:
        return [], irvine
    hanging = hanging_pieces(network)
    for piece, own in zip(network.pieces, hanging, strict=True):
        rigidity = drive.ropes[drive.free_spans[piece.span].route].axial_rigidity
        irvine[piece.span] = max(irvine[piece.span], own.irvine(rigidity))
    return hanging, irvine


def _shift(place: Place | None, turned: float) -> float:
    """How far a rope that is turned leaves its pulley before the tangent point of a straight one [m]."""
    return 0.0 if place is None else -place.sense * place.radius * turned
