"""One run of a machine with routes, chunk by chunk."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.simulation.case import Recording
from cabledrive.simulation.network.case import NetworkCase, NetworkStart, network_case
from cabledrive.simulation.network.plan import EVENTS, MOST_EVENTS, STEPS, NetworkState, new_network_workspace
from cabledrive.simulation.network.result import NetworkResult, network_content, network_result
from cabledrive.simulation.plan import NOT_FINITE, SLACK, copy_state
from cabledrive.simulation.run import SimulationInterrupted, how_to_go_on, keep_run
from cabledrive.simulation.signals import Function, Signal
from cabledrive.simulation.start import Scheme


def simulate_network(
    drive: RoutedDrive,
    duration: float,
    *,
    torque: Mapping[str, Signal | float | Function] | Signal | float | Function = 0.0,
    start: NetworkStart | None = None,
    scheme: Scheme | None = None,
    recording: Recording | None = None,
    output: str | Path | None = None,
    force: bool = False,
    resume: bool = False,
    progress: bool | None = False,
) -> NetworkResult:
    """Nonlinear motion of a machine with routes in time, about its state of rest.

    Parameters
    ----------
    drive : RoutedDrive
    duration : float
        Length of the run [s].
    torque : Signal, float, callable or dict of them by motor, default 0.0
        Torque of the first motor, or of each by the name of its pulley, beyond what holds the machine at rest
        [N m].
    start : NetworkStart, optional
        Plucks of spans, places and speeds of coordinates; default: at rest.
    scheme : Scheme, optional
        Cable law, resolution, what slack means.
    recording : Recording, optional
        How often it is recorded.
    output : path-like, optional
        NetCDF file to write; it appears whole or not at all. While the run lasts its records lie beside it,
        in a folder of that name with ".part" behind it.
    force : bool, default False
        Whether an existing file, or what is left of an interrupted run, may be replaced.
    resume : bool, default False
        Go on with an interrupted run of the same settings.
    progress : bool or None, default False
        Whether to show on standard error how far the run is; None: where that is a terminal.

    Returns
    -------
    NetworkResult
        Also of a run that ended early, with ``stopped``.

    Raises
    ------
    InputRefused
        If anything about the run is not possible; nothing was written.
    SimulationInterrupted
        On Ctrl-C. It carries the result so far.
    """
    case = network_case(drive, duration, torque=torque, start=start, scheme=scheme, recording=recording)
    result, outcome = keep_run(
        case,
        partial(network_result, case),
        network_content,
        output=output,
        force=force,
        resume=resume,
        progress=progress,
    )
    if outcome.interrupted:
        raise SimulationInterrupted(how_to_go_on(result.steps * result.step, output), result)
    return result


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
