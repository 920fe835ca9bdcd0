"""Links of a network that are heavy strings or tensioned beams, with the motion of their ends."""

from dataclasses import dataclass

import numpy as np

from cabledrive.mechanics.network.assembly import DIRECTIONS, Network
from cabledrive.mechanics.network.elements import Element, element_of
from cabledrive.mechanics.network.motion import ACROSS, Array
from cabledrive.mechanics.tensioned_beam import beam_stiffness


@dataclass(frozen=True, eq=False, kw_only=True)
class ElasticLink:
    """An element that a component holds.

    Attributes
    ----------
    link : int
        Number of the link in the network.
    element : Element
    ropes : int
        Parallel ropes that move alike.
    rows : ndarray, shape (4, n)
        Displacement and slope of its start and end by the coordinates of the component.
    """

    link: int
    element: Element
    ropes: int
    rows: Array

    @property
    def unknowns(self) -> int:
        """Coordinates of a joint: displacement, and of a beam the slope."""
        return 2 if self.element.bending else 1

    @property
    def end_rows(self) -> tuple[Array, Array]:
        """Rows of start and end that count, shape (unknowns, n) each."""
        return self.rows[: self.unknowns], self.rows[2 : 2 + self.unknowns]

    def static_stiffness(self) -> Array:
        """Stiffness at rest with even tension, shape (2 unknowns, 2 unknowns)."""
        own = self.element
        if own.bending:
            values = (np.array([x]) for x in (own.bending, own.tension, own.density, own.length))
            return np.asarray(self.ropes * beam_stiffness(0.0, *values)[0])
        return self.ropes * own.tension / own.length * np.array([[1.0, -1.0], [-1.0, 1.0]])


def slope_columns(network: Network) -> int:
    """Number of the network's coordinates and of two slopes for each carriage, where ropes have bending."""
    names, drive = len(network.motion.names), network.drive
    bent = any(rope.bending_stiffness for rope in drive.ropes)
    return names + (2 * len(drive.carriage) if bent else 0)


def elastic_links(network: Network) -> dict[int, ElasticLink]:
    """Heavy strings and tensioned beams by the number of their link; rows of coordinates and slopes."""
    found, size = {}, slope_columns(network)
    for number, (piece, way) in enumerate(zip(network.piece, network.direction, strict=True)):
        element = element_of(network.drive, network.pieces[piece], DIRECTIONS[way])
        if element is None:
            continue
        rows = np.zeros((4, size))
        named = len(network.motion.names)
        rows[0, :named], rows[2, :named] = network.start[number], network.end[number]
        if element.bending:
            for row, start in ((1, True), (3, False)):
                rows[row] = _slope_row(network, int(piece), DIRECTIONS[way], start, size)
        found[number] = ElasticLink(link=number, element=element, ropes=int(network.ropes[number]), rows=rows)
    return found


def _slope_row(network: Network, piece: int, direction: str, start: bool, size: int) -> Array:
    """Slope of a beam at one end: zero on a pulley and at what is guided, that of the body at an anchor."""
    drive, motion, own = network.drive, network.motion, network.pieces[piece]
    span, row = drive.free_spans[own.span], np.zeros(size)
    here = own.start if start else own.end
    if 0.0 < here < span.length:
        number = next(
            i for i, (at, place) in enumerate(drive.carriage_places) if at == own.span and place == here
        )
        if not drive.carriage[number].guided and motion.carriage_name(number) not in motion.hold:
            row[len(motion.names) + 2 * number + (direction != ACROSS)] = 1.0
        return row
    place = span.start if start else span.end
    if place.sense == 0 and direction == ACROSS:
        row[: len(motion.names)] = motion.rotation(motion.body_of(place))
    return row
