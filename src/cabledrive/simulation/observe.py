"""What is counted each step, and what a record holds, compiled.

A row holds for every piece its mean tension, least tension, kinetic energy along and across and strain energy
of its inner nodes, then u, v, w of every probe, energy of the weights, kinetic energy and springs of the
coordinates, works and losses, the balance, places and speeds of the coordinates, and the torques.
"""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_inner, njit_strict
from cabledrive.simulation import channels as column
from cabledrive.simulation import plan as at
from cabledrive.simulation.plan import Plan, State, Workspace
from cabledrive.simulation.segment_laws import add_pulls, end_pulls


@njit_strict
@for_kernels
def balance_of(plan: Plan) -> int:
    """Column of the balance."""
    return 5 * plan.nodes.shape[0] + 3 * plan.probe.shape[0] + 3 + column.TALLIES


@njit_strict
@for_kernels
def add_to(tallies: Array, number: int, amount: float) -> None:
    """Add to a tally, with what rounding took away last time (compensated summation).

    Callers write int(NAME): a named constant by itself would be compiled into a version of its own.
    """
    amount -= tallies[1, number]
    total = tallies[0, number] + amount
    tallies[1, number] = (total - tallies[0, number]) - amount
    tallies[0, number] = total


@njit_inner
def keep_extremes(plan: Plan, state: State) -> None:
    """Least and largest of each coordinate, largest size of v and w at the middle of each piece."""
    x, extremes, peaks = state.x, state.extremes, state.peaks
    for i in range(state.q.size):
        extremes[0, i] = min(extremes[0, i], state.q[i])
        extremes[1, i] = max(extremes[1, i], state.q[i])
    for piece in range(peaks.shape[0]):
        i, share = int(plan.probe[piece, 0]), plan.probe[piece, 1]
        for axis in range(1, 3):
            size = abs((1.0 - share) * x[axis, i] + share * x[axis, i + 1] - plan.probe[piece, 2 + axis])
            peaks[piece, axis - 1] = max(peaks[piece, axis - 1], size)


@njit_inner
def copy_rows(source: Array, target: Array) -> None:
    """Copy an array of rows into another of the same shape."""
    for row in range(source.shape[0]):
        for i in range(source.shape[1]):
            target[row, i] = source[row, i]


@njit_inner
def keep_before(state: State, work: Workspace) -> None:
    """Keep what a record needs from before the kick."""
    copy_rows(state.x, work.before[0])
    copy_rows(state.x_t, work.before[1])
    copy_rows(state.tallies, work.before_tallies)
    for i in range(state.q.size):
        work.before_q[0, i], work.before_q[1, i] = state.q[i], state.q_t[i]


@njit_inner
def observe(plan: Plan, state: State, work: Workspace, torque: Array, row: Array) -> float:
    """Write one row; returns its balance.

    ``work`` holds displacements, velocities and tallies from before the kick, components, tension and energy.
    The energy in the balance is the mean of those of the two half steps beside t_j::

        H(t_j) + |d|^2 / 2 - step / 2 d . F,  d = (velocity after - velocity before) / 2,  F = -dV/dx,

    which leapfrog keeps to round-off for a linear machine, and to a bounded remainder for the others.
    """
    row[:] = 0.0
    x, pieces, probes, n = work.before[0], plan.nodes.shape[0], plan.probe.shape[0], state.q.size
    energy = observe_ropes(plan, state.x_t, work, row)
    for k in range(2 * pieces, 5 * pieces):
        energy += row[k]
    for probe in range(probes):
        i, share = int(plan.probe[probe, 0]), plan.probe[probe, 1]
        for axis in range(3):
            place = (1.0 - share) * x[axis, i] + share * x[axis, i + 1]
            row[5 * pieces + 3 * probe + axis] = place - plan.probe[probe, 2 + axis]
    here = 5 * pieces + 3 * probes
    energy += observe_coordinates(plan, state, work, row[here : here + 3])
    for k in range(3):
        energy += row[here + k]
    for k in range(column.TALLIES):
        value = 0.5 * (work.before_tallies[0, k] + state.tallies[0, k])
        row[here + 3 + k] = value
        energy += -value if k in (column.TORQUE_WORK, column.FORCE_WORK) else value
    here = balance_of(plan)
    row[here] = energy
    for i in range(n):
        row[here + 1 + i] = work.before_q[0, i]
        row[here + 1 + n + i] = 0.5 * (work.before_q[1, i] + state.q_t[i])
    for m in range(torque.size):
        row[here + 1 + 2 * n + m] = torque[m]
    return energy


@njit_inner
def observe_ropes(plan: Plan, after: Array, work: Workspace, row: Array) -> float:
    """Tensions and energies of the pieces; their part of the balance's correction."""
    h, p, mass, pieces = plan.segment[at.SPACING], work.p, plan.node[at.MASS], plan.nodes.shape[0]
    old, correction = work.before[1], 0.0
    for piece in range(pieces):
        first, last, ropes = plan.nodes[piece, 0], plan.nodes[piece, 1], plan.piece[piece, at.ROPES]
        length, mean, least, stored = 0.0, 0.0, 1e300, 0.0
        for i in range(first, last):
            length += h[i]
            mean += work.damp[at.TENSION, i] * h[i]
            stored += work.damp[at.ENERGY, i] * h[i]
            least = min(least, work.damp[at.TENSION, i])
        row[piece], row[pieces + piece] = mean / length, least
        row[4 * pieces + piece] = ropes * stored
        for axis in range(3):
            kinetic, changed = 0.0, 0.0
            for i in range(first + 1, last):
                change = 0.5 * (after[axis, i] - old[axis, i])
                kinetic += 0.5 * mass[i] * (old[axis, i] + change) ** 2
                changed += 0.5 * mass[i] * change * change
                changed -= 0.5 * plan.step * change * (p[axis, i] - p[axis, i - 1])
            row[(2 if axis == 0 else 3) * pieces + piece] += ropes * kinetic
            correction += ropes * changed
    return correction


@njit_inner
def observe_coordinates(plan: Plan, state: State, work: Workspace, energies: Array) -> float:
    """Energy of weights, kinetic energy and springs of the coordinates; their part of the correction."""
    n, x, correction = state.q.size, work.before[0], 0.0
    weight_u, weight_w = plan.node[at.WEIGHT_U], plan.node[at.WEIGHT_W]
    for i in range(weight_u.size):
        energies[0] -= weight_u[i] * x[0, i] + weight_w[i] * x[2, i]
        rate = weight_u[i] * (state.x_t[0, i] - work.before[1, 0, i])
        rate += weight_w[i] * (state.x_t[2, i] - work.before[1, 2, i])
        correction -= 0.25 * plan.step * rate
    for i in range(n):
        work.right[i] = plan.rest[i]
        for k in range(n):
            work.right[i] -= plan.stiffness[i, k] * work.before_q[0, k]
            mean = 0.5 * (work.before_q[1, i] + state.q_t[i]) * 0.5 * (work.before_q[1, k] + state.q_t[k])
            change = 0.5 * (state.q_t[i] - work.before_q[1, i]) * 0.5 * (state.q_t[k] - work.before_q[1, k])
            energies[1] += 0.5 * plan.mass[i, k] * mean
            correction += 0.5 * plan.mass[i, k] * change
            energies[2] += 0.5 * plan.stiffness[i, k] * work.before_q[0, i] * work.before_q[0, k]
        energies[2] -= plan.rest[i] * work.before_q[0, i]
    end_pulls(plan, work.p, work)
    add_pulls(plan, work, work.right)
    for i in range(n):
        correction -= 0.25 * plan.step * (state.q_t[i] - work.before_q[1, i]) * work.right[i]
    return correction
