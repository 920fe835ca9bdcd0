"""Strain of a drive's cable under steady forces at its shafts, its free motion accelerating as a whole."""

from collections.abc import Sequence

import numpy as np

from cabledrive.mechanics.holding import DRIVE_PULLEY, MOTOR
from cabledrive.mechanics.labelled_chain import LabelledChain
from cabledrive.mechanics.mesh import Mesh
from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array


def static_strain(drive: Drive, mesh: Mesh, shafts: Sequence[str]) -> Array:
    """Strain per pretensioned metre and force at each of some shafts, shape (shafts, segments) [1/N].

    What nothing holds accelerates as a rigid body: its inertia, the cable's too, balances the force.
    A "motor" that is joined rigidly is the drive pulley.
    """
    found = np.zeros((len(shafts), mesh.spacing.size))
    for chain in longitudinal_chains(drive):
        for row, shaft in enumerate(shafts):
            name = DRIVE_PULLEY if shaft == MOTOR and MOTOR not in chain.joints else shaft
            if name in chain.joints:
                found[row] += _of_chain(drive, mesh, chain, chain.joints.index(name))
    return found


def _of_chain(drive: Drive, mesh: Mesh, chain: LabelledChain, pushed: int) -> Array:
    """Strain per force at one joint of a chain."""
    parts = chain.chain
    joints, size, rigidity = parts.masses.size, len(chain.joints), drive.cable.axial_rigidity
    stiffness, mass = np.zeros((size, size)), np.array(parts.all_masses, dtype=np.float64)
    ends = [(i, (i + 1) % joints) for i in range(parts.lengths.size)]
    springs = [(*pair, rigidity / length) for pair, length in zip(ends, parts.lengths, strict=True)]
    springs += [(p.joint, joints + n, p.stiffness) for n, p in enumerate(parts.pendants)]
    for one, other, k in springs:
        turned = np.zeros(size)
        turned[other] += 1.0
        turned[one] -= 1.0
        stiffness += k * np.outer(turned, turned)
    if parts.grounds is not None:
        stiffness[:joints, :joints] += np.diag(parts.grounds)
    for n, pendant in enumerate(parts.pendants):
        stiffness[joints + n, joints + n] += pendant.ground
    density = drive.cable.mass_per_length
    for (one, other), length in zip(ends, parts.lengths, strict=True):  # each half of a stretch at its end
        mass[one] += 0.5 * density * length
        mass[other] += 0.5 * density * length
    force = np.zeros(size)
    force[pushed] = 1.0
    speeding = 1.0 / mass.sum() if parts.rigid_body_modes else 0.0
    held = [0] * parts.fixed[0] + [joints - 1] * parts.fixed[1]
    free = np.setdiff1d(np.arange(size), held)
    moved = np.zeros(size)
    if free.size:
        balanced = (force - speeding * mass)[free]
        moved[free] = np.linalg.lstsq(stiffness[np.ix_(free, free)], balanced, rcond=None)[0]
    return _along(drive, mesh, chain, [(moved[b] - moved[a]) for a, b in ends], speeding * density / rigidity)


def _along(drive: Drive, mesh: Mesh, chain: LabelledChain, longer: Sequence[float], rise: float) -> Array:
    """Strain of each segment: the mean of its stretch, and the rise along it by acceleration."""
    factor = 1.0 + drive.cable.prestrain
    found = np.zeros(mesh.spacing.size)
    for stretch, elongation in zip(chain.stretches, longer, strict=True):
        span, length = mesh.spans.index(stretch.span), stretch.end - stretch.start
        middle = 0.5 * (mesh.position[span, 1:] + mesh.position[span, :-1]) / factor
        inside = (middle >= stretch.start) & (middle < stretch.end)
        place = middle[inside] - 0.5 * (stretch.start + stretch.end)
        found[span * mesh.segments + np.flatnonzero(inside)] = (elongation / length + rise * place) / factor
    return found
