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
from cabledrive.mechanics.cable_laws import (
    ConsistentWeakLaw,
    ExactLaw,
    LinearLaw,
    WeakLaw,
    taut_law,
    without_pushing,
)
from cabledrive.mechanics.mesh import Mesh
from cabledrive.parameters.arrays import Integers
from cabledrive.simulation.channels import EXTREMES, TALLIES

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

# Columns of the table of runs: spacing [m]; velocity gained over a step per pull h p along u, and by weight;
# the same across, with the share of the velocity that is kept; transverse loss per square of twice the mean
# velocity; bounds of the y at which a segment is taut and the series holds; coefficients of the gain in y.
H, SPEED_U, RUN_FALL_U, SPEED_T, KEPT, LOSS, CENTRE, REACH, GAIN = range(9)
COLUMNS = GAIN + len(SERIES)


def runs_of(mesh: Mesh, stops: Integers) -> Integers:
    """First and last segment of each run, the last not included, shape (runs, 2)."""
    h = mesh.spacing
    changes = np.abs(np.diff(h)) > 1e-12 * h[:-1]
    if mesh.weight_u.any():
        changes[mesh.segments - 1 :: mesh.segments] = True
    starts = np.unique([0, *(np.flatnonzero(changes) + 1), *stops])
    return np.stack([starts, np.append(starts[1:], h.size)], axis=1).astype(np.int64)


def segments_beside(mesh: Mesh, stops: Integers) -> Integers:
    """Segments beside rims and stops, shape (number,)."""
    ends = np.unique([*range(0, mesh.nodes, mesh.segments), *stops])
    return np.unique([ends[:-1], ends[1:] - 1]).astype(np.int64)


def numbers_of_runs(
    mesh: Mesh, runs: Integers, rigidity: float, slack_strain: float, step: float, damping: float
) -> Array:
    """Table of the runs, shape (runs, COLUMNS); ``damping``: transverse, Gamma [1/s]."""
    h = mesh.spacing[runs[:, 0]]
    mass, damped = mesh.density * h, 0.5 * step * damping
    table = np.zeros((len(runs), COLUMNS))
    table[:, H] = h
    table[:, SPEED_U] = step / mass / h
    table[:, SPEED_T] = step / mass / (1.0 + damped) / h
    table[:, KEPT] = (1.0 - damped) / (1.0 + damped)
    table[:, RUN_FALL_U] = step / mass * mesh.weight_u[np.minimum(runs[:, 0] + 1, runs[:, 1] - 1)]
    table[:, LOSS] = 0.25 * step * damping * mass
    lowest = max((1.0 + slack_strain) ** 2 - 1.0, -LARGEST_Z)
    table[:, CENTRE] = 0.5 * (LARGEST_Z + lowest) * h**2
    table[:, REACH] = 0.5 * (LARGEST_Z - lowest) * h**2
    for power, coefficient in enumerate(SERIES, start=1):
        table[:, GAIN + power - 1] = rigidity * coefficient / h ** (2 * power)
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

# Rows of the tables of a plan.
SPACING, INVERSE_SPACING, COMPLIANCE = range(3)
KICK_U, KICK_T, KEEP_T, FALL_U, FALL_W, CARRIAGE_MASS, DRAG, WEIGHT_U, WEIGHT_W = range(9)
RADIUS, RIM_MASS, VISCOUS, COULOMB, SMOOTH, TURNS, HOLDING = range(7)
# Entries of State.counts, and of State.extra: E, C, what rounding took from E and from rims and motor.
STEPS, EVENTS, UPPER_SLACK, LOWER_SLACK = range(4)
STORED, SHIFT, STORED_LOST, DRIVE_LOST, LOAD_LOST, MOTOR_LOST = range(6)
# Rows of Workspace.shaft, and of Workspace.q those that a record is written from, behind what damping solves.
OLD, NEW, FORCE, RIGHT, FRICTION = range(5)
TENSION, ENERGY = 4, 5


class Plan(NamedTuple):
    """Numbers of one run.

    Rows of ``segment``, (3, segments): length h [m], 1 / h, and of the axial damper h / (b_kv (1 + eps0))
    [m/s / N], 0 without damping. Rows of ``node``, (9, nodes): velocity gained per force over a step along u
    and across [m/s / N], 0 where a node is held; share of the velocity across that a step keeps; velocity
    gained by weight along u and w [m/s]; carriage [kg]; transverse damping x cable mass [kg/s]; weight along
    u and w [N]. Rows of ``shaft``, (7, 3), of drive pulley, load pulley, motor, measured at the rim: radius,
    J / r^2, b / r^2, c / r, rim speed over which friction is smoothed (0: stick-slip), 1.0 where the shaft
    can turn, holding stiffness k / r^2.
    """

    law: int
    tension_only: bool
    stop_when_slack: bool
    pretension: float
    rigidity: float
    slack_strain: float
    step: float
    spans: int
    segments: int  # per span
    closed: bool
    uniform: bool  # equal segments, no carriages, no axial damping, no forces
    density: float
    driven: int  # shaft on which the torque acts
    joint_stiffness: float  # k_m / r^2 [N/m]
    joint_damping: float  # b_m / r^2 [kg/s]
    axial_damping: float  # b_kv (1 + eps0) [N s]
    segment: Array
    node: Array
    shaft: Array
    shaft_matrices: Array  # (2, 3, 3): what acts on the new speeds of the shafts, and on the old ones [kg/s]
    probe: Array  # (probes, 2): segment, and place between its ends from 0 to 1
    force: Integers  # (forces, 2): node, and axis
    stop: Integers  # (stops,): nodes with a carriage or a force, in rising order
    beside: Integers  # (number,): segments beside rims and stops
    runs: Integers  # (runs, 2): first and last segment of each run of equal segments, the last not included
    run: Array  # (runs, columns): their numbers, see `cabledrive.simulation.plan`


class State(NamedTuple):
    """Displacements at the time of a step, velocities half a step before it, and what was counted."""

    x: Array  # (3, nodes): u, v, w [m]
    x_t: Array  # (3, nodes) [m/s]
    motor: Array  # (2,): displacement and velocity of the motor, at the rim
    tallies: Array  # (2, TALLIES): works and losses [J], and what rounding took from them
    extremes: Array  # (EXTREMES,)
    events: Array  # (MOST_EVENTS, 4): step, span, segment and tension [N] where a span went slack
    counts: Integers  # (4,)
    extra: Array  # (6,) of the energy-conserving scheme, (0,) of the others


class Workspace(NamedTuple):
    """Arrays without meaning between steps."""

    before: Array  # (2, 3, nodes): displacements and velocities before the kick of a recorded step
    before_motor: Array
    before_tallies: Array
    p: Array  # (3, segments): components above the pretension [N]
    rest: Array  # (3, segments): of these, what the linear law has not
    old: Array  # (3, nodes): velocities before the kick
    mean: Array  # (3, nodes)
    free: Array  # (3, nodes): velocities without the forces beyond the linear law
    direction: Array  # (3, segments): along which the segments are damped
    q: Array  # (6, segments): damping tensions and pivots; of a record, tension and energy per length
    shaft: Array  # (5, 3)
    matrix: Array  # (3, 3)
    lost: Array  # (2, TALLIES): losses of a trial
    stop: Array  # (3, 3, stops): speeds of stops before and after, and their places


def plan_of(
    mesh: Mesh,
    law: CableLaw,
    *,
    step: float,
    transverse_damping: float = 0.0,
    axial_damping: float = 0.0,
    smoothing_speed: float = 0.0,
    stop_when_slack: bool = True,
    probes: tuple[tuple[str, float], ...] = (),
    forces: tuple[tuple[int, int], ...] = (),
) -> Plan:
    """Numbers of one run.

    ``step`` [s]; ``transverse_damping``: Gamma [1/s]; ``axial_damping``: b_kv [N s]; ``smoothing_speed`` of
    Coulomb friction [rad/s], 0: stick-slip; ``probes``: span and distance from its start, behind the
    midpoints; ``forces``: node and axis of each.
    """
    damper = axial_damping * (1.0 + law.pretension / law.axial_rigidity)
    square = mesh.shafts[0].radius ** 2
    stiffness, damping = (mesh.joint.stiffness, mesh.joint.damping) if mesh.joint else (0.0, 0.0)
    shaft = _shafts(mesh, smoothing_speed)
    stops = np.unique([*mesh.carriage_node, *(node for node, _ in forces)]).astype(np.int64)
    runs = runs_of(mesh, stops)
    midpoints = tuple((span, 0.5 * float(mesh.position[0, -1])) for span in mesh.spans)
    return Plan(
        law=kernel_number(law),
        tension_only=law.tension_only,
        stop_when_slack=stop_when_slack,
        pretension=law.pretension,
        rigidity=law.axial_rigidity,
        slack_strain=law.slack_strain,
        step=step,
        spans=len(mesh.spans),
        segments=mesh.segments,
        closed=mesh.closed,
        uniform=mesh.uniform and axial_damping == 0.0 and not forces,
        density=mesh.density,
        driven=2 if mesh.joint else 0,
        joint_stiffness=stiffness / square,
        joint_damping=damping / square,
        axial_damping=damper,
        segment=np.array([h := mesh.spacing, 1.0 / h, h / damper if damper else 0.0 * h]),
        node=_nodes(mesh, step, transverse_damping),
        shaft=shaft,
        shaft_matrices=_shaft_matrices(mesh, shaft, step, damping / square),
        probe=_probes(mesh, (*midpoints, *probes)),
        force=np.array(forces, dtype=np.int64).reshape(-1, 2),
        stop=stops,
        beside=segments_beside(mesh, stops),
        runs=runs,
        run=numbers_of_runs(mesh, runs, law.axial_rigidity, law.slack_strain, step, transverse_damping),
    )


def kernel_number(law: CableLaw) -> int:
    """Number of a law in the kernels; a subclass of a law they know is not that law."""
    kind = type(taut_law(law))
    return KERNEL_LAWS.index(kind) if kind in KERNEL_LAWS else OWN


def law_of(plan: Plan) -> CableLaw:
    """The cable law of a plan, which is one of those that the kernels know."""
    if plan.law not in range(len(KERNEL_LAWS)):
        raise ValueError(f"no kernel knows the cable law with number {plan.law}")
    law = KERNEL_LAWS[plan.law](pretension=plan.pretension, axial_rigidity=plan.rigidity)
    return without_pushing(law) if plan.tension_only else law


def _nodes(mesh: Mesh, step: float, transverse_damping: float) -> Array:
    damped = 0.5 * step * transverse_damping * mesh.cable_mass / mesh.mass
    kick_u = step / mesh.mass
    kick_u[[*mesh.rims, -1]] = 0.0
    kick_t = np.where(mesh.sways, step / mesh.mass / (1.0 + damped), 0.0)
    keep = np.where(mesh.sways, (1.0 - damped) / (1.0 + damped), 0.0)
    drag = np.where(mesh.sways, transverse_damping * mesh.cable_mass, 0.0)
    fall = kick_u * mesh.weight_u, kick_t * mesh.weight_w
    return np.array([kick_u, kick_t, keep, *fall, mesh.carriage_mass, drag, mesh.weight_u, mesh.weight_w])


def _shafts(mesh: Mesh, smoothing_speed: float) -> Array:
    table = np.zeros((7, 3))
    table[RADIUS] = mesh.shafts[0].radius
    for i, shaft in enumerate(mesh.shafts):
        r = shaft.radius
        turns, holding = 0.0 if shaft.fixed else 1.0, shaft.holding_stiffness / r**2
        friction = shaft.viscous_friction / r**2, shaft.coulomb_friction / r
        table[:, i] = r, shaft.rim_mass, *friction, 0.0, turns, holding
    table[SMOOTH] = smoothing_speed * table[RADIUS]
    return table


def _shaft_matrices(mesh: Mesh, shaft: Array, step: float, joint_damping: float) -> Array:
    """What acts on the new speeds, M / step + C / 2, and on the old ones, M / step - C / 2."""
    mass = np.diag([*mesh.axial_mass[list(mesh.rims)], shaft[RIM_MASS, 2]]) / step
    joint = np.array([[1.0, 0.0, -1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 1.0]])
    damping = np.diag(shaft[VISCOUS]) + joint_damping * joint
    return np.array([mass + 0.5 * damping, mass - 0.5 * damping])


def _probes(mesh: Mesh, probes: tuple[tuple[str, float], ...]) -> Array:
    table = np.zeros((len(probes), 2))
    for number, (span, place) in enumerate(probes):
        row = mesh.spans.index(span)
        ends = mesh.position[row]
        i = int(np.clip(np.searchsorted(ends, place, side="right") - 1, 0, mesh.segments - 1))
        table[number] = row * mesh.segments + i, (place - ends[i]) / (ends[i + 1] - ends[i])
    return table


def new_state(displacement: Array, velocity: Array, motor: tuple[float, float]) -> State:
    """State at the start of a run; ``velocity``: of nodes half a step before; ``motor``: at the rim."""
    return State(
        x=np.array(displacement, dtype=np.float64),
        x_t=np.array(velocity, dtype=np.float64),
        motor=np.array(motor, dtype=np.float64),
        tallies=np.zeros((2, TALLIES)),
        extremes=np.array([np.inf, -np.inf] * 3 + [0.0] * (EXTREMES - 6)),
        events=np.zeros((MOST_EVENTS, 4)),
        counts=np.zeros(4, dtype=np.int64),
        extra=np.zeros(0),
    )


def new_workspace(plan: Plan) -> Workspace:
    """Work space for a run."""
    n = plan.segment.shape[1]
    shapes = (
        (2, 3, n + 1),
        (2,),
        (2, TALLIES),
        (3, n),
        (3, n),
        (3, n + 1),
        (3, n + 1),
        (3, n + 1),
        (3, n),
        (6, n),
    )
    return Workspace(
        *(np.zeros(shape) for shape in (*shapes, (5, 3), (3, 3), (2, TALLIES), (3, 3, plan.stop.size)))
    )


def copy_state(state: AnyState) -> AnyState:
    """Copy of a state, of this or another kind of run, that shares nothing with it."""
    copies: Any = (np.array(array) for array in state)
    return type(state)(*copies)


def set_state(state: AnyState, other: AnyState) -> None:
    """Write another state of the same run into this one."""
    for mine, theirs in zip(state, other, strict=True):
        mine[...] = theirs


def half_step_before(
    plan: Plan,
    x: Array,
    x_t: Array,
    motor: tuple[float, float],
    torque: float,
    forces: Array,
    law: CableLaw,
) -> tuple[Array, float]:
    r"""Velocities of nodes and motor half a step before t = 0, Eq. (2.39) with the term the print drops.

    :math:`\dot x_{-1/2} = \dot x_0 - \tfrac12 \Delta t\,\ddot x_0`, so that the first whole step comes out of
    the same formula as all others. ``motor``: displacement and velocity at the rim.
    """
    gradients, n = np.diff(x, axis=1) * plan.segment[INVERSE_SPACING], plan.segments
    pull = np.stack(law.excess_components(*gradients))
    if plan.axial_damping > 0.0:
        direction = np.stack(law.strain_gradient(*gradients))
        pull = pull + direction * np.sum(direction * np.diff(x_t, axis=1), axis=0) / plan.segment[COMPLIANCE]
    kick = plan.node[[KICK_U, KICK_T, KICK_T]]
    gain, force = np.zeros_like(x_t), np.diff(pull, axis=1)
    gain[:, 1:-1] = kick[:, 1:-1] * force
    gain[[0, 2], 1:-1] += plan.node[[FALL_U, FALL_W], 1:-1]
    for (node, axis), pushed in zip(plan.force, forces, strict=True):
        gain[axis, node] += kick[axis, node] * pushed
    damped = (1.0 - plan.node[KEEP_T]) / (1.0 + plan.node[KEEP_T])
    gain[1:] = gain[1:] * (1.0 + damped) - 2.0 * damped * x_t[1:]
    before = x_t - 0.5 * gain

    old, place = np.array([*x_t[0, [0, n]], motor[1]]), np.array([x[0, 0], x[0, n], motor[0]])
    twisted = plan.joint_stiffness * (x[0, 0] - motor[0])
    on_shaft = np.array([pull[0, 0] - twisted, -pull[0, n - 1], twisted]) - plan.shaft[HOLDING] * place
    on_shaft[:2] += plan.node[WEIGHT_U, [0, n]]
    if plan.closed:
        on_shaft[:2] += -pull[0, -1], pull[0, n]
    on_shaft[plan.driven] += torque / plan.shaft[RADIUS, 0]
    on_shaft -= (plan.shaft_matrices[0] - plan.shaft_matrices[1]) @ old
    coulomb, smooth = plan.shaft[COULOMB], plan.shaft[SMOOTH]
    friction = np.where(old == 0.0, np.clip(on_shaft, -coulomb, coulomb), coulomb * np.sign(old))
    if smooth.any():
        friction = coulomb * np.tanh(old / smooth)
    inertia = 0.5 * np.diag(plan.shaft_matrices.sum(axis=0))
    gained = plan.shaft[TURNS] * (on_shaft - friction) / np.where(inertia > 0.0, inertia, 1.0)
    speeds = old - 0.5 * gained
    before[0, [0, n]] = speeds[:2]
    if plan.closed:
        before[:, -1] = before[:, 0]
    return before, float(speeds[2])
