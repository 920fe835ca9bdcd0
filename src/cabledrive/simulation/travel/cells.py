"""Compiled motion of cells of rope, bodies, pulleys and rotors over a step."""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit_inner
from cabledrive.simulation.coordinates import dot, invert, rub
from cabledrive.simulation.observe import add_to, copy_rows
from cabledrive.simulation.travel import plan as at
from cabledrive.simulation.travel.plan import TravelPlan, TravelState, TravelWorkspace


@njit_inner
def pull_spans(plan: TravelPlan, state: TravelState, work: TravelWorkspace) -> int:
    """Elastic tensions of all segments and speeds of the ends; the first span that is slack, or -1."""
    slack = -1
    for s in range(plan.rim.shape[0]):
        first, last = plan.cells[s], plan.cells[s + 1]
        cell = state.length[s] / (last - first)
        for side in range(2):
            work.speed[s, side] = dot(work.rows[s, side], state.q_t)
        place = 0.0
        for j in range(last - first + 1):
            beyond = state.x[first + j] if first + j < last else work.free[s]
            own = cell if 0 < j < last - first else 0.5 * cell
            tension = plan.piece[s, at.RIGIDITY] * ((beyond - place) / own - 1.0)
            work.tension[first + s + j] = tension
            if tension < 0.0 and slack < 0:
                slack = s
            place = beyond
    return slack


@njit_inner
def damp_spans(plan: TravelPlan, state: TravelState, work: TravelWorkspace) -> None:
    """Damping tensions on the mean speeds of the cells over the step, which they change; pulls of the ends.

    Implicit, as light cells would ask for a far smaller step; of the ends with the speeds before it.
    """
    for s in range(plan.rim.shape[0]):
        first, last = plan.cells[s], plan.cells[s + 1]
        cell = state.length[s] / (last - first)
        half = 0.5 * plan.step / (plan.piece[s, at.DENSITY] * cell)
        inner, outer = half * plan.piece[s, at.DAMPING] / cell, 2.0 * half * plan.piece[s, at.DAMPING] / cell
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


@njit_inner
def kick_cells(plan: TravelPlan, state: TravelState, work: TravelWorkspace) -> None:
    """New speeds of the rope, with what its damping takes and its weight gives."""
    lost, fallen = 0.0, 0.0
    for s in range(plan.rim.shape[0]):
        first, last = plan.cells[s], plan.cells[s + 1]
        n, lines = last - first, plan.piece[s, at.ROPES]
        mass = plan.piece[s, at.DENSITY] * state.length[s] / n
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
        before, behind = dot(work.rows[s, 0], work.right), dot(work.rows[s, 1], work.right)
        for j in range(n + 1):
            own = behind
            if j < n:
                own = 0.5 * (state.x_t[first + j] + work.trial[first + j])
                fallen += lines * mass * fall * own
            lost += lines * work.damped[first + s + j] * (own - before)
            before = own
        for i in range(first, last):
            state.x_t[i] = work.trial[i]
    add_to(state.tallies, int(at.AXIAL_LOSS), plan.step * lost)
    add_to(state.tallies, int(at.WEIGHT_WORK), plan.step * fallen)


@njit_inner
def fill_inverse(plan: TravelPlan, wound: Array, work: TravelWorkspace) -> None:
    """M with the rope on drums, M / step + C / 2, its inverse but for prescribed rotors, mobilities."""
    n, mass, matrix = plan.mass.shape[0], work.matrix[0], work.matrix[1]
    copy_rows(plan.mass, mass)
    for s in range(plan.rim.shape[0]):
        for side in range(2):
            if plan.beyond[s, side] == at.DRUM:
                on_it = plan.piece[s, at.ROPES] * plan.piece[s, at.DENSITY] * wound[s, side]
                for i in range(n):
                    for k in range(n):
                        mass[i, k] += on_it * plan.turn[s, side, i] * plan.turn[s, side, k]
    for i in range(n):
        for k in range(n):
            matrix[i, k] = mass[i, k] / plan.step + 0.5 * plan.damping[i, k]
    invert(matrix, plan, plan.inverse, plan.rub_mobility, plan.rub_own)


@njit_inner
def gather_ends(plan: TravelPlan, state: TravelState, work: TravelWorkspace) -> None:
    """Forces on the coordinates: springs, weights, the ropes' tensions, and the rope that runs over rims."""
    n = state.q.size
    for i in range(n):
        work.force[i] = plan.rest[i] - dot(plan.stiffness[i], state.q)
        work.carried[i], work.fallen[i] = 0.0, 0.0
    for s in range(plan.rim.shape[0]):
        lines, density = plan.piece[s, at.ROPES], plan.piece[s, at.DENSITY]
        across = plan.gravity[1] * work.along[s, 0] - plan.gravity[0] * work.along[s, 1]
        hangs = 0.5 * lines * density * state.length[s] * across
        for side in range(2):
            sign = 1.0 if side == 0 else -1.0
            cell = state.x_t[plan.cells[s] if side == 0 else plan.cells[s + 1] - 1]
            running = lines * density * state.flow[s, side] / plan.step
            turning = dot(plan.turn[s, side], state.q_t)
            # Rope joins the rim with the speed of its cell, and leaves it with that of the rim.
            pull = sign * lines * work.pull[s, side, 0]
            pull += sign * 0.5 * running * (work.speed[s, side] - cell)
            for k in range(n):
                centre = work.rows[s, side, k] - plan.turn[s, side, k]
                work.force[k] += pull * work.rows[s, side, k]
                work.carried[k] -= sign * running * turning * centre
                work.fallen[k] += hangs * work.across[s, side, k]
    for k in range(n):
        work.force[k] += work.carried[k] + work.fallen[k]


@njit_inner
def turn_coordinates(plan: TravelPlan, state: TravelState, work: TravelWorkspace, given: Array) -> None:
    """New speeds of the coordinates, with the works and losses of the step.

    ``given``: torques of the rotors [N m], or their speeds over the step [rad/s] where they are prescribed.
    """
    n, old, new, matrix = state.q.size, state.q_t, work.new, work.matrix[1]
    gather_ends(plan, state, work)
    for m in range(given.size if not plan.prescribed else 0):
        work.force[plan.rotor[m]] += given[m]
    for i in range(n):
        work.force[i] += 2.0 * dot(work.matrix[0, i], old) / plan.step - dot(matrix[i], old)
        work.right[i] = work.force[i]
        for m in range(given.size if plan.prescribed else 0):
            work.right[i] -= matrix[i, plan.rotor[m]] * given[m]
    for i in range(n):
        new[i] = dot(plan.inverse[i], work.right)
    for m in range(given.size if plan.prescribed else 0):
        new[plan.rotor[m]] = given[m]
    rub(plan, state.q_t, plan.rub_mobility, plan.rub_own, work)
    for m in range(given.size):
        own, torque = plan.rotor[m], given[m]
        if plan.prescribed:
            torque = dot(matrix[own], new) + dot(plan.rub[:, own], work.friction) - work.force[own]
        work.torque[m] = torque
        add_to(state.tallies, int(at.TORQUE_WORK), 0.5 * plan.step * torque * (old[own] + new[own]))
    viscous, coulomb = 0.0, 0.0
    for i in range(n):
        work.right[i] = 0.5 * (old[i] + new[i])
    for i in range(n):
        viscous += dot(plan.damping[i], work.right) * work.right[i]
        coulomb += dot(work.friction, plan.rub[:, i]) * work.right[i]
    add_to(state.tallies, int(at.VISCOUS_LOSS), plan.step * viscous)
    add_to(state.tallies, int(at.COULOMB_LOSS), plan.step * coulomb)
    add_to(state.tallies, int(at.WOUND_ENERGY), -plan.step * dot(work.carried, work.right))
    add_to(state.tallies, int(at.WEIGHT_WORK), plan.step * dot(work.fallen, work.right))
