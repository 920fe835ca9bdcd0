"""One run of a machine with routes in time."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.simulation.case import Recording
from cabledrive.simulation.kept_run import how_to_go_on, keep_run
from cabledrive.simulation.network.case import network_case
from cabledrive.simulation.network.result import NetworkResult
from cabledrive.simulation.network.result_of_run import network_content, network_result
from cabledrive.simulation.network.start import NetworkStart
from cabledrive.simulation.scheme import Scheme
from cabledrive.simulation.signals import Function, Signal
from cabledrive.simulation.stopped import SimulationInterrupted


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
