"""Steps of a machine with routes, chunk by chunk, and the line that says why one is cut short."""

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.simulation.network.case import NetworkCase
from cabledrive.simulation.network.state import (
    EVENTS,
    MOST_EVENTS,
    STEPS,
    NetworkState,
    new_network_workspace,
)
from cabledrive.simulation.state import copy_state

DONE, SLACK, NOT_FINITE = range(3)


class NetworkStepper:
    """Takes the steps of a network; see `cabledrive.simulation.prepared_run`."""

    def __init__(self, case: NetworkCase) -> None:
        self.case = case
        self._work = new_network_workspace(case.plan)
        self._still = np.zeros(case.mesh.size)

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
        """Steps in machine code; a network that has not left its plane has no motion out of it."""
        from cabledrive.simulation.network.kernels import integrate_network

        (u, v, w), (u_t, v_t, w_t) = state.x, state.x_t
        given = self.case.plan, state, self._work, torque, every, rows, self._still
        if not (v.any() or v_t.any()) and not self.case.mesh.ends[:, :, 1].any():
            return int(integrate_network(*given, u, None, w, u_t, None, w_t))
        return int(integrate_network(*given, u, v, w, u_t, v_t, w_t))


def _slack_line(case: NetworkCase, state: NetworkState) -> str:
    step, piece, tension = state.events[min(int(state.counts[EVENTS]), MOST_EVENTS) - 1]
    return (
        f"span {case.mesh.pieces[int(piece)]} goes slack at t = {step * case.grid.step:.6g} s "
        f"({tension:.3g} N): raise pretension, lower the input or allow slack"
    )


def _not_finite_torque(case: NetworkCase, step: int) -> str:
    return f"the torque is not finite at t = {step * case.grid.step:.6g} s"
