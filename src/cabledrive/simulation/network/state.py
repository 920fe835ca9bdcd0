"""What changes from step to step in a network, and room for what does not outlive a step."""

from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.simulation.network.plan import TALLIES, NetworkPlan
from cabledrive.simulation.runs import Integers

MOST_EVENTS = 1000

# Entries of NetworkState.counts.
STEPS, EVENTS = range(2)


class NetworkState(NamedTuple):
    """Displacements at the time of a step, velocities half a step before it, and what was counted."""

    x: Array  # (3, nodes): u, v, w [m]
    x_t: Array  # (3, nodes) [m/s]
    q: Array  # (n,): coordinates [m], [rad]
    q_t: Array  # (n,)
    tallies: Array  # (2, TALLIES): works and losses [J], and what rounding took from them
    extremes: Array  # (2, n): least and largest of each coordinate
    peaks: Array  # (pieces,): largest |w| at the middle [m]
    events: Array  # (MOST_EVENTS, 3): step, piece and least tension [N] where a piece went slack
    slack: Integers  # (pieces,): whether it was slack at the last step
    counts: Integers  # (2,): steps done, events


class NetworkWorkspace(NamedTuple):
    """Arrays without meaning between steps."""

    before: Array  # (2, 3, nodes): displacements, and velocities before the kick, of a recorded step
    before_q: Array  # (2, n)
    before_tallies: Array  # (2, TALLIES)
    p: Array  # (3, nodes - 1): components above the pretension [N]
    pull: Array  # (pieces, 2, 3): those beside both ends
    damping: Array  # (nodes - 1,): damping tensions [N]
    force: Array  # (n,)
    right: Array  # (n,)
    new: Array  # (n,)
    friction: Array  # (frictions,)
    bound: Array  # (frictions,)


def new_network_state(plan: NetworkPlan, x: Array, x_t: Array, q: Array, q_t: Array) -> NetworkState:
    """State at the start of a run; velocities half a step before it."""
    pieces = len(plan.nodes)
    return NetworkState(
        x=np.array(x),
        x_t=np.array(x_t),
        q=np.array(q),
        q_t=np.array(q_t),
        tallies=np.zeros((2, TALLIES)),
        extremes=np.stack([np.full(q.size, np.inf), np.full(q.size, -np.inf)]),
        peaks=np.zeros(pieces),
        events=np.zeros((MOST_EVENTS, 3)),
        slack=np.zeros(pieces, dtype=np.int64),
        counts=np.zeros(2, dtype=np.int64),
    )


def new_network_workspace(plan: NetworkPlan) -> NetworkWorkspace:
    """Work space for a run."""
    nodes, n, pieces = int(plan.nodes[-1, 1]) + 1, len(plan.mass), len(plan.nodes)
    return NetworkWorkspace(
        before=np.zeros((2, 3, nodes)),
        before_q=np.zeros((2, n)),
        before_tallies=np.zeros((2, TALLIES)),
        p=np.zeros((3, nodes - 1)),
        pull=np.zeros((pieces, 2, 3)),
        damping=np.zeros(nodes - 1),
        force=np.zeros(n),
        right=np.zeros(n),
        new=np.zeros(n),
        friction=np.zeros(plan.bound.size),
        bound=np.zeros(plan.bound.size),
    )
