"""A machine with routes as the network of its modes."""

from dataclasses import dataclass

import numpy as np

from cabledrive.mechanics.network.assembly import DIRECTIONS, Network
from cabledrive.mechanics.network.hanging import HangingElement, hanging_elements
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
    spans = [drive.free_spans[piece.span] for piece in net.pieces]
    links = {
        (int(p), DIRECTIONS[d]): i for i, (p, d) in enumerate(zip(net.piece, net.direction, strict=True))
    }
    waves: list[Wave] = []
    ropes: list[Rope] = []

    def slope(number: int, way: str, start: bool) -> Row:
        """Slope of a beam at its end: zero on a pulley and at what is guided, the body's at an anchor."""
        piece, span = net.pieces[number], spans[number]
        here = piece.start if start else piece.end
        if 0.0 < here < span.length:
            carriage = carriage_at(drive, piece.span, here)
            name = motion.carriage_name(carriage)
            if drive.carriage[carriage].guided or name in motion.hold:
                return ()
            name = f"{name} slope {way}"
            if name not in slopes:
                slopes[name] = len(names)
                names.append(name)
            return ((slopes[name], 1.0),)
        place = span.start if start else span.end
        turns = place.sense == 0 and way == ACROSS
        return _sparse(motion.rotation(motion.body_of(place))) if turns else ()

    for number, piece in enumerate(net.pieces):
        for way in DIRECTIONS:
            if number in hung and way == ALONG:
                continue
            link = links[number, way]
            element: Element | None = hung.get(number) if way == ACROSS else None
            if element is None and not even:
                element = element_of(drive, piece, way)
            ways = (ALONG, ACROSS) if number in hung and way == ACROSS else (way,)
            ends = [[_sparse(rows[links[number, own]]) for own in ways] for rows in (net.start, net.end)]
            count = int(net.ropes[link])
            if element is None:
                wave = net.impedance[link], net.time[link], (number, way), net.lag[link], count
                waves.append(Wave(ends[0][0], ends[1][0], *wave))
                continue
            if element.bending:
                ends[0].append(slope(number, way, True))
                ends[1].append(slope(number, way, False))
            ropes.append(_rope(element, ends, tuple((number, own) for own in ways), count))
    fixed = [Fixed(MASS, float(m), _sparse(row)) for m, row in zip(net.mass, net.mass_rows, strict=True)]
    fixed += [
        Fixed(SPRING, float(k), _sparse(row), name)
        for k, row, name in zip(net.spring, net.spring_rows, net.spring_names, strict=True)
    ]
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
            PieceOfSpan(span.name, piece.start, piece.end, (0.0, span.length))
            for span, piece in zip(spans, net.pieces, strict=True)
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
    hangs = isinstance(element, HangingElement)
    return Rope(
        tuple(ends[0]),
        tuple(ends[1]),
        element.length,
        force,
        element.density / element.stretch,
        tags,
        direction=force.direction if hangs else None,
        pull=element.axial_rigidity * element.stretch,
        bend=element.bending,
        ropes=ropes,
        longer=element.length / element.along if isinstance(element, HangingElement) else 1.0,
        before=element.before,
    )


@dataclass(frozen=True)
class _Force:
    """The force in an element, by the distance from its start under tension; equal where elements are."""

    element: Element

    def __call__(self, x: Array) -> Array:
        """R = T/(1 + T/EA), of a metre under tension [N]."""
        own = self.element
        if isinstance(own, HangingElement):
            tension = own.tension_at(x)
        else:
            tension = own.start_tension + (own.end_tension - own.start_tension) * np.asarray(x) / own.length
        return np.asarray(tension * own.stretch / (1.0 + tension / own.axial_rigidity))

    def direction(self, x: Array) -> tuple[Array, Array]:
        """Cosine and sine against the chord."""
        assert isinstance(self.element, HangingElement)
        slope = self.element.slope(x)
        return 1.0 / np.sqrt(1.0 + slope**2), slope / np.sqrt(1.0 + slope**2)
