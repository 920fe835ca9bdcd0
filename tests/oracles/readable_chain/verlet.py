r"""Readable Stoermer-Verlet integration of the staggered chain.

With forces F, masses M and damping C, one step from :math:`t_j` is

.. math:: M\,\frac{\dot x_{j+1/2} - \dot x_{j-1/2}}{\Delta t}
          = F(x_j) - C\,\frac{\dot x_{j+1/2} + \dot x_{j-1/2}}{2} - f, \qquad
          x_{j+1} = x_j + \Delta t\,\dot x_{j+1/2}

with Coulomb friction f in :math:`c\,\mathrm{Sgn}(\dot x_{j+1/2})`.
"""

from collections.abc import Callable

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.cable_laws import taut_law
from cabledrive.simulation import channels
from cabledrive.simulation.dampers import UNDAMPED
from cabledrive.simulation.plan import (
    DRAG,
    EVENTS,
    FALL_U,
    FALL_W,
    INVERSE_SPACING,
    KEEP_T,
    KICK_T,
    KICK_U,
    MOST_EVENTS,
    STEPS,
    Plan,
    State,
    Workspace,
    copy_state,
    law_of,
)
from oracles.readable_chain.axial_damping import damped_span_reference, damper_directions
from oracles.readable_chain.observe import balance_of, observe_reference
from oracles.readable_chain.shafts import solve_shafts_reference

DONE, SLACK, NOT_FINITE = range(3)


def observed(
    plan: Plan, law: CableLaw, before: State, after: State, gradients: Array, torque: float, row: Array
):
    """The record of a step."""
    observe_reference(
        plan, law, np.stack([before.x, before.x_t]), after.x_t, before.q,
        np.stack([before.q_t, after.q_t]), np.stack([before.tallies, after.tallies]), torque, row,
    )  # fmt: skip


def twin(step: Callable[..., None], observe: Callable[..., None] = observed) -> Callable[..., int]:
    """Twin of `cabledrive.simulation.kernels.integrate` under a step, for any law; needs no work space."""

    def integrate(
        plan: Plan,
        state: State,
        work: Workspace,
        torque: Array,
        forces: Array,
        every: int,
        rows: Array,
        fields: Array,
        law: CableLaw | None = None,
    ) -> int:
        law = law or law_of(plan)
        for j in range(len(torque)):
            keep_extremes_reference(plan, state)
            before = copy_state(state)
            gradients = np.diff(state.x, axis=1) * plan.segment[INVERSE_SPACING]
            slack = note_slack_reference(plan, law, state, gradients)
            if slack and plan.stop_when_slack:
                return SLACK
            step(plan, law, state, gradients, torque[j], forces[j])
            if j % every == 0:
                record = j // every
                observe(plan, law, before, state, gradients, torque[j], rows[record])
                if fields.shape[0] > 0:
                    fields[record] = before.x
                if not abs(rows[record, balance_of(plan)]) < 1e300:
                    return NOT_FINITE
        return DONE

    return integrate


def step_reference(
    plan: Plan, law: CableLaw, state: State, excess: Array, torque: Array, forces: Array
) -> None:
    """One step under given components of the segments: kick of all nodes and shafts, tallies, drift."""
    old, shaft_old = state.x_t.copy(), state.q_t.copy()
    new = _kicked(plan, old, excess, forces)
    shaft_force = shaft_forces_reference(plan, state, excess[0], torque)
    own = matrix = plan.matrix - 0.5 * plan.dampers
    direction = damper_directions(plan, law, state.x)
    if plan.axial != UNDAMPED:
        matrix, shaft_force = _with_dampers(
            plan, direction, 0.5 * (old + new), shaft_old, matrix, shaft_force
        )
    right = shaft_force + (own - plan.loss) @ shaft_old
    shaft_new, friction = solve_shafts_reference(plan, matrix, right, shaft_old)
    if plan.axial != UNDAMPED:
        _damp(plan, state, direction, old, new, 0.5 * (shaft_old + shaft_new))
    tally_reference(plan, state, old, new, 0.5 * (shaft_old + shaft_new), friction, torque, forces)
    moved_reference(plan, state, new, shaft_new)


def moved_reference(plan: Plan, state: State, new: Array, shaft_new: Array) -> None:
    """Speeds and places after the step."""
    new[0, [0, plan.nodes[0, 1]]] = shaft_new[:2]
    if len(plan.nodes) > 1:
        new[:, -1] = new[:, 0]
    state.x_t[:] = new
    state.x[:] += plan.step * new
    state.q_t[:] = shaft_new
    state.q[:] += plan.step * shaft_new
    state.counts[STEPS] += 1


def _kicked(plan: Plan, old: Array, excess: Array, forces: Array) -> Array:
    """Velocities after the kick of all nodes but the rims, without axial damping."""
    new = old.copy()
    inner = slice(1, -1)
    force = np.diff(excess, axis=1)
    new[0, inner] += plan.node[KICK_U, inner] * force[0] + plan.node[FALL_U, inner]
    new[1:, inner] *= plan.node[KEEP_T, inner]
    new[1:, inner] += plan.node[KICK_T, inner] * force[1:]
    new[2, inner] += plan.node[FALL_W, inner]
    for (node, axis), pushed in zip(plan.force, forces, strict=True):
        new[axis, node] += plan.node[KICK_U if axis == 0 else KICK_T, node] * pushed
    return new


def shaft_forces_reference(plan: Plan, state: State, pull: Array, torque: Array) -> Array:
    """Forces on drive rim, load rim and motor at the step's time."""
    n = plan.nodes[0, 1]
    force = plan.rest - plan.stiffness @ state.q + plan.motor.T @ torque
    force[:2] += pull[0], -pull[n - 1]
    if len(plan.nodes) > 1:
        force[:2] += -pull[-1], pull[n]
    return force


def _rim_pull(plan: Plan, direction: Array, mean: Array, rims: Array) -> Array:
    """Forces of the damping tensions on drive rim and load rim, at given mean speeds of the rims."""
    force = np.zeros(3)
    for span, (first, behind) in enumerate(plan.nodes):
        start, end, last = span, 1 - span, behind - 1
        q = damped_span_reference(plan, span, direction, mean, (rims[start], rims[end]))
        force[start] += direction[0, first] * q[0]
        force[end] -= direction[0, last] * q[-1]
    return force


def _with_dampers(
    plan: Plan, direction: Array, mean: Array, old: Array, matrix: Array, force: Array
) -> tuple[Array, Array]:
    """Shaft equations with the pull of the dampers, which is affine in the rims' speeds."""
    constant = _rim_pull(plan, direction, mean, np.zeros(2))
    answers = np.zeros((3, 3))
    for rim in range(2):
        answers[:, rim] = _rim_pull(plan, direction, mean, np.eye(2)[rim]) - constant
    return matrix - 0.5 * answers, force + constant + 0.5 * answers @ old


def _damp(plan: Plan, state: State, direction: Array, old: Array, new: Array, rims: Array) -> None:
    """Kick of the damping tensions on all nodes between the rims, and what they cost."""
    mean = 0.5 * (old + new)
    q = np.concatenate(
        [
            damped_span_reference(plan, span, direction, mean, (rims[span], rims[1 - span]))
            for span in range(len(plan.nodes))
        ]
    )
    force = np.diff(direction * q, axis=1)
    new[0, 1:-1] += plan.node[KICK_U, 1:-1] * force[0]
    new[1:, 1:-1] += plan.node[KICK_T, 1:-1] * force[1:]
    mean = 0.5 * (old + new)
    power = 0.0
    for span, (first, last) in enumerate(plan.nodes):
        mean[0, [first, last]] = rims[span], rims[1 - span]
        power += np.sum((direction * q * np.diff(mean, axis=1))[:, first:last])
    state.tallies[0, channels.AXIAL_LOSS] += plan.step * power


def tally_reference(
    plan: Plan,
    state: State,
    old: Array,
    new: Array,
    shaft_mean: Array,
    friction: Array,
    torque: Array,
    forces: Array,
) -> None:
    """Works and losses over the step."""
    mean = 0.5 * (old + new)
    worked = state.tallies[0]
    worked[channels.TORQUE_WORK] += plan.step * (plan.motor.T @ torque) @ shaft_mean
    for (node, axis), pushed in zip(plan.force, forces, strict=True):
        worked[channels.FORCE_WORK] += plan.step * pushed * mean[axis, node]
    worked[channels.TRANSVERSE_LOSS] += plan.step * np.sum(
        (plan.node[DRAG] * (mean[1] ** 2 + mean[2] ** 2))[1:-1]
    )
    worked[channels.VISCOUS_LOSS] += plan.step * shaft_mean @ plan.damping[0] @ shaft_mean
    worked[channels.COULOMB_LOSS] += plan.step * np.sum(friction * shaft_mean)
    worked[channels.JOINT_LOSS] += plan.step * shaft_mean @ plan.damping[1] @ shaft_mean


def keep_extremes_reference(plan: Plan, state: State) -> None:
    """Least and largest place of each rim, largest size of v and w at each midpoint."""
    state.extremes[0] = np.minimum(state.extremes[0], state.q)
    state.extremes[1] = np.maximum(state.extremes[1], state.q)
    for span in range(len(plan.nodes)):
        i, share = int(plan.probe[span, 0]), plan.probe[span, 1]
        size = np.abs((1.0 - share) * state.x[1:, i] + share * state.x[1:, i + 1])
        state.peaks[span] = np.maximum(state.peaks[span], size)


def note_slack_reference(plan: Plan, law: CableLaw, state: State, gradients: Array) -> bool:
    """Note where and when a span goes slack that was taut at the step before; whether one is slack now."""
    pushes = law.is_slack(*gradients).reshape(len(plan.nodes), -1)
    slack = pushes.any(axis=1)
    for span in np.flatnonzero(slack & (state.slack == 0)):
        if state.counts[EVENTS] < MOST_EVENTS:
            tension = taut_law(law).tension(*gradients).reshape(len(plan.nodes), -1)[span]
            place = int(np.argmin(tension))
            state.events[state.counts[EVENTS]] = state.counts[STEPS], span, place, tension[place]
        state.counts[EVENTS] += 1
    state.slack[:] = slack
    return bool(slack.any())


def _step(plan: Plan, law: CableLaw, state: State, gradients: Array, torque: Array, forces: Array) -> None:
    step_reference(plan, law, state, np.stack(law.excess_components(*gradients)), torque, forces)


integrate_reference = twin(_step)
