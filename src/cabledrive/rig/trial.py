"""`track`: run a law on the rig, or two laws one after the other, and judge it by its bounds."""

from dataclasses import replace
from os import PathLike
from typing import Any

import numpy as np

from cabledrive.control.numbers import HIGH, LOW
from cabledrive.control.own_controller import ControllerProtocol, checked_controller
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.route.two_pulleys import AxisDrive
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.reduction.network_axis import cross_motion
from cabledrive.rig.closed_loop.chain_plant import doubled
from cabledrive.rig.closed_loop.loop import Loop, Run, check_drawable, close_loop, run
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY
from cabledrive.rig.closed_loop.own_plant import PlantProtocol
from cabledrive.rig.disturbed_plants import loop_with_loads
from cabledrive.rig.expected_bound import bound_over_draws
from cabledrive.rig.laws.controller_file import is_controller_path, read_controller
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.laws.given import law_from_file, own_law, with_filter
from cabledrive.rig.laws.indirect import NAME, run_indirect, run_learning_samples
from cabledrive.rig.laws.registry import CONTROLLERS, known_name, needed_order
from cabledrive.rig.plant_samples import draw_words, run_samples
from cabledrive.rig.ranked import BEST, best_controller, best_words
from cabledrive.rig.repetition import repeat_motion
from cabledrive.rig.setting import CABLE, DEGREE, Motion, RigOptions, sample_interval
from cabledrive.rig.theorem import bound_along
from cabledrive.rig.tracking import Tracking, summarize, within
from cabledrive.rig.tuning import design
from cabledrive.trajectories import move_limits, peak_demand


def judged_apart(found: Tracking, first: Loop, last: Loop, done: Run) -> Tracking:
    """A run as `cabledrive.rig.tracking.summarize` puts it, its first part held to the first law's bounds."""
    pause = min(first.rig.first_end, done.ended)
    before, after = first.controller, last.controller
    inside = [within(found.estimates[:pause], before), within(found.estimates[pause:], after)]
    found.summary["estimates_within_bounds"] = all(inside)
    low, high = LOW, HIGH
    limits = np.array(
        [
            np.minimum(before.law.learning[low], after.law.learning[low]),
            np.maximum(before.law.learning[high], after.law.learning[high]),
        ]
    )
    found = replace(found, estimate_bounds=limits)
    early = bound_along(first, done.log[:pause])
    if early is None or found.bound is None:
        return found
    if first is not last:  # the causes of the error are measured for one law only: every departure counts
        broken = [*found.summary["departures"], "the law was made anew during the run"]
        found.summary.update(
            broken_assumptions=broken,
            within_bound=None,
            within_bound_reason="; ".join(broken),
            bound_used=None,
        )
    tube = np.concatenate((early.tube / first.gear, found.bound[pause:]))
    printed = max(early.printed / first.gear / DEGREE, found.summary["printed_norm_bound_deg"])
    kept = bool(np.all(np.abs(found.error) <= tube + 1e-12))
    found.summary.update(
        theory_bound_deg=float(tube.max()) / DEGREE, printed_norm_bound_deg=printed, inside_tube=kept
    )
    if not found.summary["broken_assumptions"]:
        found.summary["within_bound"] = kept
    return replace(found, bound=tube)


PLANTS: dict[str, int | None] = {f"model-{number}": number for number in (1, 2, 3, 4)} | {CABLE: None}

GAINS = {"best": True, "dissertation": False, "printed": False}


def track_pulses(
    drive: Drive,
    *,
    controller: str | PathLike[str] | ControllerProtocol | None = None,
    bandwidth: float | None = None,
    plant: str | LumpedChain | PlantProtocol | None = None,
    motion: Motion | None = None,
    options: RigOptions | None = None,
    plant_drive: Drive | None = None,
    seed: int = 0,
    gains: str = "best",
    adapt: bool = True,
    draws: int = 0,
    feedforward: str = "damped",
    repeat: int = 0,
) -> Tracking:
    """Let a control law follow pulses of the load pulley; see `cabledrive.rig.front_door.track`."""
    motion, options = motion or Motion(), options or RigOptions()
    if options.pair:
        drive, plant_drive = doubled(drive), None if plant_drive is None else doubled(plant_drive)
    actual = plant_drive or drive
    if isinstance(actual, AxisDrive) and not options.forbid_slack:
        raise InputRefused("a lumped chain of routes ends where a span goes slack: leave --tension-only out")
    if seed < 0:
        raise InputRefused(f"seed = {seed} must not be negative: give 0 or more")
    if gains not in GAINS:
        raise InputRefused(f"gains = {gains!r} is not known: take best or dissertation")
    file = read_controller(controller) if is_controller_path(controller) else None
    own = file is None and controller is not None and not isinstance(controller, str)
    best = controller == BEST if isinstance(controller, str) else False
    name = controller_name(None if best else controller if file is None else file.name, drive)
    if (file is not None or own or best) and gains != "best":
        raise InputRefused(f'gains = "{gains}" is a setting of the packaged laws: leave it out')
    if file is not None:
        options = replace(options, feedback=file.feedback)
    if motion.order is None:
        motion = replace(motion, order=needed_order(name, drive))
    check_motion(actual, motion)
    check_clock(drive, actual)
    spec = spec_for(
        drive,
        motion,
        bandwidth=bandwidth,
        feedback=options.feedback,
        adapt=adapt,
        best=GAINS[gains],
        feedforward=feedforward,
        options=options,
        plant=plant_drive,
    )
    if file is not None:
        made = law_from_file(file, spec)
    elif best:
        made = best_controller(spec)
    else:
        made = own_law(controller, spec) if own else design(name, spec)
    loop = close_loop(
        drive,
        actual,
        made,
        motion,
        options,
        np.random.default_rng(seed),
        plant_model=plant_number(plant) if isinstance(plant, str) else None,
        cable=isinstance(plant, str) and plant == CABLE,
        plant=None if isinstance(plant, str) else plant,
    )
    if file is not None:
        loop = with_filter(loop, file, options)
    loop = loop_with_loads(loop, motion, options)
    if draws < 0:
        raise InputRefused(f"draws = {draws} must not be negative: ask for 0 or more")
    if draws:
        check_drawable(loop)
    first, learnt = loop, None
    learns = made.name == NAME and not own and file is None
    if repeat and (learns or draws):
        other = f"{NAME} makes its law anew after a pulse" if learns else "draws are runs of their own"
        raise InputRefused(f"repeat = {repeat}: {other}: leave one of the two out")
    repeated = repeat_motion(loop, spec, options, repeat) if repeat else None
    if repeated is not None:
        loop, done = repeated.loop, repeated.done
    elif learns:
        loop, done, learnt = run_indirect(spec, loop, options)
    else:
        done = run(loop)
    found = summarize(loop, done, drive, actual, motion, options, seed)
    if learnt is not None:
        found = judged_apart(found, first, loop, done)
    if repeated is not None:
        found.summary["repeated"] = repeated.words
    if best:
        found.summary["best"] = best_words(spec)
    if learns:
        found.summary["learnt"] = None if learnt is None else learnt.words
    if draws:
        found.summary["over_draws"] = over_draws(first, spec, motion, options, draws, seed)
    if isinstance(drive, AxisDrive):
        found.summary["axis"] = _axis_words(drive, found, actual)
    return found


def _axis_words(drive: AxisDrive, found: Tracking, actual: Drive) -> dict[str, Any]:
    """The chain of a machine with routes, the error of a load that slides [mm], what the chain neglects."""
    peak = found.summary["peak_error_deg"] * DEGREE
    error = {"peak_error_mm": 1e3 * abs(drive.gain) * peak} if drive.slides else {}
    assert isinstance(actual, AxisDrive)
    return drive.words | error | {"cross_motion": cross_motion(actual, found.torque, found.time[1])}


def over_draws(
    loop: Loop, spec: DesignSpec, motion: Motion, options: RigOptions, draws: int, seed: int
) -> dict[str, Any]:
    """Peaks over many plants, each learnt anew by a law that learns and has a second pulse to do so."""
    if loop.controller.name == NAME and loop.controller.own is None and motion.pulses > 1:
        words = run_learning_samples(loop, spec, options, draws, seed).words
        closed: dict[str, Any] = {
            "flanks_closed": None,
            "flanks_closed_reason": f"not looked at in draws of {NAME}",
        }
    else:
        found = run_samples(loop, options, draws, seed)
        words = draw_words(found)
        closed = {"flanks_closed": int(np.count_nonzero(found.scores[:, SUMMARY.index("loose")] == 0.0))}
    if loop.pair is not None:
        words |= closed
    return words | bound_over_draws(loop)


def spec_for(drive: Drive, motion: Motion, **choices: Any) -> DesignSpec:
    """What a law is designed for, from a drive and a motion."""
    interval = sample_interval(drive)
    trajectory = motion.trajectory
    samples = round(trajectory.duration / interval) + 1
    return DesignSpec(
        drive=drive, trajectory=trajectory, interval=interval, samples=samples, motion=motion, **choices
    )


def controller_name(controller: Any, drive: Drive) -> str:
    """Name of a law, or of a controller of the user's own."""
    if controller is None or isinstance(controller, str):
        return known_name(controller, drive)
    name = checked_controller(controller).name
    if name in CONTROLLERS:
        raise InputRefused(f'controller "{name}" has the name of a packaged law: give it another')
    return name


def plant_number(plant: Any) -> int | None:
    """Number of the model that is the plant; None: the highest that the data allow, or the cable."""
    if plant is None:
        return None
    if plant not in PLANTS:
        raise InputRefused(f"plant = {plant!r} is not known: take one of {', '.join(PLANTS)}")
    return PLANTS[plant]


def check_clock(drive: Drive, actual: Drive) -> None:
    """Refuse a plant whose sensors are sampled at another rate than the law's."""
    ours, theirs = (1.0 / sample_interval(one) for one in (drive, actual))
    if abs(ours - theirs) > 1e-9 * ours:
        raise InputRefused(
            f"sensors.sample_rate = {theirs:.6g} Hz of the plant is not the law's {ours:.6g} Hz, and the "
            "controller has one clock: change both with --set"
        )


def check_motion(drive: Drive, motion: Motion) -> None:
    """Refuse a motion beyond the speed, the torque or the slack torque of a drive."""
    _ = motion.trajectory  # refuses what is no motion
    limits = move_limits(drive)
    demand = peak_demand(limits, motion.angle * DEGREE, motion.rise, motion.rise_order)
    bounds = {"speed": "rad/s", "torque": "N m"}
    if drive.kind == "loop":
        bounds["slack_torque"] = "N m"
    for name, unit in bounds.items():
        if demand[name] > getattr(limits, name):
            raise InputRefused(
                f"{motion.angle:.4g} deg in {motion.rise:.4g} s asks for a {name.replace('_', ' ')} of up to "
                f"{demand[name]:.4g} {unit}, above {getattr(limits, name):.4g} {unit}: take longer, turn less"
            )
