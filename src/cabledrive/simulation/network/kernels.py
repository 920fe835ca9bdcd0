"""Compiled steps of a network of spans: Stoermer-Verlet on every piece, coordinates between them."""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place
from cabledrive.simulation.network.any_steps import step_any_network
from cabledrive.simulation.network.observing import record_network
from cabledrive.simulation.network.plan import NetworkPlan
from cabledrive.simulation.network.state import STEPS, NetworkState, NetworkWorkspace
from cabledrive.simulation.observe import copy_rows
from cabledrive.simulation.plan import DONE, NOT_FINITE, SLACK


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
        state.counts[STEPS] += 1
        if j % every == 0 and not record_network(plan, state, work, torque[j], rows[j // every]):
            return NOT_FINITE
    return DONE
