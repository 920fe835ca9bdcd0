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
from math import pi

import numpy as np

from cabledrive.mechanics.holding import DRIVE_PULLEY, LOAD_PULLEY, MOTOR, modal_losses, shaft_frictions
from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.modal.networks import network_of_chain
from cabledrive.modal.shapes import SlopeWave
from cabledrive.modal.spectrum import Spectrum
from cabledrive.modal.tuning import rims_of
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.static_state import StaticState, TransverseShapes, static_strain, transverse_shapes
from cabledrive.reduction.stretch_runs import extremes_run
from cabledrive.reduction.stretches import StretchModel, new_stretch_state, numbers_of
from cabledrive.reduction.transverse_sections import fixed_length

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


def _frictions(drive: Drive) -> Array:
    """Coulomb friction at the rims of the shafts, (3,) [N]; without a joint the motor's is its pulley's."""
    friction = np.zeros(len(SHAFTS))
    for place, (_, coulomb, _) in enumerate(shaft_frictions(drive)[: len(SHAFTS)]):
        rigid = place == SHAFTS.index(MOTOR) and drive.motor and drive.motor.joint_stiffness is None
        friction[0 if rigid else place] += coulomb
    return friction


def sagging_model(
    drive: Drive, state: StaticState, modes: LongitudinalModes, numbers: Sequence[Sequence[int]]
) -> tuple[StretchModel, tuple[TransverseShapes, ...]]:
    """Coefficients of Eq. (A.36) for a state of rest and some ``numbers`` of modes of each free stretch.

    Rows are the free stretches in the plane w, then in v, filled up with modes that nothing couples.
    Followers are the shafts with friction and the motor: the static strain per force of all modes not kept.
    Watched are the tension at ends and middle of each piece between two joints, and the displacement at up
    to `PROBES` points of each stretch. Returns the free stretches with these modes as well.
    """
    flat = transverse_shapes(drive, state, numbers)
    cable, mesh, most = drive.cable, state.mesh, max(len(part.numbers) for part in flat)
    rigidity, spacing, k = cable.axial_rigidity, mesh.spacing, modes.natural.size
    friction = _frictions(drive)
    followers = np.flatnonzero((friction > 0.0) | (np.arange(len(SHAFTS)) == SHAFTS.index(MOTOR)))
    # static strain per force at the shafts of the followers, less that of the kept modes
    softness = np.divide(1.0, modes.natural**2, out=np.zeros(k), where=modes.natural > 0.0)
    kept = (modes.rims[:, followers] * softness[:, None]).T @ modes.strain
    left_out = static_strain(drive, mesh, [SHAFTS[shaft] for shaft in followers]) - kept
    strain = np.concatenate([modes.strain, left_out])
    points = min(PROBES, 2 * max(part.numbers[-1] for part in flat) + 5)
    size = (2 * len(flat), most)
    transverse, mass, loss, bend = np.ones(size), np.ones(size), np.zeros(size), np.zeros(size)
    square, direct = np.zeros((*size, most)), np.zeros((len(strain), *size))
    coupling, probes = np.zeros((len(strain), *size, most)), np.zeros((*size, points))
    for row, part in enumerate((*flat, *flat)):
        m, here = part.omega.size, part.segments
        slopes = part.slopes * np.sqrt(spacing[here])
        transverse[row, :m], mass[row, :m], loss[row, :m] = part.omega, part.mass, part.loss
        near = np.tri(m, k=BAND) * np.tri(m, k=BAND).T
        coupling[:, row, :m, :m] = near * np.einsum(
            "ki,ai,bi->kab", rigidity * strain[:, here], slopes, slopes
        )
        square[row, :m, :m] = 2.0 * near * (slopes @ slopes.T)
        places = np.linspace(0, part.shapes.shape[1] - 1, points + 2).round().astype(int)
        at = np.unique(places[1:-1])
        probes[row, :m, : at.size] = part.shapes[:, at]
        if row < len(flat):
            sag = state.slope[here] * np.sqrt(spacing[here])
            direct[:, row, :m] = rigidity * np.einsum("ki,i,ai->ka", strain[:, here], sag, slopes)
            bend[row, :m] = 2.0 * slopes @ sag
    cuts = {0, spacing.size, mesh.segments, *(int(node) for node in mesh.carriage_node)}
    ends = itertools.pairwise(sorted(cut for cut in cuts if cut <= spacing.size))
    watched = sorted({i for first, last in ends for i in (first, (first + last) // 2, last - 1)})
    shared = rigidity**2 / (4.0 * (rigidity + cable.pretension) * fixed_length(drive))
    model = StretchModel(
        natural=modes.natural,
        damping=modal_losses(drive, modes.rims, modes.natural**2),
        torque_shape=modes.rims[:, 2] / drive.drive_pulley.radius,
        transverse=transverse,
        mass=mass,
        loss=loss,
        sag=np.zeros(size),
        direct=direct,
        coupling=coupling,
        softness=softness,
        bend=bend,
        square=square,
        carried=np.full((len(bend), len(bend)), shared),
        rest=np.ascontiguousarray(state.tension[watched]),
        tension=np.ascontiguousarray((rigidity + cable.pretension) * strain[:, watched].T),
        raised=np.full((len(watched), len(bend)), 2.0 * shared),
        probes=probes,
        motions=np.zeros((0, k)),
        friction=friction,
        friction_shape=np.ascontiguousarray(modes.rims.T),
        followers=followers,
        rim_force=1.0 / drive.drive_pulley.radius,
    )
    return model, flat


PROBES = 40
"""Most points of each stretch at which the displacement is watched, two and a bit for each mode."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Extremes:
    """Largest and least values along a motion."""

    displacement: Array  # (b,): largest one from rest at the watched points of each stretch and plane [m]
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

    ``stages``: model, and the torque above the holding torque at each of its steps [N m]; ``h``: step [s];
    ``floor``: amplitude below which no transverse mode falls [m]; ``phase``: phase at which that amplitude
    begins [rad]; ``history``: whether to keep the longitudinal amplitudes and the followers' forces.
    Returns ``history``, shape (steps, k + f).
    """
    first = stages[0][0]
    (rows, most, points), state = first.probes.shape, new_stretch_state(numbers_of(first, h))
    here = np.any(first.probes, axis=2)  # not the modes that only fill up
    state.sines[:] = np.where(here, floor * np.cos(phase), 0.0)
    state.rates[:] = np.where(here, floor * np.sin(phase) * first.transverse, 0.0)
    top, modal, when = np.zeros((rows, points)), np.zeros((rows, most)), np.zeros((rows, most))
    least, kept, done = np.array([np.inf]), [], 0
    for model, torque in stages:
        recorded = np.zeros((torque.size if history else 0, len(model.direct)))
        seen = (top, modal, when, least, recorded)
        extremes_run(numbers_of(model, h), state, np.ascontiguousarray(torque), done, floor, seen)
        kept.append(recorded)
        done += torque.size
    extremes = Extremes(displacement=top.max(axis=1), amplitude=modal, time=h * when, tension=float(least[0]))
    return extremes, np.concatenate(kept)
