"""Room for intermediate results of a step, made once per run."""

from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.simulation.channels import TALLIES
from cabledrive.simulation.plan import Plan

# Rows of Workspace.shaft.
OLD, NEW, FORCE, RIGHT, FRICTION = range(5)

# Rows of Workspace.q while a record is written.
TENSION, ENERGY = range(2)

# Rows of Workspace.stop.
BEFORE, AFTER, PLACE = range(3)


class Workspace(NamedTuple):
    """Arrays without meaning between steps."""

    before: Array  # (2, 3, nodes): displacements, and velocities before the kick, of a recorded step
    before_motor: Array  # (2,)
    before_tallies: Array  # (2, TALLIES)
    p: Array  # (3, segments): components of the segments above the pretension [N]
    old: Array  # (3, nodes): velocities before the kick
    mean: Array  # (3, nodes): mean velocities over the step
    direction: Array  # (3, segments): along which the segments are damped
    q: Array  # (4, segments): damping tensions and pivots; for a record, tension and energy per length
    shaft: Array  # (5, 3): old speed, new speed, force, right side, friction
    matrix: Array  # (3, 3)
    stop: Array  # (3, 3, stops): velocities before and after the step, and places before it, of the stops


def new_workspace(plan: Plan) -> Workspace:
    """Work space for a run."""
    segments = plan.segment.shape[1]
    return Workspace(
        before=np.zeros((2, 3, segments + 1)),
        before_motor=np.zeros(2),
        before_tallies=np.zeros((2, TALLIES)),
        p=np.zeros((3, segments)),
        old=np.zeros((3, segments + 1)),
        mean=np.zeros((3, segments + 1)),
        direction=np.zeros((3, segments)),
        q=np.zeros((4, segments)),
        shaft=np.zeros((5, 3)),
        matrix=np.zeros((3, 3)),
        stop=np.zeros((3, 3, plan.stop.size)),
    )
