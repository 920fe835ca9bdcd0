r"""Largest stable step of cells of rope between moving bodies.

A segment between two cells of stiffness k does at most :math:`k(x_a^2 + x_b^2)` to its ends, one of half a
length at a pulley twice that; so a cell of mass m has at most :math:`\omega^2 = 6k/m` (:math:`8k/m` where it
is alone), and the coordinates have the eigenvalues of their masses with all end segments doubled.
"""

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.network import Network
from cabledrive.simulation.runs import Integers


def largest_travel_step(network: Network, counts: Integers, shortest: Array) -> float:
    """Step [s] that is stable in a pose; ``counts``: cells of the spans, ``shortest``: their lengths [m].

    Axial damping acts on the ends with their speeds before the step, which lowers it.
    """
    from scipy.linalg import eigh  # here, for asking for help does not need it

    drive = network.drive
    ropes = [drive.ropes[span.route] for span in drive.free_spans]
    lines = np.array([drive.route[span.route].ropes for span in drive.free_spans], dtype=np.float64)
    rigidity, density, damping = (
        np.array([getattr(rope, key) for rope in ropes])
        for key in ("axial_rigidity", "density", "axial_damping")
    )
    cell = shortest / counts
    own = np.where(counts == 1, 8.0, 6.0) * rigidity / density / cell**2
    along = network.direction == 0
    ends = np.concatenate([network.start[along], network.end[along]])
    stiffness = np.tile(4.0 * lines * rigidity / cell, 2)
    matrix = (ends.T * stiffness) @ ends
    matrix = matrix + 2.0 * (network.spring_rows.T * network.spring) @ network.spring_rows
    mass = (network.mass_rows.T * network.mass) @ network.mass_rows
    omega = float(np.sqrt(eigh(matrix, mass, eigvals_only=True)[-1]))
    ratio = 0.5 * omega * float((damping / rigidity).max())
    return min(2.0 / float(np.sqrt(own.max())), 2.0 / omega * float(np.sqrt(1.0 + ratio**2) - ratio))
