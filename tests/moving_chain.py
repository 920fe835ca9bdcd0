"""A lumped plant of the rig moved without a loop."""

from typing import NamedTuple

import numpy as np

from cabledrive.rig.closed_loop.chain_kernels import move


class Moving(NamedTuple):
    x: np.ndarray
    terms: np.ndarray


def states_of(plant, commands, hold, start=None, load=0.0):
    """States after each command, held for a time [s], from rest or a state."""
    x = np.zeros(2 * len(plant.inertia) + 1) if start is None else np.array(start, dtype=float)
    s, found = Moving(x, np.zeros((5, len(x)))), []
    for u in commands:
        move(plant, s, float(u), 0.0, 0.0, 0.0, load, 0.0, hold)
        found.append(x.copy())
    return np.array(found)
