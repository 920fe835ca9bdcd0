"""The cable at rest as a motion finds it: tension, slope, strain, and transverse modes under that tension."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from cabledrive.mechanics.holding import DRIVE_PULLEY, LOAD_PULLEY, MOTOR
from cabledrive.mechanics.mesh import Mesh, mesh_of
from cabledrive.mechanics.rest import rest_state
from cabledrive.parameters import Drive, NotComputed
from cabledrive.parameters.arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StaticState:
    """Static equilibrium of a drive whose drive pulley is held."""

    mesh: Mesh
    tension: Array  # (segments of all spans,): of each segment [N]
    stretch: Array  # (segments of all spans,): its length over the straight pretensioned one [-]
    slope: Array  # (segments of all spans,): against the straight span in the loop's plane, by sag [-]
    holding_torque: float  # torque on the drive pulley that keeps it at rest [N m]

    @property
    def steepest(self) -> float:
        """Largest slope [-]."""
        return float(np.max(np.abs(self.slope)))


def static_state(drive: Drive, *, load_torque: float = 0.0, segments: int = 120) -> StaticState:
    """Where the cable rests under gravity, carriages and a steady torque on the load pulley [N m].

    A positive torque pulls the upper span. `NotComputed`: no equilibrium, or a piece of cable hangs slack.
    """
    at_torque = -load_torque * drive.drive_pulley.radius / drive.load_pulley.radius
    guided = sum(carriage.guided for carriage in drive.carriage)
    rest, mesh = rest_state(drive, at_torque=at_torque), mesh_of(drive, max(segments, 8 * (1 + guided)))
    if rest.lowest_tension <= 0.0:
        raise NotComputed(
            f"a span hangs slack at rest (lowest tension {rest.lowest_tension:.4g} N): raise cable.pretension"
        )
    tension, slope = np.empty(mesh.spacing.size), np.empty(mesh.spacing.size)
    unstretched = 1.0 + drive.cable.prestrain
    for number, span in enumerate(mesh.spans):
        middle = 0.5 * (mesh.position[number, 1:] + mesh.position[number, :-1]) / unstretched
        for piece in rest.stretches:
            inside = np.flatnonzero((middle > piece.start) & (middle < piece.end))
            if piece.span == span:
                along, across = piece.force_at(middle[inside])
                tension[number * mesh.segments + inside] = piece.tension_at(middle[inside])
                slope[number * mesh.segments + inside] = across / along
    return StaticState(
        mesh=mesh,
        tension=tension,
        stretch=(1.0 + tension / drive.cable.axial_rigidity) / unstretched,
        slope=slope,
        holding_torque=rest.holding_torque,
    )


def static_strain(drive: Drive, mesh: Mesh, shafts: Sequence[str]) -> Array:
    """Strain per pretensioned metre and force at each of some shafts, shape (shafts, segments) [1/N].

    What nothing holds accelerates as a rigid body: its inertia, the cable's too, balances the force.
    A "motor" that is joined rigidly is the drive pulley.
    """
    nodes, segments = mesh.nodes - mesh.closed, mesh.spacing.size
    size, square = nodes + (mesh.joint is not None), drive.drive_pulley.radius**2
    stretch = np.zeros((segments, size))
    own = np.arange(segments)
    stretch[own, own], stretch[own, (own + 1) % nodes] = -1.0, 1.0
    rigidity = drive.cable.axial_rigidity * (1.0 + drive.cable.prestrain)
    stiffness = (stretch.T * (rigidity / mesh.spacing)) @ stretch
    mass = np.append(mesh.axial_mass[:nodes], [shaft.rim_mass for shaft in mesh.shafts[2:]])
    places = [*mesh.rims, nodes]
    for place, shaft in zip(places, mesh.shafts, strict=False):
        stiffness[place, place] += shaft.holding_stiffness / square
    if mesh.joint is not None:
        ends = np.ix_([0, nodes], [0, nodes])
        stiffness[ends] += mesh.joint.stiffness / square * np.array([[1.0, -1.0], [-1.0, 1.0]])
    held = [place for place, shaft in zip(places, mesh.shafts, strict=False) if shaft.fixed]
    force = np.zeros((size, len(shafts)))
    for column, name in enumerate(shafts):
        force[
            {DRIVE_PULLEY: 0, LOAD_PULLEY: mesh.segments, MOTOR: size - 1 if mesh.joint else 0}[name], column
        ] = 1.0
    if not held and not any(shaft.holding_stiffness for shaft in mesh.shafts):
        force -= np.outer(mass, force.sum(axis=0)) / mass.sum()
        stiffness += rigidity / mesh.spacing[0] * np.outer(mass, mass) / mass.sum() ** 2
    moved, free = np.zeros_like(force), np.setdiff1d(np.arange(size), held)
    moved[free] = np.linalg.solve(stiffness[np.ix_(free, free)], force[free])
    return np.asarray((stretch @ moved).T / mesh.spacing)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FreeStretch:
    """A part of a span between two neighbouring points that are held across."""

    span: str  # "upper" or "lower"
    ends: tuple[float, float]  # unstretched positions from the pulley where the span starts [m]
    segments: slice  # its segments among those of all spans
    travel_time: float  # time a transverse wave takes along it [s]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TransverseShapes(FreeStretch):
    """Some modes of a free stretch, of unit largest displacement."""

    numbers: tuple[int, ...]  # which modes, from 1
    omega: Array  # (m,) [rad/s]
    mass: Array  # (m,): modal mass [kg]
    loss: Array  # (m,): modal damping [1/s]; carriages on the stretch are not damped
    shapes: Array  # (m, nodes of the stretch)
    slopes: Array  # (m, segments of the stretch) [1/m]


def free_stretches(drive: Drive, state: StaticState) -> tuple[FreeStretch, ...]:
    """Stretches between pulleys and guided carriages, upper first, none below a fortieth of the longest."""
    mesh, stretch = state.mesh, 1.0 + drive.cable.prestrain
    times = mesh.spacing * np.sqrt(mesh.density * state.stretch / np.maximum(state.tension, 1e-300))
    found = []
    for number, span in enumerate(mesh.spans):
        held = np.flatnonzero(~mesh.sways[mesh.span_nodes(span)])
        first = number * mesh.segments
        for start, end in itertools.pairwise(held):
            here = slice(first + int(start), first + int(end))
            places = mesh.position[number, [start, end]] / stretch
            found.append(
                FreeStretch(
                    span=span,
                    ends=(float(places[0]), float(places[1])),
                    segments=here,
                    travel_time=float(times[here].sum()),
                )
            )
    longest = max(part.ends[1] - part.ends[0] for part in found)
    return tuple(part for part in found if 40.0 * (part.ends[1] - part.ends[0]) >= longest)


def transverse_shapes(
    drive: Drive, state: StaticState, numbers: Sequence[Sequence[int]]
) -> tuple[TransverseShapes, ...]:
    """Some transverse modes of every free stretch. ``numbers``: which of each stretch, ascending from 1."""
    parts = free_stretches(drive, state)
    return tuple(_shapes(drive, state, part, own) for part, own in zip(parts, numbers, strict=True))


def _shapes(drive: Drive, state: StaticState, part: FreeStretch, numbers: Sequence[int]) -> TransverseShapes:
    from scipy.linalg import eigh

    here, mesh = part.segments, state.mesh
    h = mesh.spacing[here]
    inner = slice(here.start + 1, here.stop)
    spring = state.tension[here] / (h * state.stretch[here])
    stiffness = _tridiagonal(spring[:-1] + spring[1:], -spring[1:-1])
    # the mean of lumped and consistent mass: frequencies are right to fourth order in the segment
    cell = mesh.density * h
    cable = _tridiagonal(5.0 / 12.0 * (cell[:-1] + cell[1:]), cell[1:-1] / 12.0)
    total = cable + np.diag(mesh.carriage_mass[inner])
    chosen = np.array([number - 1 for number in numbers if number < h.size])
    squared, vectors = eigh(stiffness, total, subset_by_index=[0, int(chosen[-1])])
    shapes = np.zeros((chosen.size, h.size + 1))
    shapes[:, 1:-1] = vectors[:, chosen].T
    largest = np.abs(shapes).max(axis=1)
    shapes *= (np.where(shapes[:, 1] < 0.0, -1.0, 1.0) / largest)[:, None]
    mass = 1.0 / largest**2
    moved = np.einsum("mi,ij,mj->m", shapes[:, 1:-1], cable, shapes[:, 1:-1])
    return TransverseShapes(
        **{field.name: getattr(part, field.name) for field in fields(FreeStretch)},
        numbers=tuple(int(number) + 1 for number in chosen),
        omega=np.sqrt(squared[chosen]),
        mass=mass,
        loss=drive.cable.transverse_damping * moved / mass,
        shapes=shapes,
        slopes=np.diff(shapes, axis=1) / h,
    )


def _tridiagonal(diagonal: Array, beside: Array) -> Array:
    return np.diag(diagonal) + np.diag(beside, 1) + np.diag(beside, -1)
