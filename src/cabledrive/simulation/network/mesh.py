"""A network of spans divided into segments, with the rows by which its coordinates move the ends."""

from dataclasses import dataclass

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.network import Network
from cabledrive.mechanics.network.damping import dampers_of, rotor_turn
from cabledrive.mechanics.network.motion import ACROSS, ALONG, OUT_OF_PLANE
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation.network.wraps import Wrap
from cabledrive.simulation.runs import Integers

AXES = (ALONG, OUT_OF_PLANE, ACROSS)
"""Directions of u, v, w."""
FEWEST_SEGMENTS, MOST_NODES = 2, 10_000_000


@dataclass(frozen=True, kw_only=True, eq=False)
class NetworkMesh:
    """Pieces of rope between joints, each of equal segments, and the coordinates q that move their ends."""

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
    inverse_spacing: Array  # (nodes - 1,) [1/m]; 0 between pieces
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


def network_mesh(network: Network, wraps: list[Wrap], segments: int) -> NetworkMesh:
    """Divide the spans of a machine; ``segments``: of the longest piece, others in proportion."""
    if not isinstance(segments, int) or segments < FEWEST_SEGMENTS:
        raise InputRefused(
            f"segments = {segments!r} must be a whole number of at least {FEWEST_SEGMENTS}: give one"
        )
    drive = network.drive
    ropes = [drive.ropes[drive.free_spans[piece.span].route] for piece in network.pieces]
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
    inverse = np.zeros(last[-1])
    for (a, b), h in zip(nodes, spacing, strict=True):
        inverse[a:b] = 1.0 / h
    ends = _ends(network, wraps)
    n = ends.shape[-1]
    lines = np.array([network.ropes[3 * k] for k in range(len(length))], dtype=np.float64)
    half = 0.5 * lines * density * spacing
    mass = _padded((network.mass_rows.T * network.mass) @ network.mass_rows, n)
    mass += np.einsum("k,kaxi,kaxj->ij", half, ends, ends)
    dampers, rows = dampers_of(network)
    springs = (network.spring_rows.T * network.spring) @ network.spring_rows + network.geometric
    driven = drive.driven or tuple(range(len(drive.pulley)))[:1]
    motors = [np.append(rotor_turn(network, number), np.zeros(len(wraps))) for number in driven]
    return NetworkMesh(
        names=(*network.motion.names, *(f"slip at {wrap.name}" for wrap in wraps)),
        pieces=_names(network),
        nodes=nodes,
        length=length,
        spacing=spacing,
        density=density,
        transverse_damping=np.array([rope.transverse_damping for rope in ropes]),
        axial_damping=np.array([rope.axial_damping for rope in ropes]),
        tension=tension,
        rigidity=rigidity,
        ropes=lines,
        inverse_spacing=inverse,
        ends=ends,
        mass=mass,
        stiffness=_padded(springs, n),
        damping=_padded((rows.T * dampers) @ rows, n),
        driven=tuple(drive.pulley[number].name for number in driven),
        motor=np.array(motors) if motors else np.zeros((0, n)),
    )


def _ends(network: Network, wraps: list[Wrap]) -> Array:
    """Rows of both ends of each piece; a rope that slips on a pulley moves the ends on both its sides."""
    n = len(network.motion.names)
    ends = np.zeros((len(network.pieces), 2, 3, n + len(wraps)))
    for number, piece in enumerate(network.pieces):
        for axis, way in enumerate(AXES):
            for side in range(2):
                ends[number, side, axis, :n] = piece.rows[way][side]
    for number, wrap in enumerate(wraps):
        ends[wrap.before, 1, 0, n + number] = 1.0
        ends[wrap.behind, 0, 0, n + number] = 1.0
    return ends


def _padded(matrix: Array, n: int) -> Array:
    total = np.zeros((n, n))
    total[: len(matrix), : len(matrix)] = matrix
    return total


def _names(network: Network) -> tuple[str, ...]:
    spans = [piece.span for piece in network.pieces]
    names = []
    for number, span in enumerate(spans):
        name = network.drive.free_spans[span].name
        place = spans[: number + 1].count(span)
        names.append(f"{name}, part {place}" if spans.count(span) > 1 else name)
    return tuple(names)
