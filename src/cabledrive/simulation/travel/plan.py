r"""Numbers of a run in which bodies travel, worked out once, and its largest stable step.

A segment between two cells of stiffness k does at most :math:`k(x_a^2 + x_b^2)` to its ends, one of half a
length at a pulley twice that; so a cell of mass m has at most :math:`\omega^2 = 6k/m` (:math:`8k/m` where it
is alone), and the coordinates have the eigenvalues of their masses with all end segments doubled.
"""

from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.network import Network
from cabledrive.parameters.arrays import Integers

# Columns of TravelPlan.rope. The first is there for the friction of `cabledrive.simulation.network`.
PRETENSION, RIGIDITY, DENSITY, DAMPING, ROPES, WRAP = range(6)

# What stands behind the end of a span: the number of a span, or one of these.
ANCHOR, DRUM = -1, -2

# Tallies of a run, in the order of their columns in a record.
TORQUE_WORK, WEIGHT_WORK, AXIAL_LOSS, VISCOUS_LOSS, COULOMB_LOSS, CREEP_LOSS, WOUND_ENERGY = range(7)
TALLIES = 7

# How steps end besides: a span too short, a rope off its pulley, no line between two pulleys.
TOO_SHORT, OFF_THE_PULLEY, NO_SPAN = range(3, 6)


class TravelPlan(NamedTuple):
    """Numbers of one run. Spans are cut in cells of equal unstretched length, which stand in a row."""

    step: float  # [s]
    winds: bool  # whether a rope comes onto a drum
    prescribed: bool  # whether the turns of the rotors are given, not their torques
    cells: Integers  # (spans + 1,): first cell of each span
    piece: Array  # (spans, 6): -, EA [N], unstretched kg/m, axial damping [N s], ropes, wrap
    shortest: Array  # (spans,): free length down to which the step is stable [m]
    centre: Array  # (spans, 2, 2): centres of what its ends lie on, at q = 0 [m]
    frame: Array  # (spans, 2, 2, n): motion of those centres in x and y
    turn: Array  # (spans, 2, n): speed of the rim along the span by turning
    rim: Array  # (spans, 2): radius with the sense of the rope as its sign [m], 0 at anchors
    beyond: Integers  # (spans, 2): span behind the pulley at each end, ANCHOR or DRUM
    bearing: Array  # (spans, 2): unit vector along each span at q = 0
    gravity: Array  # (2,) [m/s^2]
    mass: Array  # (n, n): of q, with no rope wound on drums since the start
    stiffness: Array  # (n, n): springs
    damping: Array  # (n, n)
    moves: Array  # (n,): 0 of prescribed rotors, else 1
    rest: Array  # (n,): weights, loads and preloads [N]
    rotor: Integers  # (motors,): coordinate of each rotor
    rub: Array  # (frictions, n): what rubs, per speed of q
    smooth: Array  # (frictions,): zeros
    bound: Array  # (frictions,): Coulomb friction [N], [N m]
    wrap: Integers  # (frictions, 2): -1, as no wrap slips
    inverse: Array  # (n, n): of M / step + C / 2 without prescribed rotors; filled at each step
    rub_mobility: Array  # (n, frictions): filled at each step
    rub_own: Array  # (frictions,): filled at each step


class TravelState(NamedTuple):
    """Places at the time of a step, speeds half a step before it, and what was counted."""

    x: Array  # (cells,): distance of the cells from the start of their span [m]
    x_t: Array  # (cells,): speeds of the rope along its span [m/s]
    q: Array  # (n,)
    q_t: Array  # (n,)
    length: Array  # (spans,): unstretched [m]
    flow: Array  # (spans, 2): unstretched length that ran in at the start, out at the end, last step [m]
    wound: Array  # (spans, 2): unstretched length wound on a drum since the start [m]
    tallies: Array  # (2, TALLIES): works and losses [J], and what rounding took from them
    extremes: Array  # (2, n)
    reached: Array  # (2, spans): shortest free length [m], largest friction coefficient needed on the wrap
    events: Array  # (1, 2): span and figure at which the run stopped
    counts: Integers  # (1,): steps done


class TravelWorkspace(NamedTuple):
    """Arrays that are filled anew at each step."""

    before: Array  # (spans, 2): directions of the spans at the step before
    along: Array  # (spans, 2): unit vectors
    free: Array  # (spans,): free lengths [m]
    pull: Array  # (spans, 2, 3): tensions of one rope at both ends, along, - and - [N]
    tension: Array  # (cells + spans,): elastic tensions between cells [N]
    damped: Array  # (cells + spans,): damping tensions [N]
    rate: Array  # (cells,)
    pivot: Array  # (cells,)
    trial: Array  # (cells,)
    rows: Array  # (spans, 2, n): motion of the rope along the span at its ends
    across: Array  # (spans, 2, n): motion of the centres across it
    speed: Array  # (spans, 2): of those rows [m/s]
    matrix: Array  # (2, n, n): M, and M / step + C / 2
    force: Array  # (n,)
    carried: Array  # (n,): force of the rope that turns round pulleys, its own momentum
    fallen: Array  # (n,): force of the ropes' weight across their spans
    right: Array  # (n,)
    new: Array  # (n,)
    friction: Array  # (frictions,)
    bound: Array  # (frictions,)
    torque: Array  # (motors,) [N m]
    kept: Array  # (4, ...): from before a recorded step, see `cabledrive.simulation.travel.kernels`


def new_travel_workspace(plan: TravelPlan) -> TravelWorkspace:
    """Room for what is filled anew at each step."""
    n, spans, cells, rubs = len(plan.mass), len(plan.rim), int(plan.cells[-1]), plan.bound.size
    shapes: tuple[tuple[int, ...], ...] = ((spans, 2), (spans, 2), (spans,), (spans, 2, 3))
    shapes += ((cells + spans,), (cells + spans,), (cells,), (cells,), (cells,))
    shapes += ((spans, 2, n), (spans, 2, n), (spans, 2), (2, n, n), (n,), (n,), (n,), (n,), (n,))
    shapes += ((rubs,), (rubs,), (plan.rotor.size,), (4, max(n, spans, cells, TALLIES)))
    return TravelWorkspace(*(np.zeros(shape) for shape in shapes))


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
    ends = np.concatenate([network.start[::3], network.end[::3]])
    stiffness = np.tile(4.0 * lines * rigidity / cell, 2)
    matrix = (ends.T * stiffness) @ ends + 2.0 * network.springs.matrix
    omega = float(np.sqrt(eigh(matrix, network.masses.matrix, eigvals_only=True)[-1]))
    ratio = 0.5 * omega * float((damping / rigidity).max())
    return min(2.0 / float(np.sqrt(own.max())), 2.0 / omega * float(np.sqrt(1.0 + ratio**2) - ratio))
