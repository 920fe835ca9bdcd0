r"""The cable of one run as its kernels take it: what stays, what moves, runs of equal segments.

A run ends where the spacing changes and at a stop, a node with a carriage or a force; at a rim only where the
cable has a weight along its span, which then changes sign. The numbers of a run are scaled by its spacing h,
so that the pass works with the differences of displacements of a segment's ends: with
:math:`y = h^2 z = \Delta u\,(2h + \Delta u) + \Delta v^2 + \Delta w^2` the gain of the exact law is
:math:`EA\,z\,s(z)`, a polynomial in y.

Few arrays with many rows: each array costs a kernel time to compile.
"""

from typing import Any, NamedTuple, TypeVar

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.cable_laws import ConsistentWeakLaw, ExactLaw, LinearLaw, WeakLaw, taut_law
from cabledrive.parameters.arrays import Integers
from cabledrive.simulation.channels import TALLIES

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
    axial: int  # how segments are damped, see `cabledrive.simulation.damped`
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
    damper: Array  # (5, nodes - 1): eliminated dampers of straight ropes, see `cabledrive.simulation.damped`
    # (probes, 5): segment, place between its ends from 0 to 1, u, v, w there from which a record counts; the
    # middles of pieces come first
    probe: Array
    force: Integers = NO_PAIRS  # (forces, 2): node, and axis
    stop: Integers = NO_NODES  # (stops,): nodes with a carriage or a force, in rising order
    beside: Integers = NO_PAIRS  # (number, 2): segments beside rims and stops, and their pieces
    # (runs, 2): first and last segment of each run of equal segments, the last not included
    runs: Integers = NO_PAIRS
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
