"""One run of a machine with routes, chunk by chunk."""

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation.network.case import NetworkCase, NetworkStart
from cabledrive.simulation.network.plan import EVENTS, MOST_EVENTS, STEPS, NetworkState, new_network_workspace
from cabledrive.simulation.plan import NOT_FINITE, SLACK, copy_state


def refuse_of_routes(start: object, **given: bool) -> None:
    """Refuse what `simulate` does not support on routes: a start of a loop, options that are ``given``."""
    for name, asked in given.items():
        if asked:
            raise InputRefused(f'kind = "route": {name} is for drives of kind "loop" or "line": leave it out')
    if start is not None and not isinstance(start, NetworkStart):
        raise InputRefused('kind = "route": start must be a NetworkStart: spans are called by their names')


class NetworkStepper:
    """Takes the steps of a network; see `cabledrive.simulation.records`."""

    def __init__(self, case: NetworkCase) -> None:
        self.case = case
        self._work = new_network_workspace(case.plan)

    def chunk(self, state: NetworkState, done: int, count: int) -> tuple[Array, Array, str | None]:
        """Steps of some records; returns what was recorded and why it is less than asked for, if so."""
        case, every = self.case, self.case.grid.every
        torque = case.torque(done * every, count * every)
        bad = np.flatnonzero(~np.isfinite(torque).all(axis=1))
        whole = int(bad[0]) // every if bad.size else count
        rows, torque = np.zeros((whole, case.width)), torque[: whole * every]
        code = self._integrate(state, torque, every, rows)
        taken = int(state.counts[STEPS])
        whole = -(-taken // every) - done
        if code == SLACK:
            return rows[:whole], self._no_fields, _slack_line(case, state)
        if code == NOT_FINITE:
            stopped = f"diverged at t = {taken * case.grid.step:.6g} s: lower the input"
            return rows[: max(whole - 1, 0)], self._no_fields, stopped
        if bad.size:
            return rows, self._no_fields, _not_finite_torque(case, done * every + int(bad[0]))
        return rows, self._no_fields, None

    def last(self, state: NetworkState) -> tuple[Array, Array, str | None]:
        """The record at the end of the run, of a step beyond it that is taken back but for the extremes."""
        case, beyond = self.case, copy_state(state)
        rows = np.zeros((1, case.width))
        torque = case.torque(case.grid.steps, 1)
        if not np.isfinite(torque).all():
            return rows, self._no_fields, _not_finite_torque(case, case.grid.steps)
        code = self._integrate(beyond, torque, 1, rows)
        for name in ("extremes", "peaks", "events"):
            getattr(state, name)[...] = getattr(beyond, name)
        state.counts[EVENTS] = beyond.counts[EVENTS]
        if code == SLACK:
            return rows, self._no_fields, _slack_line(case, state)
        if code == NOT_FINITE:
            return rows, self._no_fields, "diverged in the last step: lower the input"
        return rows, self._no_fields, None

    @property
    def _no_fields(self) -> Array:
        return np.zeros((0, 3, self.case.mesh.size))

    def _integrate(self, state: NetworkState, torque: Array, every: int, rows: Array) -> int:
        from cabledrive.simulation.network.kernels import integrate_network

        return int(integrate_network(self.case.plan, state, self._work, torque, every, rows))


def _slack_line(case: NetworkCase, state: NetworkState) -> str:
    step, piece, tension = state.events[min(int(state.counts[EVENTS]), MOST_EVENTS) - 1]
    return (
        f"span {case.mesh.pieces[int(piece)]} goes slack at t = {step * case.grid.step:.6g} s "
        f"({tension:.3g} N): raise pretension, lower the input or allow slack"
    )


def _not_finite_torque(case: NetworkCase, step: int) -> str:
    return f"the torque is not finite at t = {step * case.grid.step:.6g} s"
