r"""The step of the energy-conserving scheme, compiled: components scaled so that energy is conserved.

.. math:: c_j = \frac{\psi_{j+1/2} + \psi_{j-1/2}}{2\sqrt{2(V(x_j) + C)}}, \qquad
          E_{j+1/2} - E_{j-1/2} = -c_j F(x_j)\cdot\frac{x_{j+1} - x_{j-1}}{2}, \qquad \psi = \sqrt{2(E + C)}

for the energy V beyond the linear one and its forces F, Eqs. (L.1)-(L.3).
"""

from math import sqrt

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_inner, njit_strict
from cabledrive.simulation import plan as at
from cabledrive.simulation.channels import (
    AXIAL_LOSS,
)
from cabledrive.simulation.coordinates import gather, place_ends
from cabledrive.simulation.node_motion import kick_nodes, turn_and_damp
from cabledrive.simulation.observe import add_to, copy_rows
from cabledrive.simulation.plan import Plan, State, Workspace
from cabledrive.simulation.segment_laws import add_pulls, end_pulls, gradients, transverse_stretch

MOST_TRIALS, SETTLED = 20, 1e-12


@njit_inner
def step_with_energy(
    plan: Plan, state: State, extra: Array, work: Workspace, torque: Array, forces: Array
) -> None:
    """One step: the nodes answer linearly to the force scale, coordinates and dampers are tried."""
    x, x_t, q, q_t, rest = state.x, state.x_t, state.q, state.q_t, work.rest
    last, free, old, n = x.shape[1] - 1, work.free, work.old, state.q.size
    add_linear(plan, x, work.p, rest, -1.0)
    energy = nonlinear_energy(plan, x)
    while min(energy, extra[at.STORED]) + extra[at.SHIFT] < 0.5 * extra[at.SHIFT]:
        extra[at.SHIFT] *= 2.0
    root, psi = sqrt(2.0 * (energy + extra[at.SHIFT])), sqrt(2.0 * (extra[at.STORED] + extra[at.SHIFT]))
    scale = 0.5 * plan.step / root
    for axis in range(3):
        for i in range(last):
            work.p[axis, i] -= rest[axis, i]
    kick_nodes(plan, x_t, work, forces)
    end_pulls(plan, work.p, work)
    gather(plan, q, torque, work)
    end_pulls(plan, rest, work)
    for i in range(n):
        work.trial[0, i], work.trial[1, i] = work.force[i], 0.0
    add_pulls(plan, work, work.trial[1])
    met, answer, damped = 0.0, 0.0, plan.axial != at.UNDAMPED
    for axis in range(3):
        for i in range(1, last):
            kick = plan.node[at.KICK_U if axis == 0 else at.KICK_T, i]
            force = rest[axis, i] - rest[axis, i - 1] if kick > 0.0 else 0.0
            met += force * (old[axis, i] + x_t[axis, i])
            answer += kick * force * force
    if damped:
        copy_rows(x_t, free)
    change, result, c = 0.0, 0.0, 1.0
    for trial in range(MOST_TRIALS):
        c = (psi + 0.5 * change) / root
        for i in range(n):
            work.force[i] = work.trial[0, i] + c * work.trial[1, i]
        work.lost[:] = 0.0
        if damped:
            scaled_kick(plan, free, x_t, rest, c)
        turn_and_damp(plan, q_t, x_t, work.lost, work)
        if damped:
            place_ends(plan, q, work.new, x, x_t)
            result = scale * (power(rest, old) + power(rest, x_t))
        else:
            moved = met + c * answer
            for i in range(n):
                moved += work.trial[1, i] * (q_t[i] + work.new[i])
            result = -scale * moved
        if abs(result - change) <= SETTLED * abs(result) or trial == MOST_TRIALS - 1:
            break
        change += (result - change) / (1.0 + 0.5 * scale / root * answer)
    if not damped:
        scaled_kick(plan, x_t, x_t, rest, c)
    if work.lost[0, int(AXIAL_LOSS)] != 0.0:
        add_to(state.tallies, int(AXIAL_LOSS), work.lost[0, int(AXIAL_LOSS)])
    extra[at.STORED] = sum_with_loss(extra, at.STORED_LOST, extra[at.STORED], result * (psi + 0.5 * change))
    # A rim turns far while forces on it are large: what rounding takes there would be work nobody does.
    for i in range(n):
        work.trial[0, i] = sum_with_loss(extra, at.PLACES_LOST + i, q[i], plan.step * work.new[i])


@njit_inner
def place_compensated(state: State, work: Workspace) -> None:
    """Places of the coordinates after the step, with what rounding took of them."""
    for i in range(state.q.size):
        state.q[i] = work.trial[0, i]


@njit_inner
def scaled_kick(plan: Plan, free: Array, x_t: Array, rest: Array, c: float) -> None:
    """Velocities after the kick of the components beyond the linear law, scaled by ``c``."""
    for axis in range(3):
        kick = plan.node[at.KICK_U if axis == 0 else at.KICK_T]
        for i in range(1, rest.shape[1]):
            x_t[axis, i] = free[axis, i] + c * kick[i] * (rest[axis, i] - rest[axis, i - 1])


@njit_strict
@for_kernels
def sum_with_loss(extra: Array, number: int, value: float, amount: float) -> float:
    """Value plus amount, and what rounding took away last time; keeps what it takes away now."""
    amount -= extra[number]
    total = value + amount
    extra[number] = (total - value) - amount
    return total


@njit_inner
def add_linear(plan: Plan, x: Array, p: Array, out: Array, sign: float) -> None:
    """Components plus or minus those of the linear law."""
    for axis in range(3):
        along = plan.piece[0, at.RIGIDITY] if axis == 0 else 0.0
        stiffness = sign * (plan.piece[0, at.PRETENSION] + along)
        for i in range(p.shape[1]):
            slope = (x[axis, i + 1] - x[axis, i]) * plan.segment[at.INVERSE_SPACING, i]
            out[axis, i] = p[axis, i] + stiffness * slope


@njit_inner
def power(rest: Array, x_t: Array) -> float:
    """Power of components on the differences of velocities."""
    total = 0.0
    for axis in range(3):
        for i in range(rest.shape[1]):
            total += rest[axis, i] * (x_t[axis, i + 1] - x_t[axis, i])
    return total


@njit_inner
def nonlinear_energy(plan: Plan, x: Array) -> float:
    """Elastic energy beyond that of the linear law."""
    total, rigidity = 0.0, plan.piece[0, at.RIGIDITY]
    rigidity += 0.0 if plan.law == at.EXACT else plan.piece[0, at.PRETENSION]
    if plan.law == at.LINEAR:
        return 0.0
    for i in range(x.shape[1] - 1):
        u_x, v_x, w_x = gradients(x, plan.segment[at.INVERSE_SPACING], i)
        slopes = transverse_stretch(plan.law, u_x, v_x, w_x)
        total += plan.segment[at.SPACING, i] * slopes * (2.0 * u_x + slopes)
    return 0.5 * rigidity * total


@njit_inner
def own_balance(plan: Plan, work: Workspace, after: Array, stored: float) -> float:
    """What the balance of this scheme has beyond that of Stoermer-Verlet; ``work.p`` holds the components."""
    x = work.before[0]
    add_linear(plan, x, work.p, work.p, -1.0)
    changed = 0.5 * (power(work.p, after) - power(work.p, work.before[1]))
    return stored - nonlinear_energy(plan, x) - 0.5 * plan.step * changed
