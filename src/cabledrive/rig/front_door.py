"""`track`: the one door to the rig, for pulses of a load pulley and for a body between two winches."""

from dataclasses import fields
from os import PathLike
from typing import Any, overload

import numpy as np

from cabledrive.control.own_controller import ControllerProtocol
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.reduction.network_axis import as_axis
from cabledrive.reduction.two_motors import is_winched, winched_machine
from cabledrive.rig.closed_loop.own_plant import PlantProtocol
from cabledrive.rig.setting import BodyMotion, Disturbance, Motion, RigOptions
from cabledrive.rig.tracking import Tracking
from cabledrive.rig.trial import track_pulses
from cabledrive.rig.two_motors.plan import ORDER, design_tensions, plan_motion, way_of
from cabledrive.rig.two_motors.run import Setup, TwoMotorTracking, forces_of, run_plant, run_samples
from cabledrive.rig.two_motors.summary import CONTROLLER, summarize


@overload
def track(
    drive: Drive,
    *,
    controller: str | PathLike[str] | ControllerProtocol | None = ...,
    bandwidth: float | None = ...,
    plant: str | LumpedChain | PlantProtocol | None = ...,
    motion: Motion | None = ...,
    options: RigOptions | None = ...,
    plant_drive: Drive | RoutedDrive | None = ...,
    axis: None = ...,
    seed: int = ...,
    gains: str = ...,
    adapt: bool = ...,
    draws: int = ...,
    feedforward: str = ...,
    repeat: int = ...,
) -> Tracking: ...


@overload
def track(
    drive: Drive | RoutedDrive,
    *,
    controller: str | PathLike[str] | ControllerProtocol | None = ...,
    bandwidth: float | None = ...,
    plant: str | LumpedChain | PlantProtocol | None = ...,
    motion: Motion | BodyMotion | None = ...,
    options: RigOptions | None = ...,
    plant_drive: Drive | RoutedDrive | None = ...,
    axis: str | None = ...,
    seed: int = ...,
    gains: str = ...,
    adapt: bool = ...,
    draws: int = ...,
    feedforward: str = ...,
    repeat: int = ...,
    least_tension: float | None = ...,
    gust: float | None = ...,
) -> Tracking | TwoMotorTracking: ...


def track(
    drive: Drive | RoutedDrive,
    *,
    controller: str | PathLike[str] | ControllerProtocol | None = None,
    bandwidth: float | None = None,
    plant: str | LumpedChain | PlantProtocol | None = None,
    motion: Motion | BodyMotion | None = None,
    options: RigOptions | None = None,
    plant_drive: Drive | RoutedDrive | None = None,
    axis: str | None = None,
    seed: int = 0,
    gains: str = "best",
    adapt: bool = True,
    draws: int = 0,
    feedforward: str = "damped",
    repeat: int = 0,
    least_tension: float | None = None,
    gust: float | None = None,
) -> Tracking | TwoMotorTracking:
    """Let a control law follow pulses on the virtual rig, or move a body between two winches.

    Parameters
    ----------
    drive : Drive or RoutedDrive
        As the law believes it to be; of a machine with routes the chain of its axis, where it is one, or the
        body that its two winches move.
    controller : str, path or ControllerProtocol, optional
        Name of the law, "best" (what `compare` ranks first), the controller.json of a study or its folder,
        or a controller of your own (`OwnController`); by default the law that the drive's joint calls for.
        One in plain Python runs sample by sample, and the result says so.
    bandwidth : float, optional
        lambda/(2 pi) [Hz] instead of that of ``gains``.
    plant : {"model-1", "model-2", "model-3", "model-4", "cable"}, LumpedChain or PlantProtocol, optional
        Default: the highest model that the drive's data allow. "cable": the nonlinear distributed cable. Any
        lumped chain from "motor" to "load", or a plant of your own (`OwnPlant`); encoders, torque limit,
        delay and torque loop stay those of the drive.
    motion : Motion or BodyMotion, optional
        Default: one pulse of 45 deg in 0.5 s with 0.5 s dwell; of two winches a short way and back.
    options : RigOptions, optional
        Default: encoders with random phases, Kalman filter, stick-slip.
    plant_drive : Drive, optional
        The drive as it is, where that differs.
    axis : str, optional
        Of a machine with routes: its load, such as "head.x"; default: the first that is a chain.
    seed : int, default 0
        Of encoder phases and jitter.
    gains : {"best", "dissertation"}
        The bandwidth that trial runs accept on this drive with these options, or that of the dissertation;
        "printed" is another name of the second.
    adapt : bool, default True
        Whether estimates move.
    draws : int, default 0
        How many plants to draw from what is known of the drive, besides the run that is kept.
    feedforward : {"damped", "undamped", "rigid"}
        Of the baselines; the laws of the chain bring their own.
    repeat : int, default 0
        Repeat the motion at most so often and learn the torque that is missing along it between repetitions;
        the result is the best repetition, with the proof of convergence.
    least_tension : float, optional
        Of two winches: tension that no line may fall below [N]; default: a fifth of the smaller one at rest.
    gust : float, optional
        Of two winches: force on the body for which that is promised [N]; default: a tenth of its weight.

    Returns
    -------
    Tracking or TwoMotorTracking
        The second of a body between two winches.

    Raises
    ------
    InputRefused
        If a name is unknown, data are missing, or the motion exceeds what the drive can do.
    """
    if isinstance(drive, RoutedDrive) and axis is None and is_winched(drive):
        others = (plant, gains, adapt, feedforward, repeat)
        _refuse_pulses(controller, motion, options or RigOptions(), dict(zip(PULSES, others, strict=True)))
        if isinstance(plant_drive, Drive):
            raise InputRefused("plant_drive has no winches: give the same machine with other figures")
        assert not isinstance(motion, Motion)
        return track_two_motors(
            drive,
            motion=motion,
            least_tension=least_tension,
            gust=gust,
            bandwidth=bandwidth,
            disturbances=() if options is None else options.disturbances,
            plant_drive=plant_drive,
            seed=seed,
            draws=draws,
        )
    for name, value in (("least_tension", least_tension), ("gust", gust)):
        if value is not None:
            raise InputRefused(f"{name} is for a body between two winches: this drive has none: leave it out")
    if isinstance(motion, BodyMotion):
        raise InputRefused(
            "motion = BodyMotion(...) is for a body between two winches: give Motion(angle=45)"
        )
    return track_pulses(
        as_axis(drive, axis),
        controller=controller,
        bandwidth=bandwidth,
        plant=plant,
        motion=motion,
        options=options,
        plant_drive=None if plant_drive is None else as_axis(plant_drive, axis),
        seed=seed,
        gains=gains,
        adapt=adapt,
        draws=draws,
        feedforward=feedforward,
        repeat=repeat,
    )


OWN = (None, CONTROLLER, "best")
"""Names of the one law that moves a body between two winches."""
PULSES: dict[str, Any] = {
    "plant": None, "gains": "best", "adapt": True, "feedforward": "damped", "repeat": 0
}  # fmt: skip
"""Arguments of `track` that winches do not have, by default."""


def _refuse_pulses(
    controller: Any, motion: Motion | BodyMotion | None, options: RigOptions, others: dict[str, Any]
) -> None:
    """Refuse what is asked of two winches and is for pulses of a load pulley."""
    if controller not in OWN:
        raise InputRefused(
            f'controller = "{str(controller)[:60]}" moves a load by one motor: a body between two winches '
            f"has {CONTROLLER}: leave it out"
        )
    if isinstance(motion, Motion):
        raise InputRefused(
            "motion = Motion(...) is a pulse of a load pulley: two winches move a body, give "
            'BodyMotion(moves={"camera.x": 2.0})'
        )
    names = [field.name for field in fields(RigOptions) if field.name != "disturbances"]
    plain = PULSES | {name: getattr(RigOptions(), name) for name in names}
    for name, value in (others | {name: getattr(options, name) for name in names}).items():
        if value != plain[name]:
            raise InputRefused(
                f"{name} is for pulses of a load pulley: two winches move a body: leave it out"
            )


def track_two_motors(
    drive: RoutedDrive,
    *,
    motion: BodyMotion | None = None,
    least_tension: float | None = None,
    gust: float | None = None,
    bandwidth: float | None = None,
    disturbances: tuple[Disturbance, ...] = (),
    plant_drive: RoutedDrive | None = None,
    seed: int = 0,
    draws: int = 0,
) -> TwoMotorTracking:
    """Move a body that two motors hold between them and keep both lines tight; arguments as of `track`."""
    if seed < 0:
        raise InputRefused(f"seed = {seed} must not be negative: give 0 or more")
    machine, motion = winched_machine(drive), motion or BodyMotion()
    design = design_tensions(machine, least_tension=least_tension, gust=gust, bandwidth=bandwidth)
    plan = plan_motion(
        machine,
        design,
        way_of(machine, motion.moves),
        rise=motion.rise,
        dwell=motion.dwell,
        pulses=motion.pulses,
        order=ORDER if motion.order is None else motion.order,
    )
    setup = Setup(machine=machine, design=design, plan=plan)
    actual = machine.numbers if plant_drive is None else winched_machine(plant_drive).numbers
    force, rng = forces_of(setup, disturbances), np.random.default_rng(seed)
    done = run_plant(setup, actual, force, rng)
    drawn = run_samples(setup, draws, rng) if draws else None
    return summarize(setup, actual, done, force, seed=seed, drawn=drawn)
