"""Steps of a loop or a line, chunk by chunk, and the line that says why one is cut short."""

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.simulation.case import Case
from cabledrive.simulation.method import DONE, SLACK, TOO_STIFF
from cabledrive.simulation.own_law import stiffness_over_limit
from cabledrive.simulation.state import STEPS, State, copy_state, set_state
from cabledrive.simulation.workspace import Workspace, new_workspace


class LoopStepper:
    """Takes the steps of a loop or a line; see `cabledrive.simulation.prepared_run`."""

    def __init__(self, case: Case) -> None:
        self.case = case
        self._work = new_workspace(case.plan)

    def chunk(self, state: State, done: int, count: int) -> tuple[Array, Array, str | None]:
        """Steps of some records; returns what was recorded and why it is less than asked for, if so."""
        case, work = self.case, self._work
        every, steps = case.grid.every, count * case.grid.every
        rows = np.zeros((count, case.width))
        fields = np.zeros((count if case.recording.fields else 0, 3, case.mesh.nodes))
        before = copy_state(state)
        torque, forces = case.inputs(done * every, steps)
        bad = np.flatnonzero(~(np.isfinite(torque) & np.isfinite(forces).all(axis=1)))
        if bad.size:
            steps = int(bad[0])
        code = case.method.integrate(
            case.plan, state, work, torque[:steps], forces[:steps], every, rows, fields
        )
        taken = int(state.counts[STEPS]) - done * every
        whole = -(-taken // every)
        stopped = None
        if code == SLACK:
            stopped = slack_line(case, state)
        elif code == TOO_STIFF:
            stopped = _too_stiff_line(case, state)
        elif code != DONE:
            whole -= 1
            set_state(state, before)
            stopped = _not_finite_line(case, state, work, torque, forces)
        elif bad.size:
            stopped = (
                f"the torque or a force is not finite at t = {(done * every + steps) * case.grid.step:.6g} s"
            )
        if case.recording.fields:
            fields = fields[:whole][-done % case.recording.fields :: case.recording.fields]
        return rows[:whole], fields, stopped

    def last(self, state: State) -> tuple[Array, Array, str | None]:
        """The record at the end of the run, of a step beyond it that is taken back but for the extremes."""
        case, work, stopped = self.case, self._work, None
        beyond = copy_state(state)
        rows = np.zeros((1, case.width))
        keeps_field = case.recording.fields and case.grid.records % case.recording.fields == 0
        fields = np.zeros((1 if keeps_field else 0, 3, case.mesh.nodes))
        torque, forces = case.inputs(case.grid.steps, 1)
        code = case.method.integrate(case.plan, beyond, work, torque, forces, 1, rows, fields)
        for mine, theirs in ((state.extremes, beyond.extremes), (state.events, beyond.events)):
            mine[...] = theirs
        state.counts[1:] = beyond.counts[1:]
        if code == SLACK:
            stopped = slack_line(case, state)
        elif code == TOO_STIFF:
            stopped = _too_stiff_line(case, state)
        elif code != DONE:
            stopped = _not_finite_line(case, state, work, torque, forces)
        return rows, fields, stopped


def slack_line(case: Case, state: State) -> str:
    """One line about the span that went slack last."""
    step, span, segment, tension = state.events[min(int(state.counts[1]), len(state.events)) - 1]
    place = case.mesh.position[int(span), int(segment) : int(segment) + 2].mean()
    return (
        f"the {case.mesh.spans[int(span)]} span goes slack at t = {step * case.grid.step:.6g} s, "
        f"x = {place:.4g} m ({tension:.3g} N): raise cable.pretension, lower the input or allow slack"
    )


def _too_stiff_line(case: Case, state: State) -> str:
    """One line about the segment that is too stiff for the step."""
    over = stiffness_over_limit(case.plan, case.law, state.x)
    span, segment = divmod(int(np.argmax(over)), case.mesh.segments)
    return (
        f"the law {case.law_name} is too stiff for the step of {case.grid.step:.4g} s at "
        f"t = {state.counts[STEPS] * case.grid.step:.6g} s in the {case.mesh.spans[span]} span at "
        f"{case.mesh.position[span, segment]:.4g} m: give a step of at most "
        f"{case.grid.step / np.sqrt(over.max()):.4g} s"
    )


def _not_finite_line(case: Case, state: State, work: Workspace, torque: Array, forces: Array) -> str:
    """Repeat the chunk step by step up to the first energy that is not finite."""
    rows, no_fields = np.zeros((1, case.width)), np.zeros((0, 3, case.mesh.nodes))
    for j in range(torque.size):
        inputs = torque[j : j + 1], forces[j : j + 1]
        if case.method.integrate(case.plan, state, work, *inputs, 1, rows, no_fields) != DONE:
            break
    size = np.max(np.abs(state.x), axis=0)
    farthest = int(np.argmax(np.where(np.isfinite(size), size, np.inf)))
    span, segment = divmod(min(farthest, case.mesh.spacing.size - 1), case.mesh.segments)
    time_there = state.counts[STEPS] * case.grid.step
    return (
        f"diverged: the energy is not finite from t = {time_there:.6g} s on, the motion largest in the "
        f"{case.mesh.spans[span]} span at {case.mesh.position[span, segment]:.4g} m: lower cfl or the input"
    )
