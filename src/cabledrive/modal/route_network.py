"""A machine with routes as the network of its modes."""

import numpy as np

from cabledrive.mechanics.network.assembly import DIRECTIONS, Network
from cabledrive.mechanics.network.pieces import Piece, carriage_at, lift_off
from cabledrive.modal.component import Fixed
from cabledrive.modal.elements import ACROSS, OUT, Rope, Row, Wave
from cabledrive.modal.networks import ModalNetwork, PieceOfSpan
from cabledrive.modal.pieces import End, parts_of_piece, straight_above
from cabledrive.modal.rows import MASS, SPRING, Array


def network_of_routes(net: Network, *, hanging: bool = True, even: bool = False) -> ModalNetwork:
    """A machine with routes, its rows and statics those of `cabledrive.mechanics.network`.

    ``hanging``: whether ropes sag, else they are straight; ``even``: all are straight strings of even tension
    without bending stiffness, as the frequency response takes them, and as ropes are that run.
    """
    drive, motion = net.drive, net.motion
    edges = _edges(net) if hanging else [0.0] * len(net.pieces)
    names, slopes = list(motion.names), dict[str, int]()
    parts: list[Wave | Rope] = []

    def slope(piece: Piece, way: str, start: bool) -> Row:
        """Slope of a beam at its end: zero on a pulley and at what is guided, the body's at an anchor."""
        place = piece.place(start)
        if place is None:
            carriage = carriage_at(drive, piece, start=start)
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

    def end(piece: Piece, start: bool) -> End:
        moves = [_sparse(piece.rows[way][not start]) for way in DIRECTIONS]
        place, bends = piece.place(start), bool(piece.rope.bending_stiffness)
        return End(
            moves,
            (slope(piece, ACROSS, start), slope(piece, OUT, start)) if bends else ((), ()),
            lift_off(drive, piece, start=start) if bends else 0.0,
            0.0 if place is None else place.radius,
        )

    for number, piece in enumerate(net.pieces):
        if even or piece.route.speed:
            for link, way in enumerate(DIRECTIONS, start=3 * number):
                ends = [_sparse(row) for row in piece.rows[way]]
                wave = net.impedance[link], net.time[link], (number, way), net.lag[link], int(net.ropes[link])
                parts.append(Wave(ends[0], ends[1], *wave))
            continue
        rope = piece.rope.density, piece.rope.bending_stiffness or 0.0, piece.route.ropes
        parts += parts_of_piece(number, piece.rest, rope, end(piece, True), end(piece, False), edges[number])
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
        waves=tuple(part for part in parts if isinstance(part, Wave)),
        ropes=tuple(part for part in parts if isinstance(part, Rope)),
        fixed=tuple(fixed),
        by_span=True,
    )


def _edges(net: Network) -> list[float]:
    """Frequency above which each piece is straight [rad/s]; 0: it does not sag, or it runs."""
    found: list[float] = []
    for own in net.sections:
        rope, runs = own[0].rope, bool(own[0].route.speed)
        edge = 0.0 if runs else straight_above([piece.rest for piece in own], rope.density)
        found += [edge] * len(own)
    return found


def _sparse(row: Array, least: float = 0.0) -> Row:
    return tuple((int(i), float(row[i])) for i in np.flatnonzero(np.abs(row) > least))
