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
from cabledrive.mechanics.network.pieces import Element, Piece, straight_element
from cabledrive.parameters.arrays import Array

STRAIGHT = 5e-7
r"""Irvine's :math:`\lambda^2` up to which a rope is straight: it moves no frequency by more than 1e-4."""


def irvine_parameters(network: Network) -> Array:
    r"""Irvine's :math:`\lambda^2` of all free spans at rest, the largest of their pieces, shape (spans,).

    Of a span without carriages it is :math:`(q L/T)^2\,EA/T`.
    """
    irvine = np.zeros(len(network.drive.free_spans))
    for piece in network.pieces:
        irvine[piece.span] = max(irvine[piece.span], piece.irvine)
    return irvine


def hanging_elements(network: Network) -> dict[int, Element]:
    """Elements of the pieces that hang, Eq. (N.13), by the number of the piece; none of ropes that run."""
    irvine, found = irvine_parameters(network), dict[int, Element]()
    for number, piece in enumerate(network.pieces):
        if irvine[piece.span] <= STRAIGHT or piece.route.speed:
            continue
        straight = straight_element(network.drive, piece)
        near, far = piece.end_slopes.tolist()
        before, after = _shift(piece, True, near), -_shift(piece, False, far)
        found[number] = replace(
            straight,
            length=straight.length + before + after,
            before=straight.before + before,
            hanging=piece,
            along=piece.length + before + after,
        )
    return found


def _shift(piece: Piece, start: bool, turned: float) -> float:
    """How far a rope that is turned leaves its pulley before the tangent point of a straight one [m]."""
    place = piece.place(start)
    return 0.0 if place is None else -place.sense * place.radius * turned
