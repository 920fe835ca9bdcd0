"""The public door: one run of the nonlinear cable loop."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from cabledrive.mechanics.cable_laws import Model
from cabledrive.mechanics.mesh import FEWEST_SEGMENTS
from cabledrive.parameters import Drive, Machine
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation.case import case_of
from cabledrive.simulation.result import SimulationResult
from cabledrive.simulation.run import keep_run
from cabledrive.simulation.signals import CarriageForce, Function, Signal
from cabledrive.simulation.start import Pluck, Recording, Scheme, Start
from cabledrive.simulation.travel.case import PlannedMove
from cabledrive.simulation.travel.prepare import travel_case


def simulate(
    drive: Machine | Drive,
    duration: float,
    *,
    torque: Signal | float | Function | Mapping[str, Signal | float | Function] = 0.0,
    forces: Sequence[CarriageForce] = (),
    start: Start | Sequence[Pluck] | None = None,
    scheme: Scheme | None = None,
    recording: Recording | None = None,
    model: Model | None = None,
    travel: PlannedMove | bool = False,
    error_estimate: bool = False,
    output: str | Path | None = None,
    force: bool = False,
    resume: bool = False,
    progress: bool | None = False,
) -> SimulationResult:
    """Nonlinear motion of cable and pulleys in time.

    Parameters
    ----------
    drive : Machine or Drive
        A machine with routes moves about its state of rest, see `cabledrive.simulation.network`.
    duration : float
        Length of the run [s].
    torque : Signal, float or callable, default 0.0
        Torque of the motor, of the drive pulley where there is none [N m]: a number, a function of time, or
        one of the signals of `cabledrive.simulation.signals`; of a machine with routes also one by motor.
    forces : sequence of CarriageForce, optional
        Forces on carriages.
    start : sequence of Pluck or Start, optional
        Plucks of spans by their names, or more of what is at t = 0. Default: the straight cable at rest; a
        machine with routes where it hangs.
    scheme : Scheme, optional
        Cable law, method, resolution, friction, what slack means.
    recording : Recording, optional
        What is kept, and how often.
    model : str or subclass of CableLaw, optional
        Cable law, in place of that of `scheme`, see `Scheme`.
    travel : PlannedMove or bool, default False
        Bodies go far, with elastic ropes that run over pulleys and onto drums, so that lengths and directions
        of spans follow; a planned move, whose turns the motors make, or True for given torques. The run
        begins in the pose of the file; `Scheme.segments` is 16 by default. Results are those of machines with
        routes.
    error_estimate : bool, default False
        Whether to estimate the discretisation error from a second run with half as many segments.
    output : path-like, optional
        NetCDF file to write. While the run lasts its records lie beside it, in a folder of that name with
        ".part" behind it.
    force : bool, default False
        Whether an existing file, or what is left of an interrupted run, may be replaced.
    resume : bool, default False
        Go on with an interrupted run of the same settings.
    progress : bool or None, default False
        Whether to show on standard error how far the run is; None: where that is a terminal.

    Returns
    -------
    SimulationResult
        Also of a run that ended early (slack, a number that is not finite, a full disk): ``stopped`` says
        why.

    Raises
    ------
    InputRefused
        If anything about the run is not possible; nothing was written.
    SimulationInterrupted
        On Ctrl-C. It carries the result so far.
    """
    drive = drive.machine
    if model is not None:
        scheme = replace(scheme or Scheme(), model=model)
    keeping: Any = {"output": output, "force": force, "resume": resume, "progress": progress}
    asked: Any = {"torque": torque, "recording": recording, "scheme": scheme}
    asked["start"] = start if isinstance(start, Start) else Start(plucks=tuple(start or ()))
    case: Any
    if travel:
        if forces or error_estimate:
            raise InputRefused("travel goes without forces and error_estimate: leave them out")
        case = travel_case(drive, duration, move=None if travel is True else travel, **asked)
    else:
        prepare = partial(case_of, drive, duration, forces=forces)
        case = prepare(**asked)
        if error_estimate:
            if case.scheme.segments // 4 < FEWEST_SEGMENTS:
                said = f"segments = {case.scheme.segments}: an error estimate halves them twice and needs "
                raise InputRefused(f"{said}{4 * FEWEST_SEGMENTS}: use more")
            case = replace(case, coarser=lambda other: prepare(**asked | {"scheme": other}))
    return keep_run(case, **keeping)
