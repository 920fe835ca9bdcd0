r"""Readable Stoermer-Verlet integration of the staggered chain.

With forces F, masses M and damping C, one step from :math:`t_j` is

.. math:: M\,\frac{\dot x_{j+1/2} - \dot x_{j-1/2}}{\Delta t}
          = F(x_j) - C\,\frac{\dot x_{j+1/2} + \dot x_{j-1/2}}{2} - f, \qquad
          x_{j+1} = x_j + \Delta t\,\dot x_{j+1/2}

with Coulomb friction f in :math:`c\,\mathrm{Sgn}(\dot x_{j+1/2})`, set-valued or smoothed. The dampers along
the cable, of Kelvin and Voigt, are one linear system for the new velocities of the nodes of a span.
"""

from itertools import product

import numpy as np

from cabledrive.mechanics.cable_laws import taut_law, without_pushing
from cabledrive.simulation import channels
from cabledrive.simulation import plan as entries
from cabledrive.simulation.damped import AS_STRAIGHT, UNDAMPED
from cabledrive.simulation.plan import copy_state

DONE, SLACK, NOT_FINITE = range(3)


def law_of(plan):
    """The cable law of a plan of one rope."""
    pretension, rigidity = plan.piece[0, [entries.PRETENSION, entries.RIGIDITY]].tolist()
    law = entries.KERNEL_LAWS[plan.law](pretension=pretension, axial_rigidity=rigidity)
    return without_pushing(law) if plan.tension_only else law


def balance_of(plan):
    """Column of the balance."""
    return 5 * len(plan.nodes) + 3 * len(plan.probe) + 3 + channels.TALLIES


def observed(plan, law, before, after, gradients, torque, row):
    """The record of a step: angles, tensions, energies, budget."""
    x, q, new = before.x, before.q, after.x_t
    change, velocity = 0.5 * (new - before.x_t), 0.5 * (new + before.x_t)
    turned, turning = 0.5 * (after.q_t - before.q_t), 0.5 * (after.q_t + before.q_t)
    spacing, tension, stored = (
        np.stack([own[first:last] for first, last in plan.nodes])
        for own in (plan.segment[entries.SPACING], law.tension(*gradients), law.energy_density(*gradients))
    )
    inner, mass = [slice(first + 1, last) for first, last in plan.nodes], plan.node[entries.MASS]
    weight = plan.node[[entries.WEIGHT_U, entries.WEIGHT_W]]

    along = [0.5 * mass[own] @ velocity[0, own] ** 2 for own in inner]
    across = [0.5 * mass[own] @ np.sum(velocity[1:, own] ** 2, axis=0) for own in inner]
    probes = [
        (1.0 - share) * x[:, int(i)] + share * x[:, int(i) + 1] - rest for i, share, *rest in plan.probe
    ]
    springs = 0.5 * q @ plan.stiffness @ q - plan.rest @ q
    energies = [-np.sum(weight * x[[0, 2]]), 0.5 * turning @ plan.mass @ turning, springs]
    done = 0.5 * (before.tallies[0] + after.tallies[0])
    works = done[channels.TORQUE_WORK] + done[channels.FORCE_WORK]

    excess = np.stack(law.excess_components(*gradients))
    inertia = 0.5 * np.sum(mass * np.sum(change**2, axis=0)) + 0.5 * turned @ plan.mass @ turned
    pull = -np.sum(excess * np.diff(change, axis=1)) + np.sum(weight * change[[0, 2]])
    pull += (plan.rest - plan.stiffness @ q) @ turned
    strain = np.sum(stored * spacing, axis=1)
    kept = np.sum(along) + np.sum(across) + np.sum(strain) + np.sum(energies)
    balance = kept + inertia - 0.5 * plan.step * pull + np.sum(done) - 2.0 * works
    mean = np.sum(tension * spacing, axis=1) / np.sum(spacing, axis=1)
    parts = (mean, np.min(tension, axis=1), along, across, strain, *probes, energies, done, [balance])
    row[:] = np.concatenate([*parts, q, turning, torque])


def twin(step, observe=observed):
    """Twin of `cabledrive.simulation.kernels.integrate` under a step, for any law; needs no work space."""

    def integrate(plan, state, work, torque, forces, every, rows, fields, law=None):
        law = law or law_of(plan)
        for j in range(len(torque)):
            keep_extremes_reference(plan, state)
            before = copy_state(state)
            gradients = np.diff(state.x, axis=1) * plan.segment[entries.INVERSE_SPACING]
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


def step_reference(plan, law, state, excess, torque, forces):
    """One step under given components of the segments: kick of all nodes and shafts, tallies, drift."""
    old, shaft_old = state.x_t.copy(), state.q_t.copy()
    new = _kicked(plan, old, excess, forces)
    shaft_force = shaft_forces_reference(plan, state, excess, torque)
    own = matrix = plan.matrix - 0.5 * plan.dampers
    # along which the segments are damped, (3, segments): derivative of each strain, zero where it is slack
    gradients = np.diff(state.x, axis=1) * plan.segment[entries.INVERSE_SPACING]
    direction = np.stack(law.strain_gradient(*gradients))
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


def moved_reference(plan, state, new, shaft_new):
    """Speeds and places after the step."""
    for ends, rims in zip(plan.nodes, rims_of(plan) @ shaft_new, strict=True):
        new[:, ends] = rims.T
    state.x_t[:] = new
    state.x[:] += plan.step * new
    state.q_t[:] = shaft_new
    state.q[:] += plan.step * shaft_new
    state.counts[entries.STEPS] += 1


def rims_of(plan):
    """Motion of both ends of each span by the coordinates, shape (spans, 2, 3, n)."""
    rows = np.zeros((plan.row_start.size - 1, len(plan.mass)))
    rows[np.repeat(np.arange(len(rows)), np.diff(plan.row_start)), plan.row_column] = plan.row_value
    return rows.reshape(len(plan.nodes), 2, 3, -1)


def _kicked(plan, old, excess, forces):
    """Velocities after the kick of all nodes but the rims, without axial damping."""
    new = old.copy()
    inner = slice(1, -1)
    force = np.diff(excess, axis=1)
    new[0, inner] += plan.node[entries.KICK_U, inner] * force[0] + plan.node[entries.FALL_U, inner]
    new[1:, inner] *= plan.node[entries.KEEP_T, inner]
    new[1:, inner] += plan.node[entries.KICK_T, inner] * force[1:]
    new[2, inner] += plan.node[entries.FALL_W, inner]
    for (node, axis), pushed in zip(plan.force, forces, strict=True):
        new[axis, node] += plan.node[entries.KICK_U if axis == 0 else entries.KICK_T, node] * pushed
    return new


def shaft_forces_reference(plan, state, pull, torque):
    """Forces on the coordinates at the step's time."""
    force = plan.rest - plan.stiffness @ state.q + plan.motor.T @ torque
    for (first, behind), (start, end) in zip(plan.nodes, rims_of(plan), strict=True):
        force += pull[:, first] @ start - pull[:, behind - 1] @ end
    return force


def _rim_pull(plan, direction, mean, speeds):
    """Forces of the damping tensions on the coordinates, at given mean speeds of these."""
    force = np.zeros(len(plan.mass))
    for span, (first, behind) in enumerate(plan.nodes):
        start, end = rims_of(plan)[span]
        q = damped_span_reference(plan, span, direction, mean, (start @ speeds, end @ speeds))
        force += direction[:, first] * q[0] @ start - direction[:, behind - 1] * q[-1] @ end
    return force


def _with_dampers(plan, direction, mean, old, matrix, force):
    """Equations of the coordinates with the pull of the dampers, which is affine in their speeds."""
    units = np.eye(old.size)
    constant = _rim_pull(plan, direction, mean, 0.0 * old)
    answers = np.stack([_rim_pull(plan, direction, mean, own) - constant for own in units], axis=1)
    return matrix - 0.5 * answers, force + constant + 0.5 * answers @ old


def _damp(plan, state, direction, old, new, speeds):
    """Kick of the damping tensions on all nodes between the rims, and what they cost."""
    mean, rims = 0.5 * (old + new), rims_of(plan) @ speeds
    q = np.zeros(direction.shape[1])
    for span, (first, last) in enumerate(plan.nodes):
        q[first:last] = damped_span_reference(plan, span, direction, mean, rims[span])
    force = np.diff(direction * q, axis=1)
    new[0, 1:-1] += plan.node[entries.KICK_U, 1:-1] * force[0]
    new[1:, 1:-1] += plan.node[entries.KICK_T, 1:-1] * force[1:]
    mean = 0.5 * (old + new)
    power = 0.0
    for span, (first, last) in enumerate(plan.nodes):
        mean[:, [first, last]] = rims[span].T
        power += np.sum((direction * q * np.diff(mean, axis=1))[:, first:last])
    state.tallies[0, channels.AXIAL_LOSS] += plan.step * power


def tally_reference(plan, state, old, new, shaft_mean, friction, torque, forces):
    """Works and losses over the step."""
    mean = 0.5 * (old + new)
    worked = state.tallies[0]
    worked[channels.TORQUE_WORK] += plan.step * (plan.motor.T @ torque) @ shaft_mean
    for (node, axis), pushed in zip(plan.force, forces, strict=True):
        worked[channels.FORCE_WORK] += plan.step * pushed * mean[axis, node]
    worked[channels.TRANSVERSE_LOSS] += plan.step * np.sum(
        (plan.node[entries.DRAG] * (mean[1] ** 2 + mean[2] ** 2))[1:-1]
    )
    worked[channels.VISCOUS_LOSS] += plan.step * shaft_mean @ plan.damping[0] @ shaft_mean
    worked[channels.COULOMB_LOSS] += plan.step * np.sum(friction * shaft_mean)
    worked[channels.JOINT_LOSS] += plan.step * shaft_mean @ plan.damping[1] @ shaft_mean


def keep_extremes_reference(plan, state):
    """Least and largest place of each rim, largest size of v and w at each midpoint."""
    state.extremes[0] = np.minimum(state.extremes[0], state.q)
    state.extremes[1] = np.maximum(state.extremes[1], state.q)
    for span in range(len(plan.nodes)):
        i, share = int(plan.probe[span, 0]), plan.probe[span, 1]
        place = (1.0 - share) * state.x[1:, i] + share * state.x[1:, i + 1]
        size = np.abs(place - plan.probe[span, 3:])
        state.peaks[span] = np.maximum(state.peaks[span], size)


def note_slack_reference(plan, law, state, gradients):
    """Note where and when a span goes slack that was taut at the step before; whether one is slack now."""
    pushes = law.is_slack(*gradients)
    slack = np.array([pushes[first:last].any() for first, last in plan.nodes])
    for span in np.flatnonzero(slack & (state.slack == 0)):
        if state.counts[entries.EVENTS] < entries.MOST_EVENTS:
            tension = taut_law(law).tension(*gradients)[slice(*plan.nodes[span])]
            place = int(np.argmin(tension))
            state.events[state.counts[entries.EVENTS]] = (
                state.counts[entries.STEPS],
                span,
                place,
                tension[place],
            )
        state.counts[entries.EVENTS] += 1
    state.slack[:] = slack
    return bool(slack.any())


def _step(plan, law, state, gradients, torque, forces):
    step_reference(plan, law, state, np.stack(law.excess_components(*gradients)), torque, forces)


# --- Shafts
def solve_shafts_reference(plan, matrix, right, old):
    r"""New speeds v and frictions f of the shafts: :math:`A v + f = r`, :math:`f \in c\,\mathrm{Sgn}(v)`.

    Each shaft sticks or slips one way or the other: all cases are tried until one fits. A smoothed friction
    :math:`f_i = c_i \tanh\frac{v_i + v_i^{old}}{2 s_i}` is found by Newton's method.
    """
    free = np.flatnonzero(plan.moves > 0.0)
    new, friction = np.zeros(old.size), np.zeros(old.size)
    inner = matrix[np.ix_(free, free)]
    coulomb, smooth = np.zeros(old.size), np.full(old.size, plan.smooth.max(initial=0.0))
    coulomb[plan.stick], smooth[plan.stick] = plan.bound, plan.smooth
    coulomb, smooth = coulomb[free], smooth[free]
    if (smooth > 0.0).any():
        new[free] = _smoothed(inner, right[free], coulomb, smooth, old[free])
    else:
        new[free] = _stick_slip(inner, right[free], coulomb)
    rubbing = free[coulomb > 0.0]
    friction[rubbing] = (right - matrix @ new)[rubbing]
    return new, friction


def _stick_slip(matrix, right, coulomb):
    best, least = np.zeros_like(right), np.inf
    for case in product((0.0, 1.0, -1.0), repeat=right.size):
        way = np.array(case)
        slips = way != 0.0
        speed = np.zeros_like(right)
        inner = matrix[np.ix_(slips, slips)]
        speed[slips] = np.linalg.solve(inner, (right - coulomb * way)[slips])
        friction = right - matrix @ speed
        wrong_way = np.maximum(-speed * way, 0.0)
        too_much = np.where(slips, 0.0, np.maximum(np.abs(friction) - coulomb, 0.0)) / np.diag(matrix)
        miss = float(np.sum(wrong_way + too_much))
        if miss < least:
            best, least = speed, miss
    return best


def _smoothed(matrix, right, coulomb, smooth, old):
    def excess(speed):
        return matrix @ speed + coulomb * np.tanh(0.5 * (speed + old) / smooth) - right

    speed = old.copy()
    for _ in range(200):
        push, left = np.tanh(0.5 * (speed + old) / smooth), excess(speed)
        slope = matrix + np.diag(0.5 * coulomb * (1.0 - push**2) / smooth)
        step = np.linalg.solve(slope, left)
        if np.linalg.norm(excess(speed - step)) > np.linalg.norm(left):
            # where the tangent is flat and the friction is not, the chord through zero keeps it from cycling
            chord = matrix + np.diag(coulomb / np.maximum(np.abs(speed + old), 2.0 * smooth))
            step = np.linalg.solve(chord, left)
        speed = speed - step
        if np.max(np.abs(step)) <= 1e-15 * np.max(np.abs(speed), initial=1e-300):
            break
    return speed


# --- Dampers along the cable
def damped_span_reference(plan, span, direction, mean, rim_speeds):
    """Damping tensions of a span for given mean speeds of its rims, shape (segments per span,) [N].

    ``mean`` (3, nodes) holds the mean velocities over the step as they would be without the damping. Solves
    (1 + G C / 2) V = mean for the velocities V between the rims, with the dampers C = D^T D / compliance and
    the step over each node's mass in G.
    """
    first, last = plan.nodes[span]
    n, nodes, segments = last - first, slice(first, last + 1), slice(first, last)
    velocity = mean[:, nodes].copy()
    velocity[:, [0, -1]] = np.transpose(rim_speeds)
    rates = _rates(direction[:, segments])  # (segments, 3 nodes)
    dampers = rates.T @ (rates / plan.segment[entries.COMPLIANCE, segments, None])
    gain = plan.node[[entries.KICK_U, entries.KICK_T, entries.KICK_T], nodes].T.ravel()
    system = np.eye(gain.size) + 0.5 * gain[:, None] * dampers
    if plan.axial == AS_STRAIGHT:  # the tensions' own matrix is that of a rope along u
        along = _rates(np.eye(3)[[0]].T + np.zeros((3, n)))
        matrix = np.diag(plan.segment[entries.COMPLIANCE, segments]) + 0.5 * along * gain @ along.T
        tension = np.linalg.solve(matrix, rates @ velocity.T.ravel())
        return tension
    between = np.linalg.solve(system, velocity.T.ravel())
    tension = (rates @ between) / plan.segment[entries.COMPLIANCE, segments]
    return tension


def _rates(direction):
    """Matrix that takes velocities (u, v, w node after node) to the rates at which the segments stretch."""
    segments = direction.shape[1]
    rates = np.zeros((segments, segments + 1, 3))
    own = np.arange(segments)
    rates[own, own] = -direction.T
    rates[own, own + 1] = direction.T
    return rates.reshape(segments, -1)


integrate_reference = twin(_step)
