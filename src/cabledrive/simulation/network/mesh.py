r"""A network of spans divided into segments, with wraps where ropes slide, dry friction and axial damping.

A piece of rope is N segments of equal unstretched length; the reference of its cable law is a straight line.
Under gravity the segment at the unstretched place s carries the force :math:`\mathbf F(s)` of Eq. (N.10),
since the weight of a node is the difference of its neighbours: so a divided rope is in balance under the
forces of `cabledrive.mechanics.network.statics`, whatever its law. Coordinates are zero at rest.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.cable_laws import taut_law
from cabledrive.mechanics.mesh import Mesh, Wrap, weights_of
from cabledrive.mechanics.network import Network
from cabledrive.mechanics.network.pieces import Piece
from cabledrive.mechanics.network.rest_forces import MOST_STEPS
from cabledrive.parameters.arrays import Integers
from cabledrive.parameters.errors import NotComputed
from cabledrive.simulation import plan as at
from cabledrive.simulation.damped import eliminated
from cabledrive.simulation.plan import Plan, kernel_number, moved_by, numbers_of_runs, rows_of_ends
from cabledrive.simulation.start import Scheme, probed, straight


def rubbing_of(
    network: Network, wraps: Sequence[Wrap] = (), parts: Sequence[Sequence[Piece]] = ()
) -> tuple[Array, Array, Integers, Array]:
    """All Coulomb friction.

    Returns rows (k, n): speed of what rubs per speed of the coordinates; largest friction (k,) [N], [N m], of
    a wrap per tension of its slacker side; pieces (k, 2) before and behind a wrap, -1 elsewhere; difference
    (n,) of the tensions at rest on both sides of a wrap, which its friction holds [N].
    """
    moved, shared = len(network.motion.names), dict[tuple[float, ...], float]()
    for row, value in zip(network.rubs.dense.tolist(), network.rubs.values.tolist(), strict=True):
        shared[tuple(row)] = shared.get(tuple(row), 0.0) + value
    first, n = len(shared), moved + len(wraps)
    rows, rest = np.zeros((first + len(wraps), n)), np.zeros(n)
    rows[:first, :moved], rows[first:, moved:] = np.array([*shared]).reshape(first, moved), np.eye(len(wraps))
    for number, wrap in enumerate(wraps, start=moved):
        before, behind = parts[wrap.before][-1], parts[wrap.behind][0]
        rest[number] = wrap.ropes * (behind.start_tension - before.end_tension)
    bound = np.append([*shared.values()], [wrap.ropes * wrap.factor for wrap in wraps])
    beside = [(-1, -1)] * first + [(wrap.before, wrap.behind) for wrap in wraps]
    return rows, bound, np.array(beside, dtype=np.int64).reshape(-1, 2), rest


class Rest(NamedTuple):
    """A divided network where its coordinates are 0: at rest, its ropes hanging."""

    x: Array  # (3, nodes): displacements u, v, w of the nodes, from the straight line of each piece [m]
    counted: Array  # (3, nodes): those from which records count, of loops and lines of straight spans [m]
    turned: Array  # (n,): coordinates there
    weight: Array  # (2, nodes): of the nodes of one rope, along and across [N]
    given: Array  # (n,): on the coordinates, what balances the ropes
    energy: float  # of ropes and their weight, above that of the straight lines [J]


def hanging_gradients(law: CableLaw, along: Array, across: Array) -> tuple[Array, Array]:
    """Gradients u', w' under which a law gives some forces, by Newton's method from the exact law."""
    tension = np.where(across == 0.0, along, np.hypot(along, across))
    strain = (tension - law.pretension) / law.stiffness
    cosine, sine = along / tension, across / tension
    u_x, w_x = strain * cosine - sine**2 / (1.0 + cosine), (1.0 + strain) * sine
    for _ in range(MOST_STEPS):
        x, _, z = law.excess_components(u_x, 0.0 * w_x, w_x)
        left = np.stack([along - law.pretension - x, across - z], axis=-1)
        if np.abs(left).max() <= 64.0 * np.finfo(float).eps * law.stiffness:
            return u_x, w_x
        slope = law.stiffness_matrix(u_x, 0.0 * w_x, w_x)[:, ::2, ::2]
        u_x, w_x = np.stack([u_x, w_x]) + np.linalg.solve(slope, left[..., None])[..., 0].T
    raise NotComputed(f"no equilibrium: the law {law.name} does not give {tension.min():.4g} N; take another")


def rest_of(mesh: Mesh, laws: Sequence[CableLaw], g: Array) -> Rest:
    """How the ropes hang, and from where records count.

    ``laws``: of each piece; ``g``, (2,): gravity in the plane of the machine [m/s^2].
    """
    x, weight = np.zeros((3, mesh.size)), weights_of(mesh, g)
    force, energy = np.zeros(len(mesh.names)), 0.0
    for k, (law, (first, last)) in enumerate(zip(map(taut_law, laws), mesh.nodes.tolist(), strict=True)):
        h = mesh.spacing[first:last]
        joints = np.unique([first, *mesh.carriages[(mesh.carriages > first) & (mesh.carriages < last)], last])
        both = [(own.rest, n) for own, n in zip(mesh.parts[k], np.diff(joints).tolist(), strict=True)]
        places = [own.start + own.length * (np.arange(n) + 0.5) / n for own, n in both]
        forces = [own.force_at(at_rest) for (own, _), at_rest in zip(both, places, strict=True)]
        u_x, w_x = hanging_gradients(law, *np.hstack(forces))
        x[::2, first + 1 : last + 1] = np.cumsum(np.stack([u_x, w_x]) * h, axis=1)
        pulls = np.stack(law.excess_components(u_x, 0.0 * w_x, w_x))
        force += mesh.ropes[k] * (pulls[:, 0] @ mesh.ends[k, 0] - pulls[:, -1] @ mesh.ends[k, 1])
        stored = h @ law.energy_density(u_x, 0.0 * w_x, w_x)
        energy += mesh.ropes[k] * (stored - np.sum(weight[:, first:last] * x[::2, first:last]))
    counted, turned = straight(mesh, x) if mesh.whole else (x, np.zeros_like(force))
    return Rest(x, counted, turned, weight, -force, float(energy))


MOST_OFF, MOST_PASSED, MOST_ASIDE = 0.01, 0.1, 1e-4
"""Share of a tension by which turning ends may stretch a span that hangs, and shares of its length that they
may pass on, and move aside, before a run says so."""


def passed_words(mesh: Mesh, turned: Array) -> Iterator[str]:
    """Spans that hang and pass so much rope on that ends which follow their tangents at rest mislead.

    ``turned``: largest motion of each coordinate from rest, (n,).
    """
    for k, own in enumerate(mesh.parts):
        rims, length = mesh.network.motion.dense(own[0].rims[0], own[-1].rims[1]), float(mesh.length[k])
        passed = np.abs(rims) @ turned[: rims.shape[1]]
        slope = np.abs([own[0].direction(True)[1], own[-1].direction(False)[1]])
        aside, most = float(passed @ slope) / length, float(passed.max()) / length
        off = 0.5 * aside**2 * mesh.rigidity[k] / max(mesh.tension[k], 1e-300)
        if off > MOST_OFF or (most > MOST_PASSED and aside > MOST_ASIDE):
            yield (
                f"{passed.max():.3g} m of rope pass the ends of {mesh.pieces[k]}, which hangs at a slope of "
                f"{slope.max():.2g} there: ends follow tangents at rest, which puts its tension up to "
                f"{100.0 * off:.2g} % off, and what shakes it across up to {200.0 * most:.2g} %"
            )


def tables_of(mesh: Mesh, weight: Array, step: float) -> tuple[Array, Array]:
    """Tables of the segments, (3, nodes - 1), and of the nodes, (9, nodes); weights (2, nodes), step [s]."""
    segment, node = np.zeros((3, mesh.size - 1)), np.zeros((9, mesh.size))
    for k, (first, last) in enumerate(mesh.nodes):
        h, inner, rope = mesh.spacing[first:last], slice(first + 1, last), mesh.parts[k][0].rope
        mass, drag = (mesh.cells + mesh.carried)[inner], rope.transverse_damping * mesh.cells[inner]
        damped, sways = 0.5 * step * drag / mass, mesh.sways[inner]
        segment[:2, first:last] = h, 1.0 / h
        node[at.KICK_U, inner], node[at.MASS, inner] = step / mass, mass
        node[at.KICK_T, inner], node[at.KEEP_T, inner] = (
            sways / (1.0 + damped) * np.stack([step / mass, 1.0 - damped])
        )
        node[at.DRAG, inner] = sways * drag * mesh.ropes[k]
        node[at.WEIGHT_U : at.WEIGHT_W + 1, inner] = weight[:, inner] * mesh.ropes[k]
        if damping := rope.axial_damping * (1.0 + float(mesh.tension[k] / mesh.rigidity[k])):
            segment[at.COMPLIANCE, first:last] = h / damping
    node[[at.FALL_U, at.FALL_W]] = node[[at.KICK_U, at.KICK_T]] * weight
    return segment, node


def runs_of(nodes: Integers, stops: Integers) -> tuple[Integers, Integers]:
    """Runs of equal segments between ends of pieces and stops, as of `Plan`, and the piece of each."""
    edges = [np.unique([a, *stops[(stops > a) & (stops < b)], b]) for a, b in nodes]
    runs = np.concatenate([np.stack([own[:-1], own[1:]], axis=1) for own in edges])
    return runs, np.repeat(np.arange(len(nodes)), [own.size - 1 for own in edges])


def network_plan(
    mesh: Mesh,
    laws: list[CableLaw],
    rest: Rest,
    probes: Sequence[tuple[str, float]],
    step: float,
    scheme: Scheme,
    forces: Sequence[tuple[int, int]] = (),
) -> Plan:
    """Numbers of one run: laws of the pieces, how they hang, points to record, time step [s], friction.

    ``forces``: node and axis of each force on a node.
    """
    segment, node = tables_of(mesh, rest.weight, step)
    made = eliminated(mesh.nodes, segment[at.COMPLIANCE], node[at.KICK_U], mesh.ropes, mesh.ends[:, :, 0])
    rub, bound, wrap, held = rubbing_of(mesh.network, mesh.wraps, mesh.parts)
    probe = probed(mesh.spans, [*zip(mesh.pieces, 0.5 * mesh.length, strict=True), *probes])
    before, share = probe[:, 0].astype(np.int64), probe[:, 1]
    places = (1.0 - share) * rest.counted[:, before] + share * rest.counted[:, before + 1]
    numbers = [(law.pretension, law.axial_rigidity, law.slack_strain) for law in laws]
    piece = np.column_stack([numbers, mesh.ropes, rest.x[:, mesh.nodes[:, 1]].T])
    stops = np.unique([*mesh.carriages, *(own for own, _ in forces)]).astype(np.int64)
    runs, owner = runs_of(mesh.nodes, stops)
    return Plan(
        law=(number := kernel_number(laws[0])),
        tension_only=laws[0].tension_only,
        stop_when_slack=scheme.slack == "stop",
        step=step,
        axial=made.how(exact=number == at.EXACT),
        nodes=mesh.nodes,
        piece=piece,
        segment=segment,
        node=node,
        **rows_of_ends(mesh.ends),
        **moved_by(mesh.mass, (mesh.damping.sum(axis=0), made.loss), np.ones(len(held)), step, rub, bound),
        stiffness=mesh.stiffness,
        damping=mesh.damping,
        rest=held + rest.given,
        motor=mesh.motor,
        smooth=np.where(wrap[:, 0] < 0, scheme.smoothing_speed * (scheme.friction == "smoothed"), 0.0),
        wrap=wrap,
        damper=made.table,
        probe=np.column_stack([probe, places.T]),
        force=np.array(forces, dtype=np.int64).reshape(-1, 2),
        stop=stops,
        beside=np.unique(np.stack([(runs - (0, 1)).ravel(), np.repeat(owner, 2)], axis=1), axis=0),
        runs=runs,
        run=numbers_of_runs(runs, piece[owner], segment, node, step),
    )
