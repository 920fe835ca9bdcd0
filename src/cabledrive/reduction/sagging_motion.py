"""Numbers that the integration of Eq. (A.36) takes, for one step length; the integration itself."""

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters.arrays import Array
from cabledrive.reduction.sagging_kernels import integrate_sagging
from cabledrive.reduction.sagging_model import BAND, SaggingModel
from cabledrive.reduction.static_state import StaticState

PROBES = 40
"""Most points of each stretch at which the displacement is watched, two and a bit for each mode."""


class SaggingNumbers(NamedTuple):
    """What a step needs, arrays only; see `cabledrive.reduction.sagging_model.SaggingModel`.

    ``table``, shape (b, m, (1 + k) m), is the model's ``square`` and then its ``coupling`` with each of the k
    longitudinal modes, in rows along which a step runs in one loop; ``probes``, shape (b, m, points). A rigid
    motion strains nothing: its part of ``direct`` and ``table`` is zero. The last of the k are followers:
    their amplitude is the force at the shafts ``followers`` [N], ``rim_force`` per torque of the motor.
    """

    stiff: Array
    compliance: Array
    kept: Array
    solve: Array
    torque_shape: Array
    friction: Array
    friction_shape: Array
    impulse_rate: Array
    solved: Array
    counts: NDArray[np.int64]
    natural: Array
    spring: Array
    mass: Array
    loss: Array
    direct: Array
    table: Array
    bend: Array
    carried: float
    raised: float
    probes: Array
    rest: Array
    watched: Array
    followers: NDArray[np.int64]
    rim_force: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Extremes:
    """Largest and least values along a motion."""

    displacement: Array  # (b,): largest one from rest at the watched points of each stretch and plane [m]
    amplitude: Array  # (b, m): largest amplitude of each transverse mode [m]
    time: Array  # (b, m): when it is reached [s]
    tension: float  # lowest tension [N]


def exact_spring(omega: Array, h: float) -> Array:
    """Stiffness per mass with which a leapfrog of step h turns at exactly omega."""
    return (2.0 * np.sin(0.5 * h * omega) / h) ** 2


def numbers_of(model: SaggingModel, state: StaticState, h: float, detuned: float = 0.0) -> SaggingNumbers:
    """Prepare an integration of step h [s], all transverse frequencies changed by a share ``detuned``."""
    modes = model.natural.size
    solve = np.asarray(np.linalg.inv(np.eye(modes) + 0.5 * h * model.damping), dtype=np.float64)
    solved = model.friction_shape @ solve.T
    natural = model.transverse * (1.0 + detuned)
    watched = _watched(model, state)
    rigidity = 4.0 * model.carried
    compliance = np.divide(1.0, model.natural**2, out=np.zeros(modes), where=model.natural > 0.0)
    return SaggingNumbers(
        stiff=exact_spring(model.natural, h),
        compliance=compliance,
        kept=solve @ (np.eye(modes) - 0.5 * h * model.damping),
        solve=solve,
        torque_shape=model.torque_shape,
        friction=model.friction,
        friction_shape=model.friction_shape,
        impulse_rate=np.maximum(np.einsum("sk,sk->s", model.friction_shape, solved), 1e-300),
        solved=np.ascontiguousarray(solved),
        counts=model.count,
        natural=natural,
        spring=exact_spring(natural, h),
        mass=model.mass,
        loss=model.loss,
        direct=model.direct,
        table=_table(model),
        bend=model.bend,
        carried=model.carried,
        raised=0.5 * rigidity,
        probes=_probes(model),
        rest=np.ascontiguousarray(state.tension[watched]),
        watched=np.ascontiguousarray(model.rigidity * model.strain[:, watched]),
        followers=model.followers,
        rim_force=model.rim_force,
    )


def _table(model: SaggingModel) -> Array:
    """What the amplitudes are multiplied with, shape (b, m, (1 + k) m): a row for each of them."""
    rows, most = model.transverse.shape
    banded = np.stack([model.square, *model.coupling])
    found = np.zeros((rows, most, banded.shape[0], most))
    for i in range(most):
        for j in range(max(0, i - BAND), min(most, i + BAND + 1)):
            found[:, i, :, j] = banded[:, :, j, i - j + BAND].T
    return found.reshape(rows, most, -1)


def _probes(model: SaggingModel) -> Array:
    """Shapes at the watched points, shape (b, m, points)."""
    rows, most = model.transverse.shape
    highest = max(number for part in model.stretches for number in part.numbers)
    points = min(PROBES, 2 * highest + 5)
    found = np.zeros((rows, most, points))
    for r, part in enumerate(model.stretches):
        nodes = part.shapes.shape[1]
        at = np.unique(np.linspace(0, nodes - 1, points + 2).round().astype(int)[1:-1])
        found[r, : part.omega.size, : at.size] = part.shapes[:, at]
    return found


def _watched(model: SaggingModel, state: StaticState) -> NDArray[np.intp]:
    """Segments at which the tension is watched: ends and middle of each piece between two joints."""
    mesh = state.mesh
    cuts = {0, mesh.spacing.size, mesh.segments, *(int(node) for node in mesh.carriage_node)}
    ends = sorted(cut for cut in cuts if cut <= mesh.spacing.size)
    found = set()
    for first, last in itertools.pairwise(ends):
        found |= {first, (first + last) // 2, last - 1}
    return np.array(sorted(found), dtype=np.intp)


def integrate(
    stages: list[tuple[SaggingNumbers, Array]],
    h: float,
    *,
    floor: float = 0.0,
    phase: float = 0.0,
    history: bool = False,
) -> tuple[Extremes, Array]:
    """Move the model from rest through stages, each with its own coefficients.

    ``stages``: coefficients, and the torque above the holding torque at each of their steps [N m]; ``h``:
    step [s]; ``floor``: amplitude below which no transverse mode falls [m]; ``phase``: phase at which that
    amplitude begins [rad]; ``history``: whether to keep the longitudinal amplitudes.
    Returns ``history``, shape (steps, k).
    """
    first = stages[0][0]
    modes, rows, most = first.direct.shape
    q, p = np.zeros(modes), np.zeros(modes)
    inside = np.arange(most) < first.counts[:, None]
    a = np.where(inside, floor * np.cos(phase), 0.0)
    b = np.where(inside, floor * np.sin(phase) * first.natural, 0.0)
    top, modal = np.zeros((rows, first.probes.shape[2])), np.zeros((rows, most))
    when, done = np.zeros((rows, most)), 0
    least, kept = np.array([np.inf]), []
    for numbers, torque in stages:
        recorded = np.zeros((torque.size if history else 0, modes))
        state = (q, p, a, b, top, modal, when, least, recorded)
        integrate_sagging(numbers, np.ascontiguousarray(torque), done, h, floor, *state)
        kept.append(recorded)
        done += torque.size
    extremes = Extremes(displacement=top.max(axis=1), amplitude=modal, time=h * when, tension=float(least[0]))
    return extremes, np.concatenate(kept)
