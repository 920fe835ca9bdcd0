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
from cabledrive.simulation.channels import (
    AXIAL_LOSS,
    BALANCE,
    COULOMB_LOSS,
    FORCE_WORK,
    JOINT_LOSS,
    TORQUE_WORK,
    TRANSVERSE_LOSS,
    VISCOUS_LOSS,
)
from cabledrive.simulation.plan import (
    COMPLIANCE,
    DRAG,
    EVENTS,
    FALL_U,
    FALL_W,
    HOLDING,
    INVERSE_SPACING,
    KEEP_T,
    KICK_T,
    KICK_U,
    LOWER_SLACK,
    MOST_EVENTS,
    RADIUS,
    STEPS,
    UPPER_SLACK,
    VISCOUS,
    WEIGHT_U,
    Plan,
    State,
    Workspace,
    copy_state,
    law_of,
)
from oracles.readable_chain.axial_damping import damped_span_reference, damper_directions
from oracles.readable_chain.observe import observe_reference
from oracles.readable_chain.shafts import solve_shafts_reference

DONE, SLACK, NOT_FINITE = range(3)


def observed(
    plan: Plan, law: CableLaw, before: State, after: State, gradients: Array, torque: float, row: Array
):
    """The record of a step."""
    observe_reference(
        plan, law, np.stack([before.x, before.x_t]), after.x_t,
        np.stack([before.motor, after.motor]), np.stack([before.tallies, after.tallies]),
        torque, row,
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
        for j in range(torque.size):
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
                if not abs(rows[record, BALANCE]) < 1e300:
                    return NOT_FINITE
        return DONE

    return integrate


def step_reference(
    plan: Plan, law: CableLaw, state: State, excess: Array, torque: float, forces: Array
) -> None:
    """One step under given components of the segments: kick of all nodes and shafts, tallies, drift."""
    old, motor_old = state.x_t.copy(), float(state.motor[1])
    new = _kicked(plan, old, excess, forces)
    shaft_old = np.array([*old[0, [0, plan.segments]], motor_old])
    shaft_force = shaft_forces_reference(plan, state, excess[0], torque)
    matrix = plan.shaft_matrices[0]
    direction = damper_directions(plan, law, state.x)
    if plan.axial_damping > 0.0:
        matrix, shaft_force = _with_dampers(
            plan, direction, 0.5 * (old + new), shaft_old, matrix, shaft_force
        )
    right = shaft_force + plan.shaft_matrices[1] @ shaft_old
    shaft_new, friction = solve_shafts_reference(matrix, plan.shaft, right, shaft_old)
    if plan.axial_damping > 0.0:
        _damp(plan, state, direction, old, new, 0.5 * (shaft_old + shaft_new))
    new[0, [0, plan.segments]] = shaft_new[:2]
    if plan.closed:
        new[0, -1] = new[0, 0]
    tally_reference(plan, state, old, new, 0.5 * (shaft_old + shaft_new), friction, torque, forces)
    state.x_t[:] = new
    state.x[:] += plan.step * new
    state.motor[1] = shaft_new[2]
    state.motor[0] += plan.step * shaft_new[2]
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


def shaft_forces_reference(plan: Plan, state: State, pull: Array, torque: float) -> Array:
    """Forces on drive rim, load rim and motor at the step's time."""
    n = plan.segments
    twisted = plan.joint_stiffness * (state.x[0, 0] - state.motor[0])
    force = np.array([pull[0] - twisted, -pull[n - 1], twisted])
    force -= plan.shaft[HOLDING] * np.array([state.x[0, 0], state.x[0, n], state.motor[0]])
    force[:2] += plan.node[WEIGHT_U, [0, n]]
    if plan.closed:
        force[:2] += -pull[-1], pull[n]
    force[plan.driven] += torque / plan.shaft[RADIUS, 0]
    return force


def _rim_pull(plan: Plan, direction: Array, mean: Array, rims: Array) -> Array:
    """Forces of the damping tensions on drive rim and load rim, at given mean speeds of the rims."""
    force = np.zeros(3)
    for span in range(plan.spans):
        start, end = span, 1 - span
        first, last = span * plan.segments, (span + 1) * plan.segments - 1
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
            for span in range(plan.spans)
        ]
    )
    force = np.diff(direction * q, axis=1)
    new[0, 1:-1] += plan.node[KICK_U, 1:-1] * force[0]
    new[1:, 1:-1] += plan.node[KICK_T, 1:-1] * force[1:]
    state.tallies[0, AXIAL_LOSS] += plan.step * np.sum(plan.segment[COMPLIANCE] * q**2)


def tally_reference(
    plan: Plan,
    state: State,
    old: Array,
    new: Array,
    shaft_mean: Array,
    friction: Array,
    torque: float,
    forces: Array,
) -> None:
    """Works and losses over the step."""
    mean = 0.5 * (old + new)
    worked = state.tallies[0]
    worked[TORQUE_WORK] += plan.step * torque / plan.shaft[RADIUS, 0] * shaft_mean[plan.driven]
    for (node, axis), pushed in zip(plan.force, forces, strict=True):
        worked[FORCE_WORK] += plan.step * pushed * mean[axis, node]
    worked[TRANSVERSE_LOSS] += plan.step * np.sum((plan.node[DRAG] * (mean[1] ** 2 + mean[2] ** 2))[1:-1])
    worked[VISCOUS_LOSS] += plan.step * np.sum(plan.shaft[VISCOUS] * shaft_mean**2)
    worked[COULOMB_LOSS] += plan.step * np.sum(friction * shaft_mean)
    worked[JOINT_LOSS] += plan.step * plan.joint_damping * (shaft_mean[0] - shaft_mean[2]) ** 2


def keep_extremes_reference(plan: Plan, state: State) -> None:
    """Least and largest place of each rim, largest size of v and w at each midpoint."""
    places = np.array([state.x[0, 0], state.x[0, plan.segments], state.motor[0]])
    state.extremes[0:6:2] = np.minimum(state.extremes[0:6:2], places)
    state.extremes[1:6:2] = np.maximum(state.extremes[1:6:2], places)
    for span in range(plan.spans):
        i, share = int(plan.probe[span, 0]), plan.probe[span, 1]
        size = np.abs((1.0 - share) * state.x[1:, i] + share * state.x[1:, i + 1])
        here = slice(6 + 2 * span, 8 + 2 * span)
        state.extremes[here] = np.maximum(state.extremes[here], size)


def note_slack_reference(plan: Plan, law: CableLaw, state: State, gradients: Array) -> bool:
    """Note where and when a span goes slack that was taut at the step before; whether one is slack now."""
    pushes = law.is_slack(*gradients).reshape(plan.spans, -1)
    slack = pushes.any(axis=1)
    for span in np.flatnonzero(slack & (state.counts[UPPER_SLACK:][: plan.spans] == 0)):
        if state.counts[EVENTS] < MOST_EVENTS:
            tension = taut_law(law).tension(*gradients).reshape(plan.spans, -1)[span]
            place = int(np.argmin(tension))
            state.events[state.counts[EVENTS]] = state.counts[STEPS], span, place, tension[place]
        state.counts[EVENTS] += 1
    state.counts[UPPER_SLACK : LOWER_SLACK + 1][: plan.spans] = slack
    return bool(slack.any())


def _step(plan: Plan, law: CableLaw, state: State, gradients: Array, torque: float, forces: Array) -> None:
    step_reference(plan, law, state, np.stack(law.excess_components(*gradients)), torque, forces)


integrate_reference = twin(_step)
