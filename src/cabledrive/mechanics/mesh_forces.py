r"""Forces and energies of the divided cable.

Displacements are arrays of shape (3, nodes): u, v, w at each node. A segment stores
:math:`h\,e(u', v', w')` with the differences of its ends as gradients; the forces on the nodes are minus the
derivative of the sum, so that a law with a potential gives a conservative chain.
"""

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw, Components
from cabledrive.mechanics.mesh import Mesh


def gradients(mesh: Mesh, displacement: Array) -> Components:
    """Displacement gradients u', v', w' of the segments [-] from displacements, shape (3, nodes) [m]."""
    u_x, v_x, w_x = np.diff(displacement, axis=1) / mesh.spacing
    return u_x, v_x, w_x


def cable_forces(mesh: Mesh, law: CableLaw, displacement: Array) -> Array:
    """Forces of the cable on its nodes, the pretension's own pull left out.

    ``displacement``, shape (3, nodes): u, v, w [m].
    Returns shape (3, nodes): along u, v, w [N]. At the drive rim of a loop both spans pull; in a line each
    pulley is taken to carry the constant torque that balances the pretension.
    """
    return nodal_differences(mesh, np.stack(law.excess_components(*gradients(mesh, displacement))))


def nodal_differences(mesh: Mesh, components: Array) -> Array:
    """Force on each node, shape (3, nodes) [N], by what each segment carries, shape (3, segments) [N]."""
    force = np.zeros((3, mesh.nodes))
    force[:, :-1] += components
    force[:, 1:] -= components
    if mesh.closed:
        force[:, 0] += force[:, -1]
        force[:, -1] = force[:, 0]
    return force


def strain_energy(mesh: Mesh, law: CableLaw, displacement: Array) -> Array:
    """Elastic energy of each span [J] above the straight pretensioned cable; u, v, w, (3, nodes) [m]."""
    density = law.energy_density(*gradients(mesh, displacement))
    return np.sum((density * mesh.spacing).reshape(len(mesh.spans), -1), axis=1)


def weight_energy(mesh: Mesh, displacement: Array) -> float:
    """Potential energy of the weight [J], zero for the straight cable; u, v, w, (3, nodes) [m]."""
    last = -1 if mesh.closed else None
    lowered = mesh.weight_u * displacement[0] + mesh.weight_w * displacement[2]
    return -float(np.sum(lowered[:last]))
