"""One run of a machine with routes in time."""

import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import why_plain
from cabledrive.mechanics.tension_only import taut_law
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.parameters.files import check_writable, put_in_place
from cabledrive.parameters.hashing import content_hash
from cabledrive.parameters.one_process import one_process
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.version import __version__
from cabledrive.simulation.case import Recording
from cabledrive.simulation.network.case import NetworkCase, NetworkStart, network_case
from cabledrive.simulation.network.channels import channels_of
from cabledrive.simulation.network.plan import TALLIES
from cabledrive.simulation.network.result import NetworkResult
from cabledrive.simulation.network.state import (
    EVENTS,
    MOST_EVENTS,
    STEPS,
    NetworkState,
    NetworkWorkspace,
    new_network_workspace,
)
from cabledrive.simulation.progress import Progress
from cabledrive.simulation.run_folder import RESULT, part_of
from cabledrive.simulation.scheme import Scheme
from cabledrive.simulation.signals import Function, Signal

NODE_STEPS_PER_CHUNK = 20_000_000
MOST_MEMORY = 4e9
DONE, SLACK, NOT_FINITE = range(3)

_ASSUMPTIONS = (
    "motion about the state of rest: lengths, wraps and directions of spans stay those at rest",
    "each span has its mean tension at rest and is straight: its own weight and sag are left out",
    "torque: beyond what holds the machine at rest",
)


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
        NetCDF file to write; it appears whole or not at all.
    force : bool, default False
        Whether an existing file may be replaced.
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
    """
    case = network_case(drive, duration, torque=torque, start=start, scheme=scheme, recording=recording)
    if output is None:
        return _run(case, progress)
    path = Path(output)
    check_writable(path, force=force)
    part = part_of(path)
    with one_process(part):
        result = _run(case, progress)
        file = part / RESULT
        try:
            result.to_xarray().to_netcdf(file, engine="h5netcdf")
            put_in_place(file, path, force=force)
        except OSError as error:
            raise NotComputed(f"{path}: cannot be written ({error.strerror or error}): free space") from error
        finally:
            file.unlink(missing_ok=True)
    return replace(result, path=path)


def refuse_of_routes(start: object, **given: bool) -> None:
    """Refuse what `simulate` does not support on routes: a start of a loop, options that are ``given``."""
    for name, asked in given.items():
        if asked:
            raise InputRefused(f'kind = "route": {name} is for drives of kind "loop" or "line": leave it out')
    if start is not None and not isinstance(start, NetworkStart):
        raise InputRefused('kind = "route": start must be a NetworkStart: spans are called by their names')


def _run(case: NetworkCase, progress: bool | None) -> NetworkResult:
    began = time.perf_counter()
    channels = channels_of(case.mesh, case.mesh.driven)
    size = 8 * (case.grid.records + 1) * len(channels)
    if size > MOST_MEMORY:
        raise InputRefused(
            f"the records of this run take {size / 1e9:.1f} GB, at most {MOST_MEMORY / 1e9:.0f} GB are kept: "
            "lower the rate, or shorten the run"
        )
    state, work = case.first_state(), new_network_workspace(case.plan)
    rows = np.zeros((case.grid.records + 1, len(channels)))
    done, stopped = _integrate(
        case, state, work, rows, Progress(case.grid.records * case.grid.interval, progress)
    )
    return _result(case, channels, rows[:done], state, stopped, time.perf_counter() - began)


def _integrate(
    case: NetworkCase, state: NetworkState, work: NetworkWorkspace, rows: Array, watch: Progress
) -> tuple[int, str | None]:
    """Take all steps; returns the records made and why they are fewer than asked for, if so."""
    every, records = case.grid.every, case.grid.records
    chunk = max(1, NODE_STEPS_PER_CHUNK // (case.mesh.size * every))
    done = 0
    while done < records:
        count = min(chunk, records - done)
        torque = case.torque(done * every, count * every)
        if not np.isfinite(torque).all():
            return done, f"the torque is not finite after t = {done * case.grid.interval:.6g} s"
        code = integrate_pieces(case, state, work, torque, every, rows[done : done + count])
        if code == DONE:
            done += count
            watch.at(done * case.grid.interval)
            continue
        taken = int(state.counts[STEPS])
        if code == SLACK:
            return -(-taken // every), _slack_line(case, state)
        return max(
            -(-taken // every) - 1, 0
        ), f"diverged at t = {taken * case.grid.step:.6g} s: lower the input"
    # The record at the end is of a step beyond it, which is not counted.
    code = integrate_pieces(case, state, work, case.torque(records * every, 1), 1, rows[records:])
    watch.end()
    if code != DONE:
        return done, _slack_line(
            case, state
        ) if code == SLACK else "diverged in the last step: lower the input"
    state.counts[STEPS] -= 1
    return records + 1, None


def integrate_pieces(
    case: NetworkCase, state: NetworkState, work: NetworkWorkspace, torque: Array, every: int, rows: Array
) -> int:
    """Steps in machine code; a network that has not left its plane has no motion out of it."""
    from cabledrive.simulation.network.kernels import integrate_network

    (u, v, w), (u_t, v_t, w_t) = state.x, state.x_t
    still = np.zeros(case.mesh.size)
    plane = not (v.any() or v_t.any()) and not case.mesh.ends[:, :, 1].any()
    if plane:
        return int(
            integrate_network(case.plan, state, work, torque, every, rows, still, u, None, w, u_t, None, w_t)
        )
    return int(integrate_network(case.plan, state, work, torque, every, rows, still, u, v, w, u_t, v_t, w_t))


def _slack_line(case: NetworkCase, state: NetworkState) -> str:
    step, piece, tension = state.events[min(int(state.counts[EVENTS]), MOST_EVENTS) - 1]
    return (
        f"span {case.mesh.pieces[int(piece)]} goes slack at t = {step * case.grid.step:.6g} s "
        f"({tension:.3g} N): raise pretension, lower the input or allow slack"
    )


def _left_out(drive: RoutedDrive) -> tuple[str, ...]:
    """What the drive states and the run does not have."""
    names = [motor.pulley or "the first pulley" for motor in drive.motor if motor.offset_torque != 0.0]
    return (f"motor.offset_torque of {', '.join(names)} is left out",) if names else ()


def _result(
    case: NetworkCase,
    channels: tuple[Any, ...],
    rows: Array,
    state: NetworkState,
    stopped: str | None,
    wall_time: float,
) -> NetworkResult:
    mesh, names = case.mesh, case.mesh.names
    columns = {channel.name: k for k, channel in enumerate(channels)}
    energies = rows[:1, columns["rope_energy"] : columns["rope_energy"] + 4].sum() if len(rows) else 0.0
    work = float(np.max(rows[:, -1 - TALLIES], initial=0.0))
    extremes = np.where(np.isfinite(state.extremes), state.extremes, 0.0)
    reach = np.abs(extremes).max(axis=0)
    # Turning a pulley passes rope on and leaves the geometry as it is: only bodies count.
    bodies = [n for n, name in enumerate(names) if "." in name and not name.startswith("slip at ")]
    along = np.einsum("kaxn,n->kax", np.abs(mesh.ends[:, :, [0, 2]][..., bodies]), reach[bodies])
    noted = state.events[: min(int(state.counts[EVENTS]), MOST_EVENTS)]
    return NetworkResult(
        time=np.arange(len(rows), dtype=np.float64) * case.grid.interval,
        rows=rows,
        channels=channels,
        spans=mesh.pieces,
        steps=int(state.counts[STEPS]),
        step=case.grid.step,
        largest_step=case.grid.largest_step,
        energy_handled=max(float(energies), 0.0) + work,
        extremes={name: (float(low), float(high)) for name, low, high in zip(names, *extremes, strict=True)},
        midpoint_peaks=dict(zip(mesh.pieces, state.peaks.tolist(), strict=True)),
        slack_events=tuple(
            {"time": float(step * case.grid.step), "span": mesh.pieces[int(piece)], "tension": float(tension)}
            for step, piece, tension in noted
        ),
        largest_motion=float((along.max(axis=(1, 2)) / mesh.length).max(initial=0.0)),
        assumptions=_ASSUMPTIONS + _left_out(case.network.drive),
        provenance={
            "cabledrive": __version__,
            "drive": case.network.drive.name,
            "drive_hash": content_hash(case.network.drive),
            "method": {
                "name": "verlet",
                "model": taut_law(case.laws[0]).name,
                "compiled": why_plain() is None,
                "interpreted": why_plain(),
                "segments": case.scheme.segments,
                "step": case.grid.step,
                "largest_step": case.grid.largest_step,
                "motor": case.network.motion.motor,
                "friction": case.scheme.friction,
                "slack": case.scheme.slack,
            },
            "torque": [signal.fingerprint for signal in case.torques],
        },
        stopped=stopped,
        wall_time=wall_time,
    )
