"""Links of a network that are heavy strings, tensioned beams or hanging ropes, and how their ends move."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cabledrive.mechanics.network.assembly import DIRECTIONS, Network
from cabledrive.mechanics.network.elements import Element, carriage_at, element_of
from cabledrive.mechanics.network.hanging import HangingElement
from cabledrive.mechanics.network.motion import ACROSS, ALONG, Array


@dataclass(frozen=True, eq=False, kw_only=True)
class ElasticLink:
    """An element that a component holds.

    Attributes
    ----------
    link : int
        Number of the link in the network; of a hanging rope that across it.
    covers : tuple of int
        All links that it stands for: of a hanging rope along and across.
    element : Element
    ropes : int
        Parallel ropes that move alike.
    rows : ndarray, shape (2 motions, n)
        Motions of its start and its end by the coordinates of the component.
    """

    link: int
    covers: tuple[int, ...]
    element: Element
    ropes: int
    rows: Array

    @property
    def hangs(self) -> bool:
        """Whether it is a hanging rope, along and across together."""
        return len(self.covers) > 1

    @property
    def unknowns(self) -> int:
        """Coordinates of a joint: of a hanging rope the motion along; displacement; of a beam the slope."""
        return self.element.motions

    @property
    def end_rows(self) -> tuple[Array, Array]:
        """Rows of start and end, shape (unknowns, n) each."""
        return self.rows[: self.unknowns], self.rows[self.unknowns :]

    def rest_stiffness(self) -> Array:
        """Stiffness of its ends at rest, all ropes together, shape (2 unknowns, 2 unknowns)."""
        return self.ropes * self.element.rest_stiffness()


def slope_columns(network: Network) -> int:
    """Number of the network's coordinates and of two slopes for each carriage, where ropes have bending."""
    names, drive = len(network.motion.names), network.drive
    bent = any(rope.bending_stiffness for rope in drive.ropes)
    return names + (2 * len(drive.carriage) if bent else 0)


def elastic_links(network: Network, hung: Mapping[int, HangingElement]) -> dict[int, ElasticLink]:
    """Heavy strings, tensioned beams and hanging ropes by the number of their link.

    ``hung``: elements of the pieces that hang, by the number of the piece.
    Their rows are by coordinates and slopes.
    """
    found = {}
    for number, (piece, way) in enumerate(zip(network.piece, network.direction, strict=True)):
        direction = DIRECTIONS[way]
        hangs = direction == ACROSS and int(piece) in hung
        covers = (_along(network, int(piece)), number) if hangs else (number,)
        straight = element_of(network.drive, network.pieces[piece], direction)
        element = hung[int(piece)] if hangs else straight
        if element is None:
            continue
        rows = [_row(network, link, start) for start in (True, False) for link in covers]
        if element.bending:
            slopes = [_slope_row(network, int(piece), direction, start) for start in (True, False)]
            rows = [*rows[: len(covers)], slopes[0], *rows[len(covers) :], slopes[1]]
        found[number] = ElasticLink(
            link=number, covers=covers, element=element, ropes=int(network.ropes[number]), rows=np.array(rows)
        )
    return found


def _along(network: Network, piece: int) -> int:
    """The link along a piece."""
    along = network.direction == DIRECTIONS.index(ALONG)
    return int(np.flatnonzero((network.piece == piece) & along)[0])


def _row(network: Network, link: int, start: bool) -> Array:
    """Motion of one end of a link by coordinates and slopes."""
    row = np.zeros(slope_columns(network))
    row[: len(network.motion.names)] = (network.start if start else network.end)[link]
    return row


def _slope_row(network: Network, piece: int, direction: str, start: bool) -> Array:
    """Slope of a beam at one end: zero on a pulley and at what is guided, that of the body at an anchor."""
    drive, motion, own = network.drive, network.motion, network.pieces[piece]
    span, row = drive.free_spans[own.span], np.zeros(slope_columns(network))
    here = own.start if start else own.end
    if 0.0 < here < span.length:
        number = carriage_at(drive, own.span, here)
        if not drive.carriage[number].guided and motion.carriage_name(number) not in motion.hold:
            row[len(motion.names) + 2 * number + (direction != ACROSS)] = 1.0
        return row
    place = span.start if start else span.end
    if place.sense == 0 and direction == ACROSS:
        row[: len(motion.names)] = motion.rotation(motion.body_of(place))
    return row
