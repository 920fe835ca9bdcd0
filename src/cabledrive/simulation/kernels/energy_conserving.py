"""Compiled march of the energy-conserving scheme. Twin: `cabledrive.simulation.readable.energy_conserving`.

Equal segments under the exact law take a quick loop as long as they are taut; everything else takes the long
one, in which a step is repeated until force scale and velocities agree.
"""

from math import sqrt

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit, njit_in_place
from cabledrive.simulation.channels import BALANCE, TALLIES
from cabledrive.simulation.kernels.energy_equal_segments import MOST_TRIALS, SETTLED, step_equal_segments
from cabledrive.simulation.kernels.equal_segments import gain_series, stays_in_plane
from cabledrive.simulation.kernels.nodes import damp_axially, kick_nodes, tally_nodes, turn
from cabledrive.simulation.kernels.observe import observe
from cabledrive.simulation.kernels.segments import EXACT, LINEAR, segment_tensions, transverse_stretch
from cabledrive.simulation.kernels.shafts import add_to
from cabledrive.simulation.kernels.steps import (
    copy_rows,
    keep_before,
    keep_extremes,
    note_slack,
    shaft_forces,
    tally_shafts,
)
from cabledrive.simulation.kernels.stored_energy import (
    DRIVE_LOST,
    LOAD_LOST,
    MOTOR_LOST,
    SHIFT,
    STORED,
    STORED_LOST,
    raised_shift,
    sum_with_loss,
)
from cabledrive.simulation.plan import INVERSE_SPACING, KICK_T, KICK_U, RADIUS, SPACING, Plan
from cabledrive.simulation.state import LOWER_SLACK, STEPS, UPPER_SLACK, State
from cabledrive.simulation.workspace import Workspace

DONE, SLACK, NOT_FINITE = range(3)


@njit
def march(
    plan: Plan,
    state: State,
    work: Workspace,
    torque: Array,
    forces: Array,
    every: int,
    rows: Array,
    fields: Array,
) -> int:
    """Take a step per entry of ``torque``; as `cabledrive.simulation.kernels.verlet.march`."""
    series = gain_series(plan.rigidity, plan.segment[INVERSE_SPACING, 0])
    rest, lost = np.zeros(work.p.shape), np.zeros((2, TALLIES))
    return _march(plan, state, work, series, rest, lost, torque, forces, every, rows, fields)


@njit_in_place
def _march(
    plan: Plan,
    state: State,
    work: Workspace,
    series: Array,
    rest: Array,
    lost: Array,
    torque: Array,
    forces: Array,
    every: int,
    rows: Array,
    fields: Array,
) -> int:
    """As `march`, with the series of the gain and room for nonlinear components and losses of a trial."""
    x, x_t, motor, tallies = state.x, state.x_t, state.motor, state.tallies
    quick = plan.uniform and plan.law == EXACT
    planar = stays_in_plane(x, x_t)
    j, stored_before = 0, 0.0
    while j < torque.size:
        recording = j % every == 0
        if recording:
            keep_before(x, x_t, motor, tallies, work.before, work.before_motor, work.before_tallies)
            stored_before = state.extra[STORED]
        stop = j + 1 if recording else min(torque.size, j - j % every + every)
        taken = _quick_steps(plan, state, work, torque[j:stop], series, rest[0], planar) if quick else 0
        j += taken
        if j < stop:
            if _is_slack(plan, state, work):
                return SLACK
            _long_step(plan, state, work, rest, lost, torque[j], forces[j])
            j += 1
        if recording:
            record = (j - 1) // every
            row = rows[record]
            observe(
                plan, work.before, x_t, work.before_motor, motor, work.before_tallies, tallies,
                torque[j - 1], work.p, work.q[0], row,
            )  # fmt: skip
            row[BALANCE] += _own_balance(plan, work, x_t, 0.5 * (stored_before + state.extra[STORED]))
            if fields.shape[0] > 0:
                copy_rows(work.before[0], fields[record])
            if not abs(row[BALANCE]) < 1e300:
                return NOT_FINITE
    return DONE


@njit_in_place
def _quick_steps(
    plan: Plan, state: State, work: Workspace, torque: Array, series: Array, gain: Array, planar: bool
) -> int:
    """Steps of the quick loop, up to one it cannot take; returns their number."""
    x, x_t = state.x, state.x_t
    if planar:
        taken = step_equal_segments(
            plan, state, work, torque, series, gain, x[0], None, x[2], x_t[0], None, x_t[2]
        )
    else:
        taken = step_equal_segments(
            plan, state, work, torque, series, gain, x[0], x[1], x[2], x_t[0], x_t[1], x_t[2]
        )
    state.counts[STEPS] += taken
    if taken > 0:
        state.counts[UPPER_SLACK] = 0
        state.counts[LOWER_SLACK] = 0
    return taken


@njit_in_place
def _is_slack(plan: Plan, state: State, work: Workspace) -> bool:
    """Components of all segments; whether a slack one stops the run."""
    keep_extremes(plan.segments, plan.spans, plan.probe, state.x, state.motor, state.extremes)
    slack = segment_tensions(
        plan.law, False, plan.pretension, plan.rigidity, state.x, plan.segment[INVERSE_SPACING], work.p
    )
    if slack > 0 or state.counts[UPPER_SLACK] + state.counts[LOWER_SLACK] > 0:
        note_slack(plan, state.x, state.events, state.counts)
    return plan.stop_when_slack and slack > 0


@njit_in_place
def _long_step(
    plan: Plan, state: State, work: Workspace, rest: Array, lost: Array, torque: float, forces: Array
) -> None:
    """One step for every law and every drive; the components are in ``work.p``."""
    x, x_t, motor, extra, shaft = state.x, state.x_t, state.motor, state.extra, work.shaft
    place, speed = motor[0], motor[1]
    _take_linear(plan, x, work.p, rest, -1.0)
    energy = nonlinear_energy(plan, x)
    extra[SHIFT] = raised_shift(extra[SHIFT], min(energy, extra[STORED]))
    root, psi = sqrt(2.0 * (energy + extra[SHIFT])), sqrt(2.0 * (extra[STORED] + extra[SHIFT]))
    scale = 0.5 * plan.step / root
    answer = 0.5 * scale / root * _answer(plan, rest)
    push = torque / plan.shaft[RADIUS, 0]
    change, result = 0.0, 0.0
    for trial in range(MOST_TRIALS):
        if trial > 0:
            copy_rows(work.old, x_t)
            motor[0], motor[1] = place, speed
        for k in range(TALLIES):
            lost[0, k], lost[1, k] = 0.0, 0.0
        for axis in range(3):
            for i in range(rest.shape[1]):
                work.p[axis, i] = (psi + 0.5 * change) / root * rest[axis, i]
        _take_linear(plan, x, work.p, work.p, 1.0)
        shaft_forces(
            plan.closed, plan.segments, plan.joint_stiffness, plan.node, x, x_t, motor, work.p,
            plan.driven, push, shaft,
        )  # fmt: skip
        kick_nodes(plan, x_t, work.old, work.p, forces)
        if plan.axial_damping > 0.0:
            damp_axially(plan, x, x_t, motor, lost, work)
        else:
            turn(plan, plan.shaft_matrices[0], x_t, motor, shaft)
        result = scale * (_stretching(rest, work.old) + _stretching(rest, x_t))
        if abs(result - change) <= SETTLED * abs(result) or trial == MOST_TRIALS - 1:
            break
        change += (result - change) / (1.0 + answer)
    extra[STORED] = sum_with_loss(extra, STORED_LOST, extra[STORED], result * (psi + 0.5 * change))
    tally_nodes(plan, x_t, work.old, state.tallies, forces)
    tally_shafts(plan.step, plan.joint_damping, plan.shaft, plan.driven, push, shaft, state.tallies)
    for k in range(TALLIES):
        if lost[0, k] != 0.0:
            add_to(state.tallies, k, lost[0, k])
    _drift(plan, x, x_t, extra)
    motor[0] = sum_with_loss(extra, MOTOR_LOST, place, plan.step * motor[1])
    state.counts[STEPS] += 1


@njit_in_place
def _drift(plan: Plan, x: Array, x_t: Array, extra: Array) -> None:
    """Displacements after the step."""
    n, last = plan.segments, x.shape[1] - 1
    drive = sum_with_loss(extra, DRIVE_LOST, x[0, 0], plan.step * x_t[0, 0])
    load = sum_with_loss(extra, LOAD_LOST, x[0, n], plan.step * x_t[0, n])
    for axis in range(3):
        for i in range(x.shape[1]):
            x[axis, i] += plan.step * x_t[axis, i]
    x[0, 0], x[0, n] = drive, load
    if plan.closed:
        x[0, last] = drive


@njit_in_place
def _take_linear(plan: Plan, x: Array, p: Array, out: Array, sign: float) -> None:
    """Components plus or minus those of the linear law."""
    for axis in range(3):
        stiffness = plan.pretension + (plan.rigidity if axis == 0 else 0.0)
        for i in range(p.shape[1]):
            slope = (x[axis, i + 1] - x[axis, i]) * plan.segment[INVERSE_SPACING, i]
            out[axis, i] = p[axis, i] + sign * stiffness * slope


@njit_in_place
def _answer(plan: Plan, rest: Array) -> float:
    """How much the nodes answer to their nonlinear forces, sum of kick times force squared."""
    total = 0.0
    for axis in range(3):
        kick = plan.node[KICK_U if axis == 0 else KICK_T]
        for i in range(1, rest.shape[1]):
            total += kick[i] * (rest[axis, i] - rest[axis, i - 1]) ** 2
    return total


@njit_in_place
def _stretching(rest: Array, x_t: Array) -> float:
    """Power of nonlinear components on the differences of velocities."""
    total = 0.0
    for axis in range(3):
        for i in range(rest.shape[1]):
            total += rest[axis, i] * (x_t[axis, i + 1] - x_t[axis, i])
    return total


@njit_in_place
def nonlinear_energy(plan: Plan, x: Array) -> float:
    """Elastic energy beyond that of the linear law."""
    total = 0.0
    rigidity = plan.rigidity + (0.0 if plan.law == EXACT else plan.pretension)
    if plan.law == LINEAR:
        return 0.0
    for i in range(x.shape[1] - 1):
        h = plan.segment[INVERSE_SPACING, i]
        u_x = (x[0, i + 1] - x[0, i]) * h
        slopes = transverse_stretch(plan.law, u_x, (x[1, i + 1] - x[1, i]) * h, (x[2, i + 1] - x[2, i]) * h)
        total += plan.segment[SPACING, i] * slopes * (2.0 * u_x + slopes)
    return 0.5 * rigidity * total


@njit_in_place
def _own_balance(plan: Plan, work: Workspace, after: Array, stored: float) -> float:
    """What the balance of this scheme has beyond that of Stoermer-Verlet; ``work.p`` holds the components."""
    x, before = work.before[0], work.before[1]
    _take_linear(plan, x, work.p, work.p, -1.0)
    changed = 0.5 * (_stretching(work.p, after) - _stretching(work.p, before))
    return stored - nonlinear_energy(plan, x) - 0.5 * plan.step * changed
