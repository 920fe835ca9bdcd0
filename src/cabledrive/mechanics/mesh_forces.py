r"""Forces and energies of the divided cable.

Displacements are arrays of shape (3, nodes): u, v, w at each node. A segment stores
:math:`h\,e(u', v', w')` with the differences of its ends as gradients; the forces on the nodes are minus the
derivative of the sum, so that a law with a potential gives a conservative chain.
"""

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw, Components
from cabledrive.mechanics.mesh import Mesh


def gradients(mesh: Mesh, displacement: Array) -> Components:
    """Displacement gradients of the segments.

    ``displacement``, shape (3, nodes): u, v, w [m].
    Returns shape (segments of all spans,): u', v', w' [-].
    """
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
    """Difference of what pulls behind a node and what pulls before it.

    ``components``, shape (3, segments of all spans): what each segment carries [N].
    Returns shape (3, nodes): force on each node [N].
    """
    force = np.zeros((3, mesh.nodes))
    force[:, :-1] += components
    force[:, 1:] -= components
    if mesh.closed:
        force[:, 0] += force[:, -1]
        force[:, -1] = force[:, 0]
    return force


def strain_energy(mesh: Mesh, law: CableLaw, displacement: Array) -> Array:
    """Elastic energy of each span above the straight pretensioned cable.

    ``displacement``, shape (3, nodes): u, v, w [m].
    Returns shape (spans,): energy [J].
    """
    density = law.energy_density(*gradients(mesh, displacement))
    return np.sum((density * mesh.spacing).reshape(len(mesh.spans), -1), axis=1)


def weight_energy(mesh: Mesh, displacement: Array) -> float:
    """Potential energy of the weight, zero for the straight cable.

    ``displacement``, shape (3, nodes): u, v, w [m].
    Returns energy [J].
    """
    last = -1 if mesh.closed else None
    lowered = mesh.weight_u * displacement[0] + mesh.weight_w * displacement[2]
    return -float(np.sum(lowered[:last]))
