r"""A network of spans divided into segments, with wraps where ropes slide, dry friction and axial damping.

A piece of rope is N segments of equal unstretched length; the reference of its cable law is a straight line
under its mean tension at rest. Under gravity it hangs as `cabledrive.mechanics.statics` says. Coordinates are
zero at rest.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp
from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.mesh import check_segments
from cabledrive.mechanics.network import Network
from cabledrive.mechanics.network.assembly import turns_by_torque
from cabledrive.mechanics.network.motion import ACROSS, ALONG, OUT_OF_PLANE
from cabledrive.mechanics.network.span_table import next_span
from cabledrive.mechanics.statics import hanging_gradients, segment_forces
from cabledrive.parameters.arrays import Integers
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation import plan as at
from cabledrive.simulation.dampers import eliminated
from cabledrive.simulation.plan import (
    Plan,
    kernel_number,
    moved_by,
    numbers_of_runs,
    rows_of_ends,
)
from cabledrive.simulation.start import Divided, Scheme, probed


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


@dataclass(frozen=True, kw_only=True, eq=False)
class NetworkMesh:
    """Pieces of rope between joints, each of equal segments, and the coordinates q that move their ends."""

    network: Network
    wraps: tuple[Wrap, ...]
    names: tuple[str, ...]  # of the coordinates; "slip at NAME" where the rope may slide on a pulley
    pieces: tuple[str, ...]  # names: the span's, with a number where carriages cut it
    nodes: Integers  # (pieces, 2): first and last node
    length: Array  # (pieces,): under the mean tension at rest [m]
    spacing: Array  # (pieces,) [m]
    density: Array  # (pieces,) [kg/m]
    tension: Array  # (pieces,): mean at rest, of one rope [N]
    rigidity: Array  # (pieces,): EA of one rope [N]
    ropes: Array  # (pieces,)
    ends: Array  # (pieces, 2, 3, n): rows u, v, w of start and end
    mass: Array  # (n, n): of the coordinates, with the half cells at the ends
    stiffness: Array  # (n, n): springs and turning bodies
    damping: Array  # (n, n): bearings and bodies, with the half cells across
    driven: tuple[str, ...]  # pulleys of the motors; the first of the file where there is none
    motor: Array  # (motors, n): turn of each rotor

    @property
    def size(self) -> int:
        """Number of nodes."""
        return int(self.nodes[-1, 1]) + 1

    @property
    def spans(self) -> Divided:
        """Its pieces as plucks and probes take them."""
        both = zip(self.length, self.nodes, strict=True)
        positions = [np.linspace(0.0, own, last - first + 1) for own, (first, last) in both]
        return self.pieces, positions, self.nodes, np.isin(np.arange(self.size), self.nodes)


def network_mesh(network: Network, segments: int) -> NetworkMesh:
    """Divide the spans of a machine; ``segments``: of the longest piece, others in proportion."""
    check_segments(segments, fewest=2)
    drive, wraps = network.drive, wraps_of(network)
    ropes = [piece.rope for piece in network.pieces]
    chord = np.array([piece.length for piece in network.pieces])
    tension = np.array([0.5 * (piece.start_tension + piece.end_tension) for piece in network.pieces])
    rigidity = np.array([rope.axial_rigidity for rope in ropes])
    count = np.maximum(1, np.rint(segments * chord / chord.max())).astype(np.int64)
    stretch = 1.0 + tension / rigidity
    length = stretch * np.array([piece.rest.length for piece in network.pieces])
    spacing, density = length / count, np.array([rope.density for rope in ropes]) / stretch
    last = np.cumsum(count + 1) - 1
    nodes = np.stack([last - count, last], axis=1)
    moved, n = len(network.motion.names), len(network.motion.names) + len(wraps)
    ends = np.zeros((len(ropes), 2, 3, n))
    for number, piece in enumerate(network.pieces):
        for axis, way in enumerate((ALONG, OUT_OF_PLANE, ACROSS)):
            ends[number, :, axis, :moved] = network.motion.dense(*piece.rows[way])
    for number, wrap in enumerate(wraps, start=moved):  # a rope that slips moves the ends on both its sides
        ends[wrap.before, 1, 0, number] = ends[wrap.behind, 0, 0, number] = 1.0
    lines = network.ropes[::3].astype(np.float64)
    half = 0.5 * lines * density * spacing
    mass = np.pad(network.masses.matrix, (0, len(wraps)))
    mass += np.einsum("k,kaxi,kaxj->ij", half, ends, ends)
    dragged = half * [rope.transverse_damping for rope in ropes]
    damping = np.pad(network.dampers.matrix, (0, len(wraps)))
    damping += np.einsum("k,kaxi,kaxj->ij", dragged, ends[:, :, 1:], ends[:, :, 1:])
    return NetworkMesh(
        network=network,
        wraps=wraps,
        names=(*network.motion.names, *(f"slip at {wrap.name}" for wrap in wraps)),
        pieces=piece_names(network),
        nodes=nodes,
        length=length,
        spacing=spacing,
        density=density,
        tension=tension,
        rigidity=rigidity,
        ropes=lines,
        ends=ends,
        mass=mass,
        stiffness=np.pad(network.springs.matrix + network.geometric, (0, len(wraps))),
        damping=damping,
        driven=tuple(drive.pulley[number].name for number in drive.turned),
        motor=np.pad(turns_by_torque(network), ((0, 0), (0, len(wraps)))),
    )


def piece_names(network: Network) -> tuple[str, ...]:
    """Names of the pieces of rope: the span's, with a number where carriages cut it."""
    spans = [piece.span for piece in network.pieces]
    return tuple(
        f"{piece.where.name}, part {spans[: k + 1].count(piece.span)}"
        if spans.count(piece.span) > 1
        else piece.where.name
        for k, piece in enumerate(network.pieces)
    )


def rubbing_of(network: Network, wraps: Sequence[Wrap]) -> tuple[Array, Array, Integers, Array]:
    """All Coulomb friction.

    Returns rows (k, n): speed of what rubs per speed of the coordinates; largest friction (k,) [N], [N m], of
    a wrap per tension of its slacker side; pieces (k, 2) before and behind a wrap, -1 elsewhere; difference
    (n,) of the tensions at rest on both sides of a wrap, which its friction holds [N].
    """
    parts, moved = network.rubs, len(network.motion.names)
    first, n = len(parts.values), moved + len(wraps)
    rows, rest = np.zeros((first + len(wraps), n)), np.zeros(n)
    rows[:first, :moved], rows[first:, moved:] = parts.dense, np.eye(len(wraps))
    for number, wrap in enumerate(wraps, start=moved):
        before, behind = network.pieces[wrap.before], network.pieces[wrap.behind]
        rest[number] = wrap.ropes * (behind.start_tension - before.end_tension)
    bound = np.append(parts.values, [wrap.ropes * wrap.factor for wrap in wraps])
    beside = [(-1, -1)] * first + [(wrap.before, wrap.behind) for wrap in wraps]
    return rows, bound, np.array(beside, dtype=np.int64).reshape(-1, 2), rest


class Rest(NamedTuple):
    """A divided network at rest."""

    x: Array  # (3, nodes): displacements u, v, w of the nodes, from the straight line of each piece [m]
    weight: Array  # (2, nodes): of the nodes of one rope, along and across [N]
    force: Array  # (n,): of the ropes on the coordinates, the pretension's own left out [N], [N m]
    energy: float  # of ropes and their weight, above that of the straight lines [J]


def rest_of(mesh: NetworkMesh, laws: Sequence[CableLaw]) -> Rest:
    """How the ropes hang; ``laws``: of each piece."""
    x, weight = np.zeros((3, mesh.size)), np.zeros((2, mesh.size))
    force, energy = np.zeros(len(mesh.names)), 0.0
    for k, (law, (first, last)) in enumerate(zip(laws, mesh.nodes.tolist(), strict=True)):
        carried = segment_forces(mesh.network.pieces[k].rest, last - first)
        u_x, w_x = hanging_gradients(law, *carried)
        x[::2, first + 1 : last + 1] = np.cumsum([u_x, w_x], axis=1) * mesh.spacing[k]
        weight[:, first + 1 : last] = -np.diff(carried)
        pulls = np.stack(law.excess_components(u_x, 0.0 * w_x, w_x))
        force += mesh.ropes[k] * (pulls[:, 0] @ mesh.ends[k, 0] - pulls[:, -1] @ mesh.ends[k, 1])
        stored = mesh.spacing[k] * law.energy_density(u_x, 0.0 * w_x, w_x).sum()
        energy += mesh.ropes[k] * (stored - np.sum(weight[:, first:last] * x[::2, first:last]))
    return Rest(x, weight, force, float(energy))


def tables_of(mesh: NetworkMesh, weight: Array, step: float) -> tuple[Array, Array]:
    """Tables of the segments, (3, nodes - 1), and of the nodes, (9, nodes); weights (2, nodes), step [s]."""
    segment, node = np.zeros((3, mesh.size - 1)), np.zeros((9, mesh.size))
    for k, (first, last) in enumerate(mesh.nodes):
        h, inner, rope = float(mesh.spacing[k]), slice(first + 1, last), mesh.network.pieces[k].rope
        mass, damped = float(mesh.density[k] * h), 0.5 * step * rope.transverse_damping
        segment[:2, first:last] = [[h], [1.0 / h]]
        node[[at.KICK_U, at.KICK_T, at.KEEP_T, at.MASS], inner] = [
            [step / mass], [step / mass / (1.0 + damped)], [(1.0 - damped) / (1.0 + damped)], [mass]
        ]  # fmt: skip
        node[at.DRAG, inner] = rope.transverse_damping * mass * mesh.ropes[k]
        node[at.WEIGHT_U : at.WEIGHT_W + 1, first : last + 1] = weight[:, first : last + 1] * mesh.ropes[k]
        if damping := rope.axial_damping * (1.0 + float(mesh.tension[k] / mesh.rigidity[k])):
            segment[at.COMPLIANCE, first:last] = h / damping
    node[[at.FALL_U, at.FALL_W]] = node[[at.KICK_U, at.KICK_T]] * weight
    return segment, node


def network_plan(
    mesh: NetworkMesh,
    laws: list[CableLaw],
    rest: Rest,
    probes: Sequence[tuple[str, float]],
    step: float,
    scheme: Scheme,
) -> Plan:
    """Numbers of one run: laws of the pieces, how they hang, points to record, time step [s], friction."""
    segment, node = tables_of(mesh, rest.weight, step)
    made = eliminated(mesh.nodes, segment[at.COMPLIANCE], node[at.KICK_U], mesh.ropes, mesh.ends[:, :, 0])
    rub, bound, wrap, held = rubbing_of(mesh.network, mesh.wraps)
    probe = probed(mesh.spans, [*zip(mesh.pieces, 0.5 * mesh.length, strict=True), *probes])
    before, share = probe[:, 0].astype(np.int64), probe[:, 1]
    places = (1.0 - share) * rest.x[:, before] + share * rest.x[:, before + 1]
    numbers = [(law.pretension, law.axial_rigidity, law.slack_strain) for law in laws]
    piece = np.column_stack([numbers, mesh.ropes, rest.x[:, mesh.nodes[:, 1]].T])
    if (number := kernel_number(laws[0])) == at.OWN:
        raise InputRefused(
            'kind = "route": laws of one\'s own are not simulated on routes: take a packaged law'
        )
    return Plan(
        law=number,
        tension_only=laws[0].tension_only,
        stop_when_slack=scheme.slack == "stop",
        step=step,
        axial=made.how(exact=number == at.EXACT),
        nodes=mesh.nodes,
        piece=piece,
        segment=segment,
        node=node,
        **rows_of_ends(mesh.ends),
        **moved_by(mesh.mass, (mesh.damping, made.loss), np.ones(len(held)), step, rub, bound),
        stiffness=mesh.stiffness,
        damping=np.stack([mesh.damping, np.zeros_like(mesh.damping)]),
        rest=held - rest.force,
        motor=mesh.motor,
        smooth=np.where(wrap[:, 0] < 0, scheme.smoothing_speed * (scheme.friction == "smoothed"), 0.0),
        wrap=wrap,
        damper=made.table,
        beside=np.stack([(mesh.nodes - (0, 1)).ravel(), np.repeat(np.arange(len(piece)), 2)], axis=1),
        runs=mesh.nodes,
        run=numbers_of_runs(mesh.nodes, piece, segment, node, step),
        probe=np.column_stack([probe, places.T]),
    )
