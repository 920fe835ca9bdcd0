r"""Spans of a network that hang under their weight and their carriages', as elements of shallow sag.

With y the height of the rope at rest over the chord of its tangent points, :math:`\theta = y'`, and u, w the
motion along and across the chord, the rope is stretched by :math:`u' + \theta w'`, so that

.. math::
    2 V = \int EA\,(u' + \theta w')^2 + T\,w'^2 + EI\,w''^2\,dx, \qquad
    \theta = \frac{V_0 - \int q\,dx}{T}, \qquad \int\theta\,dx = 0, \qquad \text{Eq. (N.13)}

where q is the weight across it and the shear :math:`V_0` follows from the ends that lie on the chord. A rope
that is fed round strains nothing. What is left out is of second order in :math:`\theta`.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.network.elements import Element, end_place, lift_off
from cabledrive.mechanics.network.motion import Array
from cabledrive.mechanics.network.pieces import Piece
from cabledrive.mechanics.network.sections import gravity
from cabledrive.parameters.route.geometry import Place

STRAIGHT = 5e-7
r"""Irvine's :math:`\lambda^2` up to which a rope is straight: it moves no frequency by more than 1e-4."""

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(24)


@dataclass(frozen=True, slots=True, kw_only=True)
class Hanging:
    """A piece of rope at rest that hangs.

    Attributes
    ----------
    shear : float
        Force across the chord at its start [N].
    load : float
        Weight across the chord per metre [N/m].
    start_tension, end_tension, length : float
        As of its `Piece` [N], [m].
    """

    shear: float
    load: float
    start_tension: float
    end_tension: float
    length: float

    def slope(self, x: NDArray[np.float64]) -> Array:
        """Slope against the chord; ``x`` [m] from its start, any shape."""
        tension = self.start_tension + (self.end_tension - self.start_tension) * x / self.length
        return np.asarray((self.shear - self.load * x) / tension)

    def mean(self, power: int) -> float:
        """Mean of a power of the slope."""
        x = 0.5 * self.length * (1.0 + _POINTS)
        return float(0.5 * _WEIGHTS @ self.slope(x) ** power)

    @property
    def steepest(self) -> float:
        """Largest slope against the chord."""
        return float(np.abs(self.slope(np.array([0.0, self.length]))).max())


def hanging_pieces(network: Network) -> list[Hanging]:
    """How the pieces of all spans hang at rest, in their order.

    A guided carriage lies on the chord and bears the rope; others hang on it.
    """
    drive, g = network.drive, gravity(network.drive)
    found: list[Hanging] = []
    run: list[Hanging] = []
    for piece in network.pieces:
        span = drive.free_spans[piece.span]
        across = np.array(span.across)
        end = run[-1].shear - run[-1].load * run[-1].length if run else 0.0
        if run:
            end -= _weight_at(network, piece, g @ across)
        run.append(
            Hanging(
                shear=end,
                load=float(network.statics.line_load[piece.span] @ across),
                start_tension=piece.start_tension,
                end_tension=piece.end_tension,
                length=piece.length,
            )
        )
        if piece.end == span.length or _guided(network, piece.span, piece.end):
            found += _on_chord(run)
            run = []
    return found


def _on_chord(run: list[Hanging]) -> list[Hanging]:
    """Pieces between two places on the chord, with the shear that brings their ends there."""
    rise = sum(own.mean(1) * own.length for own in run)
    unit = sum(replace(own, shear=1.0, load=0.0).mean(1) * own.length for own in run)
    return [replace(own, shear=own.shear - rise / unit) for own in run]


def _carriage(network: Network, span: int, place: float) -> int:
    """Number of the carriage at a place inside a span."""
    places = network.drive.carriage_places
    return next(i for i, (at, own) in enumerate(places) if at == span and own == place)


def _guided(network: Network, span: int, place: float) -> bool:
    return network.drive.carriage[_carriage(network, span, place)].guided


def _weight_at(network: Network, piece: Piece, across: float) -> float:
    """Weight across the chord of the carriage where a piece starts [N]; ``across``: of gravity [m/s^2]."""
    carriage = network.drive.carriage[_carriage(network, piece.span, piece.start)]
    return float(carriage.mass * across)


@dataclass(frozen=True, slots=True, kw_only=True)
class HangingElement(Element):
    """One rope that hangs, along and across its chord together.

    Attributes
    ----------
    hanging : Hanging
        Its piece at rest, from tangent point to tangent point of a straight rope.
    along : float
        Its length where it is stretched, lift-off by bending left out [m].
    """

    hanging: Hanging
    along: float

    @property
    def motions(self) -> int:
        """Along, across, and of a beam the slope."""
        return 3 if self.bending else 2

    def rest_stiffness(self) -> Array:
        r"""Stiffness of the ends at rest, by the length that sag gives, shape (2 motions, 2 motions).

        Along it is :math:`EA/L/(1 + \lambda^2/12)`.
        """
        k = self.motions
        give = self.along / self.stretch / self.axial_rigidity
        give += self.hanging.mean(2) * self.hanging.length / self.tension
        out = np.zeros((2 * k, 2 * k))
        out[::k, ::k] = np.array([[1.0, -1.0], [-1.0, 1.0]]) / give
        across = [i for i in range(2 * k) if i % k]
        out[np.ix_(across, across)] = super(HangingElement, self).rest_stiffness()
        return out

    def slope(self, x: NDArray[np.float64]) -> Array:
        """Slope against the chord; ``x`` [m] from its start, any shape."""
        return self.hanging.slope(x - self.before)

    def tension_at(self, x: NDArray[np.float64]) -> Array:
        """Tension [N]; ``x`` [m] from its start, any shape."""
        share = (x - self.before) / self.hanging.length
        return np.asarray(self.start_tension + (self.end_tension - self.start_tension) * share)


def irvine_parameters(network: Network) -> Array:
    r"""Irvine's :math:`\lambda^2` of all free spans at rest, as :math:`12\,EA/T` times the mean square slope.

    Of a span without carriages it is :math:`(q L/T)^2\,EA/T`. Returns shape (spans,).
    """
    found = np.zeros(len(network.drive.free_spans))
    if network.drive.layout.gravity == 0.0:
        return found
    for piece, own in zip(network.pieces, hanging_pieces(network), strict=True):
        rope = network.drive.ropes[network.drive.free_spans[piece.span].route]
        tension = 0.5 * (own.start_tension + own.end_tension)
        found[piece.span] = max(found[piece.span], 12.0 * own.mean(2) * rope.axial_rigidity / tension)
    return found


def hanging_elements(network: Network) -> dict[int, HangingElement]:
    """Elements of the pieces that hang, Eq. (N.13), by the number of the piece; none of ropes that run."""
    drive = network.drive
    irvine = irvine_parameters(network)
    if not np.any(irvine > STRAIGHT):
        return {}
    found = {}
    for number, (piece, own) in enumerate(zip(network.pieces, hanging_pieces(network), strict=True)):
        span = drive.free_spans[piece.span]
        if irvine[piece.span] <= STRAIGHT or drive.route[span.route].speed:
            continue
        found[number] = _element(network, piece, own)
    return found


def _element(network: Network, piece: Piece, own: Hanging) -> HangingElement:
    drive = network.drive
    rope = drive.ropes[drive.free_spans[piece.span].route]
    bending = rope.bending_stiffness or 0.0
    turned = own.slope(np.array([0.0, own.length]))
    before, after = (
        _shift(end_place(drive, piece, start), float(turn)) * (1.0 if start else -1.0)
        for start, turn in ((True, turned[0]), (False, turned[1]))
    )
    along = piece.length + before + after
    if bending:
        before, after = (
            before + lift_off(drive, piece, start=True),
            after + lift_off(drive, piece, start=False),
        )
    return HangingElement(
        start_tension=piece.start_tension,
        end_tension=piece.end_tension,
        length=before + piece.length + after,
        before=before,
        density=rope.density,
        axial_rigidity=rope.axial_rigidity,
        bending=bending,
        hanging=own,
        along=along,
    )


def _shift(place: Place | None, turned: float) -> float:
    """How far a rope that is turned leaves its pulley before the tangent point of a straight one [m]."""
    return 0.0 if place is None else -place.sense * place.radius * turned
