"""Compiled steps of a network of spans, and the record of one instant."""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place
from cabledrive.simulation.network import plan as at
from cabledrive.simulation.network.coordinates import keep_network_extremes, move_coordinates, place_ends
from cabledrive.simulation.network.plan import NetworkPlan, NetworkState, NetworkWorkspace
from cabledrive.simulation.observe import add_to, copy_rows
from cabledrive.simulation.plan import DONE, NOT_FINITE, SLACK
from cabledrive.simulation.segment_laws import Rope, segment_energy, segment_strain, segment_tensions


@njit_in_place
@for_kernels
def rope_of_piece(plan: NetworkPlan, piece: int) -> Rope:
    """What the laws take of one rope of a piece."""
    return plan.law, plan.tension_only, plan.piece[piece, at.PRETENSION], plan.piece[piece, at.RIGIDITY]


@njit_in_place
@for_kernels
def piece_tensions(plan: NetworkPlan, piece: int, x: Array, p: Array) -> int:
    """Components above the pretension along a piece, into ``p``; the number of slack segments."""
    first, last = plan.nodes[piece, 0], plan.nodes[piece, 1]
    inverse = plan.inverse_spacing[first:last]
    return segment_tensions(rope_of_piece(plan, piece), x[:, first : last + 1], inverse, p[:, first:last])


@njit_in_place
@for_kernels
def step_any_network(plan: NetworkPlan, state: NetworkState, work: NetworkWorkspace, torque: Array) -> bool:
    """Take one step under any law, slack or not; False where slack stops the run, before the step."""
    x, x_t, p = state.x, state.x_t, work.p
    keep_network_extremes(plan, state)
    slack = 0
    for piece in range(plan.nodes.shape[0]):
        first, last = plan.nodes[piece, 0], plan.nodes[piece, 1]
        slack += piece_tensions(plan, piece, x, p)
        for axis in range(3):
            work.pull[piece, 0, axis] = p[axis, first]
            work.pull[piece, 1, axis] = p[axis, last - 1]
    if slack > 0 or state.slack.any():
        note_slack_pieces(plan, state)
    if slack > 0 and plan.stop_when_slack:
        return False
    loss, damped = 0.0, 0.0
    for piece in range(plan.nodes.shape[0]):
        loss += kick_piece(plan, piece, x_t, p)
        if plan.compliance[piece] > 0.0:
            start_damping(plan, piece, x_t[0], p[0], work)
    move_coordinates(plan, torque, state, work)
    for piece in range(plan.nodes.shape[0]):
        if plan.compliance[piece] > 0.0:
            damped += end_damping(plan, piece, x_t[0], state.q_t, work)
        drift_piece(plan, piece, x, x_t)
    if damped > 0.0:
        add_to(state.tallies, int(at.AXIAL_LOSS), plan.step * damped)
    place_ends(plan, state.q, state.q_t, x, x_t)
    if loss > 0.0:
        add_to(state.tallies, int(at.TRANSVERSE_LOSS), loss)
    return True


@njit_in_place
@for_kernels
def kick_piece(plan: NetworkPlan, piece: int, x_t: Array, p: Array) -> float:
    """Kick of a piece's inner nodes; what transverse damping takes."""
    run, squares = plan.run[piece], 0.0
    h, keep = run[at.H], run[at.KEPT]
    for i in range(plan.nodes[piece, 0] + 1, plan.nodes[piece, 1]):
        x_t[0, i] += run[at.SPEED_U] * h * (p[0, i] - p[0, i - 1])
        for axis in range(1, 3):
            speed = keep * x_t[axis, i] + run[at.SPEED_T] * h * (p[axis, i] - p[axis, i - 1])
            squares += (speed + x_t[axis, i]) ** 2
            x_t[axis, i] = speed
    return run[at.LOSS] * squares


@njit_in_place
@for_kernels
def drift_piece(plan: NetworkPlan, piece: int, x: Array, x_t: Array) -> None:
    """Displacements of a piece's inner nodes a step on."""
    for axis in range(3):
        for i in range(plan.nodes[piece, 0] + 1, plan.nodes[piece, 1]):
            x[axis, i] += plan.step * x_t[axis, i]


@njit_in_place
@for_kernels
def start_damping(plan: NetworkPlan, piece: int, u_t: Array, p: Array, work: NetworkWorkspace) -> None:
    """Damping tensions of a piece between ends at rest, from the mean speeds of its kicked nodes."""
    first, last, q, pivot = plan.nodes[piece, 0], plan.nodes[piece, 1], work.damping, plan.damper[0]
    gain = plan.run[piece, at.SPEED_U] * plan.run[piece, at.H]
    before = 0.0
    for i in range(first, last):
        mean = 0.0 if i == last - 1 else u_t[i + 1] - 0.5 * gain * (p[i + 1] - p[i])
        q[i] = mean - before
        before = mean
        if i > first:
            q[i] += 0.5 * gain / pivot[i - 1] * q[i - 1]
    q[last - 1] /= pivot[last - 1]
    for i in range(last - 2, first - 1, -1):
        q[i] = (q[i] + 0.5 * gain * q[i + 1]) / pivot[i]
    work.pull[piece, 0, 0] += q[first]
    work.pull[piece, 1, 0] += q[last - 1]


@njit_in_place
@for_kernels
def end_damping(plan: NetworkPlan, piece: int, u_t: Array, q_t: Array, work: NetworkWorkspace) -> float:
    """Damping tensions with the ends' mean speeds, and what they do to the nodes; the power they take."""
    first, last, q = plan.nodes[piece, 0], plan.nodes[piece, 1], work.damping
    gain = plan.run[piece, at.SPEED_U] * plan.run[piece, at.H]
    start, end = 0.5 * u_t[first], 0.5 * u_t[last]  # speeds before the step still stand there
    for side in range(2):
        row = 6 * piece + 3 * side
        for entry in range(plan.row_start[row], plan.row_start[row + 1]):
            part = 0.5 * plan.row_value[entry] * q_t[plan.row_column[entry]]
            if side == 0:
                start += part
            else:
                end += part
    power = 0.0
    for i in range(first, last):
        q[i] += plan.damper[1, i] * start + plan.damper[2, i] * end
        power += plan.compliance[piece] * q[i] * q[i]
        if i > first:
            u_t[i] += gain * (q[i] - q[i - 1])
    return plan.piece[piece, at.ROPES] * power


@njit_in_place
@for_kernels
def note_slack_pieces(plan: NetworkPlan, state: NetworkState) -> None:
    """Note when a piece goes slack that was taut at the step before."""
    for piece in range(plan.nodes.shape[0]):
        least = 0.0
        for i in range(plan.nodes[piece, 0], plan.nodes[piece, 1]):
            strain = segment_strain(plan.law, state.x, plan.inverse_spacing, i)
            least = min(least, strain - plan.piece[piece, at.SLACK_STRAIN])
        if least < 0.0 and state.slack[piece] == 0:
            if state.counts[at.EVENTS] < at.MOST_EVENTS:
                event = state.events[state.counts[at.EVENTS]]
                event[0] = state.counts[at.STEPS]
                event[1] = piece
                event[2] = (plan.piece[piece, at.RIGIDITY] + plan.piece[piece, at.PRETENSION]) * least
            state.counts[at.EVENTS] += 1
        state.slack[piece] = 1 if least < 0.0 else 0


@njit_in_place
@for_kernels
def record_network(
    plan: NetworkPlan, state: NetworkState, work: NetworkWorkspace, torque: Array, row: Array
) -> bool:
    """Write one row, see `cabledrive.simulation.network.case`; whether its balance is finite.

    The energy in the balance is the mean of those of the two half steps beside the instant, which leapfrog
    keeps to round-off for a linear machine: H + d . d / 2 - step/2 d . F with half the change d of the
    speeds.
    """
    n, pieces, motors = state.q.size, plan.nodes.shape[0], torque.size
    ropes_energy, strain, correction = 0.0, 0.0, 0.0
    tension, middle = 2 * n + motors, 2 * n + motors + 2 * pieces
    for piece in range(pieces):
        first, last = plan.nodes[piece, 0], plan.nodes[piece, 1]
        x = work.before[0]
        piece_tensions(plan, piece, x, work.p)
        kinetic, changed = rope_motion(plan, piece, work, state.x_t)
        mean, least, stored = rope_strain(plan, piece, work)
        ropes_energy += kinetic
        correction += changed
        strain += stored
        row[tension + piece] = mean
        row[tension + pieces + piece] = least
        low, high = (first + last) // 2, (first + last + 1) // 2
        for axis in range(3):
            row[middle + 3 * piece + axis] = 0.5 * (x[axis, low] + x[axis, high])
    energies = middle + 3 * pieces
    bodies, springs, part = coordinate_energies(plan, state, work)
    for i in range(n):
        row[i] = work.before_q[0, i]
        row[n + i] = 0.5 * (work.before_q[1, i] + state.q_t[i])
    for m in range(motors):
        row[2 * n + m] = torque[m]
    row[energies] = ropes_energy
    row[energies + 1] = bodies
    row[energies + 2] = strain
    row[energies + 3] = springs
    balance = ropes_energy + bodies + strain + springs + correction + part
    for k in range(at.TALLIES):
        value = 0.5 * (work.before_tallies[0, k] + state.tallies[0, k])
        row[energies + 4 + k] = value
        balance += -value if k == at.TORQUE_WORK else value
    row[energies + 4 + at.TALLIES] = balance
    return abs(balance) < 1e300


@njit_in_place
@for_kernels
def rope_motion(plan: NetworkPlan, piece: int, work: NetworkWorkspace, after: Array) -> tuple[float, float]:
    """Kinetic energy of a piece's inner nodes; their part of the correction."""
    half = 0.5 * plan.piece[piece, at.DENSITY] * plan.run[piece, at.H]
    kinetic, correction = 0.0, 0.0
    for axis in range(3):
        for i in range(plan.nodes[piece, 0] + 1, plan.nodes[piece, 1]):
            old = work.before[1, axis, i]
            change = 0.5 * (after[axis, i] - old)
            kinetic += half * (old + change) ** 2
            correction += half * change * change
            correction -= 0.5 * plan.step * change * (work.p[axis, i] - work.p[axis, i - 1])
    return plan.piece[piece, at.ROPES] * kinetic, plan.piece[piece, at.ROPES] * correction


@njit_in_place
@for_kernels
def rope_strain(plan: NetworkPlan, piece: int, work: NetworkWorkspace) -> tuple[float, float, float]:
    """Mean and least tension of one rope of a piece, and the energy that all its ropes store."""
    x, h, rope = work.before[0], plan.run[piece, at.H], rope_of_piece(plan, piece)
    first, last = plan.nodes[piece, 0], plan.nodes[piece, 1]
    mean, least, stored = 0.0, 1e300, 0.0
    for i in range(first, last):
        pull, density = segment_energy(rope, x, plan.inverse_spacing, i)
        mean += pull
        least = min(least, pull)
        stored += density * h
    return mean / (last - first), least, plan.piece[piece, at.ROPES] * stored


@njit_in_place
@for_kernels
def coordinate_energies(
    plan: NetworkPlan, state: NetworkState, work: NetworkWorkspace
) -> tuple[float, float, float]:
    """Kinetic energy of bodies, pulleys and half cells; energy of springs; part of the correction."""
    n = state.q.size
    kinetic, springs, correction = 0.0, 0.0, 0.0
    for i in range(n):
        work.right[i] = plan.rest[i]
        for k in range(n):
            work.right[i] -= plan.stiffness[i, k] * work.before_q[0, k]
            mean = 0.5 * (work.before_q[1, i] + state.q_t[i]) * 0.5 * (work.before_q[1, k] + state.q_t[k])
            change = 0.5 * (state.q_t[i] - work.before_q[1, i]) * 0.5 * (state.q_t[k] - work.before_q[1, k])
            kinetic += 0.5 * plan.mass[i, k] * mean
            correction += 0.5 * plan.mass[i, k] * change
            springs += 0.5 * plan.stiffness[i, k] * work.before_q[0, i] * work.before_q[0, k]
        springs -= plan.rest[i] * work.before_q[0, i]
    for piece in range(plan.nodes.shape[0]):
        for side in range(2):
            segment = plan.nodes[piece, 0] if side == 0 else plan.nodes[piece, 1] - 1
            sign = plan.piece[piece, at.ROPES] if side == 0 else -plan.piece[piece, at.ROPES]
            for axis in range(3):
                row = 6 * piece + 3 * side + axis
                for entry in range(plan.row_start[row], plan.row_start[row + 1]):
                    work.right[plan.row_column[entry]] += sign * plan.row_value[entry] * work.p[axis, segment]
    for i in range(n):
        correction -= 0.25 * plan.step * (state.q_t[i] - work.before_q[1, i]) * work.right[i]
    return kinetic, springs, correction


@njit_in_place
@for_kernels
def keep_before_network(state: NetworkState, work: NetworkWorkspace) -> None:
    """Keep what a record needs from before the kick."""
    copy_rows(state.x, work.before[0])
    copy_rows(state.x_t, work.before[1])
    copy_rows(state.tallies, work.before_tallies)
    for i in range(state.q.size):
        work.before_q[0, i] = state.q[i]
        work.before_q[1, i] = state.q_t[i]


@njit_in_place
def integrate_network(
    plan: NetworkPlan, state: NetworkState, work: NetworkWorkspace, torque: Array, every: int, rows: Array
) -> int:
    """Take a step per row of ``torque``, recording the first of every ``every``.

    Returns DONE, SLACK (before the step at whose start a piece is slack) or NOT_FINITE (after the record that
    shows it).
    """
    for j in range(torque.shape[0]):
        if j % every == 0:
            keep_before_network(state, work)
        if not step_any_network(plan, state, work, torque[j]):
            return SLACK
        state.counts[at.STEPS] += 1
        if j % every == 0 and not record_network(plan, state, work, torque[j], rows[j // every]):
            return NOT_FINITE
    return DONE
