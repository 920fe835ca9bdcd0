"""A network of spans divided into segments, with wraps where ropes slide, dry friction and axial damping."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp
from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.network import Network
from cabledrive.mechanics.network.assembly import turns_by_torque
from cabledrive.mechanics.network.motion import ACROSS, ALONG, OUT_OF_PLANE
from cabledrive.mechanics.network.span_table import next_span
from cabledrive.parameters.arrays import Integers
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation import plan as at
from cabledrive.simulation.dampers import eliminated
from cabledrive.simulation.plan import (
    Plan,
    kernel_number,
    law_numbers,
    moved_by,
    rows_of_ends,
)


class Wrap(NamedTuple):
    r"""A wrap on which the rope slips where :math:`T_1 > T_2 e^{\mu\varphi}`."""

    name: str  # of the pulley
    before: int  # piece of rope that meets it
    behind: int  # piece of rope that leaves it
    factor: float  # e^(mu phi) - 1: largest friction per tension of the slacker side
    ropes: int


def wraps_of(network: Network) -> tuple[Wrap, ...]:
    """Wraps of all pulleys with a friction coefficient, those at the ends of a route left out."""
    drive, found = network.drive, []
    pieces = [piece.span for piece in network.pieces]
    for number, span in enumerate(drive.free_spans):
        if span.wrap is None or span.end.pulley is None:
            continue
        pulley = drive.pulley[span.end.pulley]
        if pulley.capstan_friction is None:
            continue
        before = len(pieces) - 1 - pieces[::-1].index(number)
        factor = exp(pulley.capstan_friction * span.wrap) - 1.0
        ropes = drive.route[span.route].ropes
        found.append(Wrap(pulley.name, before, pieces.index(next_span(drive, number)), factor, ropes))
    return tuple(found)


AXES = (ALONG, OUT_OF_PLANE, ACROSS)
"""Directions of u, v, w."""
FEWEST_SEGMENTS, MOST_NODES = 2, 10_000_000


@dataclass(frozen=True, kw_only=True, eq=False)
class NetworkMesh:
    """Pieces of rope between joints, each of equal segments, and the coordinates q that move their ends."""

    network: Network
    wraps: tuple[Wrap, ...]
    names: tuple[str, ...]  # of the coordinates; "slip at NAME" where the rope may slide on a pulley
    pieces: tuple[str, ...]  # names: the span's, with a number where carriages cut it
    nodes: Integers  # (pieces, 2): first and last node
    length: Array  # (pieces,): under the tension at rest [m]
    spacing: Array  # (pieces,) [m]
    density: Array  # (pieces,) [kg/m]
    transverse_damping: Array  # (pieces,) [1/s]
    axial_damping: Array  # (pieces,): of one rope [N s]
    tension: Array  # (pieces,): mean at rest, of one rope [N]
    rigidity: Array  # (pieces,): EA of one rope [N]
    ropes: Array  # (pieces,)
    ends: Array  # (pieces, 2, 3, n): rows u, v, w of start and end
    mass: Array  # (n, n): of the coordinates, with the half cells at the ends
    stiffness: Array  # (n, n): springs and turning bodies
    damping: Array  # (n, n): bearings and bodies
    driven: tuple[str, ...]  # pulleys of the motors; the first of the file where there is none
    motor: Array  # (motors, n): turn of each rotor

    @property
    def size(self) -> int:
        """Number of nodes."""
        return int(self.nodes[-1, 1]) + 1

    def position(self, piece: int) -> Array:
        """Distances of a piece's nodes from its start [m]."""
        first, last = self.nodes[piece]
        return np.linspace(0.0, float(self.length[piece]), int(last - first) + 1)


def network_mesh(network: Network, segments: int) -> NetworkMesh:
    """Divide the spans of a machine; ``segments``: of the longest piece, others in proportion."""
    if not isinstance(segments, int) or segments < FEWEST_SEGMENTS:
        raise InputRefused(
            f"segments = {segments!r} must be a whole number of at least {FEWEST_SEGMENTS}: give one"
        )
    drive, wraps = network.drive, wraps_of(network)
    ropes = [piece.rope for piece in network.pieces]
    length = np.array([piece.length for piece in network.pieces])
    tension = np.array([0.5 * (piece.start_tension + piece.end_tension) for piece in network.pieces])
    rigidity = np.array([rope.axial_rigidity for rope in ropes])
    count = np.maximum(1, np.rint(segments * length / length.max())).astype(np.int64)
    if int(count.sum()) > MOST_NODES:
        raise InputRefused(
            f"segments = {segments}: {count.sum()} in all, at most {MOST_NODES} are taken: fewer"
        )
    spacing, density = length / count, np.array([rope.density for rope in ropes]) / (1.0 + tension / rigidity)
    last = np.cumsum(count + 1) - 1
    nodes = np.stack([last - count, last], axis=1)
    moved, n = len(network.motion.names), len(network.motion.names) + len(wraps)
    ends = np.zeros((len(ropes), 2, 3, n))
    for number, piece in enumerate(network.pieces):
        for axis, way in enumerate(AXES):
            ends[number, :, axis, :moved] = piece.rows[way]
    for number, wrap in enumerate(wraps, start=moved):  # a rope that slips moves the ends on both its sides
        ends[wrap.before, 1, 0, number] = ends[wrap.behind, 0, 0, number] = 1.0
    lines = network.ropes[::3].astype(np.float64)
    half = 0.5 * lines * density * spacing
    mass = _padded(network.masses.matrix, n)
    mass += np.einsum("k,kaxi,kaxj->ij", half, ends, ends)
    return NetworkMesh(
        network=network,
        wraps=wraps,
        names=(*network.motion.names, *(f"slip at {wrap.name}" for wrap in wraps)),
        pieces=piece_names(network),
        nodes=nodes,
        length=length,
        spacing=spacing,
        density=density,
        transverse_damping=np.array([rope.transverse_damping for rope in ropes]),
        axial_damping=np.array([rope.axial_damping for rope in ropes]),
        tension=tension,
        rigidity=rigidity,
        ropes=lines,
        ends=ends,
        mass=mass,
        stiffness=_padded(network.springs.matrix + network.geometric, n),
        damping=_padded(network.dampers.matrix, n),
        driven=tuple(drive.pulley[number].name for number in drive.turned),
        motor=np.pad(turns_by_torque(network), ((0, 0), (0, len(wraps)))),
    )


def _padded(matrix: Array, n: int) -> Array:
    total = np.zeros((n, n))
    total[: len(matrix), : len(matrix)] = matrix
    return total


def piece_names(network: Network) -> tuple[str, ...]:
    """Names of the pieces of rope: the span's, with a number where carriages cut it."""
    spans = [piece.span for piece in network.pieces]
    return tuple(
        f"{piece.where.name}, part {spans[: k + 1].count(piece.span)}"
        if spans.count(piece.span) > 1
        else piece.where.name
        for k, piece in enumerate(network.pieces)
    )


def rubbing_of(
    network: Network, wraps: Sequence[Wrap], tension: Array
) -> tuple[Array, Array, Integers, Array]:
    """All Coulomb friction; ``tension``, shape (pieces,): at rest, of one rope [N].

    Returns rows (k, n): speed of what rubs per speed of the coordinates; largest friction (k,) [N], [N m], of
    a wrap per tension of its slacker side; pieces (k, 2) before and behind a wrap, -1 elsewhere; difference
    (n,) of the tensions at rest on both sides of a wrap, which its friction holds [N].
    """
    parts, moved = network.rubs, len(network.motion.names)
    first, n = len(parts.values), moved + len(wraps)
    rows, rest = np.zeros((first + len(wraps), n)), np.zeros(n)
    rows[:first, :moved], rows[first:, moved:] = parts.rows, np.eye(len(wraps))
    rest[moved:] = [wrap.ropes * (tension[wrap.behind] - tension[wrap.before]) for wrap in wraps]
    bound = np.append(parts.values, [wrap.ropes * wrap.factor for wrap in wraps])
    beside = [(-1, -1)] * first + [(wrap.before, wrap.behind) for wrap in wraps]
    return rows, bound, np.array(beside, dtype=np.int64).reshape(-1, 2), rest


def tables_of(mesh: NetworkMesh, step: float) -> tuple[Array, Array]:
    """Tables of the segments, (3, nodes - 1), and of the nodes, (9, nodes); ``step`` [s]."""
    segment, node = np.zeros((3, mesh.size - 1)), np.zeros((9, mesh.size))
    for k, (first, last) in enumerate(mesh.nodes):
        h, inner = float(mesh.spacing[k]), slice(first + 1, last)
        mass, damped = float(mesh.density[k] * h), 0.5 * step * float(mesh.transverse_damping[k])
        segment[:2, first:last] = [[h], [1.0 / h]]
        node[[at.KICK_U, at.KICK_T, at.KEEP_T, at.MASS], inner] = [
            [step / mass], [step / mass / (1.0 + damped)], [(1.0 - damped) / (1.0 + damped)], [mass]
        ]  # fmt: skip
        node[at.DRAG, inner] = mesh.transverse_damping[k] * mass * mesh.ropes[k]
        if damping := float(mesh.axial_damping[k]) * (1.0 + float(mesh.tension[k] / mesh.rigidity[k])):
            segment[at.COMPLIANCE, first:last] = h / damping
    return segment, node


def network_plan(mesh: NetworkMesh, laws: list[CableLaw], *, step: float, stop_when_slack: bool) -> Plan:
    """Numbers of one run; ``laws``: of each piece; ``step``: time step [s]."""
    segment, node = tables_of(mesh, step)
    made = eliminated(mesh.nodes, segment[at.COMPLIANCE], node[at.KICK_U], mesh.ropes, mesh.ends[:, :, 0])
    rub, bound, wrap, rest = rubbing_of(mesh.network, mesh.wraps, mesh.tension)
    middle = mesh.nodes.sum(axis=1) / 2.0
    probe = np.stack([middle // 1.0, middle % 1.0], axis=1)
    if (number := kernel_number(laws[0])) == at.OWN:
        raise InputRefused(
            'kind = "route": laws of one\'s own are not simulated on routes: take a packaged law'
        )
    return Plan(
        law=number,
        tension_only=laws[0].tension_only,
        stop_when_slack=stop_when_slack,
        step=step,
        axial=made.how(exact=number == at.EXACT),
        uniform=False,
        nodes=mesh.nodes,
        piece=np.array([(*law_numbers(law), ropes) for law, ropes in zip(laws, mesh.ropes, strict=True)]),
        segment=segment,
        node=node,
        **rows_of_ends(mesh.ends),
        **moved_by(mesh.mass, (mesh.damping, made.loss), np.ones(len(rest)), step, rub, bound),
        stiffness=mesh.stiffness,
        damping=np.stack([mesh.damping, np.zeros_like(mesh.damping)]),
        rest=rest,
        motor=mesh.motor,
        smooth=np.zeros(bound.size),
        wrap=wrap,
        damper=made.table,
        probe=probe,
    )
