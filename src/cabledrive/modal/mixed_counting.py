"""The count of Wittrick and Williams for a chain of different cables, or with several pendants."""

import numpy as np

from cabledrive.mechanics.chain import Chain, split_at_antinodes
from cabledrive.mechanics.stiffness_matrix import dynamic_stiffness, free_joints


def mixed_count(chain: Chain, omega: float) -> int:
    """Number of modes below a frequency [rad/s], rigid-body mode included, from the assembled matrix.

    As Eq. (M.5). Joints are weighed by the mass that each moves, so that round-off of a light one does not
    count.
    """
    from cabledrive.modal.network.stiffness import negative_eigenvalues  # few machines wait for it

    if omega <= 0.0:
        return 0
    split, _ = split_at_antinodes(chain, omega)
    stiffness, free = dynamic_stiffness(split, omega), free_joints(split)
    inside = int(np.floor(omega * split.travel_times / np.pi).sum())
    if not free.size:
        return inside
    scale = 1.0 / np.sqrt(stiffness.ground_rate[free])
    matrix = scale[:, None] * stiffness.matrix()[np.ix_(free, free)] * scale
    return inside + negative_eigenvalues(matrix)
