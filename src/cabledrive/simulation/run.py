"""The run: chunk after chunk of steps, recorded, committed, watched for whatever ends it early."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.simulation.case import Case
from cabledrive.simulation.method import DONE, SLACK, TOO_STIFF
from cabledrive.simulation.own_law import stiffness_over_limit
from cabledrive.simulation.progress import Progress
from cabledrive.simulation.records import Records
from cabledrive.simulation.state import STEPS, State, copy_state, set_state
from cabledrive.simulation.workspace import Workspace, new_workspace

NODE_STEPS_PER_CHUNK = 20_000_000
SECONDS_PER_COMMIT = 5.0
INTERRUPTED, UNWRITTEN = "interrupted", "the records cannot be written"


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """How a run ended.

    Attributes
    ----------
    state : State
        At the end.
    stopped : str or None
        Why it ended early, in one line; None if it did not.
    interrupted, unwritten : bool
        Whether it was interrupted from outside; whether the disk refused its records.
    records : int
        Records that belong to the run so far.
    wall_time : float
        How long it took [s].
    """

    state: State
    stopped: str | None
    interrupted: bool
    unwritten: bool
    records: int
    wall_time: float


def integrate_run(
    case: Case, records: Records, *, resumed: tuple[State, int] | None = None, progress: bool | None = False
) -> Outcome:
    """Take all steps of a run, or as many as can be taken.

    ``records``: gets the records; ``resumed``: state and number of records from which to go on; ``progress``:
    whether to show on standard error how far it is; None: where that is a terminal.
    """
    began = time.perf_counter()
    state, done = resumed or (case.first_state(), 0)
    watch = Progress(case.grid.records * case.grid.interval, progress)
    state, done, stopped = _chunks(case, records, state, done, watch)
    watch.end()
    return Outcome(
        state=state,
        stopped=stopped,
        interrupted=stopped == INTERRUPTED,
        unwritten=(stopped or "").startswith(UNWRITTEN),
        records=done,
        wall_time=time.perf_counter() - began,
    )


def _chunks(
    case: Case, records: Records, state: State, done: int, watch: Progress
) -> tuple[State, int, str | None]:
    """Integrate to the end; returns the state there, the records, and why the run stopped before, if so."""
    work = new_workspace(case.plan)
    per_chunk = max(1, NODE_STEPS_PER_CHUNK // (case.mesh.nodes * case.grid.every))
    committed = time.monotonic()
    try:
        while done < case.grid.records:
            count = min(per_chunk, case.grid.records - done)
            fresh = copy_state(state)
            rows, fields, stopped = _chunk(case, fresh, work, done, count)
            unwritten = _written(records.append, rows, fields)
            if unwritten:
                return state, done, stopped or unwritten
            if stopped:
                return fresh, done + len(rows), stopped
            state, done = fresh, done + count
            watch.at(done * case.grid.interval)
            if time.monotonic() - committed > SECONDS_PER_COMMIT:
                if unwritten := _written(records.commit, state, done):
                    return state, done, unwritten
                committed = time.monotonic()
        stopped = _last_record(case, records, state, work)
        return state, done + (0 if stopped else 1), stopped
    except KeyboardInterrupt:
        _written(records.commit, state, done)
        return state, done, INTERRUPTED


def _written(action: Callable[..., None], *content: Any) -> str | None:
    """Write something; returns one line where the disk refuses."""
    try:
        action(*content)
    except OSError as error:
        return f"{UNWRITTEN} ({error.strerror}): free space and resume"
    return None


def _chunk(
    case: Case, state: State, work: Workspace, done: int, count: int
) -> tuple[Array, Array, str | None]:
    """Steps of some records; returns what was recorded and why it is less than asked for, if so."""
    every, steps = case.grid.every, count * case.grid.every
    rows = np.zeros((count, case.width))
    fields = np.zeros((count if case.recording.fields else 0, 3, case.mesh.nodes))
    before = copy_state(state)
    torque, forces = case.inputs(done * every, steps)
    bad = np.flatnonzero(~(np.isfinite(torque) & np.isfinite(forces).all(axis=1)))
    if bad.size:
        steps = int(bad[0])
    code = case.method.integrate(case.plan, state, work, torque[:steps], forces[:steps], every, rows, fields)
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


def _last_record(case: Case, records: Records, state: State, work: Workspace) -> str | None:
    """The record at the end of the run, of a step beyond it that is taken back but for the extremes."""
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
        return slack_line(case, state)
    if code == TOO_STIFF:
        return _too_stiff_line(case, state)
    if code != DONE:
        return _not_finite_line(case, state, work, torque, forces)
    return _written(records.append, rows, fields)


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
