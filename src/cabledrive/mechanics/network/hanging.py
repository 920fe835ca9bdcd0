r"""Spans of a network that hang under their weight and their carriages', as elements of shallow sag.

With y the height of the rope at rest over the chord of its tangent points, :math:`\theta = y'`, and u, w the
motion along and across the chord, the rope is stretched by :math:`u' + \theta w'`, so that

.. math::
    2 V = \int EA\,(u' + \theta w')^2 + T\,w'^2 + EI\,w''^2\,dx, \qquad
    \theta = \frac{V_0 - \int q\,dx}{T}, \qquad \int\theta\,dx = 0, \qquad \text{Eq. (N.13)}

where q is the weight across it and the shear :math:`V_0` follows from the ends that lie on the chord. A rope
that is fed round strains nothing. What is left out is of second order in :math:`\theta`.
"""

from dataclasses import replace

import numpy as np

from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.network.motion import gravity
from cabledrive.mechanics.network.pieces import Element, Hanging, Piece, carriage_at, straight_element
from cabledrive.parameters.arrays import Array

STRAIGHT = 5e-7
r"""Irvine's :math:`\lambda^2` up to which a rope is straight: it moves no frequency by more than 1e-4."""


def hanging_pieces(network: Network) -> list[Hanging]:
    """How pieces of spans hang at rest, in order; a guided carriage on the chord bears them, others hang."""
    drive, g = network.drive, gravity(network.drive)
    found: list[Hanging] = []
    run: list[Hanging] = []
    for piece in network.pieces:
        across, end = np.array(piece.where.across), 0.0
        if run:
            end = run[-1].shear - run[-1].load * run[-1].piece.length
            end -= drive.carriage[carriage_at(drive, piece.span, piece.start)].mass * float(g @ across)
        load = float(network.statics.line_load[piece.span] @ across)
        run.append(Hanging(piece=piece, shear=end, load=load))
        if piece.place(False) or drive.carriage[carriage_at(drive, piece.span, piece.end)].guided:
            # the shear that brings the ends of what hangs between two places of the chord there
            rise = sum(own.mean(1) * own.piece.length for own in run)
            unit = sum(replace(own, shear=1.0, load=0.0).mean(1) * own.piece.length for own in run)
            found += [replace(own, shear=own.shear - rise / unit) for own in run]
            run = []
    return found


def irvine_parameters(network: Network) -> Array:
    r"""Irvine's :math:`\lambda^2` of all free spans at rest, the largest of their pieces, shape (spans,).

    Of a span without carriages it is :math:`(q L/T)^2\,EA/T`.
    """
    return _at_rest(network)[1]


def hanging_elements(network: Network) -> dict[int, Element]:
    """Elements of the pieces that hang, Eq. (N.13), by the number of the piece; none of ropes that run."""
    hanging, irvine = _at_rest(network)
    found: dict[int, Element] = {}
    for number, (piece, own) in enumerate(zip(network.pieces, hanging, strict=False)):
        if irvine[piece.span] <= STRAIGHT or piece.route.speed:
            continue
        straight = straight_element(network.drive, piece)
        near, far = own.end_slopes.tolist()
        before, after = _shift(piece, True, near), -_shift(piece, False, far)
        found[number] = replace(
            straight,
            length=straight.length + before + after,
            before=straight.before + before,
            hanging=own,
            along=piece.length + before + after,
        )
    return found


def _at_rest(network: Network) -> tuple[list[Hanging], Array]:
    """How the pieces of all spans hang, none without gravity, and Irvine's parameter of each span."""
    irvine = np.zeros(len(network.drive.free_spans))
    hanging = hanging_pieces(network) if network.drive.layout.gravity else []
    for own in hanging:
        irvine[own.piece.span] = max(irvine[own.piece.span], own.irvine)
    return hanging, irvine


def _shift(piece: Piece, start: bool, turned: float) -> float:
    """How far a rope that is turned leaves its pulley before the tangent point of a straight one [m]."""
    place = piece.place(start)
    return 0.0 if place is None else -place.sense * place.radius * turned
