r"""All longitudinal and transverse modes that a motion can excite, coupled to third order, and their motion.

About the state of rest, with its tension T(x) and the slope W'(x) of the sag, q are the amplitudes of the
longitudinal modes (unit modal mass), a those of the transverse modes of every free stretch (unit largest
displacement) in the plane of the loop, w, and across it, v. With :math:`s = 2W'w' + w'^2 + v'^2` the energy
of chapter 2 gives

.. math::
    \ddot q_k + \sum_l C_{kl}\dot q_l + W_k^2 q_k &= \phi_k\tau/r_1 - Q_k, \qquad
    Q_k = \tfrac12 EA\int U_k' s\,\mathrm{d}x = L_k^T a + \tfrac12 a^T G_k a \\
    m_j(\ddot a_j + \Gamma_j\dot a_j + w_j^2 a_j) &= -\sum_k\Big(q_k + \frac{Q_k}{W_k^2}\Big)
    \frac{\partial Q_k}{\partial a_j} - \frac{EA^2}{4K\Lambda}\,P\,\frac{\partial P}{\partial a_j}
    \qquad \text{Eq. (A.36)}

with :math:`P = \int s\,\mathrm{d}x` over the whole cable. The last two terms let the longitudinal modes above
the kept ones follow without inertia; what torque and friction do through them are further rows of strain,
whose amplitude is a force. :math:`L_k` is the direct excitation through the sag, the diagonal of
:math:`G_k` the parametric excitation of one mode, the rest of :math:`G_k` that of two (sum type).
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.holding import DRIVE_PULLEY, LOAD_PULLEY, MOTOR, shaft_frictions
from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.modal.networks import network_of_chain
from cabledrive.modal.shapes import SlopeWave
from cabledrive.modal.spectrum import Spectrum
from cabledrive.modal.tuning import rims_of
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.sagging_kernels import integrate_sagging
from cabledrive.reduction.static_state import StaticState, TransverseShapes, static_strain, transverse_shapes

SHAFTS = (DRIVE_PULLEY, LOAD_PULLEY, MOTOR)
FEWEST_MODES, MOST_MODES = 4, 10

BAND = 10
"""Transverse modes of a stretch couple up to this difference of their places in the list; beyond, the strain
of a longitudinal mode is too even along the stretch."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LongitudinalModes:
    """Longitudinal modes of unit modal mass, the rigid motion first where there is one."""

    natural: Array  # (k,) [rad/s]; 0: the rigid motion
    rims: Array  # (k, 3): displacement at drive pulley, load pulley and motor [kg^-1/2]
    strain: Array  # (k, segments of all spans): U' per pretensioned metre [kg^-1/2 / m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SaggingModel:
    """Coefficients of the model; k longitudinal modes, b stretches and planes with up to m modes each.

    The last of the k are followers: the static strain per force at a shaft of all modes that are not kept.
    Their frequency, damping and shapes are zero.
    """

    natural: Array  # (k,): W [rad/s]
    damping: Array  # (k, k): C [1/s]
    torque_shape: Array  # (k,): modal force per torque of the motor [kg^-1/2 / m]
    friction_shape: Array  # (3, k): rim displacement of the shafts [kg^-1/2]
    friction: Array  # (3,): Coulomb friction at the rims [N]
    strain: Array  # (k, segments): U' [kg^-1/2 / m]
    stretches: tuple[TransverseShapes, ...]  # one per row of the arrays below: all of plane w, then all of v
    planes: tuple[str, ...]
    count: NDArray[np.int64]  # (b,): number of modes of each
    transverse: Array  # (b, m): w [rad/s]
    mass: Array  # (b, m): modal mass [kg]
    loss: Array  # (b, m): damping [1/s]
    direct: Array  # (k, b, m): L [N/m kg^-1/2]
    coupling: Array  # (k, b, m, m): G, zero beyond BAND from the diagonal [N/m^2 kg^-1/2]
    bend: Array  # (b, m): P per amplitude, the sag's part [-]
    square: Array  # (b, m, m): P per product of amplitudes, in the same form [1/m]
    carried: float  # EA^2 / (4 K Lambda) [N/m]
    rigidity: float  # K = EA + T0, tension per strain of the pretensioned cable [N]
    followers: NDArray[np.int64]  # shafts whose force the followers take, of `SHAFTS`
    rim_force: float  # of the motor per torque [1/m]


def longitudinal_modes(drive: Drive, state: StaticState, top: float, least: int = 0) -> LongitudinalModes:
    """Longitudinal modes below ``top`` [rad/s], ``least`` to `MOST_MODES` of them, and segments' strain."""
    rows: list[tuple[float, Array, Array]] = []
    for chain in longitudinal_chains(drive):
        parts = chain.chain
        if parts.rigid_body_modes:
            mass = parts.all_masses.sum() + parts.cable_mass
            rows.append((0.0, np.full(3, mass**-0.5), np.zeros(state.mesh.spacing.size)))
        wanted = max(least, FEWEST_MODES, parts.masses.size)
        reach = max(top, 1.5 * wanted * pi / float(parts.travel_times.sum()))
        solved = Spectrum(network_of_chain(chain)).below(reach)
        kept = max(wanted, sum(2 * pi * mode.frequency < top for mode in solved))
        for mode in solved[: min(kept, MOST_MODES)]:
            for shape in range(mode.multiplicity):
                strain = _strain(drive, state, mode.slope_waves(shape))
                rows.append((2 * pi * mode.frequency, rims_of(mode, shape), strain))
    rows.sort(key=lambda row: row[0])
    natural, moved, strains = (np.array(own) for own in zip(*rows[: MOST_MODES + 1], strict=True))
    return LongitudinalModes(natural=natural, rims=moved, strain=strains)


def _strain(drive: Drive, state: StaticState, pieces: Sequence[SlopeWave]) -> Array:
    """Slope of a shape at the middle of each segment, per pretensioned metre."""
    mesh, stretch = state.mesh, 1.0 + drive.cable.prestrain
    found = np.zeros(mesh.spacing.size)
    for piece in pieces:
        span = mesh.spans.index(piece.span)
        middle = 0.5 * (mesh.position[span, 1:] + mesh.position[span, :-1]) / stretch
        inside = (middle >= piece.start) & (middle < piece.start + piece.length)
        turned = piece.slope * np.exp(1j * piece.wave_number * (middle[inside] - piece.start))
        found[span * mesh.segments + np.flatnonzero(inside)] = turned.real / stretch
    return found


def _shafts(drive: Drive, modes: LongitudinalModes, spacing: Array) -> tuple[Array, Array]:
    """Damping of shafts, joint and cable, (k, k) [1/s]; Coulomb friction of the shafts' rims, (3,) [N]."""
    shafts = shaft_frictions(drive)
    losses = (1.0 + drive.cable.prestrain) * drive.cable.axial_damping * (modes.strain * spacing)
    losses = losses @ modes.strain.T
    for viscous, _, way in shafts:
        losses = losses + viscous * np.outer(modes.rims @ way, modes.rims @ way)
    friction = np.array([coulomb for _, coulomb, _ in shafts] + [0.0])[:3]
    if drive.motor is not None and drive.motor.joint_stiffness is None:
        friction[0], friction[2] = friction[0] + friction[2], 0.0
    return losses, friction


def _fixed_length(drive: Drive) -> float:
    """Length that the longitudinal motion cannot change, the whole loop; infinite where an end is free."""
    chains = [chain.chain for chain in longitudinal_chains(drive)]
    if len(chains) == 1 and not chains[0].closed and not all(chains[0].fixed):
        return inf
    return (1.0 + drive.cable.prestrain) * sum(float(chain.lengths.sum()) for chain in chains)


def sagging_model(
    drive: Drive, state: StaticState, modes: LongitudinalModes, numbers: Sequence[Sequence[int]]
) -> SaggingModel:
    """Coefficients of Eq. (A.36) for a state of rest and some ``numbers`` of modes of each free stretch."""
    flat = transverse_shapes(drive, state, numbers)
    cable, most = drive.cable, max(len(part.numbers) for part in flat)
    rigidity, spacing = cable.axial_rigidity, state.mesh.spacing
    stretches, planes = (*flat, *flat), ("w",) * len(flat) + ("v",) * len(flat)
    losses, friction = _shafts(drive, modes, spacing)
    followers = np.flatnonzero((friction > 0.0) | (np.arange(len(SHAFTS)) == SHAFTS.index(MOTOR)))
    # static strain per force at the shafts of the followers, less that of the kept modes
    softness = np.divide(1.0, modes.natural**2, out=np.zeros(modes.natural.size), where=modes.natural > 0.0)
    kept = (modes.rims[:, followers] * softness[:, None]).T @ modes.strain
    left_out = static_strain(drive, state.mesh, [SHAFTS[shaft] for shaft in followers]) - kept
    rows, behind = np.concatenate([modes.strain, left_out]), (0, followers.size)
    size = (len(stretches), most)
    transverse, mass, loss, bend = np.ones(size), np.ones(size), np.zeros(size), np.zeros(size)
    square, direct = np.zeros((*size, most)), np.zeros((len(rows), *size))
    coupling = np.zeros((len(rows), *size, most))
    for b, (part, plane) in enumerate(zip(stretches, planes, strict=True)):
        m, here = part.omega.size, part.segments
        slopes = part.slopes * np.sqrt(spacing[here])
        transverse[b, :m], mass[b, :m], loss[b, :m] = part.omega, part.mass, part.loss
        strain = rows[:, here]
        near = np.tri(m, k=BAND) * np.tri(m, k=BAND).T
        coupling[:, b, :m, :m] = rigidity * near * np.einsum("ki,ai,bi->kab", strain, slopes, slopes)
        square[b, :m, :m] = near * (slopes @ slopes.T)
        if plane == "w":
            sag = state.slope[here] * np.sqrt(spacing[here])
            direct[:, b, :m] = rigidity * np.einsum("ki,i,ai->ka", strain, sag, slopes)
            bend[b, :m] = 2.0 * slopes @ sag
    return SaggingModel(
        natural=np.pad(modes.natural, behind),
        damping=np.pad(losses, behind),
        torque_shape=np.pad(modes.rims[:, 2], behind) / drive.drive_pulley.radius,
        friction_shape=np.pad(modes.rims.T, ((0, 0), behind)),
        friction=friction,
        strain=rows,
        stretches=stretches,
        planes=planes,
        count=np.array([part.omega.size for part in stretches], dtype=np.int64),
        transverse=transverse,
        mass=mass,
        loss=loss,
        direct=direct,
        coupling=coupling,
        bend=bend,
        square=square,
        carried=rigidity**2 / (4.0 * (rigidity + cable.pretension) * _fixed_length(drive)),
        rigidity=rigidity + cable.pretension,
        followers=followers,
        rim_force=1.0 / drive.drive_pulley.radius,
    )


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
    modes, (rows, most) = model.natural.size, model.transverse.shape
    solve = np.asarray(np.linalg.inv(np.eye(modes) + 0.5 * h * model.damping), dtype=np.float64)
    solved = model.friction_shape @ solve.T
    natural = model.transverse * (1.0 + detuned)
    mesh = state.mesh
    cuts = {0, mesh.spacing.size, mesh.segments, *(int(node) for node in mesh.carriage_node)}
    ends = itertools.pairwise(sorted(cut for cut in cuts if cut <= mesh.spacing.size))
    # the tension is watched at ends and middle of each piece between two joints
    watched = sorted({i for first, last in ends for i in (first, (first + last) // 2, last - 1)})
    points = min(PROBES, 2 * max(number for part in model.stretches for number in part.numbers) + 5)
    probes = np.zeros((rows, most, points))
    for r, part in enumerate(model.stretches):
        places = np.linspace(0, part.shapes.shape[1] - 1, points + 2).round().astype(int)
        at = np.unique(places[1:-1])
        probes[r, : part.omega.size, : at.size] = part.shapes[:, at]
    table = np.concatenate([model.square[None], model.coupling]).transpose(1, 3, 0, 2)
    shared = [name for name in SaggingNumbers._fields if hasattr(model, name)]
    own = {name: getattr(model, name) for name in shared} | {"natural": natural}
    return SaggingNumbers(
        **own,
        stiff=exact_spring(model.natural, h),
        compliance=np.divide(1.0, model.natural**2, out=np.zeros(modes), where=model.natural > 0.0),
        kept=solve @ (np.eye(modes) - 0.5 * h * model.damping),
        solve=solve,
        impulse_rate=np.maximum(np.einsum("sk,sk->s", model.friction_shape, solved), 1e-300),
        solved=np.ascontiguousarray(solved),
        counts=model.count,
        spring=exact_spring(natural, h),
        table=table.reshape(rows, most, -1),
        raised=2.0 * model.carried,
        probes=probes,
        rest=np.ascontiguousarray(state.tension[watched]),
        watched=np.ascontiguousarray(model.rigidity * model.strain[:, watched]),
    )


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
        seen = (top, modal, when, least, recorded)
        integrate_sagging(numbers, np.ascontiguousarray(torque), done, (h, floor), (q, p, a, b), seen)
        kept.append(recorded)
        done += torque.size
    extremes = Extremes(displacement=top.max(axis=1), amplitude=modal, time=h * when, tension=float(least[0]))
    return extremes, np.concatenate(kept)
