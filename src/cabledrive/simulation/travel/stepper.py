"""Steps of a run in which bodies travel, chunk by chunk, and the line that says why one is cut short."""

from math import degrees

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.simulation.plan import DONE, NOT_FINITE, SLACK, copy_state
from cabledrive.simulation.travel.case import TravelCase
from cabledrive.simulation.travel.plan import (
    NO_SPAN,
    OFF_THE_PULLEY,
    TALLIES,
    TOO_SHORT,
    TravelState,
    TravelWorkspace,
)


class TravelStepper:
    """Takes the steps of a run in which bodies travel; see `cabledrive.simulation.prepared_run`."""

    def __init__(self, case: TravelCase) -> None:
        self.case = case
        self._work = new_travel_workspace(case)
        self._before = np.zeros((len(case.spans), 2))
        self._no_fields = np.zeros((0, 3, case.nodes))

    def chunk(self, state: TravelState, done: int, count: int) -> tuple[Array, Array, str | None]:
        """Steps of some records; returns what was recorded and why it is less than asked for, if so."""
        case, every = self.case, self.case.grid.every
        given = case.given(done * every, count * every)
        bad = np.flatnonzero(~np.isfinite(given).all(axis=1))
        whole = int(bad[0]) // every if bad.size else count
        rows, given = np.zeros((whole, case.width)), given[: whole * every]
        code = self._integrate(state, given, every, rows)
        if code == DONE:
            step = done * every + int(bad[0]) if bad.size else 0
            words = f"the torque is not finite at t = {step * case.grid.step:.6g} s" if bad.size else None
            return rows, self._no_fields, words
        made = -(-int(state.counts[0]) // every) - done - (1 if code == NOT_FINITE else 0)
        return rows[: max(made, 0)], self._no_fields, _stopped(case, state, code)

    def last(self, state: TravelState) -> tuple[Array, Array, str | None]:
        """The record at the end of the run, of a step beyond it that is taken back but for the extremes."""
        beyond, rows = copy_state(state), np.zeros((1, self.case.width))
        code = self._integrate(beyond, self.case.given(self.case.grid.steps, 1), 1, rows)
        for name in ("extremes", "reached", "events"):
            getattr(state, name)[...] = getattr(beyond, name)
        return rows, self._no_fields, None if code == DONE else _stopped(self.case, beyond, code)

    def _integrate(self, state: TravelState, given: Array, every: int, rows: Array) -> int:
        from cabledrive.simulation.travel.kernels import integrate_travel

        return int(integrate_travel(self.case.plan, state, self._work, given, every, rows, self._before))


def new_travel_workspace(case: TravelCase) -> TravelWorkspace:
    """Room for what is filled anew at each step."""
    n, spans, cells = len(case.names), len(case.spans), case.nodes
    frictions = case.plan.bound.size
    return TravelWorkspace(
        along=np.zeros((spans, 2)),
        free=np.zeros(spans),
        pull=np.zeros((spans, 2, 3)),
        tension=np.zeros(cells + spans),
        damped=np.zeros(cells + spans),
        rate=np.zeros(cells),
        pivot=np.zeros(cells),
        trial=np.zeros(cells),
        rows=np.zeros((spans, 2, n)),
        across=np.zeros((spans, 2, n)),
        speed=np.zeros((spans, 2)),
        matrix=np.zeros((2, n, n)),
        elimination=np.zeros((n, 2 * n)),
        force=np.zeros(n),
        carried=np.zeros(n),
        fallen=np.zeros(n),
        right=np.zeros(n),
        new=np.zeros(n),
        friction=np.zeros(frictions),
        bound=np.zeros(frictions),
        torque=np.zeros(len(case.motors)),
        kept=np.zeros((4, max(n, spans, cells, TALLIES))),
    )


def _stopped(case: TravelCase, state: TravelState, code: int) -> str:
    """Why a run stopped, in one line."""
    when = f"at t = {state.counts[0] * case.grid.step:.6g} s"
    span, figure = case.network.drive.free_spans[int(state.events[0, 0])], float(state.events[0, 1])
    if code == SLACK:
        return f"span {span.name} goes slack {when}: move more slowly, or raise pretension"
    if code == TOO_SHORT:
        return (
            f"span {span.name} is {figure:.4g} m long {when}: the step of {case.grid.step:.4g} s is stable "
            f"down to {case.plan.shortest[int(state.events[0, 0])]:.4g} m: go less far"
        )
    if code == OFF_THE_PULLEY:
        return f"the rope leaves {span.end.name} {when} (wrap {degrees(figure):.3g} deg): go less far"
    if code == NO_SPAN:
        return f"span {span.name} has no free length any more {when}: go less far"
    return f"diverged {when}: lower the input, or give a smaller step"
