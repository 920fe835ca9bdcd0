"""A machine, with routes or with two pulleys, as the network of its modes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cabledrive.mechanics.holding import DRIVE_PULLEY, MOTOR, PULLEYS, held_joints
from cabledrive.mechanics.network.assembly import DIRECTIONS, Network, network_of
from cabledrive.mechanics.network.pieces import Piece, lift_off
from cabledrive.mechanics.rest import loop_statics, rest_state
from cabledrive.modal.component import Fixed
from cabledrive.modal.elements import ACROSS, ALONG, OUT, Rope, Row, Wave
from cabledrive.modal.networks import ModalNetwork, PieceOfSpan, slack_line
from cabledrive.modal.pieces import End, parts_of_piece, straight_above
from cabledrive.modal.rows import MASS, SPRING
from cabledrive.parameters import Drive, NotComputed


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
        if even or piece.route.speed:
            for link, way in enumerate(DIRECTIONS, start=3 * number):
                ends = [items(row) for row in piece.rows[way]]
                wave = net.impedance[link], net.time[link], (number, way), net.lag[link], int(net.ropes[link])
                parts.append(Wave(ends[0], ends[1], *wave))
            continue
        rope = piece.rope.density, piece.rope.bending_stiffness or 0.0, piece.route.ropes
        near, far = (end(piece, start, edges[number] > 0.0) for start in (True, False))
        parts += parts_of_piece(number, piece.rest, rope, near, far, edges[number])
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
    """Frequency above which each piece is straight [rad/s]; 0: it does not sag, or it runs."""
    found: list[float] = []
    for own in net.sections:
        rope, runs = own[0].rope, bool(own[0].route.speed)
        edge = 0.0 if runs else straight_above([piece.rest for piece in own], rope.density)
        found += [edge] * len(own)
    return found


def network_of_drive(
    drive: Drive,
    *,
    motor: str | None = None,
    hold: Sequence[str] = (),
    at_torque: float = 0.0,
    taut: bool = False,
) -> tuple[ModalNetwork, Network]:
    """A loop or line about its state of rest; ``taut``: what moves along it, without weights.

    Named as people call it: pulleys by what their rims move, carriages by numbers, sections by their ends.
    """
    if taut:
        drive, at_torque = replace(drive, layout=replace(drive.layout, gravity=0.0)), 0.0
    rest, statics = rest_state(drive, at_torque=at_torque), loop_statics(drive, at_torque)
    machine = statics.drive
    slack = tuple(own for own in rest.sections if own.lowest_tension <= 0.0)
    if slack and not drive.layout.gravity:
        raise NotComputed(slack_line(slack[0]))
    carriages = (
        replace(own, name="", guided=own.guided or taut) if own.name or taut > own.guided else own
        for own in machine.carriage
    )
    machine = replace(machine, carriage=tuple(carriages))
    held = held_joints(drive, hold)
    network = network_of(machine, motor=motor, hold=sorted(held), statics=replace(statics, drive=machine))
    found = network_of_routes(network)
    hangs = [own in slack for own in rest.sections for _ in own.stretches]
    lies = [taut or own for own in hangs]
    arms = (-own.radius for own in (*drive.pulley, drive.drive_pulley))
    return replace(
        found,
        names=tuple(
            MOTOR if name == f"rotor of {DRIVE_PULLEY}" else name.removesuffix(f" {ALONG}")
            for name in found.names
        ),
        pieces=_called(drive, network, held),
        waves=tuple(own for own in found.waves if own.tag[1] == ALONG or not lies[own.tag[0]]),
        ropes=tuple(own for own in found.ropes if not lies[own.tags[0][0]]),
        rims=PULLEYS,
        units=dict(zip((*PULLEYS, MOTOR), arms, strict=True)),
        by_span=False,
        slack=slack,
    ), network


def _called(drive: Drive, network: Network, held: frozenset[str]) -> tuple[PieceOfSpan, ...]:
    """Pieces of a loop or line by the names of their span, section and joints, in unstretched lengths."""
    found: list[PieceOfSpan] = []
    for span in drive.spans:
        own = [piece for piece in network.pieces if piece.rest.span == span]
        numbers = [piece.carriages[0] for piece in own[1:]]
        names = [f"carriage {i}" for i in numbers]
        guided = [drive.carriage[i].guided or name in held for i, name in zip(numbers, names, strict=True)]
        ends = [0.0, *(drive.carriage[i].position for i in numbers), drive.span_length]
        bounds = [end for end, still in zip(ends[1:], (*guided, True), strict=True) if still]
        joints, held_at = [PULLEYS[span == "lower"], *names, PULLEYS[span == "upper"]], 0.0
        for start, end, near, far in zip(ends[:-1], ends[1:], joints[:-1], joints[1:], strict=True):
            found.append(PieceOfSpan(span, start, end, (held_at, bounds[0]), (near, far)))
            if end == bounds[0]:
                held_at = bounds.pop(0)
    return tuple(found)
