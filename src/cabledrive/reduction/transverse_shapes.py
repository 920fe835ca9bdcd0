"""Transverse modes of every free stretch under the tension that is there, on the segments of the statics."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.static_state import StaticState


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
    """Stretches between pulleys and guided carriages, upper span first."""
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
    return tuple(found)


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
        span=part.span,
        ends=part.ends,
        segments=here,
        travel_time=part.travel_time,
        numbers=tuple(int(number) + 1 for number in chosen),
        omega=np.sqrt(squared[chosen]),
        mass=mass,
        loss=drive.cable.transverse_damping * moved / mass,
        shapes=shapes,
        slopes=np.diff(shapes, axis=1) / h,
    )


def _tridiagonal(diagonal: Array, beside: Array) -> Array:
    return np.diag(diagonal) + np.diag(beside, 1) + np.diag(beside, -1)
