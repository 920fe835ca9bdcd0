r"""Ropes divided into segments: nodes that carry mass, segments between them that carry tension.

Nodes are material points of the ropes, piece by piece. Each carriage that moves with the rope sits on a node
of its own, with equal segments between neighbouring carriages and ends, so that its place costs no accuracy.

Displacements are arrays of shape (3, nodes): u, v, w at each node. A segment stores
:math:`h\,e(u', v', w')` with the differences of its ends as gradients; the forces on the nodes are minus the
derivative of the sum, so that a law with a potential gives a conservative chain.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from math import expm1
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.cable_law import Components
from cabledrive.mechanics.chain import MOTOR_JOINT
from cabledrive.mechanics.network import Network, network_of
from cabledrive.mechanics.network.assembly import turns_by_torque
from cabledrive.mechanics.network.motion import OUT_OF_PLANE, Motion
from cabledrive.mechanics.network.pieces import Piece
from cabledrive.mechanics.network.span_table import next_span
from cabledrive.mechanics.rest import statics_under
from cabledrive.parameters import Machine
from cabledrive.parameters.arrays import Array, Integers
from cabledrive.parameters.errors import InputRefused

FEWEST_SEGMENTS = 3
MOST_SEGMENTS = 1_000_000

Divided = tuple[Sequence[str], Any, Any, NDArray[np.bool_]]
"""Names of spans, distances of their nodes from their starts, first and last node, nodes that are held."""


class Wrap(NamedTuple):
    r"""A wrap on which the rope slips where :math:`T_1 > T_2 e^{\mu\varphi}`."""

    name: str  # of the pulley
    before: int  # piece of rope that meets it
    behind: int  # piece of rope that leaves it
    factor: float  # e^(mu phi) - 1: largest friction per tension of the slacker side
    ropes: int


def wraps_of(drive: Machine, pieces: list[int]) -> tuple[Wrap, ...]:
    """Wraps of pulleys with a friction coefficient, not at ends of routes; ``pieces``: span of each piece."""
    found = []
    for number, span in enumerate(drive.free_spans):
        pulley = None if span.end.pulley is None else drive.pulley[span.end.pulley]
        if pulley and pulley.capstan_friction and span.wrap is not None:
            before, behind = len(pieces) - 1 - pieces[::-1].index(number), next_span(drive, number)
            factor, ropes = expm1(pulley.capstan_friction * span.wrap), drive.route[span.route].ropes
            found.append(Wrap(pulley.name, before, pieces.index(behind), factor, ropes))
    return tuple(found)


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh:
    """Pieces of rope in segments between coordinates q, which join their ends, Eqs. (2.29) and (2.30).

    Between the joints of a piece, its ends and the carriages that move with it, segments are of equal length.
    """

    network: Network
    wraps: tuple[Wrap, ...]
    names: tuple[str, ...]  # of the coordinates; "slip at NAME" where the rope may slide on a pulley
    whole: bool  # whether pieces are whole spans, whose carriages sit on nodes, under the file's pretension
    pieces: tuple[str, ...]  # names: the span's, with a number where carriages cut it
    parts: tuple[tuple[Piece, ...], ...]  # of the network: what each piece consists of
    nodes: Integers  # (pieces, 2): first and last node
    positions: list[Array]  # distances of the nodes of each piece from its start [m]
    spacing: Array  # (nodes - 1,): 0 between pieces [m]
    density: Array  # (pieces,) [kg/m]
    tension: Array  # (pieces,): of its law's reference, of one rope [N]
    rigidity: Array  # (pieces,): EA of one rope [N]
    ropes: Array  # (pieces,)
    cells: Array  # (nodes,): rope of each node, 0 at the ends of pieces [kg]
    carried: Array  # (nodes,): carriages that move with the rope [kg]
    carriages: Integers  # (number,): node of each of them, in the order of the file
    sways: NDArray[np.bool_]  # (nodes,): whether a node moves across: neither ends nor guided carriages do
    half: Array  # (pieces, 2): half cells of all ropes at both ends [kg]
    ends: Array  # (pieces, 2, 3, n): rows u, v, w of start and end
    mass: Array  # (n, n): of the coordinates, with the half cells at the ends
    stiffness: Array  # (n, n): springs and turning bodies
    damping: Array  # (2, n, n): bearings and bodies, with the half cells across; joints of motors
    driven: tuple[str, ...]  # pulleys of the motors; the first of the file where there is none
    motor: Array  # (motors, n): turn of each rotor
    shown: tuple[str, ...]  # what records call the coordinates; of loops and lines the angles of their shafts
    turns: Array  # (shown, n): those by the coordinates

    @property
    def size(self) -> int:
        """Number of nodes."""
        return self.cells.size

    @property
    def length(self) -> Array:
        """Length of each piece under the tension of its law's reference, (pieces,) [m]."""
        return np.array([own[-1] for own in self.positions])

    @property
    def spans(self) -> Divided:
        """Its pieces as plucks and probes take them."""
        return self.pieces, self.positions, self.nodes, ~self.sways


def divided(network: Network, segments: int, *, whole: bool = False) -> Mesh:
    """Divide the spans of a machine; ``segments``: of the longest piece, others in proportion.

    ``whole``: pieces are whole spans with carriages on their nodes, under the pretension of the file; else
    carriages are coordinates, and cut pieces under their mean tension at rest.
    """
    check_segments(segments, fewest=FEWEST_SEGMENTS if whole else 2)
    both = groupby(enumerate(network.pieces), key=lambda own: own[1].span if whole else own[0])
    parts = tuple(tuple(piece for _, piece in own) for _, own in both)
    drive, wraps = network.drive, wraps_of(network.drive, [own[0].span for own in parts])
    ropes = [own[0].rope for own in parts]
    chord = np.array([sum(piece.length for piece in own) for own in parts])
    tension = np.array([0.5 * (own[0].start_tension + own[-1].end_tension) for own in parts])
    if whole:
        tension = np.array([rope.pretension for rope in ropes])
    rigidity = np.array([rope.axial_rigidity for rope in ropes])
    fewest = np.array([len(own) for own in parts])
    count = np.rint(max(segments, fewest.max()) * chord / chord.max()).astype(np.int64)
    count, stretch = np.maximum(count, fewest), 1.0 + tension / rigidity
    last = np.cumsum(count + 1) - 1
    nodes = np.stack([last - count, last], axis=1)
    density = np.array([rope.density for rope in ropes]) / stretch
    lines = np.array([own[0].route.ropes for own in parts], dtype=np.float64)
    positions, found, carriages = [], np.zeros((3, last[-1] + 1)), {}
    spacing, cells, carried = found[0, :-1], found[1], found[2]
    sways = ~np.isin(np.arange(cells.size), nodes)
    for k, (first, own) in enumerate(zip(nodes[:, 0], parts, strict=True)):
        joints = np.append(0.0, np.cumsum([stretch[k] * piece.rest.length for piece in own]))
        counts = shared_out(np.diff(joints), count[k])
        gaps = zip(joints[:-1], joints[1:], counts, strict=True)
        places = [a + (b - a) * np.arange(n) / n for a, b, n in gaps]
        positions.append(np.concatenate([*places, joints[-1:]]))
        for piece, node in zip(own[1:], (first + np.cumsum(counts)).tolist(), strict=False):
            number = piece.carriages[0]
            carriages[number], carried[node] = node, drive.carriage[number].mass
            sways[node] = not drive.carriage[number].guided
        h = np.diff(positions[k])
        spacing[first : first + h.size] = h
        cells[first + 1 : first + h.size] = 0.5 * density[k] * (h[1:] + h[:-1])
    half = 0.5 * (lines * density)[:, None] * spacing[nodes - (0, 1)]
    moved, n = len(network.motion.names), len(network.motion.names) + len(wraps)
    ends = np.zeros((len(parts), 2, 3, n))
    for k, own in enumerate(parts):
        for end, piece in enumerate((own[0], own[-1])):
            u, w = piece.moves(not end)
            ends[k, end, :, :moved] = network.motion.dense(u, piece.rows[OUT_OF_PLANE][end], w)
    for number, wrap in enumerate(wraps, start=moved):  # a rope that slips moves the ends on both its sides
        for k, end in ((wrap.before, 1), (wrap.behind, 0)):
            ends[k, end, ::2, number] = parts[k][-end].direction(not end)
    dampers, padded = network.dampers, (0, len(wraps))
    joint = np.array([name == MOTOR_JOINT for name in dampers.names], dtype=bool)
    shares = [dampers._replace(values=np.where(joint == own, dampers.values, 0.0)) for own in (False, True)]
    damping = np.stack([np.pad(own.matrix, padded) for own in shares])
    slips = tuple(f"slip at {wrap.name}" for wrap in wraps)
    dragged = half * np.array([[rope.transverse_damping] for rope in ropes])
    damping[0] += np.einsum("ks,ksxi,ksxj->ij", dragged, ends[:, :, 1:], ends[:, :, 1:])
    shown, turns = _recorded(network.motion.names + slips, drive)
    return Mesh(
        network=network,
        wraps=wraps,
        names=network.motion.names + slips,
        shown=shown,
        turns=turns,
        whole=whole,
        pieces=tuple(own[0].where.name for own in parts) if whole else piece_names(network),
        parts=parts,
        nodes=nodes,
        positions=positions,
        spacing=spacing,
        density=density,
        tension=tension,
        rigidity=rigidity,
        ropes=lines,
        cells=cells,
        carried=carried,
        carriages=np.array([carriages[number] for number in sorted(carriages)], dtype=np.int64),
        sways=sways,
        half=half,
        ends=ends,
        mass=np.pad(network.masses.matrix, padded) + np.einsum("ks,ksxi,ksxj->ij", half, ends, ends),
        stiffness=np.pad(network.springs.matrix + network.geometric, padded),
        damping=damping,
        driven=tuple(drive.pulley[number].name for number in drive.turned),
        motor=drive.sense * np.pad(turns_by_torque(network), ((0, 0), padded)),
    )


def _recorded(names: tuple[str, ...], drive: Machine) -> tuple[tuple[str, ...], Array]:
    """What records call the coordinates, and those by the coordinates."""
    if not (angles := drive.angles):
        return names, np.eye(len(names))
    units = dict(zip(names, np.eye(len(names)), strict=True))
    others = {name: row for name, row in units.items() if name not in dict(angles).values()}
    rows = [drive.sense * units.get(own, np.zeros(len(names))) for _, own in angles]
    return (*dict(angles), *others), np.stack([*rows, *others.values()])


def mesh_of(machine: Machine, segments: int) -> Mesh:
    """Divide the ropes of a machine into segments; whole spans where records call them by its file, else cut.

    Refused: too few segments, or too many to be stored; `NotComputed` if no state of rest is found.
    """
    whole = bool(machine.called)
    carried = list(map(Motion(machine).carriage_name, range(len(machine.carriage)))) if whole else []
    network = network_of(machine, hold=carried, statics=statics_under(machine))
    return divided(network, segments, whole=whole)


def gradients(mesh: Mesh, displacement: Array) -> Components:
    """Displacement gradients u', v', w' of the segments [-] from displacements, (3, nodes) [m]; 0 between."""
    inverse = np.divide(1.0, mesh.spacing, out=np.zeros_like(mesh.spacing), where=mesh.spacing > 0.0)
    u_x, v_x, w_x = np.diff(displacement, axis=1) * inverse
    return u_x, v_x, w_x


def weights_of(mesh: Mesh, g: Array) -> Array:
    """Weights of the nodes of one rope along and across, (2, nodes) [N], Eqs. (2.26) and (2.27).

    ``g``, (2,): gravity in the plane of the machine [m/s^2].
    """
    weight = np.zeros((2, mesh.size))
    pull = np.array([(own[0].where.along, own[0].where.across) for own in mesh.parts]) @ g
    pull[np.abs(pull) <= 1e-12 * np.abs(pull).max()] = 0.0
    for own, (first, last) in zip(pull, mesh.nodes, strict=True):
        weight[:, first:last] = np.outer(own, (mesh.cells + mesh.carried)[first:last])
    weight[1] *= mesh.sways  # a rail bears what is guided
    return weight


def piece_names(network: Network) -> tuple[str, ...]:
    """Names of the pieces of rope: the span's, with a number where carriages cut it."""
    spans = [piece.span for piece in network.pieces]
    return tuple(
        f"{piece.where.name}, part {spans[: k + 1].count(piece.span)}"
        if spans.count(piece.span) > 1
        else piece.where.name
        for k, piece in enumerate(network.pieces)
    )


def check_segments(segments: int, fewest: int = FEWEST_SEGMENTS) -> None:
    """Refuse a number of segments per span that is none, too small, or too large to be stored."""
    if isinstance(segments, bool) or not isinstance(segments, int | np.integer):
        raise InputRefused(f"segments = {segments!r} is not a whole number: give the segments per span")
    if segments < fewest:
        raise InputRefused(
            f"segments = {segments} per span, but the cable needs at least {fewest}: give more"
        )
    if segments > MOST_SEGMENTS:
        raise InputRefused(f"segments = {segments} per span, at most {MOST_SEGMENTS} are taken: give fewer")


def shared_out(gaps: Array, segments: int) -> NDArray[np.intp]:
    """Segments for each gap, at least one, as equal in length as can be."""
    count = np.maximum(1, np.rint(segments * gaps / gaps.sum())).astype(np.intp)
    while count.sum() < segments:
        count[np.argmax(gaps / count)] += 1
    while count.sum() > segments:
        count[np.argmin(np.where(count > 1, gaps / np.maximum(count - 1, 1), np.inf))] -= 1
    return count
