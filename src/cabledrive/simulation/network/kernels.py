"""Compiled steps of a network of spans: Stoermer-Verlet on every piece, coordinates between them.

Taut pieces under the exact law take the loop's own pass, `cabledrive.simulation.kernels.taut_steps.move_run`;
other laws, slack and axial damping take `cabledrive.simulation.network.any_steps`, with the loop's laws.
"""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place
from cabledrive.simulation.kernels.segments import EXACT
from cabledrive.simulation.kernels.shafts import add_to
from cabledrive.simulation.kernels.steps import copy_rows
from cabledrive.simulation.kernels.taut_steps import move_run
from cabledrive.simulation.network.any_steps import step_any_network
from cabledrive.simulation.network.coordinates import keep_network_extremes, move_coordinates, place_ends
from cabledrive.simulation.network.observing import record_network
from cabledrive.simulation.network.plan import PRETENSION, TRANSVERSE_LOSS, NetworkPlan
from cabledrive.simulation.network.state import STEPS, NetworkState, NetworkWorkspace
from cabledrive.simulation.runs import GAIN, LOSS, H

DONE, SLACK, NOT_FINITE = range(3)


@njit_in_place
@for_kernels
def pull_of(
    run: Array, pretension: float, u: Array, v: Array | None, w: Array, i: int
) -> tuple[float, float, float]:
    """Components above the pretension of one taut segment under the exact law, by the loop's series [N]."""
    h = run[H]
    du, dw, dv = u[i + 1] - u[i], w[i + 1] - w[i], 0.0
    y = du * (2.0 * h + du) + dw * dw
    if v is not None:
        dv = v[i + 1] - v[i]
        y += dv * dv
    gain = run[GAIN + 7]
    for power in range(6, -1, -1):
        gain = run[GAIN + power] + y * gain
    gain *= y
    pull = pretension + gain
    return (pull * du + gain * h) / h, pull * dv / h, pull * dw / h


@njit_in_place
@for_kernels
def step_taut_network(
    plan: NetworkPlan,
    state: NetworkState,
    work: NetworkWorkspace,
    torque: Array,
    still: Array,
    u: Array,
    v: Array | None,
    w: Array,
    u_t: Array,
    v_t: Array | None,
    w_t: Array,
) -> bool:
    """Take a step per row of ``torque``; False once a segment is slack or out of the range of the series."""
    x_t, pieces = state.x_t, plan.nodes.shape[0]
    for j in range(torque.shape[0]):
        keep_network_extremes(plan, state)
        for piece in range(pieces):
            for side in range(2):
                segment = plan.nodes[piece, 0] if side == 0 else plan.nodes[piece, 1] - 1
                p_u, p_v, p_w = pull_of(plan.run[piece], plan.piece[piece, PRETENSION], u, v, w, segment)
                work.pull[piece, side, 0] = p_u
                work.pull[piece, side, 1] = p_v
                work.pull[piece, side, 2] = p_w
        move_coordinates(plan, torque[j], state, work)
        loss, outside = 0.0, 0
        for piece in range(pieces):
            first, last = plan.nodes[piece, 0], plan.nodes[piece, 1]
            h = plan.run[piece, H]
            old_v, old_w = x_t[1, first], x_t[2, first]
            # The first node is put right after: as if its segment pulled from before as well.
            beyond, squares = move_run(
                first, last, plan.run[piece], plan.piece[piece, PRETENSION], plan.step,
                h * work.pull[piece, 0, 0], h * work.pull[piece, 0, 1], h * work.pull[piece, 0, 2],
                still, u, v, w, u_t, v_t, w_t,
            )  # fmt: skip
            outside += beyond
            squares -= (x_t[1, first] + old_v) ** 2 + (x_t[2, first] + old_w) ** 2
            loss += plan.run[piece, LOSS] * squares
        if outside > 0:
            return False
        place_ends(plan, state.q, state.q_t, state.x, x_t)
        if loss > 0.0:
            add_to(state.tallies, int(TRANSVERSE_LOSS), loss)
    return True


@njit_in_place
@for_kernels
def keep_before_network(state: NetworkState, work: NetworkWorkspace) -> None:
    """Keep what a record, or a second try of its steps, needs from before."""
    copy_rows(state.x, work.before[0])
    copy_rows(state.x_t, work.before[1])
    copy_rows(state.tallies, work.before_tallies)
    for i in range(state.q.size):
        work.before_q[0, i] = state.q[i]
        work.before_q[1, i] = state.q_t[i]


@njit_in_place
@for_kernels
def take_back(state: NetworkState, work: NetworkWorkspace, steps: int) -> None:
    """The state as it was kept, ``steps`` before."""
    state.counts[STEPS] -= steps
    copy_rows(work.before[0], state.x)
    copy_rows(work.before[1], state.x_t)
    copy_rows(work.before_tallies, state.tallies)
    for i in range(state.q.size):
        state.q[i] = work.before_q[0, i]
        state.q_t[i] = work.before_q[1, i]


@njit_in_place
def integrate_network(
    plan: NetworkPlan,
    state: NetworkState,
    work: NetworkWorkspace,
    torque: Array,
    every: int,
    rows: Array,
    still: Array,
    u: Array,
    v: Array | None,
    w: Array,
    u_t: Array,
    v_t: Array | None,
    w_t: Array,
) -> int:
    """Take a step per row of ``torque``, recording the first of every ``every``.

    ``still``: zeros, one a node. Returns DONE, SLACK (before the step at whose start a piece is slack) or
    NOT_FINITE (after the record that shows it).
    """
    for record in range(torque.shape[0] // every):
        first = record * every
        keep_before_network(state, work)
        taut, part, finite = plan.law == EXACT and not plan.axially_damped, 0, True
        while part < 2:  # the step that is recorded, then the others: one place each for the compiler
            start, stop = (first, first + 1) if part == 0 else (first + 1, first + every)
            if taut:
                taut = step_taut_network(plan, state, work, torque[start:stop], still, u, v, w, u_t, v_t, w_t)
                if not taut:
                    take_back(state, work, start - first)
                    part = 0
                    continue
                state.counts[STEPS] += stop - start
            else:
                for j in range(start, stop):
                    if not step_any_network(plan, state, work, torque[j]):
                        return SLACK
                    state.counts[STEPS] += 1
            if part == 0:
                finite = record_network(plan, state, work, torque[first], rows[record])
            part += 1
        if taut:
            state.slack[:] = 0
        if not finite:
            return NOT_FINITE
    return DONE
