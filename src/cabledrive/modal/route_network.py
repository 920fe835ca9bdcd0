"""A machine, with routes or with two pulleys, as the network of its modes."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np

from cabledrive.mechanics.holding import MOTOR
from cabledrive.mechanics.network.assembly import DIRECTIONS, Network, network_of
from cabledrive.mechanics.network.motion import Motion
from cabledrive.mechanics.network.pieces import Piece, lift_off
from cabledrive.mechanics.rest import statics_under
from cabledrive.modal.component import Fixed
from cabledrive.modal.elements import ACROSS, ALONG, OUT, Rope, Row, Wave
from cabledrive.modal.networks import ModalNetwork, PieceOfSpan
from cabledrive.modal.pieces import End, parts_of_piece, straight_above
from cabledrive.modal.rows import MASS, SPRING
from cabledrive.parameters import Machine, NotComputed


def network_of_routes(net: Network, *, hanging: bool = True, even: bool = False) -> ModalNetwork:
    """A machine with routes, its rows and statics those of `cabledrive.mechanics.network`.

    ``hanging``: whether ropes sag, else they are straight; ``even``: all are straight strings of even tension
    without bending stiffness, as the frequency response takes them.
    """
    drive, motion = net.drive, net.motion
    edges = _edges(net) if hanging else [0.0] * len(net.pieces)
    names, slopes = list(motion.names), dict[str, int]()
    parts: list[Wave | Rope] = []

    def slope(piece: Piece, way: str, start: bool) -> Row:
        """Slope of a beam at its end: zero on a pulley and at what is guided, the body's at an anchor."""
        place = piece.place(start)
        if place is None:
            carriage = piece.carriages[not start]
            name = motion.carriage_name(carriage)
            if drive.carriage[carriage].guided or name in motion.hold:
                return ()
            name = f"{name} slope {way}"
            if name not in slopes:
                slopes[name] = len(names)
                names.append(name)
            return ((slopes[name], 1.0),)
        turns = place.sense == 0 and way == ACROSS
        return items(motion.rotation(motion.body_of(place))) if turns else ()

    def items(row: dict[int, float]) -> Row:
        """A row as the elements take it."""
        return tuple((c, v) for c, v in row.items() if v)

    def end(piece: Piece, start: bool, sags: bool) -> End:
        bends, out = bool(piece.rope.bending_stiffness), piece.rows[OUT][not start]
        straight = moves = itself = [items(piece.rows[way][not start]) for way in DIRECTIONS]
        if sags:
            moves, itself = (
                [items(row) for row in (*piece.moves(start, along_itself=own), out)] for own in (False, True)
            )
        return End(
            straight,
            moves,
            itself,
            (slope(piece, ACROSS, start), slope(piece, OUT, start)) if bends else ((), ()),
            lift_off(drive, piece, start=start) if bends else 0.0,
        )

    for number, piece in enumerate(net.pieces):
        if even:
            for link, way in enumerate(DIRECTIONS, start=3 * number):
                ends = [items(row) for row in piece.rows[way]]
                wave = net.impedance[link], net.time[link], (number, way), net.lag[link], int(net.ropes[link])
                parts.append(Wave(ends[0], ends[1], *wave))
            continue
        near, far = (end(piece, start, edges[number] > 0.0) for start in (True, False))
        parts += parts_of_piece(number, piece, near, far, edges[number])
    fixed = [
        Fixed(kind, float(own), tuple(row.items()), name if kind == SPRING else "")
        for kind, parts in ((MASS, net.masses), (SPRING, net.springs))
        for own, row, name in zip(*parts[:3], strict=True)
    ]
    if net.turning:
        values, vectors = np.linalg.eigh(net.geometric)
        keep = np.abs(values) > 1e-13 * np.abs(values).max()
        fixed += [
            Fixed(SPRING, v, tuple((i, own) for i, own in enumerate(row) if abs(own) > 1e-13), "turning")
            for v, row in zip(values[keep].tolist(), vectors.T[keep].tolist(), strict=True)
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
    """Frequency above which each piece is straight [rad/s]; 0: it does not sag."""
    edges = [straight_above([piece.rest for piece in own], own[0].rope.density) for own in net.sections]
    return [edge for edge, own in zip(edges, net.sections, strict=True) for _ in own]


def network_at_rest(
    drive: Machine,
    *,
    motor: str | None = None,
    hold: Sequence[str] = (),
    at_torque: float = 0.0,
    taut: bool = False,
) -> tuple[ModalNetwork, Network]:
    """A machine about its state of rest, its parts called as its file does.

    ``at_torque``: on the first pulley, taken up by the other of two [N m]; ``taut``: without weights, and of
    two pulleys what moves along the ropes alone.
    """
    drive = replace(drive, layout=replace(drive.layout, gravity=0.0)) if taut else drive
    numbers = [f"carriage {number}" for number in range(len(drive.carriage))]
    names = list(map(Motion(drive).carriage_name, range(len(drive.carriage))))
    called = numbers if drive.called else names
    held = dict(zip((*numbers, *names), 2 * called, strict=True))
    if called != names or (taut and not all(own.guided for own in drive.carriage)):
        parts = zip(drive.carriage, called, strict=True)
        carriages = tuple(replace(own, name=name, guided=own.guided or taut) for own, name in parts)
        drive = replace(drive, carriage=carriages)
    statics = statics_under(drive, at_torque)
    network = network_of(drive, motor=motor, hold=[held.get(name, name) for name in hold], statics=statics)
    if not drive.called:
        return network_of_routes(network), network
    slack = [_slack(own) for own in network.sections]
    if any(slack) and not drive.layout.gravity:
        raise NotComputed(next(filter(None, slack)))
    lies = [taut or bool(said) for said, own in zip(slack, network.sections, strict=True) for _ in own]
    return _called(network_of_routes(network), network, lies, tuple(filter(None, slack))), network


def _slack(section: list[Piece]) -> str:
    """That a section hangs slack; nothing of one that does not."""
    lowest = min(piece.rest.lowest_tension for piece in section)
    if lowest > 0.0:
        return ""
    (start, _), (_, end) = section[0].unstretched, section[-1].unstretched
    return (
        f"the {section[0].where.name} span hangs slack at rest between {start:.4g} m and {end:.4g} m, "
        f"lowest tension {lowest:.4g} N: raise cable.pretension"
    )


def _called(
    found: ModalNetwork, network: Network, lies: Sequence[bool], slack: tuple[str, ...]
) -> ModalNetwork:
    """With pulleys by what their rims move, pieces by the joints of their section, in unstretched lengths.

    ``lies``: pieces across which nothing moves; ``slack``: what is said of those that hang slack.
    """
    first = network.drive.pulley[0]
    rotor, radii = f"rotor of {first.name}", {own.name: -own.radius for own in network.drive.pulley}
    return replace(
        found,
        names=tuple(MOTOR if name == rotor else name.removesuffix(f" {ALONG}") for name in found.names),
        pieces=_in_sections(network),
        waves=tuple(own for own in found.waves if own.tag[1] == ALONG or not lies[own.tag[0]]),
        ropes=tuple(own for own in found.ropes if not lies[own.tags[0][0]]),
        rims=tuple(radii),
        units=radii | {MOTOR: radii[first.name]},
        by_span=False,
        slack=slack,
    )


def _in_sections(network: Network) -> tuple[PieceOfSpan, ...]:
    """Pieces by span and joints, each with the places between which it is held across."""
    found: list[PieceOfSpan] = []
    drive, motion = network.drive, network.motion
    for _, group in groupby(network.pieces, key=lambda piece: piece.span):
        own = list(group)
        carriages = [(drive.carriage[i], motion.carriage_name(i)) for i in (p.carriages[0] for p in own[1:])]
        names = [name for _, name in carriages]
        still = (*(part.guided or name in motion.hold for part, name in carriages), True)
        ends = [0.0, *(piece.unstretched[1] for piece in own)]
        bounds = [end for end, held in zip(ends[1:], still, strict=True) if held]
        joints, held_at = [own[0].where.start.name, *names, own[0].where.end.name], 0.0
        for start, end, near, far in zip(ends[:-1], ends[1:], joints[:-1], joints[1:], strict=True):
            found.append(PieceOfSpan(own[0].where.name, start, end, (held_at, bounds[0]), (near, far)))
            if end == bounds[0]:
                held_at = bounds.pop(0)
    return tuple(found)
