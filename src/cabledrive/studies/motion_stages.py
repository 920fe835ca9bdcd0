"""The poses that a planned motion passes, the coefficients of a machine along them, and its motion."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cabledrive.mechanics.network.assembly import Network, turns_by_torque
from cabledrive.parameters import Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.strain_free import place_of
from cabledrive.reduction.stretch_runs import extremes_run
from cabledrive.reduction.stretches import StretchModel, new_stretch_state, numbers_of
from cabledrive.studies.planned_motion import PlannedMotion

POSES = 13
"""At which modes are computed where bodies move; between them they are interpolated."""
STILL = 1e-9
"""Largest motion of a body that leaves the modes alone [m], [rad]."""
_STRAINLESS = 1e-9
_HELD = 1e-3
"""Square of frequency times duration below which a motion without strain counts as free."""
PARTS = 16
"""Steps between two poses, in each of which the coefficients stand still."""


def poses_along(
    drive: Machine, places: Mapping[str, Array], time: Array
) -> tuple[list[dict[str, float]], Array]:
    """Poses at which modes are computed, fixed places in all, and where between them the motion is."""
    moving = {key: values for key, values in places.items() if np.ptp(values) > STILL}
    fixed = {key: float(values[0]) for key, values in places.items() if key not in moving}
    fixed = {
        key: value
        for key, value in fixed.items()
        if "." not in key or abs(value - place_of(drive, key)) > STILL  # else not of a body
    }
    if not moving:
        return [fixed], np.zeros(time.size)
    if len(moving) == 1:  # on a line: a way back passes the same poses
        ((key, values),) = moving.items()
        grid = np.linspace(values.min(), values.max(), POSES)
        return [fixed | {key: float(one)} for one in grid], np.interp(values, grid, np.arange(POSES))
    scaled = np.array([values / np.ptp(values) for values in moving.values()])
    way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(scaled), axis=0)))
    grid, goes = np.linspace(0.0, way[-1], POSES), np.append(True, np.diff(way) > 0.0)
    poses = [
        fixed | {key: float(np.interp(one, way[goes], values[goes])) for key, values in moving.items()}
        for one in grid
    ]
    return poses, np.interp(way, grid, np.arange(POSES))


def pose_words(drive: Machine, pose: Mapping[str, float]) -> str:
    """A pose for a refusal, with the places of the file, for whoever gave ways instead of places."""
    return ", ".join(
        f"{key} = {value:.4g} {'rad' if key.endswith('.turn') else 'm'} "
        f"(in the file {place_of(drive, key):.4g})"
        for key, value in pose.items()
    )


def places_along(drive: Machine, network: Network, way: Array) -> dict[str, Array]:
    """Place of every body where the coordinates go a way, shape (m, n): (m,) by key [m], [rad]."""
    keys = [f"{body.name}.{move}" for body in drive.body for move in body.moves]
    return {key: place_of(drive, key) + way @ network.motion.dense(key)[0] for key in keys}


def strainless(network: Network) -> Array:
    """Motions of the coordinates that strain no rope, joint or spring, shape (n, k)."""
    rows = np.vstack((-network.stretch, network.springs.dense))
    size = np.abs(rows).max(axis=0)  # a column of metres and one of radians count alike
    scale = 1.0 / np.where(size > 0.0, size, 1.0)
    _, values, vectors = np.linalg.svd(rows * scale)
    rank = int(np.sum(values > _STRAINLESS * values[0]))
    return np.asarray(scale[:, None] * vectors[rank:].T)


def driven_way(drive: Machine, network: Network, motion: PlannedMotion) -> tuple[Array, Array] | None:
    """Where the torque takes the coordinates of the machine from rest, without friction, and their rates.

    None where weights or directions of ropes hold it against the torque.
    """
    free = strainless(network)
    mass = free.T @ network.static_mass @ free
    held = np.linalg.solve(mass, free.T @ network.static_stiffness @ free)
    if np.abs(held).max(initial=0.0) * motion.time[-1] ** 2 > _HELD:
        return None
    from scipy.integrate import cumulative_trapezoid  # a third of a second, for moving bodies alone

    push = np.column_stack(torques_of(drive, motion)) @ turns_by_torque(network) @ free
    pulled = np.asarray(np.linalg.solve(mass, push.T).T)
    speed = cumulative_trapezoid(pulled, motion.time, axis=0, initial=0.0)
    way = cumulative_trapezoid(speed, motion.time, axis=0, initial=0.0)
    return way @ free.T, speed @ free.T


def torques_of(drive: Machine, motion: PlannedMotion) -> list[Array]:
    """Torque of each motor over the motion's time [N m]."""
    others = [drive.pulley[number].name for number in drive.turned[1:]]
    return [motion.torque, *(motion.torques.get(name, np.zeros(motion.time.size)) for name in others)]


def interpolated(values: Sequence[Array], here: Array) -> Array:
    """Figures of the poses at places along them, the place first."""
    stacked = np.array(values)
    first = np.minimum(here.astype(np.intp), max(len(stacked) - 2, 0))
    share = (here - first).reshape(-1, *[1] * (stacked.ndim - 1))
    second = np.minimum(first + 1, len(stacked) - 1)
    return np.asarray((1.0 - share) * stacked[first] + share * stacked[second])


def between(models: Sequence[StretchModel], place: float) -> StretchModel:
    """Coefficients at a place along the poses."""
    number = min(int(place), len(models) - 2)
    if number < 0:
        return models[0]
    share, one, other = place - number, models[number]._asdict(), models[number + 1]._asdict()
    return StretchModel(**{name: (1.0 - share) * one[name] + share * other[name] for name in one})


def stages_along(
    models: Sequence[StretchModel], here: Array, torque: Array
) -> Iterator[tuple[StretchModel, Array]]:
    """One stage where the machine stays in its pose; else `PARTS` between neighbouring poses."""
    part = np.floor(here * PARTS)
    edges = [0, *(np.flatnonzero(np.diff(part)) + 1).tolist(), here.size]
    for start, end in pairwise(edges):
        place = (part[start] + 0.5) / PARTS if len(models) > 1 else 0.0
        yield between(models, min(place, len(models) - 1.0)), torque[start:end]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Extremes:
    """Largest and least values along a motion."""

    displacement: Array  # (b,): largest one from rest at the watched points of each row [m]
    amplitude: Array  # (b, m): largest amplitude of each transverse mode [m]
    time: Array  # (b, m): when it is reached [s]
    tension: float  # lowest tension [N]


def integrate(
    stages: list[tuple[StretchModel, Array]],
    h: float,
    *,
    floor: float = 0.0,
    phase: float = 0.0,
    history: bool = False,
) -> tuple[Extremes, Array]:
    """Move the model from rest through stages, each with its own coefficients.

    ``stages``: model, and the torques above the holding ones at each of its steps, (n, motors) [N m]; ``h``:
    step [s]; ``floor``: amplitude below which no transverse mode falls [m]; ``phase``: phase at which it
    begins [rad]; ``history``: whether to keep the longitudinal amplitudes and the followers' forces, which
    are returned, shape (steps, k + f).
    """
    first = stages[0][0]
    (rows, most, points), state = first.probes.shape, new_stretch_state(numbers_of(first, h))
    here = np.any(first.probes, axis=2)  # not the modes that only fill up
    state.sines[:] = np.where(here, floor * np.cos(phase), 0.0)
    state.rates[:] = np.where(here, floor * np.sin(phase) * first.transverse, 0.0)
    top, modal, when = np.zeros((rows, points)), np.zeros((rows, most)), np.zeros((rows, most))
    least, kept, done = np.array([np.inf]), [], 0
    for model, torque in stages:
        recorded = np.zeros((len(torque) if history else 0, len(model.direct)))
        seen = (top, modal, when, least, recorded)
        extremes_run(numbers_of(model, h), state, np.ascontiguousarray(torque), done, floor, seen)
        kept.append(recorded)
        done += len(torque)
    extremes = Extremes(
        displacement=top.max(axis=1, initial=0.0), amplitude=modal, time=h * when, tension=float(least[0])
    )
    return extremes, np.concatenate(kept)
