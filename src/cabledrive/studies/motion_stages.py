"""Coefficients of a machine along its poses, and its motion through them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cabledrive.parameters.arrays import Array
from cabledrive.reduction.stretch_runs import extremes_run
from cabledrive.reduction.stretches import StretchModel, new_stretch_state, numbers_of

PARTS = 16
"""Steps between two poses, in each of which the coefficients stand still."""


def interpolated(values: Sequence[Array], here: Array) -> Array:
    """Figures of the poses at places along them, the place first."""
    stacked = np.array(values)
    first = np.minimum(here.astype(np.intp), max(len(stacked) - 2, 0))
    share = (here - first).reshape(-1, *[1] * (stacked.ndim - 1))
    return np.asarray(
        (1.0 - share) * stacked[first] + share * stacked[np.minimum(first + 1, len(stacked) - 1)]
    )


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
