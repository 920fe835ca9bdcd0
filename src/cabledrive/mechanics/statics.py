r"""The divided cable at rest under gravity and carriages.

Of N segments of equal unstretched length the one at the unstretched place s carries the force
:math:`\mathbf F(s)` of Eq. (N.10), since the weight of a node is the difference of its neighbours. So a
divided rope is in balance under the forces of `cabledrive.mechanics.network.statics` with the gradients that
its law gives under them.
"""

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.network.rest_forces import MOST_STEPS, RestingStretch
from cabledrive.parameters.errors import NotComputed


def hanging_gradients(law: CableLaw, along: Array, across: Array) -> tuple[Array, Array]:
    """Gradients u', w' under which a law gives some forces, by Newton's method from the exact law."""
    tension = np.where(across == 0.0, along, np.hypot(along, across))
    strain = (tension - law.pretension) / law.stiffness
    cosine, sine = along / tension, across / tension
    u_x, w_x = strain * cosine - sine**2 / (1.0 + cosine), (1.0 + strain) * sine
    for _ in range(MOST_STEPS):
        x, _, z = law.excess_components(u_x, 0.0 * w_x, w_x)
        left = np.stack([along - law.pretension - x, across - z], axis=-1)
        if np.abs(left).max() <= 64.0 * np.finfo(float).eps * law.stiffness:
            return u_x, w_x
        slope = law.stiffness_matrix(u_x, 0.0 * w_x, w_x)[:, ::2, ::2]
        u_x, w_x = np.stack([u_x, w_x]) + np.linalg.solve(slope, left[..., None])[..., 0].T
    raise NotComputed(f"no equilibrium: the law {law.name} does not give {tension.min():.4g} N; take another")


def segment_forces(rest: RestingStretch, count: int) -> Array:
    """Force along and across in each of so many segments of a piece at rest, (2, count) [N]."""
    return rest.force_at(rest.start + rest.length * (np.arange(count) + 0.5) / count)
