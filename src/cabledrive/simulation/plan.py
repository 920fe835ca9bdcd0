r"""The cable of one run as its kernels take it: what stays, what moves, runs of equal segments.

A run ends where the spacing changes and at a stop, a node with a carriage or a force; at a rim only where the
cable has a weight along its span, which then changes sign. The numbers of a run are scaled by its spacing h,
so that the pass works with the differences of displacements of a segment's ends: with
:math:`y = h^2 z = \Delta u\,(2h + \Delta u) + \Delta v^2 + \Delta w^2` the gain of the exact law is
:math:`EA\,z\,s(z)`, a polynomial in y.

Few arrays with many rows: each array costs a kernel time to compile.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.cable_laws import (
    ConsistentWeakLaw,
    ExactLaw,
    LinearLaw,
    WeakLaw,
    taut_law,
)
from cabledrive.mechanics.mesh import Mesh
from cabledrive.parameters.arrays import Integers
from cabledrive.simulation.channels import TALLIES
from cabledrive.simulation.dampers import eliminated
from cabledrive.simulation.start import Scheme, divided_spans, probed

# s(z) = 1 / (1 + z + sqrt(1 + z)) for |z| <= LARGEST_Z: Chebyshev fit of degree 7, good to 2e-16.
LARGEST_Z = 0.02
SERIES = (
    0.49999999999999994,
    -0.37499999999999994,
    0.3125000000029696,
    -0.2734375000028212,
    0.24609371288165302,
    -0.22558590223736838,
    0.2096211067498548,
    -0.1965216438263875,
)

# Columns of the table of runs: T0, spacing; velocity gained over a step per pull h p along u, and by weight;
# the same across, with the share of the velocity that is kept; transverse loss per square of twice the mean
# velocity; bounds of the y at which a segment is taut and the series holds; coefficients of the gain in y.
PULL, H, SPEED_U, RUN_FALL_U, SPEED_T, KEPT, LOSS, CENTRE, REACH, GAIN = range(10)
COLUMNS = GAIN + len(SERIES)


def runs_of(mesh: Mesh, stops: Integers) -> Integers:
    """First and last segment of each run, the last not included, shape (runs, 2)."""
    h = mesh.spacing
    changes = np.abs(np.diff(h)) > 1e-12 * h[:-1]
    if mesh.weight_u.any():
        changes[mesh.segments - 1 :: mesh.segments] = True
    starts = np.unique([0, *(np.flatnonzero(changes) + 1), *stops])
    return np.stack([starts, np.append(starts[1:], h.size)], axis=1).astype(np.int64)


def numbers_of_runs(runs: Integers, piece: Array, segment: Array, node: Array, step: float) -> Array:
    """Table of the runs, (runs, COLUMNS), from those of a `Plan`; ``piece``: row of each run's piece."""
    h, inner = segment[SPACING, runs[:, 0]], np.minimum(runs[:, 0] + 1, runs[:, 1] - 1)
    table = np.zeros((len(runs), COLUMNS))
    table[:, PULL], table[:, H] = piece[:, PRETENSION], h
    table[:, SPEED_U], table[:, SPEED_T] = node[KICK_U, inner] / h, node[KICK_T, inner] / h
    table[:, KEPT], table[:, RUN_FALL_U] = node[KEEP_T, inner], node[FALL_U, inner]
    table[:, LOSS] = 0.25 * step * node[DRAG, inner]
    lowest = np.maximum((1.0 + piece[:, SLACK_STRAIN]) ** 2 - 1.0, -LARGEST_Z)
    table[:, CENTRE] = 0.5 * (LARGEST_Z + lowest) * h**2
    table[:, REACH] = 0.5 * (LARGEST_Z - lowest) * h**2
    for power, coefficient in enumerate(SERIES, start=1):
        table[:, GAIN + power - 1] = piece[:, RIGIDITY] * coefficient / h ** (2 * power)
    return table


AnyState = TypeVar("AnyState", bound=tuple[Any, ...])

# The laws that the kernels know, by their numbers there, and what stands for any other.
KERNEL_LAWS: tuple[type[CableLaw], ...] = (ExactLaw, WeakLaw, ConsistentWeakLaw, LinearLaw)
EXACT, WEAK, WEAK_CONSISTENT, LINEAR = range(4)
OWN = -1
MOST_EVENTS = 1000

# How steps end: at the last, before one that slack stops, with an energy that is not finite, or before one
# under an own law that has grown too stiff for it.
DONE, SLACK, NOT_FINITE, TOO_STIFF = range(4)

# Columns and rows of the tables of a plan.
PRETENSION, RIGIDITY, SLACK_STRAIN, ROPES, END = range(5)
SPACING, INVERSE_SPACING, COMPLIANCE = range(3)
KICK_U, KICK_T, KEEP_T, FALL_U, FALL_W, MASS, DRAG, WEIGHT_U, WEIGHT_W = range(9)
# Entries of State.counts, and of State.extra: E, C, what rounding took from E and from the coordinates.
STEPS, EVENTS = range(2)
STORED, SHIFT, STORED_LOST, PLACES_LOST = range(4)
# Rows of Workspace.damp that a record is written from, behind what damping solves.
TENSION, ENERGY = 4, 5


NO_NODES, NO_PAIRS = np.zeros(0, dtype=np.int64), np.zeros((0, 2), dtype=np.int64)


class Plan(NamedTuple):
    """Numbers of one run: pieces of rope between coordinates q, which move their ends.

    The nodes of all pieces stand in a row; neighbours may share a node. Row 6 k + 3 side + axis of the ends
    belongs to piece k, its start (0) or end (1), along u (0), v (1) or w (2). Rows of ``segment``,
    (3, nodes - 1): length h [m], 1 / h, and of the axial damper h / (b_kv (1 + eps0)) [m/s / N], 0 without
    damping and between pieces. Rows of ``node``, (9, nodes): velocity gained per force over a step along u
    and across [m/s / N], 0 where a node is held; share of the velocity across that a step keeps; velocity
    gained by weight along u and w [m/s]; mass of one rope and carriage [kg]; transverse damping x mass, and
    weight along u and w of all ropes [kg/s], [N]; 0 at the ends of pieces.
    """

    law: int
    tension_only: bool
    stop_when_slack: bool
    step: float  # [s]
    axial: int  # how segments are damped, see `cabledrive.simulation.dampers`
    nodes: Integers  # (pieces, 2): first and last node of each piece
    piece: Array  # (pieces, 7): T0 [N], EA [N], slack strain, parallel ropes; u, v, w of its end where q = 0
    segment: Array
    node: Array
    row_start: Integers  # (6 pieces + 1,): where the entries of each row of the ends begin
    row_column: Integers  # (entries,)
    row_value: Array  # (entries,)
    mass: Array  # (n, n): of q, the half cells at the ends of pieces included
    stiffness: Array  # (n, n): springs, joints and turning bodies
    damping: Array  # (2, n, n): of bearings and bodies, and of a motor joint of two pulleys
    moves: Array  # (n,): 0 of what is fixed, else 1
    matrix: Array  # (n, n): M / step + C / 2, D / 2 of the dampers as well, which acts on the new speeds
    inverse: Array  # (n, n): its inverse, 0 for what is fixed
    loss: Array  # (n, n): C
    dampers: Array  # (n, n): D, what the dampers of straight ropes do to the coordinates
    rest: Array  # (n,): weights on q, and forces at rest that friction alone holds [N]
    motor: Array  # (motors, n): turn of each rotor
    rub: Array  # (frictions, n): what rubs, per speed of q
    rub_mobility: Array  # (n, frictions): speed of q per friction over a step
    rub_own: Array  # (frictions,): speed of what rubs per its own friction
    bound: Array  # (frictions,): Coulomb friction [N], [N m]; of a wrap per tension
    smooth: Array  # (frictions,): speed over which friction is smoothed; 0: stick-slip
    stick: Integers  # (frictions,): the coordinate that rubs, -1 where there are several
    wrap: Integers  # (frictions, 2): pieces before and behind a wrap, -1 elsewhere
    damper: Array  # (5, nodes - 1): eliminated dampers of straight ropes, see `cabledrive.simulation.dampers`
    # (probes, 5): segment, place between its ends from 0 to 1, u, v, w there from which a record counts; the
    # middles of pieces come first
    probe: Array
    force: Integers = NO_PAIRS  # (forces, 2): node, and axis
    stop: Integers = NO_NODES  # (stops,): nodes with a carriage or a force, in rising order
    beside: Integers = NO_PAIRS  # (number, 2): segments beside rims and stops, and their pieces
    runs: Integers = (
        NO_PAIRS  # (runs, 2): first and last segment of each run of equal segments, the last not included
    )
    run: Array = np.zeros((0, 0))  # (runs, columns): their numbers, see `cabledrive.simulation.plan`


class State(NamedTuple):
    """Displacements at the time of a step, velocities half a step before it, and what was counted."""

    x: Array  # (3, nodes): u, v, w [m]
    x_t: Array  # (3, nodes) [m/s]
    q: Array  # (n,): coordinates [m], [rad]
    q_t: Array  # (n,)
    tallies: Array  # (2, TALLIES): works and losses [J], and what rounding took from them
    extremes: Array  # (2, n): least and largest of each coordinate
    peaks: Array  # (pieces, 2): largest |v| and |w| at the middle [m]
    events: Array  # (MOST_EVENTS, 4): step, piece, segment of it and tension [N] where a piece went slack
    slack: Integers  # (pieces,): whether it was slack at the last step
    counts: Integers  # (2,)
    extra: Array  # (3 + n,) of the energy-conserving scheme, (0,) of the others


class Workspace(NamedTuple):
    """Arrays without meaning between steps."""

    before: Array  # (2, 3, nodes): displacements and velocities before the kick of a recorded step
    before_q: Array  # (2, n)
    before_tallies: Array
    p: Array  # (3, segments): components above the pretension [N]
    rest: Array  # (3, segments): of these, what the linear law has not
    old: Array  # (3, nodes): velocities before the kick
    mean: Array  # (3, nodes)
    free: Array  # (3, nodes): velocities without the forces beyond the linear law
    direction: Array  # (3, segments): along which the segments are damped
    damp: Array  # (6, segments): damping tensions and pivots; of a record, tension and energy per length
    pull: Array  # (pieces, 2, 3): components beside both ends of each piece
    force: Array  # (n,): on the coordinates
    trial: Array  # (2, n): of these, without and with the components beyond the linear law, or of dampers
    right: Array  # (n,)
    new: Array  # (n,): speeds after the step
    friction: Array  # (frictions,)
    bound: Array  # (frictions,)
    matrix: Array  # (n, n): with the dampers' answer to the ends, as the next three
    inverse: Array
    mobility: Array
    own: Array
    ends: Array  # (pieces, 6): dampers at both ends: tension of ends at rest, rate by their speeds, tension
    lost: Array  # (2, TALLIES): losses of a trial
    stop: Array  # (3, 3, stops): speeds of stops before and after, and their places


def plan_of(
    mesh: Mesh,
    law: CableLaw,
    step: float,
    damping: tuple[float, float],
    scheme: Scheme,
    marks: tuple[Sequence[tuple[str, float]], Sequence[tuple[int, int]]] = ((), ()),
) -> Plan:
    """Numbers of one run of a loop or a line; its coordinates are the rims of both pulleys and of the motor.

    ``step`` [s]; ``damping``: transverse, Gamma [1/s], and axial, b_kv [N s]; ``scheme``: friction and what
    slack means; ``marks``: span of each probe and distance from its start, node and axis of each force.
    """
    (transverse_damping, axial_damping), (probes, forces) = damping, marks
    damper = axial_damping * (1.0 + law.pretension / law.axial_rigidity)
    stops = np.unique([*mesh.carriage_node, *(node for node, _ in forces)]).astype(np.int64)
    runs = runs_of(mesh, stops)
    joints = np.unique([*range(0, mesh.nodes, mesh.segments), *stops])  # rims and stops
    beside = np.unique([joints[:-1], joints[1:] - 1]).astype(np.int64)
    midpoints = tuple((span, 0.5 * float(mesh.position[0, -1])) for span in mesh.spans)
    h, n, spans = mesh.spacing, mesh.segments, len(mesh.spans)
    ends = np.zeros((spans, 2, 3, 3))
    for span in range(spans):
        ends[span, [0, 1], 0, [span, 1 - span]] = 1.0
    segment = np.array([h, 1.0 / h, h / damper if damper else 0.0 * h])
    node = _nodes(mesh, step, transverse_damping)
    own = np.array([(span * n, (span + 1) * n) for span in range(spans)], dtype=np.int64)
    piece = np.array([(law.pretension, law.axial_rigidity, law.slack_strain, 1.0, *3 * [0.0])] * spans)
    made = eliminated(own, segment[COMPLIANCE], node[KICK_U], np.ones(spans), ends[:, :, 0])
    return Plan(
        law=kernel_number(law),
        tension_only=law.tension_only,
        stop_when_slack=scheme.slack == "stop",
        step=step,
        axial=made.how(exact=kernel_number(law) == EXACT),
        nodes=own,
        piece=piece,
        segment=segment,
        node=node,
        **rows_of_ends(ends),
        **_shafts(mesh, step, scheme.smoothing_speed if scheme.friction == "smoothed" else 0.0, made.loss),
        damper=made.table,
        probe=np.pad(probed(divided_spans(mesh), (*midpoints, *probes)), ((0, 0), (0, 3))),
        force=np.array(forces, dtype=np.int64).reshape(-1, 2),
        stop=stops,
        beside=np.stack([beside, beside // n], axis=1),
        runs=runs,
        run=numbers_of_runs(runs, piece[runs[:, 0] // n], segment, node, step),
    )


def rows_of_ends(ends: Array) -> dict[str, Any]:
    """Rows of the ends of all pieces, shape (pieces, 2, 3, n), without their zeros."""
    rows = ends.reshape(6 * len(ends), ends.shape[-1])
    start = np.concatenate(([0], np.cumsum(np.count_nonzero(rows, axis=1)))).astype(np.int64)
    column = np.nonzero(rows)[1].astype(np.int64)
    return {"row_start": start, "row_column": column, "row_value": rows[rows != 0.0]}


def moved_by(
    mass: Array, losses: tuple[Array, Array], moves: Array, step: float, rub: Array, bound: Array
) -> dict[str, Any]:
    """What forces and friction do to coordinates over a step [s]; fields of a `Plan` as they are there.

    ``losses``: of the coordinates, and of the dampers of straight ropes.
    """
    loss, dampers = losses
    matrix, free = mass / step + 0.5 * (loss + dampers), np.ix_(moves > 0.0, moves > 0.0)
    inverse = np.zeros_like(matrix)
    inverse[free] = np.linalg.inv(matrix[free])
    mobility = np.ascontiguousarray(inverse @ rub.T)
    moved = [np.flatnonzero(row) for row in rub]
    return {
        "mass": mass,
        "loss": loss,
        "dampers": dampers,
        "moves": moves,
        "matrix": matrix,
        "inverse": inverse,
        "rub": rub,
        "rub_mobility": mobility,
        "rub_own": np.einsum("kn,nk->k", rub, mobility),
        "bound": bound,
        "stick": np.array([own[0] if own.size == 1 else -1 for own in moved], dtype=np.int64),
    }


def kernel_number(law: CableLaw) -> int:
    """Number of a law in the kernels; a subclass of a law they know is not that law."""
    kind = type(taut_law(law))
    return KERNEL_LAWS.index(kind) if kind in KERNEL_LAWS else OWN


def _nodes(mesh: Mesh, step: float, transverse_damping: float) -> Array:
    damped = 0.5 * step * transverse_damping * mesh.cable_mass / mesh.mass
    kick_u = step / mesh.mass
    kick_t = np.where(mesh.sways, step / mesh.mass / (1.0 + damped), 0.0)
    keep = np.where(mesh.sways, (1.0 - damped) / (1.0 + damped), 0.0)
    drag = np.where(mesh.sways, transverse_damping * mesh.cable_mass, 0.0)
    fall = kick_u * mesh.weight_u, kick_t * mesh.weight_w
    table = np.array([kick_u, kick_t, keep, *fall, mesh.mass, drag, mesh.weight_u, mesh.weight_w])
    table[[[KICK_U], [FALL_U], [MASS], [WEIGHT_U]], [*mesh.rims, -1]] = 0.0
    return table


def _shafts(mesh: Mesh, step: float, smoothing_speed: float, dampers: Array) -> dict[str, Any]:
    """Matrices and friction of drive pulley, load pulley and motor, measured at the rim; 0 without motor."""
    shafts, radius = mesh.shafts, mesh.shafts[0].radius
    numbers = np.zeros((4, 3))
    turns, arm = np.zeros(3, dtype=bool), np.full(3, radius)
    for i, own in enumerate(shafts):
        viscous, coulomb = own.viscous_friction / own.radius**2, own.coulomb_friction / own.radius
        numbers[:, i] = own.rim_mass, viscous, coulomb, own.holding_stiffness / own.radius**2
        turns[i], arm[i] = not own.fixed, own.radius
    mass = np.diag([*mesh.axial_mass[list(mesh.rims)], numbers[0, 2]])
    joint = np.array([[1.0, 0.0, -1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 1.0]]) / radius**2
    stiffness, loss = (mesh.joint.stiffness, mesh.joint.damping) if mesh.joint else (0.0, 0.0)
    damping = np.array([np.diag(numbers[1]), loss * joint])
    rubs = np.flatnonzero(numbers[2] * turns)
    rest, motor = np.zeros(3), np.zeros((1, 3))
    rest[:2], motor[0, 2 if mesh.joint else 0] = mesh.weight_u[list(mesh.rims)], 1.0 / radius
    return {
        **moved_by(
            mass, (damping.sum(axis=0), dampers), 1.0 * turns, step, np.eye(3)[rubs], numbers[2, rubs]
        ),
        "stiffness": stiffness * joint + np.diag(numbers[3]),
        "damping": damping,
        "rest": rest,
        "motor": motor,
        "smooth": smoothing_speed * arm[rubs],
        "wrap": np.full((rubs.size, 2), -1, dtype=np.int64),
    }


def new_state(plan: Plan, x: Array, x_t: Array, q: Array, q_t: Array) -> State:
    """State at the start of a run; velocities half a step before it."""
    pieces, n = len(plan.nodes), len(plan.mass)
    return State(
        x=np.array(x, dtype=np.float64),
        x_t=np.array(x_t, dtype=np.float64),
        q=np.array(q, dtype=np.float64),
        q_t=np.array(q_t, dtype=np.float64),
        tallies=np.zeros((2, TALLIES)),
        extremes=np.stack([np.full(n, np.inf), np.full(n, -np.inf)]),
        peaks=np.zeros((pieces, 2)),
        events=np.zeros((MOST_EVENTS, 4)),
        slack=np.zeros(pieces, dtype=np.int64),
        counts=np.zeros(2, dtype=np.int64),
        extra=np.zeros(0),
    )


def new_workspace(plan: Plan) -> Workspace:
    """Work space for a run."""
    nodes, n, pieces, k = plan.node.shape[1], len(plan.mass), len(plan.nodes), plan.bound.size
    segments, tallies = (3, nodes - 1), (2, TALLIES)
    shapes: tuple[tuple[int, ...], ...] = ((2, 3, nodes), (2, n), tallies, segments, segments)
    shapes += ((3, nodes), (3, nodes), (3, nodes), segments, (6, nodes - 1), (pieces, 2, 3))
    shapes += ((n,), (2, n), (n,), (n,), (k,), (k,), (n, n), (n, n), (n, k), (k,), (pieces, 6), tallies)
    shapes += ((3, 3, plan.stop.size),)
    return Workspace(*(np.zeros(shape) for shape in shapes))


def copy_state(state: AnyState) -> AnyState:
    """Copy of a state, of this or another kind of run, that shares nothing with it."""
    copies: Any = (np.array(array) for array in state)
    return type(state)(*copies)
