"""One run of a machine whose bodies travel: lengths and directions of spans follow, drums wind."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from cabledrive.parameters.route import RoutedDrive
from cabledrive.simulation.case import Recording
from cabledrive.simulation.kept_run import how_to_go_on, keep_run
from cabledrive.simulation.network.result import NetworkResult
from cabledrive.simulation.network.result_of_run import network_content
from cabledrive.simulation.network.start import NetworkStart
from cabledrive.simulation.scheme import Scheme
from cabledrive.simulation.signals import Function, Signal
from cabledrive.simulation.stopped import SimulationInterrupted
from cabledrive.simulation.travel.case import PlannedMove
from cabledrive.simulation.travel.prepare import travel_case
from cabledrive.simulation.travel.result_of_run import travel_result


def simulate_travel(
    drive: RoutedDrive,
    duration: float,
    *,
    move: PlannedMove | None = None,
    torque: Mapping[str, Signal | float | Function] | Signal | float | Function = 0.0,
    start: NetworkStart | None = None,
    scheme: Scheme | None = None,
    recording: Recording | None = None,
    output: str | Path | None = None,
    force: bool = False,
    resume: bool = False,
    progress: bool | None = False,
) -> NetworkResult:
    """Motion of a machine whose bodies travel, with elastic ropes that run over pulleys and onto drums.

    Parameters
    ----------
    drive : RoutedDrive
    duration : float
        Length of the run [s].
    move : PlannedMove, optional
        Where bodies go; the motors turn as it asks for where nothing stretches. Default: torques are given.
    torque : Signal, float, callable or dict of them by motor, default 0.0
        Without a move: torque of the first motor, or of each by the name of its pulley, beyond what holds the
        machine at rest [N m].
    start : NetworkStart, optional
        Speeds of coordinates; the run begins in the pose of the file.
    scheme : Scheme, optional
        Resolution, by default 16 cells on the longest span; the exact law, and slack that ends the run.
    recording : Recording, optional
        How often it is recorded.
    output : path-like, optional
        NetCDF file to write; it appears whole or not at all.
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
    case = travel_case(
        drive, duration, move=move, torque=torque, start=start, scheme=scheme, recording=recording
    )
    result, outcome = keep_run(
        case,
        partial(travel_result, case),
        network_content,
        output=output,
        force=force,
        resume=resume,
        progress=progress,
    )
    if outcome.interrupted:
        raise SimulationInterrupted(how_to_go_on(result.steps * result.step, output), result)
    return result
