"""Compiled forces and speeds of the cells of rope in their spans: elastic, damped, heavy."""

from cabledrive.mechanics.compiled import for_kernels, njit_in_place
from cabledrive.simulation.observe import add_to
from cabledrive.simulation.travel.plan import (
    AXIAL_LOSS,
    DAMPING,
    DENSITY,
    RIGIDITY,
    ROPES,
    WEIGHT_WORK,
    TravelPlan,
    TravelState,
    TravelWorkspace,
)


@njit_in_place
@for_kernels
def pull_spans(plan: TravelPlan, state: TravelState, work: TravelWorkspace) -> int:
    """Elastic tensions of all segments and speeds of the ends; the first span that is slack, or -1."""
    slack = -1
    for s in range(plan.rim.shape[0]):
        first, last = plan.cells[s], plan.cells[s + 1]
        cell = state.length[s] / (last - first)
        for side in range(2):
            speed = 0.0
            for k in range(state.q.size):
                speed += work.rows[s, side, k] * state.q_t[k]
            work.speed[s, side] = speed
        place = 0.0
        for j in range(last - first + 1):
            beyond = state.x[first + j] if first + j < last else work.free[s]
            own = cell if 0 < j < last - first else 0.5 * cell
            tension = plan.piece[s, RIGIDITY] * ((beyond - place) / own - 1.0)
            work.tension[first + s + j] = tension
            if tension < 0.0 and slack < 0:
                slack = s
            place = beyond
    return slack


@njit_in_place
@for_kernels
def damp_spans(plan: TravelPlan, state: TravelState, work: TravelWorkspace) -> None:
    """Damping tensions on the mean speeds of the cells over the step, which they change; pulls of the ends.

    Implicit, as light cells would ask for a far smaller step; of the ends with the speeds before it.
    """
    for s in range(plan.rim.shape[0]):
        first, last = plan.cells[s], plan.cells[s + 1]
        cell = state.length[s] / (last - first)
        half = 0.5 * plan.step / (plan.piece[s, DENSITY] * cell)
        inner, outer = half * plan.piece[s, DAMPING] / cell, 2.0 * half * plan.piece[s, DAMPING] / cell
        fall = plan.gravity[0] * work.along[s, 0] + plan.gravity[1] * work.along[s, 1]
        for i in range(first, last):
            j = i + s
            left, right = inner if i > first else outer, inner if i + 1 < last else outer
            known = state.x_t[i] + half * (work.tension[j + 1] - work.tension[j]) + 0.5 * plan.step * fall
            pivot = 1.0 + left + right
            if i > first:
                pivot -= left * left / work.pivot[i - 1]
                known += left / work.pivot[i - 1] * work.rate[i - 1]
            else:
                known += left * work.speed[s, 0]
            if i + 1 == last:
                known += right * work.speed[s, 1]
            work.pivot[i], work.rate[i] = pivot, known
        behind = work.speed[s, 1]
        for i in range(last - 1, first - 1, -1):
            own = work.rate[i]
            if i + 1 < last:
                own += inner * behind
            own /= work.pivot[i]
            right = inner if i + 1 < last else outer
            work.damped[i + 1 + s] = right / half * (behind - own)
            behind = own
        work.damped[first + s] = outer / half * (behind - work.speed[s, 0])
        for side, j in ((0, first + s), (1, last + s)):
            work.pull[s, side, 0] = work.tension[j] + work.damped[j]


@njit_in_place
@for_kernels
def kick_cells(plan: TravelPlan, state: TravelState, work: TravelWorkspace) -> None:
    """New speeds of the rope, with what its damping takes and its weight gives."""
    lost, fallen = 0.0, 0.0
    for s in range(plan.rim.shape[0]):
        first, last = plan.cells[s], plan.cells[s + 1]
        n, lines = last - first, plan.piece[s, ROPES]
        mass = plan.piece[s, DENSITY] * state.length[s] / n
        fall = plan.gravity[0] * work.along[s, 0] + plan.gravity[1] * work.along[s, 1]
        for i in range(first, last):
            j = i + s
            pulled = work.tension[j + 1] + work.damped[j + 1] - work.tension[j] - work.damped[j]
            work.rate[i] = state.x_t[i] + plan.step * (pulled / mass + fall)
            work.trial[i] = work.rate[i]
        for _sweep in range(2):  # rope that runs past the cells: midpoint rule, two rounds are enough
            before = work.speed[s, 0]
            for i in range(first, last):
                face = (i - first) / n
                left = (1.0 - face) * state.flow[s, 0] + face * state.flow[s, 1]
                right = left + (state.flow[s, 1] - state.flow[s, 0]) / n
                own = 0.5 * (state.x_t[i] + work.trial[i])
                behind = work.speed[s, 1]
                if i + 1 < last:
                    behind = 0.5 * (state.x_t[i + 1] + work.trial[i + 1])
                moved = left * (own - before) + right * (behind - own)
                before = own
                work.trial[i] = work.rate[i] - 0.5 * moved * n / state.length[s]
        before, behind = 0.0, 0.0
        for k in range(state.q.size):
            mean = 0.5 * (state.q_t[k] + work.new[k])
            before += work.rows[s, 0, k] * mean
            behind += work.rows[s, 1, k] * mean
        for j in range(n + 1):
            own = behind
            if j < n:
                own = 0.5 * (state.x_t[first + j] + work.trial[first + j])
                fallen += lines * mass * fall * own
            lost += lines * work.damped[first + s + j] * (own - before)
            before = own
        for i in range(first, last):
            state.x_t[i] = work.trial[i]
    add_to(state.tallies, int(AXIAL_LOSS), plan.step * lost)
    add_to(state.tallies, int(WEIGHT_WORK), plan.step * fallen)
