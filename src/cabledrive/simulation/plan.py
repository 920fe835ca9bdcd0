"""What does not change during a run, as the kernels take it: numbers and arrays, worked out once."""

from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.cable_laws import ConsistentWeakLaw, ExactLaw, LinearLaw, WeakLaw
from cabledrive.mechanics.mesh import Mesh
from cabledrive.mechanics.tension_only import taut_law, without_pushing
from cabledrive.simulation.runs import Integers, numbers_of_runs, runs_of, segments_beside

# The laws that the kernels know, by the numbers of `kernels.segments`, and what stands for any other.
KERNEL_LAWS: tuple[type[CableLaw], ...] = (ExactLaw, WeakLaw, ConsistentWeakLaw, LinearLaw)
OWN = -1

# Rows of the tables in a plan.
SPACING, INVERSE_SPACING, COMPLIANCE = range(3)
KICK_U, KICK_T, KEEP_T, FALL_U, FALL_W, CARRIAGE_MASS, DRAG, WEIGHT_U, WEIGHT_W = range(9)
RADIUS, RIM_MASS, VISCOUS, COULOMB, SMOOTH, TURNS, HOLDING = range(7)


class Plan(NamedTuple):
    """Numbers of one run. Few arrays with many rows: each array costs a kernel time to compile.

    Rows of ``segment``, shape (3, segments of all spans): length h [m], 1 / h [1/m], and of the segment's
    axial damper h / (b_kv (1 + eps0)) [m/s / N], 0 without damping.

    Rows of ``node``, shape (9, nodes): velocity gained per force over a step along u and, with transverse
    damping, along v and w [m/s / N], 0 at rims and where a node does not sway; share of the transverse
    velocity kept over a step; velocity gained by weight over a step along u and w [m/s]; carriage [kg];
    transverse damping Gamma x cable mass [kg/s]; weight along u and w [N].

    Rows of ``shaft``, shape (7, 3), for drive pulley, load pulley and motor, all measured at the rim: radius
    [m], J / r^2 [kg], b / r^2 [kg/s], c / r [N], rim speed over which Coulomb friction is smoothed [m/s], 0
    for stick-slip, 1.0 where the shaft can turn, and the stiffness that holds it at angle zero, k / r^2
    [N/m].
    """

    law: int  # position in KERNEL_LAWS; OWN: none of them
    tension_only: bool
    stop_when_slack: bool
    pretension: float  # [N]
    rigidity: float  # EA [N]
    slack_strain: float
    step: float  # [s]
    spans: int
    segments: int  # per span
    closed: bool
    uniform: bool  # equal segments, no carriages, no axial damping
    density: float  # [kg/m]
    driven: int  # shaft on which the torque acts
    joint_stiffness: float  # k_m / r^2 [N/m]
    joint_damping: float  # b_m / r^2 [kg/s]
    axial_damping: float  # b_kv (1 + eps0): damping force per rate of apparent strain [N s]
    segment: Array
    node: Array
    shaft: Array
    shaft_matrices: Array  # (2, 3, 3): what acts on the new speeds of the shafts, and on the old ones [kg/s]
    probe: Array  # (probes, 2): segment, and place between its ends from 0 to 1
    force: Integers  # (forces, 2): node, and axis (0: u, 1: v, 2: w)
    stop: Integers  # (stops,): nodes with a carriage or a force, in rising order
    beside: Integers  # (number,): segments beside rims and stops
    runs: Integers  # (runs, 2): first and last segment of each run of equal segments, the last not included
    run: Array  # (runs, columns): their numbers, see `cabledrive.simulation.runs`


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

    ``step``: time step [s]; ``transverse_damping``: Gamma [1/s]; ``axial_damping``: Kelvin-Voigt damping b_kv
    [N s], force per rate of true strain; ``smoothing_speed``: angular speed over which Coulomb friction is
    smoothed [rad/s]; 0: stick-slip; ``stop_when_slack``: whether a slack segment ends the run; ``probes``:
    span and distance [m] from its start, on the pretensioned cable. The midpoints come first anyway;
    ``forces``: node and axis (0: u, 1: v, 2: w) of each force.
    """
    stops = np.unique([*mesh.carriage_node, *(node for node, _ in forces)]).astype(np.int64)
    runs = runs_of(mesh, stops)
    damper = axial_damping * (1.0 + law.pretension / law.axial_rigidity)
    stiffness, damping = _joint(mesh)
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
        joint_stiffness=stiffness,
        joint_damping=damping,
        axial_damping=damper,
        segment=np.array(
            [mesh.spacing, 1.0 / mesh.spacing, mesh.spacing / damper if damper else 0.0 * mesh.spacing]
        ),
        node=_nodes(mesh, step, transverse_damping),
        shaft=_shafts(mesh, smoothing_speed),
        shaft_matrices=_shaft_matrices(mesh, step, damping),
        probe=_probes(mesh, (*_midpoints(mesh), *probes)),
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


def check_kernel_law(plan: Plan) -> None:
    """Refuse to compile a law as another.

    Raises `ValueError` if the kernels do not know the plan's law.
    """
    if plan.law not in range(len(KERNEL_LAWS)):
        raise ValueError(f"no kernel knows the cable law with number {plan.law}")


def law_of(plan: Plan) -> CableLaw:
    """The cable law of a plan, which is one of those that the kernels know."""
    check_kernel_law(plan)
    law = KERNEL_LAWS[plan.law](pretension=plan.pretension, axial_rigidity=plan.rigidity)
    return without_pushing(law) if plan.tension_only else law


def _nodes(mesh: Mesh, step: float, transverse_damping: float) -> Array:
    damped = 0.5 * step * transverse_damping * mesh.cable_mass / mesh.mass
    kick_u = step / mesh.mass
    kick_u[list(mesh.rims)] = kick_u[-1] = 0.0
    kick_t = np.where(mesh.sways, step / mesh.mass / (1.0 + damped), 0.0)
    return np.array(
        [
            kick_u,
            kick_t,
            np.where(mesh.sways, (1.0 - damped) / (1.0 + damped), 0.0),
            kick_u * mesh.weight_u,
            kick_t * mesh.weight_w,
            mesh.carriage_mass,
            np.where(mesh.sways, transverse_damping * mesh.cable_mass, 0.0),
            mesh.weight_u,
            mesh.weight_w,
        ]
    )


def _shafts(mesh: Mesh, smoothing_speed: float) -> Array:
    table = np.zeros((7, 3))
    table[RADIUS] = mesh.shafts[0].radius
    for i, shaft in enumerate(mesh.shafts):
        table[RADIUS, i], table[RIM_MASS, i] = shaft.radius, shaft.rim_mass
        table[VISCOUS, i] = shaft.viscous_friction / shaft.radius**2
        table[COULOMB, i] = shaft.coulomb_friction / shaft.radius
        table[TURNS, i] = 0.0 if shaft.fixed else 1.0
        table[HOLDING, i] = shaft.holding_stiffness / shaft.radius**2
    table[SMOOTH] = smoothing_speed * table[RADIUS]
    return table


def _shaft_matrices(mesh: Mesh, step: float, joint_damping: float) -> Array:
    """What acts on the new speeds, M / step + C / 2, and on the old ones, M / step - C / 2."""
    shafts = _shafts(mesh, 0.0)
    mass = np.array([*mesh.axial_mass[list(mesh.rims)], shafts[RIM_MASS, 2]])
    joint = joint_damping * np.array([[1.0, 0.0, -1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 1.0]])
    damping = np.diag(shafts[VISCOUS]) + joint
    return np.array([np.diag(mass) / step + 0.5 * damping, np.diag(mass) / step - 0.5 * damping])


def _joint(mesh: Mesh) -> tuple[float, float]:
    """Stiffness and damping of the joint, at the rim."""
    if mesh.joint is None:
        return 0.0, 0.0
    square = mesh.shafts[0].radius ** 2
    return mesh.joint.stiffness / square, mesh.joint.damping / square


def _midpoints(mesh: Mesh) -> tuple[tuple[str, float], ...]:
    return tuple((span, 0.5 * float(mesh.position[0, -1])) for span in mesh.spans)


def _probes(mesh: Mesh, probes: tuple[tuple[str, float], ...]) -> Array:
    """Segment of each probe, and its place between the segment's ends."""
    table = np.zeros((len(probes), 2))
    for number, (span, place) in enumerate(probes):
        row = mesh.spans.index(span)
        ends = mesh.position[row]
        i = int(np.clip(np.searchsorted(ends, place, side="right") - 1, 0, mesh.segments - 1))
        table[number] = row * mesh.segments + i, (place - ends[i]) / (ends[i + 1] - ends[i])
    return table
