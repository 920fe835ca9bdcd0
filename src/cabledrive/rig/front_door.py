"""`track`: the one door to the rig, with laws of the user's own or of a controller.json made ready for it."""

from dataclasses import asdict, replace
from inspect import signature
from math import pi
from os import PathLike
from typing import Any

import numpy as np

from cabledrive.control.load_schedule import LoadSchedule
from cabledrive.control.numbers import DARC, HIGH, LOW, OWN, LawNumbers, start_estimates
from cabledrive.control.own_controller import OwnController, checked_controller
from cabledrive.control.reference import reference_numbers
from cabledrive.parameters import Drive, InputRefused, Machine, content_hash
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.reduction.network_axis import as_axis, axis_words, cross_motion
from cabledrive.reduction.two_motors import is_winched, winched_machine
from cabledrive.rig import setting, trial
from cabledrive.rig.closed_loop.chain_plant import doubled
from cabledrive.rig.closed_loop.loop import Loop, check_drawable, close_loop, run
from cabledrive.rig.closed_loop.own_plant import OwnPlant
from cabledrive.rig.laws import load_learning as learning
from cabledrive.rig.laws.baselines import BASELINES, FEEDFORWARDS, inverse_of
from cabledrive.rig.laws.controller_file import ControllerFile, is_controller_path, read_controller
from cabledrive.rig.laws.controllers import Controller, DesignSpec, chain_law, place
from cabledrive.rig.laws.registry import CONTROLLERS, needed_order
from cabledrive.rig.plant_samples import loop_with_loads
from cabledrive.rig.setting import CABLE, DEGREE, BodyMotion, Motion, RigOptions, check_run, random_from
from cabledrive.rig.tracking import Tracking, summarize
from cabledrive.rig.tuning import design
from cabledrive.rig.winch_plan import design_tensions, plan_motion, way_of
from cabledrive.rig.winch_run import run_plant, run_samples
from cabledrive.rig.winch_summary import CONTROLLER
from cabledrive.rig.winch_summary import summarize as summarize_winches

GAINS = {"best": True, "dissertation": False, "printed": False}


def track(
    drive: Machine | Drive,
    *,
    controller: str | PathLike[str] | OwnController | None = None,
    bandwidth: float | None = None,
    plant: str | LumpedChain | OwnPlant | Any = None,
    motion: Motion | BodyMotion | None = None,
    options: RigOptions | None = None,
    plant_drive: Machine | Drive | None = None,
    axis: str | None = None,
    seed: int = 0,
    gains: str = "best",
    adapt: bool = True,
    draws: int = 0,
    feedforward: str = "damped",
    repeat: int = 0,
    least_tension: float | None = None,
    gust: float | None = None,
) -> Tracking:
    """Let a control law follow pulses on the virtual rig, or move a body between two winches.

    Parameters
    ----------
    drive : Machine or Drive
        As the law believes it to be; of a machine with routes the chain of its axis, where it is one, or the
        body that its two winches move.
    controller : str, path or OwnController, optional
        Name of the law, "best" (what `compare` ranks first), the controller.json of a study or its folder,
        or a controller of your own (`OwnController`); by default the law that the drive's joint calls for.
        One in plain Python runs sample by sample, and the result says so.
    bandwidth : float, optional
        lambda/(2 pi) [Hz] instead of that of ``gains``.
    plant : {"model-1", "model-2", "model-3", "model-4", "cable"}, LumpedChain or OwnPlant, optional
        Default: the highest model that the drive's data allow. "cable": the nonlinear distributed cable. Any
        lumped chain from "motor" to "load", or a plant of your own (`OwnPlant`); encoders, torque limit,
        delay and torque loop stay those of the drive.
    motion : Motion or BodyMotion, optional
        Default: one pulse of 45 deg in 0.5 s with 0.5 s dwell; of two winches a short way and back.
    options : RigOptions, optional
        Default: encoders with random phases, Kalman filter, stick-slip.
    plant_drive : Machine or Drive, optional
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
    Tracking

    Raises
    ------
    InputRefused
        If a name is unknown, data are missing, or the motion exceeds what the drive can do.
    """
    rng = random_from(seed)
    if axis is None and is_winched(drive):
        others = {"plant": plant, "gains": gains, "adapt": adapt, "feedforward": feedforward}
        options = options or RigOptions()
        _refuse_pulses(controller, options, others | {"repeat": repeat})
        if plant_drive is not None and not is_winched(plant_drive):
            raise InputRefused("plant_drive has no winches: give the same machine with other figures")
        machine, motion = winched_machine(drive), BodyMotion.asked(motion)
        tensions = design_tensions(machine, least_tension=least_tension, gust=gust, bandwidth=bandwidth)
        setup = plan_motion(machine, tensions, way_of(machine, motion.moves), motion)
        numbers = machine.numbers if plant_drive is None else winched_machine(plant_drive).numbers
        interval, samples = tensions.gains.interval, len(setup.table)
        setting.check_runs(setup.task, interval, options, draws)
        force = setting.stepped_in(options.disturbances, machine.names, interval, samples)
        ended = run_plant(setup, numbers, force, rng)
        drawn = run_samples(setup, draws, rng) if draws else None
        return summarize_winches(setup, numbers, ended, force, seed=seed, drawn=drawn)
    for name, value in (("least_tension", least_tension), ("gust", gust)):
        if value is not None:
            raise InputRefused(f"{name} is for a body between two winches: this drive has none: leave it out")
    drive = as_axis(drive, axis)
    plant_drive = None if plant_drive is None else as_axis(plant_drive, axis)
    motion, options = Motion.asked(motion), options or RigOptions()
    if options.pair:
        drive, plant_drive = doubled(drive), None if plant_drive is None else doubled(plant_drive)
    actual = plant_drive or drive
    if actual.chain_of and plant != CABLE and not options.forbid_slack:
        raise InputRefused(
            "a lumped chain of routes ends where a span goes slack: leave --tension-only out, or take "
            "--plant cable"
        )
    if gains not in GAINS:
        raise InputRefused(f"gains = {gains!r} is not known: take best or dissertation")
    file = read_controller(controller) if is_controller_path(controller) else None
    own = file is None and controller is not None and not isinstance(controller, str)
    best = controller == trial.BEST if isinstance(controller, str) else False
    name = trial.controller_name(None if best else controller if file is None else file.name, drive)
    if (file is not None or own or best) and gains != "best":
        raise InputRefused(f'gains = "{gains}" is a setting of the packaged laws: leave it out')
    if not (adapt or own or best) and name in BASELINES:
        raise InputRefused(f"adapt = False, --no-adaptation: {name} adapts nothing: leave it out")
    if file is not None:
        options = replace(options, feedback=file.feedback)
    if motion.order is None:
        known = None if file is None else file.order
        motion = replace(motion, order=known or needed_order(name, drive))
    check_run(actual, motion, options, draws=draws, cable=plant == CABLE)
    trial.check_motion(actual, motion)
    trial.check_clock(drive, actual)
    spec = DesignSpec(
        drive,
        motion,
        bandwidth=bandwidth,
        adapt=adapt,
        best=GAINS[gains],
        feedforward=feedforward,
        options=options,
        plant=plant_drive,
    )
    made = law_for(controller, spec) if file is None else law_from_file(file, spec)
    loop = close_loop(spec, made, rng, plant)
    loop = loop_with_loads(loop if file is None else with_filter(loop, file))
    if draws:
        check_drawable(loop)
    first, learnt, more = loop, None, dict[str, Any]()
    learns = learning.made_anew(loop.controller) and file is None
    if repeat and (learns or draws):
        other = (
            f"{learning.INDIRECT} makes its law anew after a pulse"
            if learns
            else "draws are runs of their own"
        )
        raise InputRefused(f"repeat = {repeat}: {other}: leave one of the two out")
    if repeat:
        loop, done, more["repeated"] = trial.repeat_motion(loop, repeat)
    elif learns:
        loop, done, learnt = learning.run_indirect(loop)
        more["learnt"] = None if learnt is None else learnt.words
    else:
        done = run(loop)
    found = summarize(loop, done, seed)
    if learnt is not None:
        found = trial.judged_apart(found, first, loop, done)
    found.summary.update(more)
    if best:
        found.summary["best"] = trial.best_words(spec)
    if draws:
        found.summary["over_draws"] = trial.over_draws(first, draws, seed)
    # The error of a load that slides, and what a chain of routes neglects.
    peak = found.summary["peak_error_deg"] * DEGREE
    error = {"peak_error_mm": 1e3 * abs(drive.axis.gain) * peak} if drive.axis.slides else {}
    cross = cross_motion(actual, found.torque, found.time[1])
    found.summary.update(axis_words(drive, **error, cross_motion=cross))
    return found


def _refuse_pulses(controller: Any, options: RigOptions, others: dict[str, Any]) -> None:
    """Refuse what is asked of two winches and is for pulses of a load pulley."""
    if controller not in (None, CONTROLLER, "best"):  # names of the one law of two winches
        said = f'controller = "{str(controller)[:60]}" moves a load by one motor'
        raise InputRefused(f"{said}: a body between two winches has {CONTROLLER}: leave it out")
    usual = {name: one.default for name, one in signature(track).parameters.items()} | asdict(RigOptions())
    for name, value in (others | asdict(replace(options, disturbances=()))).items():
        if value != usual[name]:
            raise InputRefused(
                f"{name} is for pulses of a load pulley: two winches move a body: leave it out"
            )


def law_for(controller: Any, spec: DesignSpec) -> Controller:
    """A law by its name, "best", the drive's own, or one of the user's."""
    if controller is not None and not isinstance(controller, str):
        return own_law(controller, spec)
    return trial.best_controller(spec) if controller == trial.BEST else design(controller, spec)


def own_law(given: Any, spec: DesignSpec) -> Controller:
    """The user's controller with its reference along the motion."""
    own = checked_controller(given)
    if own.sample_time is not None and abs(own.sample_time - spec.interval) > 1e-9 * spec.interval:
        raise InputRefused(
            f'controller "{own.name}": sample_time = {own.sample_time:.6g} s is not that of the rig, '
            f"{spec.interval:.6g} s: design it for that, or change sensors.sample_rate"
        )
    if spec.bandwidth is not None:
        said = f"bandwidth = {spec.bandwidth:.4g} Hz is a setting of the packaged laws"
        raise InputRefused(f'{said}; "{own.name}" has gains of its own: leave it out')
    if not spec.adapt:
        raise InputRefused(f'adapt = False is a setting of the packaged laws: leave it out for "{own.name}"')
    chain, shafts = spec.chain, own.shafts or spec.shafts
    if "drive" in shafts and chain.size == 2 and "motor" in shafts:
        raise InputRefused(
            f'controller "{own.name}": shafts = {shafts}, but motor and drive pulley of {spec.drive.name} '
            "turn as one: take motor and load, or give motor.joint_stiffness"
        )
    gains, n, generator = {"measures": own.measures, "follows": own.follows}, chain.size, None
    if own.follows == "motion":
        generator = reference_numbers(np.eye(2 * n + 1))
        reference = spec.rows(generator)
    else:
        gains["feedforward"] = FEEDFORWARDS[spec.feedforward]
        places, whole = [place(chain, shaft) for shaft in shafts], inverse_of(spec, chain)
        kept = [*places, *(n + i for i in places), 2 * n]
        reference = spec.rows(whole)[:, kept]
        if "motor" in shafts or chain.coulomb[0] == 0.0:  # else friction needs a shaft that is left out
            columns = [[kept.index(column) for column in one] for one in whole.places.tolist()]
            generator = whole._replace(
                output=np.ascontiguousarray(whole.output[kept]),
                constant=whole.constant[kept],
                places=np.array(columns, dtype=np.int64).reshape(-1, 2),
            )
    return Controller(
        name=own.name,
        law=LawNumbers(OWN, np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((5, 0)), np.zeros(7)),
        reference=np.ascontiguousarray(reference),
        shafts=shafts,
        gains=gains,
        model=spec.number,
        own=own,
        generator=generator,
    )


def law_from_file(found: ControllerFile, spec: DesignSpec) -> Controller:
    """The law of a file with its reference along another motion; tables along the motion are made anew."""
    if content_hash(spec.drive) != found.drive_hash:
        raise InputRefused(
            f"was made for another drive, hash {found.drive_hash[:12]}, not {content_hash(spec.drive)[:12]}: "
            "give the drive.toml beside it, and what differs as the plant"
        ).at(found.path)
    if spec.bandwidth is not None or not spec.adapt:
        raise InputRefused("holds its own gains: leave bandwidth and adaptation out").at(found.path)
    if spec.feedforward != "damped":
        raise InputRefused("holds a law with the damped inverse: leave feedforward out").at(found.path)
    spec = replace(spec, best=False)
    if found.reference is None:
        raise InputRefused("has no generator of its reference: run the study again").at(found.path)
    # the packaged law of that name, for what a run says of it
    given = replace(spec, bandwidth=found.bandwidth)
    if found.name.endswith("-damped"):  # without the trial runs that chose its gains
        made = chain_law(given, int(found.name.split("-")[1]), damped=True)
    elif found.name in learning.KINDS:
        made = learning.load_learning(given, found.name, found.reference.load.turning)
    else:
        made = CONTROLLERS[found.name](given)
    hertz = {} if found.bandwidth is None else {"bandwidth_hz": found.bandwidth}
    rate = None if found.bandwidth is None or found.law.kind != DARC else 2.0 * pi * found.bandwidth
    gains = {"file": found.path} | hertz
    changed = replace(made, law=found.law, start=start_estimates(found.law), gains=gains, bandwidth=rate)
    made = replace(changed, reference=spec.rows(found.reference), generator=found.reference)
    if made.schedule is None:
        return made
    low, high = (float(end) for end in made.law.learning[[LOW, HIGH], 0])
    for one in spec.motion.payload:  # that the motion announces
        if not low <= one.factor <= high:
            raise InputRefused(
                f"payload = {one.factor:.4g} times the load is outside what it is designed for, {low:.4g} to "
                f"{high:.4g}: announce less, or design it anew with a wider payload_range"
            ).at(found.path)
    schedule = LoadSchedule(low=low, high=high, points=len(made.law.rows))
    load = learning.announced(spec.motion.payload, spec.interval, len(made.reference))
    return learning.with_announced_load(replace(made, schedule=schedule), load)


def with_filter(loop: Loop, found: ControllerFile) -> Loop:
    """A loop with the filter and the torque limit of a file."""
    wrong = ""
    if loop.spec.options.ideal_sensors or loop.spec.options.observer != "kalman":
        wrong = "brings its own Kalman filter: leave observer and ideal_sensors out"
    elif abs(found.sample_time - loop.rig.interval) > 1e-9 * found.sample_time:
        wrong = f"samples every {found.sample_time:.6g} s, the rig every {loop.rig.interval:.6g} s"
    elif found.encoders != loop.encoder_shafts:
        wrong = f"reads the encoders of {found.encoders}, the rig {loop.encoder_shafts}"
    if wrong:
        raise InputRefused(wrong).at(found.path)
    limit = min(found.torque_limit, loop.rig.torque_limit)
    return replace(loop, observer=found.observer, rig=loop.rig._replace(torque_limit=limit))
