r"""The cable divided into segments: nodes that carry mass, segments between them that carry tension.

Nodes are material points of the cable, numbered round the loop: node 0 is the drive rim, then the upper
span, then the load rim (node n), then the lower span back to the drive rim. Arrays over nodes have one entry
more than there are segments; in a loop the last entry is node 0 again. Each carriage sits on a node of its
own, with equal segments between neighbouring carriages and rims, so that its place costs no accuracy.

Displacements are arrays of shape (3, nodes): u, v, w at each node. A segment stores
:math:`h\,e(u', v', w')` with the differences of its ends as gradients; the forces on the nodes are minus the
derivative of the sum, so that a law with a potential gives a conservative chain.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.cable_law import Array, CableLaw, Components
from cabledrive.mechanics.holding import Joint, Shaft, joint_of, shafts_of
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.errors import InputRefused

FEWEST_SEGMENTS = 3
MOST_SEGMENTS = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mesh:
    """A drive in n segments per span, joined at the rims as Eqs. (2.29) and (2.30) say.

    Lengths and masses are per pretensioned metre.
    """

    spans: tuple[str, ...]  # names of the spans
    closed: bool  # whether the spans form a loop
    segments: int  # segments per span, n; at least one between neighbouring carriages
    position: Array
    """(spans, n + 1): distance of the nodes of each span from the pulley at which the span starts [m]."""
    spacing: Array  # (spans * n,): length of each segment [m]
    density: float  # mass of the cable per pretensioned metre [kg/m]
    cable_mass: Array
    """(spans * n + 1,): cable that belongs to each node, half of each neighbouring segment [kg]."""
    carriage_mass: Array  # (spans * n + 1,): carriage at each node [kg]
    weight_u: Array  # (spans * n + 1,): of cable and carriage along u [N]; sign of (2.26)
    weight_w: Array  # (spans * n + 1,): along w [N]; sign of (2.27)
    sways: NDArray[np.bool_]
    """(spans * n + 1,): whether a node moves transversely: neither rims nor guided carriages do."""
    carriage_node: NDArray[np.intp]  # node of each carriage, in the order of the drive file
    shafts: tuple[Shaft, ...]  # drive pulley, load pulley, and the motor if its joint is flexible
    joint: Joint | None  # the flexible joint

    @property
    def nodes(self) -> int:
        """Entries of an array over nodes."""
        return self.spacing.size + 1

    @property
    def rims(self) -> tuple[int, int]:
        """Nodes of drive rim and load rim."""
        return 0, self.segments

    @property
    def mass(self) -> Array:
        """Mass that moves with each node along u, without the pulleys [kg]."""
        return self.cable_mass + self.carriage_mass

    @property
    def axial_mass(self) -> Array:
        """Mass that moves with each node along u: at the rims J/r^2 and the half cells [kg]."""
        mass = self.mass
        for node, shaft in zip(self.rims, self.shafts, strict=False):
            mass[node] += shaft.rim_mass
        if self.closed:
            mass[-1] = mass[0]
        return mass

    def span_nodes(self, span: str) -> slice:
        """Nodes of a span, its two rims included."""
        start = self.spans.index(span) * self.segments
        return slice(start, start + self.segments + 1)


def mesh_of(drive: Drive, segments: int) -> Mesh:
    """Divide the cable of a drive into segments, one per gap at least where carriages stand close.

    Refused: too few segments, or too many to be stored.
    """
    check_segments(segments)
    stretch, stops = drive.pulley_distance / drive.span_length, []
    for span in drive.spans:  # places where there must be a node: rims and carriages
        carried = [carriage.position * stretch for carriage in drive.carriages_on(span)]
        stops.append(np.array([0.0, *carried, drive.pulley_distance]))
    segments = max(segments, *(len(stop) - 1 for stop in stops))
    places, node = [], {}
    for number, (span, stop) in enumerate(zip(drive.spans, stops, strict=True)):
        counts = _share_out(np.diff(stop), segments)
        parts = zip(stop[:-1], stop[1:], counts, strict=True)
        places.append(np.concatenate([a + (b - a) * np.arange(n) / n for a, b, n in parts] + [stop[-1:]]))
        joints = np.cumsum(counts)[:-1] + number * segments
        for carriage, place in zip(drive.carriages_on(span), joints, strict=True):
            node[carriage.span, carriage.position] = place
    position = np.array(places)
    carriage_node = np.array([node[own.span, own.position] for own in drive.carriage], dtype=np.intp)
    density = drive.cable.stretched_mass_per_length
    nodes = segments * len(drive.spans) + 1
    carriage_mass = np.zeros(nodes)
    carriage_mass[carriage_node] = [carriage.mass for carriage in drive.carriage]
    cable_mass, (weight_u, weight_w) = _cells(drive, position, density, carriage_mass)
    sways = np.ones(nodes, dtype=bool)
    sways[::segments] = False
    sways[carriage_node[[carriage.guided for carriage in drive.carriage]]] = False
    return Mesh(
        spans=drive.spans,
        closed=drive.kind == "loop",
        segments=segments,
        position=position,
        spacing=np.diff(position, axis=1).ravel(),
        density=density,
        cable_mass=cable_mass,
        carriage_mass=carriage_mass,
        weight_u=weight_u,
        weight_w=np.where(sways, weight_w, 0.0),
        sways=sways,
        carriage_node=carriage_node,
        shafts=shafts_of(drive),
        joint=joint_of(drive),
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


def _share_out(gaps: Array, segments: int) -> NDArray[np.intp]:
    """Segments for each gap, at least one, as equal in length as can be."""
    count = np.maximum(1, np.rint(segments * gaps / gaps.sum())).astype(np.intp)
    while count.sum() < segments:
        count[np.argmax(gaps / count)] += 1
    while count.sum() > segments:
        count[np.argmin(np.where(count > 1, gaps / np.maximum(count - 1, 1), np.inf))] -= 1
    return count


def _cells(
    drive: Drive, position: Array, density: float, carriage_mass: Array
) -> tuple[Array, tuple[Array, Array]]:
    """Cable mass of each node, and its weight along u and w with the signs of Eqs. (2.26) and (2.27).

    A rim node has half a cell in each span.
    """
    pull = np.array([drive.layout.gravity_along, drive.layout.gravity_across])
    cable_mass = np.zeros(carriage_mass.size)
    weight = np.zeros((2, carriage_mass.size))
    segments = position.shape[1] - 1
    for number, places in enumerate(position):
        half = 0.5 * density * np.diff(places)
        cell = np.concatenate(([0.0], half)) + np.concatenate((half, [0.0]))
        here = slice(number * segments, (number + 1) * segments + 1)
        cable_mass[here] += cell
        downwards = -1.0 if number == 0 else 1.0  # u and w of the lower span point the other way
        weight[:, here] += downwards * pull[:, None] * (cell + carriage_mass[here])
    if drive.kind == "loop":
        for array in (cable_mass, weight[0], weight[1]):
            array[0] += array[-1]
            array[-1] = array[0]
    return cable_mass, (weight[0], weight[1])


def gradients(mesh: Mesh, displacement: Array) -> Components:
    """Displacement gradients u', v', w' of the segments [-] from displacements, shape (3, nodes) [m]."""
    u_x, v_x, w_x = np.diff(displacement, axis=1) / mesh.spacing
    return u_x, v_x, w_x


def strain_energy(mesh: Mesh, law: CableLaw, displacement: Array) -> Array:
    """Elastic energy of each span [J] above the straight pretensioned cable; u, v, w, (3, nodes) [m]."""
    density = law.energy_density(*gradients(mesh, displacement))
    return np.sum((density * mesh.spacing).reshape(len(mesh.spans), -1), axis=1)


def weight_energy(mesh: Mesh, displacement: Array) -> float:
    """Potential energy of the weight [J], zero for the straight cable; u, v, w, (3, nodes) [m]."""
    last = -1 if mesh.closed else None
    lowered = mesh.weight_u * displacement[0] + mesh.weight_w * displacement[2]
    return -float(np.sum(lowered[:last]))
