r"""All longitudinal and transverse modes that a motion can excite, coupled to third order.

About the state of rest, with its tension T(x) and the slope W'(x) of the sag, q are the amplitudes of the
longitudinal modes (unit modal mass), a those of the transverse modes of every span (unit largest
displacement) in the plane of the machine, w, and across it, v. With :math:`s = 2W'w' + w'^2 + v'^2` the
energy of chapter 2 gives

.. math::
    \ddot q_k + \sum_l C_{kl}\dot q_l + W_k^2 q_k &= \theta_k\tau - Q_k, \qquad
    Q_k = \tfrac12 EA\int U_k' s\,\mathrm{d}x = L_k^T a + \tfrac12 a^T G_k a \\
    m_j(\ddot a_j + \Gamma_j\dot a_j + w_j^2 a_j) &= -\sum_k\Big(q_k + \frac{Q_k}{W_k^2}\Big)
    \frac{\partial Q_k}{\partial a_j} - \sum_{cd} N_{cd} P_c\,\frac{\partial P_d}{\partial a_j}
    \qquad \text{Eq. (A.36)}

with :math:`P = \frac{EA}{2K}\int s\,\mathrm{d}x` over each strand c, all rope that rests under one tension
whatever stretches it, and N the static stiffness of the machine against lengths that strands take up; of a
loop :math:`K/\Lambda`. The last two terms let the longitudinal modes above the kept ones follow without
inertia; what torque and friction do through them are further rows of strain, whose amplitude is a force or a
torque. :math:`L_k` is the direct excitation through the sag, the diagonal of :math:`G_k` the parametric
excitation of one mode, the rest of :math:`G_k` that of two (sum type).
"""

from collections.abc import Sequence
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.assembly import Network, turns_by_torque
from cabledrive.mechanics.network.motion import ACROSS
from cabledrive.modal.route_network import network_of_routes
from cabledrive.modal.spectrum import Spectrum
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.stretches import StretchModel
from cabledrive.reduction.waves import Waves

PROBES = 40
"""Most points of each row at which the displacement is watched."""
_ALIKE = 1e-6
"""Relative difference of static stiffnesses up to which two pieces belong to one strand."""


def rigid_motions(network: Network) -> Array:
    """Motions of the coordinates that nothing holds, of unit modal mass, shape (n, f)."""
    from scipy.linalg import eigh

    count = Spectrum(network_of_routes(network, even=True)).rigid_body_modes
    return np.asarray(eigh(network.static_stiffness, network.static_mass)[1][:, :count])


def sag_slopes(waves: Waves) -> tuple[Array, Array]:
    """Slope of the sag at the points of all pieces [-] and the tension there [N], (pieces, points)."""
    slopes, tensions = [], []
    for piece in waves.network.pieces:
        at = piece.rest.start + waves.inside * piece.rest.length
        along, across = piece.rest.force_at(at)
        slopes.append(across / along)
        tensions.append(piece.rest.tension_at(at))
    return np.array(slopes), np.array(tensions)


def rows_of(planes: NDArray[Any], moving: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """Modes across that can couple: of one plane and tied by the pieces that they move, (modes, pieces)."""
    from scipy.sparse.csgraph import connected_components

    both = (moving.astype(int) @ moving.T > 0) & np.equal.outer(planes, planes)
    count, labels = connected_components(both, directed=False)
    return [np.flatnonzero(labels == own) for own in range(count)]


def strands_of(waves: Waves) -> NDArray[np.intp]:
    """Number of the strand of each piece, shape (pieces,)."""
    given = _static(waves, rigid_motions(waves.network), np.zeros((0, len(waves.network.motion.names))))[1]
    found, size = np.full(len(given), -1), np.abs(given).max()
    for piece in range(len(given)):
        if found[piece] < 0:
            alike = np.abs(given - given[piece]).max(axis=1) <= _ALIKE * size
            found[alike & (found < 0)] = found.max(initial=-1) + 1
    return found


def sagging_model(
    waves: Waves,
    rows: Sequence[tuple[Sequence[int], NDArray[np.intp]]],
    strands: NDArray[np.intp] | None = None,
) -> StretchModel:
    """Coefficients of Eq. (A.36) for a state of rest and some modes.

    ``rows``: numbers of the modes across in each row, -1 where a place stays empty, and the pieces that they
    move; rows are filled up with modes that nothing couples. ``strands``: of the pieces, by default those of
    this state. Rigid motions stand before the longitudinal modes. Followers are the motors,
    then what rubs. Watched are the tension at ends and middle of each piece and the displacement at up to
    `PROBES` points of each row.
    """
    network, (sag, tension) = waves.network, sag_slopes(waves)
    rigid, links = rigid_motions(network), (network.impedance / network.time)[::3]
    shapes = np.hstack((rigid, waves.coordinates[0].T))
    natural = np.array([*[0.0] * rigid.shape[1], *(2.0 * pi * one.frequency for one in waves.along)])
    softness = np.divide(1.0, natural**2, out=np.zeros(natural.size), where=natural > 0.0)
    damping = shapes.T @ network.dampers.matrix @ shapes
    elastic = np.arange(rigid.shape[1], natural.size)
    damping[elastic, elastic] = waves.losses[0]
    forces = np.vstack((turns_by_torque(network), network.rubs.dense))
    kept = np.concatenate((np.zeros((rigid.shape[1], *sag.shape)), waves.slopes[0]))
    stiffness = links * waves.length  # EA + T
    static, given = _static(waves, rigid, forces)
    left_out = static - np.tensordot(forces @ shapes * softness, kept, axes=1)
    strain = np.concatenate((kept, left_out))
    strands = strands_of(waves) if strands is None else strands
    share = (waves.rigidity / stiffness * waves.length)[:, None] * waves.weights
    force = (waves.rigidity * waves.length)[:, None] * waves.weights
    peaks = np.abs(waves.shapes).max(axis=(1, 2), initial=0.0)
    scale = 1.0 / np.where(peaks > 0.0, peaks, 1.0)
    couplings = waves.products(force * strain) * np.outer(scale, scale)
    in_strand = np.equal.outer(np.unique(strands), strands)
    squares = waves.products(share * in_strand[:, :, None]) * np.outer(scale, scale)
    in_plane = np.array([one.plane == "w" for one in waves.across], dtype=bool)
    alone = np.array([one.clamped for one in waves.across], dtype=bool)
    sagging = waves.slopes[1] * np.where(alone[:, None], 1.0, waves.ropes)[:, :, None] * sag
    sagging = sagging * (scale * in_plane)[:, None, None]
    direct = np.einsum("kpg,apg->ka", force * strain, sagging)
    bends = np.einsum("pg,cp,apg->ca", share, in_strand.astype(float), sagging)
    shaken = shaken_by_rims(waves, shapes) * scale * in_plane
    direct[: natural.size] -= natural[:, None] ** 2 * shaken
    torque_shape = np.ascontiguousarray(shapes.T @ turns_by_torque(network).T)
    shove = waves.coordinates[1] @ forces.T * scale[:, None] - shaken.T @ (shapes.T @ forces.T)
    touched = [sorted(set(strands[pieces].tolist())) for _, pieces in rows]
    most, n = max((len(own) for own, _ in rows), default=0), max(map(len, touched), default=0)
    size = len(rows), most
    transverse, mass, loss, bend = (
        np.ones(size),
        np.ones(size),
        np.zeros(size),
        np.zeros((len(rows), n, most)),
    )
    coupling, square = np.zeros((len(strain), *size, most)), np.zeros((len(rows), n, most, most))
    straight, probes = np.zeros((len(strain), *size)), np.zeros((*size, PROBES))
    shoved, which = np.zeros((*size, shove.shape[1])), np.full((len(rows), n), -1)
    omega, lost = np.array([2.0 * pi * one.frequency for one in waves.across]), waves.losses[1]
    for row, (own, pieces) in enumerate(rows):
        slots = np.array([i for i, a in enumerate(own) if a >= 0], dtype=int)
        modes = np.array([a for a in own if a >= 0], dtype=int)
        transverse[row, slots], mass[row, slots] = omega[modes], scale[modes] ** 2
        loss[row, slots], shoved[row, slots] = lost[modes], shove[modes]
        square_of, direct_of = np.ix_(slots, slots), np.ix_(modes, modes)
        for one, other in zip(coupling, couplings, strict=True):
            one[row][square_of] = other[direct_of]
        straight[:, row, slots] = direct[:, modes]
        for e, strand in enumerate(touched[row]):
            which[row, e] = strand
            square[row, e][square_of], bend[row, e, slots] = squares[strand][direct_of], bends[strand, modes]
        points = waves.shapes[modes][:, pieces].reshape(modes.size, len(pieces) * waves.inside.size)
        places = np.linspace(0, points.shape[1] - 1, min(PROBES, points.shape[1])).round().astype(int)
        probes[row, slots, : places.size] = (scale[modes][:, None] * points)[:, places]
    first = np.array([np.argmax(strands == own) for own in np.unique(strands)], dtype=int)
    inside, strand = which.ravel() >= 0, first[which.ravel()]
    at = [0, waves.inside.size // 2, waves.inside.size - 1]
    raised = given[:, strand] / waves.ropes[:, None] * inside
    return StretchModel(
        natural=natural,
        damping=damping,
        torque_shape=torque_shape,
        motions=np.zeros((0, natural.size)),
        transverse=transverse,
        mass=mass,
        loss=loss,
        sag=np.zeros(size),
        coupling=coupling,
        square=square,
        carried=given[np.ix_(strand, strand)] * np.outer(inside, inside),
        probes=probes,
        rest=np.ascontiguousarray(tension[:, at].ravel()),
        tension=np.ascontiguousarray((stiffness[:, None] * strain)[:, :, at].reshape(len(strain), -1).T),
        raised=np.ascontiguousarray(np.repeat(raised, len(at), axis=0)),
        direct=straight,
        bend=bend,
        softness=softness,
        shoved=shoved,
        friction=network.rubs.values,
        friction_shape=np.ascontiguousarray(network.rubs.dense @ shapes),
    )


def shaken_by_rims(waves: Waves, shapes: Array) -> Array:
    r"""Inertia by which motions of the coordinates, (n, k), shake modes across, (k, across) [kg^1/2].

    A rim moves a rope that sags along its own direction there. Motions across count from the chord between
    the ends, :math:`\int\rho\varphi_j\ddot w_k` the force of the chord that rims of motion k move.
    """
    network, pieces = waves.network, waves.network.pieces
    mass = np.array([piece.rope.density * piece.rest.length for piece in pieces])
    alone = np.array([one.clamped for one in waves.across], dtype=bool)
    found, number = np.zeros((shapes.shape[1], len(waves.across))), 0
    for section in network.sections:
        first, last = section[0], section[-1]
        rims = network.motion.dense(first.rims[0], last.rims[1])
        steep = np.array([first.direction(True)[1], last.direction(False)[1]])
        ends, begun = (steep[:, None] * rims) @ shapes, 0.0
        length = sum(piece.length for piece in section)
        for piece in section:
            share = (begun + waves.inside * piece.length) / length
            chord = np.outer(ends[0], 1.0 - share) + np.outer(ends[1], share)
            count = np.where(alone, 1.0, waves.ropes[number]) * mass[number]
            found += (chord * waves.weights) @ (count[:, None] * waves.shapes[:, number]).T
            begun, number = begun + piece.length, number + 1
            if piece is not last:
                carriage = pieces[number].carriages[0]
                name = f"{network.motion.carriage_name(carriage)} {ACROSS}"
                chord_there = ends[0] + (ends[1] - ends[0]) * begun / length
                swings = waves.coordinates[1] @ network.motion.dense(name)[0]
                found += network.drive.carriage[carriage].mass * np.outer(chord_there, swings)
    return found


def _static(waves: Waves, rigid: Array, forces: Array) -> tuple[Array, Array]:
    """Static slopes per force, (forces, pieces, points), and pull of pieces per length taken up, (p, p).

    What nothing holds accelerates as a rigid body: its inertia, the ropes' too, balances the force.
    """
    network = waves.network
    inertia, links = network.static_mass @ rigid, (network.impedance / network.time)[::3]
    held = inertia @ inertia.T
    own = network.static_stiffness
    own = own + held * (np.abs(own).max(initial=0.0) / max(np.abs(held).max(initial=0.0), 1e-300))
    pull = np.linalg.solve(own, forces.T - inertia @ (rigid.T @ forces.T))
    moved = rigid @ (rigid.T @ forces.T)
    near, far = network.start[::3] @ moved, network.end[::3] @ moved
    x, mass = waves.inside, (network.impedance * network.time)[::3, None]
    tension = (network.pull @ pull)[:, :, None] + (
        (mass * near)[:, :, None] * (x - 0.5 * x**2 - 1.0 / 3.0)
        + (mass * far)[:, :, None] * (0.5 * x**2 - 1.0 / 6.0)
    )
    link = np.diag(waves.ropes * links)
    given = link - link @ network.stretch @ np.linalg.solve(own, network.stretch.T @ link)
    return (tension / (links * waves.length)[:, None, None]).swapaxes(0, 1), given
