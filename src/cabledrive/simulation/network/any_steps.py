"""Compiled steps of a network node by node: every law, slack, axial damping."""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place
from cabledrive.simulation.network.coordinates import keep_network_extremes, move_coordinates, place_ends
from cabledrive.simulation.network.plan import (
    AXIAL_LOSS,
    KEPT,
    LOSS,
    PRETENSION,
    RIGIDITY,
    ROPES,
    SLACK_STRAIN,
    SPEED_T,
    SPEED_U,
    TRANSVERSE_LOSS,
    H,
    NetworkPlan,
)
from cabledrive.simulation.network.state import EVENTS, MOST_EVENTS, STEPS, NetworkState, NetworkWorkspace
from cabledrive.simulation.observe import add_to
from cabledrive.simulation.segment_laws import segment_strain, segment_tensions


@njit_in_place
@for_kernels
def step_any_network(plan: NetworkPlan, state: NetworkState, work: NetworkWorkspace, torque: Array) -> bool:
    """Take one step under any law, slack or not; False where slack stops the run, before the step."""
    x, x_t, p = state.x, state.x_t, work.p
    keep_network_extremes(plan, state)
    slack = 0
    for piece in range(plan.nodes.shape[0]):
        first, last = plan.nodes[piece, 0], plan.nodes[piece, 1]
        slack += segment_tensions(
            plan.law,
            plan.tension_only,
            plan.piece[piece, PRETENSION],
            plan.piece[piece, RIGIDITY],
            x[:, first : last + 1],
            plan.inverse_spacing[first:last],
            p[:, first:last],
        )
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
        add_to(state.tallies, int(AXIAL_LOSS), plan.step * damped)
    place_ends(plan, state.q, state.q_t, x, x_t)
    if loss > 0.0:
        add_to(state.tallies, int(TRANSVERSE_LOSS), loss)
    return True


@njit_in_place
@for_kernels
def kick_piece(plan: NetworkPlan, piece: int, x_t: Array, p: Array) -> float:
    """Kick of a piece's inner nodes; what transverse damping takes."""
    run, squares = plan.run[piece], 0.0
    h, keep = run[H], run[KEPT]
    for i in range(plan.nodes[piece, 0] + 1, plan.nodes[piece, 1]):
        x_t[0, i] += run[SPEED_U] * h * (p[0, i] - p[0, i - 1])
        for axis in range(1, 3):
            speed = keep * x_t[axis, i] + run[SPEED_T] * h * (p[axis, i] - p[axis, i - 1])
            squares += (speed + x_t[axis, i]) ** 2
            x_t[axis, i] = speed
    return run[LOSS] * squares


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
    gain = plan.run[piece, SPEED_U] * plan.run[piece, H]
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
    gain = plan.run[piece, SPEED_U] * plan.run[piece, H]
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
    return plan.piece[piece, ROPES] * power


@njit_in_place
@for_kernels
def note_slack_pieces(plan: NetworkPlan, state: NetworkState) -> None:
    """Note when a piece goes slack that was taut at the step before."""
    for piece in range(plan.nodes.shape[0]):
        least = 0.0
        for i in range(plan.nodes[piece, 0], plan.nodes[piece, 1]):
            strain = segment_strain(plan.law, state.x, plan.inverse_spacing, i)
            least = min(least, strain - plan.piece[piece, SLACK_STRAIN])
        if least < 0.0 and state.slack[piece] == 0:
            if state.counts[EVENTS] < MOST_EVENTS:
                event = state.events[state.counts[EVENTS]]
                event[0] = state.counts[STEPS]
                event[1] = piece
                event[2] = (plan.piece[piece, RIGIDITY] + plan.piece[piece, PRETENSION]) * least
            state.counts[EVENTS] += 1
        state.slack[piece] = 1 if least < 0.0 else 0
