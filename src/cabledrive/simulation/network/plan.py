"""Numbers of a run of a network, worked out once, and what changes from step to step."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.network import Network
from cabledrive.parameters.arrays import Integers
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation.network.mesh import NetworkMesh, Wrap, axial_dampers, rubbing_of
from cabledrive.simulation.plan import KERNEL_LAWS

# Columns of NetworkPlan.run: spacing [m]; velocity gained per pull h p along u, and across; share of the
# velocity across that a step keeps; transverse loss per square of twice the mean velocity.
H, SPEED_U, SPEED_T, KEPT, LOSS = range(5)
# Columns of NetworkPlan.piece.
PRETENSION, RIGIDITY, SLACK_STRAIN, ROPES, DENSITY = range(5)

# Tallies of a network, in the order of their columns in a record.
TORQUE_WORK, TRANSVERSE_LOSS, AXIAL_LOSS, VISCOUS_LOSS, COULOMB_LOSS = range(5)
TALLIES = 5


class NetworkPlan(NamedTuple):
    """Numbers of one run. The nodes of all pieces stand in a row, each piece with both its ends.

    The ends of a piece move as rows of the coordinates q say; row 6 k + 3 side + axis belongs to piece k, its
    start (0) or end (1), along (0), out of plane (1) or across (2).
    """

    law: int  # position in KERNEL_LAWS
    tension_only: bool
    stop_when_slack: bool
    step: float  # [s]
    nodes: Integers  # (pieces, 2): first and last node of each piece
    piece: Array  # (pieces, 5): T0 [N], EA [N], slack strain, parallel ropes, mass per length [kg/m]
    inverse_spacing: Array  # (nodes - 1,): 1 / h [1/m], 0 between pieces
    run: Array  # (pieces, 5)
    row_start: Integers  # (6 pieces + 1,): where the entries of each row begin
    row_column: Integers  # (entries,)
    row_value: Array  # (entries,)
    mass: Array  # (n, n): of q, the half cells at the ends of pieces included
    stiffness: Array  # (n, n): springs and turning bodies
    damping: Array  # (n, n): of bearings, bodies and joints
    inverse: Array  # (n, n): of M / step + C / 2, axial damping of the ropes included
    back: Array  # (n, n): M / step - C / 2
    compliance: Array  # (pieces,): see `cabledrive.simulation.network.mesh`
    damper: Array  # (3, nodes - 1): pivots, tension per speed of the start and of the end
    rest: Array  # (n,): forces at rest that friction alone holds [N]
    motor: Array  # (motors, n): turn of each rotor
    rub: Array  # (frictions, n): what rubs, per speed of q
    rub_mobility: Array  # (n, frictions): speed of q per friction over a step
    rub_own: Array  # (frictions,): speed of what rubs per its own friction
    bound: Array  # (frictions,): Coulomb friction [N], [N m]; of a wrap per tension
    wrap: Integers  # (frictions, 2): pieces before and behind a wrap, -1 elsewhere


def network_plan(
    network: Network,
    wraps: list[Wrap],
    mesh: NetworkMesh,
    laws: list[CableLaw],
    *,
    step: float,
    stop_when_slack: bool,
) -> NetworkPlan:
    """Numbers of one run; ``laws``: of each piece; ``step``: time step [s]."""
    compliance, damper, dampers = axial_dampers(mesh, step)
    damping = mesh.damping + dampers
    inverse = np.linalg.inv(mesh.mass / step + 0.5 * damping).astype(np.float64)
    rub, bound, wrap, rest = rubbing_of(network, wraps, mesh.tension)
    mobility = inverse @ rub.T
    start, column, value = _rows(mesh)
    return NetworkPlan(
        law=_number(laws[0]),
        tension_only=laws[0].tension_only,
        stop_when_slack=stop_when_slack,
        step=step,
        nodes=mesh.nodes,
        piece=np.array(
            [
                (law.pretension, law.axial_rigidity, law.slack_strain, ropes, density)
                for law, ropes, density in zip(laws, mesh.ropes, mesh.density, strict=True)
            ]
        ),
        inverse_spacing=mesh.inverse_spacing,
        run=_runs(mesh, step),
        row_start=start,
        row_column=column,
        row_value=value,
        mass=mesh.mass,
        stiffness=mesh.stiffness,
        damping=mesh.damping,
        inverse=inverse,
        back=mesh.mass / step - 0.5 * damping,
        compliance=compliance,
        damper=damper,
        rest=rest,
        motor=mesh.motor,
        rub=rub,
        rub_mobility=np.ascontiguousarray(mobility),
        rub_own=np.einsum("kn,nk->k", rub, mobility),
        bound=bound,
        wrap=wrap,
    )


def _number(law: CableLaw) -> int:
    from cabledrive.mechanics.cable_laws import taut_law

    kind = type(taut_law(law))
    if kind not in KERNEL_LAWS:
        raise InputRefused(
            'kind = "route": laws of one\'s own are not simulated on routes: take a packaged law'
        )
    return KERNEL_LAWS.index(kind)


def _runs(mesh: NetworkMesh, step: float) -> Array:
    """Table of the pieces' numbers; of one rope."""
    h, kick, damped = (
        mesh.spacing,
        step / (mesh.density * mesh.spacing**2),
        0.5 * step * mesh.transverse_damping,
    )
    kept, loss = (1.0 - damped) / (1.0 + damped), 0.25 * step * mesh.transverse_damping * mesh.density * h
    return np.stack([h, kick, kick / (1.0 + damped), kept, loss * mesh.ropes], axis=1)


def _rows(mesh: NetworkMesh) -> tuple[Integers, Integers, Array]:
    """The rows of the ends without their zeros."""
    rows = mesh.ends.reshape(-1, mesh.ends.shape[-1])
    start = np.concatenate(([0], np.cumsum(np.count_nonzero(rows, axis=1)))).astype(np.int64)
    column: NDArray[np.int64] = np.nonzero(rows)[1].astype(np.int64)
    return start, column, rows[rows != 0.0]


MOST_EVENTS = 1000

# Entries of NetworkState.counts.
STEPS, EVENTS = range(2)


class NetworkState(NamedTuple):
    """Displacements at the time of a step, velocities half a step before it, and what was counted."""

    x: Array  # (3, nodes): u, v, w [m]
    x_t: Array  # (3, nodes) [m/s]
    q: Array  # (n,): coordinates [m], [rad]
    q_t: Array  # (n,)
    tallies: Array  # (2, TALLIES): works and losses [J], and what rounding took from them
    extremes: Array  # (2, n): least and largest of each coordinate
    peaks: Array  # (pieces,): largest |w| at the middle [m]
    events: Array  # (MOST_EVENTS, 3): step, piece and least tension [N] where a piece went slack
    slack: Integers  # (pieces,): whether it was slack at the last step
    counts: Integers  # (2,): steps done, events


class NetworkWorkspace(NamedTuple):
    """Arrays without meaning between steps."""

    before: Array  # (2, 3, nodes): displacements, and velocities before the kick, of a recorded step
    before_q: Array  # (2, n)
    before_tallies: Array  # (2, TALLIES)
    p: Array  # (3, nodes - 1): components above the pretension [N]
    pull: Array  # (pieces, 2, 3): those beside both ends
    damping: Array  # (nodes - 1,): damping tensions [N]
    force: Array  # (n,)
    right: Array  # (n,)
    new: Array  # (n,)
    friction: Array  # (frictions,)
    bound: Array  # (frictions,)


def new_network_state(plan: NetworkPlan, x: Array, x_t: Array, q: Array, q_t: Array) -> NetworkState:
    """State at the start of a run; velocities half a step before it."""
    pieces = len(plan.nodes)
    return NetworkState(
        x=np.array(x),
        x_t=np.array(x_t),
        q=np.array(q),
        q_t=np.array(q_t),
        tallies=np.zeros((2, TALLIES)),
        extremes=np.stack([np.full(q.size, np.inf), np.full(q.size, -np.inf)]),
        peaks=np.zeros(pieces),
        events=np.zeros((MOST_EVENTS, 3)),
        slack=np.zeros(pieces, dtype=np.int64),
        counts=np.zeros(2, dtype=np.int64),
    )


def new_network_workspace(plan: NetworkPlan) -> NetworkWorkspace:
    """Work space for a run."""
    nodes, n, pieces = int(plan.nodes[-1, 1]) + 1, len(plan.mass), len(plan.nodes)
    return NetworkWorkspace(
        before=np.zeros((2, 3, nodes)),
        before_q=np.zeros((2, n)),
        before_tallies=np.zeros((2, TALLIES)),
        p=np.zeros((3, nodes - 1)),
        pull=np.zeros((pieces, 2, 3)),
        damping=np.zeros(nodes - 1),
        force=np.zeros(n),
        right=np.zeros(n),
        new=np.zeros(n),
        friction=np.zeros(plan.bound.size),
        bound=np.zeros(plan.bound.size),
    )
