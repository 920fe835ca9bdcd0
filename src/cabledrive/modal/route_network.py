"""A machine with routes as the network of its modes."""

from dataclasses import dataclass

import numpy as np

from cabledrive.mechanics.network.assembly import DIRECTIONS, Network
from cabledrive.mechanics.network.hanging import hanging_elements
from cabledrive.mechanics.network.pieces import Element, carriage_at, element_of
from cabledrive.modal.component import Fixed
from cabledrive.modal.elements import ACROSS, ALONG, Rope, Row, Tag, Wave
from cabledrive.modal.networks import ModalNetwork, PieceOfSpan
from cabledrive.modal.rows import MASS, SPRING, Array


def network_of_routes(net: Network, *, hanging: bool = True, even: bool = False) -> ModalNetwork:
    """A machine with routes, its rows and statics those of `cabledrive.mechanics.network`.

    ``hanging``: whether ropes sag, else they are straight; ``even``: all are straight strings of even tension
    without bending stiffness, as the frequency response takes them.
    """
    drive, motion = net.drive, net.motion
    hung = hanging_elements(net) if hanging and not even else {}
    names, slopes = list(motion.names), dict[str, int]()
    waves: list[Wave] = []
    ropes: list[Rope] = []

    def slope(number: int, way: str, start: bool) -> Row:
        """Slope of a beam at its end: zero on a pulley and at what is guided, the body's at an anchor."""
        piece = net.pieces[number]
        here = piece.start if start else piece.end
        place = piece.place(start)
        if place is None:
            carriage = carriage_at(drive, piece.span, here)
            name = motion.carriage_name(carriage)
            if drive.carriage[carriage].guided or name in motion.hold:
                return ()
            name = f"{name} slope {way}"
            if name not in slopes:
                slopes[name] = len(names)
                names.append(name)
            return ((slopes[name], 1.0),)
        turns = place.sense == 0 and way == ACROSS
        return _sparse(motion.rotation(motion.body_of(place))) if turns else ()

    for number, piece in enumerate(net.pieces):
        for link, way in enumerate(DIRECTIONS, start=3 * number):
            if number in hung and way == ALONG:
                continue
            element = hung.get(number) if way == ACROSS else None
            if element is None and not even:
                element = element_of(drive, piece, way)
            ways = (ALONG, ACROSS) if number in hung and way == ACROSS else (way,)
            ends = [[_sparse(piece.rows[own][side]) for own in ways] for side in (0, 1)]
            count = int(net.ropes[link])
            if element is None:
                wave = net.impedance[link], net.time[link], (number, way), net.lag[link], count
                waves.append(Wave(ends[0][0], ends[1][0], *wave))
                continue
            if element.bending:
                ends[0].append(slope(number, way, True))
                ends[1].append(slope(number, way, False))
            ropes.append(_rope(element, ends, tuple((number, own) for own in ways), count))
    fixed = [Fixed(MASS, float(m), _sparse(row)) for m, row, _ in zip(*net.masses, strict=True)]
    fixed += [Fixed(SPRING, float(k), _sparse(row), name) for k, row, name in zip(*net.springs, strict=True)]
    if net.geometric.any():
        values, vectors = np.linalg.eigh(net.geometric)
        keep = np.abs(values) > 1e-13 * np.abs(values).max()
        fixed += [
            Fixed(SPRING, float(v), _sparse(row, 1e-13), "turning")
            for v, row in zip(values[keep], vectors.T[keep], strict=True)
        ]
    return ModalNetwork(
        names=tuple(names),
        pieces=tuple(
            PieceOfSpan(piece.where.name, piece.start, piece.end, (0.0, piece.where.length))
            for piece in net.pieces
        ),
        waves=tuple(waves),
        ropes=tuple(ropes),
        fixed=tuple(fixed),
        by_span=True,
    )


def _sparse(row: Array, least: float = 0.0) -> Row:
    return tuple((int(i), float(row[i])) for i in np.flatnonzero(np.abs(row) > least))


def _rope(element: Element, ends: list[list[Row]], tags: tuple[Tag, ...], ropes: int) -> Rope:
    """An element of a route, in metres under tension."""
    force = _Force(element)
    return Rope(
        tuple(ends[0]),
        tuple(ends[1]),
        element.length,
        force,
        element.density / element.stretch,
        tags,
        direction=force.direction if element.hanging else None,
        pull=element.axial_rigidity * element.stretch,
        bend=element.bending,
        ropes=ropes,
        longer=element.length / element.along if element.hanging else 1.0,
        before=element.before,
    )


@dataclass(frozen=True)
class _Force:
    """The force in an element, by the distance from its start under tension; equal where elements are."""

    element: Element

    def __call__(self, x: Array) -> Array:
        """R = T/(1 + T/EA), of a metre under tension [N]."""
        own = self.element
        tension = own.tension_at(np.asarray(x))
        return np.asarray(tension * own.stretch / (1.0 + tension / own.axial_rigidity))

    def direction(self, x: Array) -> tuple[Array, Array]:
        """Cosine and sine against the chord."""
        assert self.element.hanging is not None
        slope = self.element.hanging.slope(x - self.element.before)
        return 1.0 / np.sqrt(1.0 + slope**2), slope / np.sqrt(1.0 + slope**2)
