"""Runs beyond one: two laws in turn, many plants, a motion repeated, laws ranked; what is refused before."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from cabledrive.control.bound import impulse_response
from cabledrive.control.numbers import GAIN, HIGH, LEARNING, LINEAR, LOW
from cabledrive.control.own_controller import checked_controller
from cabledrive.control.regression import RepetitionLearning, lifted, repetition_learning, torque_along
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.parts import require_within_travel
from cabledrive.parameters.route.strain_free import place_of
from cabledrive.reduction.lumped_chain import highest_model
from cabledrive.rig import plant_samples as plants
from cabledrive.rig.bounds import bound_along
from cabledrive.rig.closed_loop.loop import Loop, Run, run, with_plant
from cabledrive.rig.laws.controllers import Controller, DesignSpec, load_count, load_gear
from cabledrive.rig.laws.load_learning import CHANGING, INDIRECT, LOAD_LEARNING, SCHEDULED, made_anew
from cabledrive.rig.laws.registry import CONTROLLERS, MAIN_LAWS, OPEN_LOOPS, known_name
from cabledrive.rig.margins import bound_over_draws, closed_loop, sampled_controller, sampled_plant
from cabledrive.rig.setting import DEGREE, Motion, RigOptions, sample_interval
from cabledrive.rig.tracking import Tracking, within
from cabledrive.rig.tuning import LawSetting, law_at, limit_words, ripple_limit, setting_of, tuned_loop
from cabledrive.trajectories.limits import move_limits, peak_demand


def judged_apart(found: Tracking, first: Loop, last: Loop, done: Run) -> Tracking:
    """A run as `cabledrive.rig.tracking.summarize` puts it, its first part held to the first law's bounds."""
    pause = min(first.rig.first_end, done.ended)
    before, after = first.controller, last.controller
    inside = [within(found.estimates[:pause], before), within(found.estimates[pause:], after)]
    found.summary["estimates_within_bounds"] = all(inside)
    both = np.array([before.law.learning, after.law.learning])
    limits = np.array([both[:, LOW].min(axis=0), both[:, HIGH].max(axis=0)])
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


def over_draws(loop: Loop, draws: int, seed: int) -> dict[str, Any]:
    """Peaks over many plants; of a law that learns on each, and has a second pulse for it, the later ones."""
    learns = made_anew(loop.controller) and loop.spec.motion.pulses > 1
    found = replace(plants.over(plants.sampled_loops(loop, draws, seed)), learns=learns)
    shares = {"median_peak_error_deg": 0.5, "peak_error_99_deg": 0.99, "worst_peak_error_deg": 1.0}
    words = {"draws": draws} | plants.error_words(found.errors / DEGREE, shares)
    words |= {
        "worst_first_pulse_error_deg": max(found.first_peak) / DEGREE,
        "worst_torque": max(found.peak_torque),
        "failed": sum(found.failed),
    }
    if loop.pair is not None:
        words["flanks_closed"] = found.loose.count(0.0)
    return words | bound_over_draws(loop)


def controller_name(controller: Any, drive: Drive) -> str:
    """Name of a law, or of a controller of the user's own."""
    if controller is None or isinstance(controller, str):
        return known_name(controller, drive)
    name = checked_controller(controller).name
    if name in CONTROLLERS:
        raise InputRefused(f'controller "{name}" has the name of a packaged law: give it another')
    return name


def check_clock(drive: Drive, actual: Drive) -> None:
    """Refuse a plant whose sensors are sampled at another rate than the law's."""
    ours, theirs = (1.0 / sample_interval(one) for one in (drive, actual))
    if abs(ours - theirs) > 1e-9 * ours:
        said = f"sensors.sample_rate = {theirs:.6g} Hz of the plant is not the law's {ours:.6g} Hz"
        raise InputRefused(f"{said}, and the controller has one clock: change both with --set")


def check_motion(drive: Drive, motion: Motion) -> None:
    """Refuse a motion beyond the speed, the torque or the slack torque of a drive."""
    _ = motion.trajectory  # refuses what is no motion
    check_way(drive, motion.angle * DEGREE)
    limits = move_limits(drive)
    demand = peak_demand(limits, motion.angle * DEGREE, motion.rise, motion.rise_order)
    bounds = {"speed": "rad/s", "torque": "N m"}
    if drive.closed:
        bounds["slack_torque"] = "N m"
    for name, unit in bounds.items():
        if demand[name] > getattr(limits, name):
            raise InputRefused(
                f"{motion.angle:.4g} deg in {motion.rise:.4g} s asks for a {name.replace('_', ' ')} of up to "
                f"{demand[name]:.4g} {unit}, above {getattr(limits, name):.4g} {unit}: take longer, turn less"
            )


def check_way(drive: Drive, angle: float) -> None:
    """Refuse a way of the load [rad] that leaves what its body may travel."""
    machine, load = drive.axis.machine, drive.axis.load
    for body in machine.body:
        if body.name == load.rpartition(".")[0]:
            require_within_travel(body, place_of(machine, load) + drive.axis.per_angle * angle)


NODE_TIME = 4e-3
"""From node to node of the torque [s]."""
RIPPLE_SHARE = 0.2
"""Of the torque ripple that a comparison allows, for what rounding makes of the learnt torque."""
MOST_REPETITIONS = 100
PATIENCE, LEAST_GAIN = 2, 0.02
"""Repetitions without a smaller error by so much after which learning stops."""
ASSUMED = (
    "each repetition starts from rest at the same place",
    "motor and load slip: where they stick the loop is not the linear one of the proof",
)


def repeat_motion(loop: Loop, repetitions: int) -> tuple[Loop, Run, dict[str, Any]]:
    """Run a motion several times and learn the torque that is missing along it.

    Learning goes by the load's encoder, which is all that a machine sees. It stops when the root mean square
    of its error has not fallen by 2 % for two repetitions. Returns the loop with the torque of the best
    repetition, that one, errors of each and the proof of convergence for people and JSON.
    """
    made = loop.controller
    if not 2 <= repetitions <= MOST_REPETITIONS:
        raise InputRefused(f"repeat = {repetitions} must be from 2 to {MOST_REPETITIONS}")
    if made.own is not None or loop.own_plant is not None:
        raise InputRefused("repeat needs a packaged law and plant, whose equations are known: leave it out")
    if made.law.kind not in (LINEAR, LEARNING):
        raise InputRefused(
            f"repeat adds a torque along the motion, and {made.name} takes none: take lqg, lqi, "
            "lqi-learning, pd or another law with a feedforward torque"
        )
    done = run(loop)
    width = max(1, round(NODE_TIME / loop.rig.interval))
    nodes = len(loop.target) // width
    learning = design_learning(loop, width, nodes)
    frozen = loop
    if made.law.kind == LEARNING:  # with the estimates of the first repetition: the proof is of a fixed loop
        count = made.law.learning.shape[1]
        start, table = np.zeros_like(made.start), made.law.learning.copy()
        start[:count], table[GAIN] = done.state.controller.parameters[:count], 0.0
        frozen = replace(loop, controller=replace(made, start=start, law=made.law._replace(learning=table)))
    place, best, errors = np.zeros(learning.directions.shape[1]), (loop, done), [_errors(loop, done)]
    radius = learning.radius(_mean_error(loop, done, width, nodes))
    waited, stopped = 0, f"{repetitions} repetitions, as asked"
    while len(errors) < repetitions:
        if done.failed:
            stopped = "a repetition ended before its time"
            break
        place = learning.corrected(place, _mean_error(loop, done, width, nodes), radius)
        torque, made = torque_along(learning.directions @ place, width, len(loop.target)), frozen.controller
        table = made.reference.copy()
        table[: len(torque), 2 * len(made.shafts)] += torque
        tried = replace(frozen, controller=replace(made, reference=table))
        done = run(tried)
        errors.append(_errors(tried, done))
        least = min(one["encoder_rms_deg"] for one in errors[:-1])
        waited = 0 if errors[-1]["encoder_rms_deg"] < (1.0 - LEAST_GAIN) * least else waited + 1
        if not done.failed and errors[-1]["encoder_rms_deg"] < least:
            best = tried, done
        if waited == PATIENCE:
            stopped = f"the error fell by less than {100 * LEAST_GAIN:g} % for {PATIENCE} repetitions"
            break
    words = {
        "repetitions": errors,
        "best": errors.index(min(errors, key=lambda one: one["encoder_rms_deg"])) + 1,
        "stopped": stopped,
        "contraction": learning.contraction,
        "directions": int(learning.directions.shape[1]),
        "assumed": list(ASSUMED),
    }
    return *best, words


def design_learning(loop: Loop, width: int, nodes: int) -> RepetitionLearning:
    """What is learnt between repetitions, with its contraction on the nominal plant and at eight corners."""
    believed = replace(loop, cable=None)
    chain = loop.spec.model(loop.controller.model)
    chains = [chain, *plants.corners(chain)]
    maps = [_lifted(with_plant(believed, chain), width, nodes) for chain in chains]
    noise, ripple = float(loop.rig.counts[-1]) / np.sqrt(12.0), RIPPLE_SHARE * ripple_limit(loop.spec)
    found = repetition_learning(maps[0][0], [error for error, _ in maps[1:]], maps[0][1], noise, ripple)
    if found is None:
        said = "repeat: not one direction of the torque converges on every plant within the intervals"
        raise NotComputed(f"{said}: raise the bandwidth, or leave repeat out")
    return found


def _lifted(loop: Loop, width: int, nodes: int) -> tuple[Array, Array]:
    """From torque at the nodes to the load's error, and to the whole command, in the linear loop."""
    controller, plant = sampled_controller(loop), sampled_plant(loop)
    matrix, _, command = closed_loop(controller, plant)
    push = np.concatenate((plant.b, controller.b[:, -1:]))
    push[-1] = 1.0  # the last command that the law remembers holds the added torque as well
    load = np.zeros(len(matrix))
    load[loop.chain.size - 1] = 1.0
    later = impulse_response(matrix, push, np.array((load, command)), nodes * width - 1)[:, :, 0]
    both = np.vstack(([0.0, 1.0], later))  # the added torque itself comes at once
    return lifted(both[:, 0], nodes, width), lifted(both[:, 1], nodes, width)


def _readings(loop: Loop, done: Run) -> Array:
    """What the load's encoder says of the error, shape (samples,) [rad at the first shaft]."""
    last = 2 * loop.chain.size + len(loop.rig.encoders)
    return np.asarray(done.log[: done.ended, last] - loop.target[: done.ended])


def _mean_error(loop: Loop, done: Run, width: int, nodes: int) -> Array:
    error = np.nan_to_num(_readings(loop, done))
    return np.asarray(error[: nodes * width].reshape(nodes, width).mean(axis=1))


def _errors(loop: Loop, done: Run) -> dict[str, Any]:
    """Root mean square by the load's encoder, and the largest true error [deg]."""
    seen, true = _readings(loop, done) / loop.gear / DEGREE, loop.load_error(done.log)[: done.ended] / DEGREE
    return {
        "encoder_rms_deg": float(np.sqrt(np.nanmean(seen**2))) if not done.failed else float("inf"),
        "peak_error_deg": float(np.abs(true).max()),
    }


BEST = "best"
LEARNS = (INDIRECT, LOAD_LEARNING, CHANGING)
"""Laws whose first pulse is for learning, where there are more."""
BEST_DRAWS = 20
COMPARED = RigOptions(forbid_slack=False)
"""Options of a comparison: random encoder phases, Kalman filter, spans that may go slack and go on."""


def offered(drive: Drive, disturbances: plants.Disturbances) -> tuple[str, ...]:
    """Laws compared where none are named, simplest first; more where the load changes, or for a stepper."""
    rigid = "darc-3-damped" if highest_model(drive) < 4 else "darc-4-damped"
    *fixed, learning = (rigid if name == "darc-4-damped" else name for name in MAIN_LAWS)
    steppers = OPEN_LOOPS if drive.motor is not None and drive.motor.holding_stiffness else ()
    changing = (SCHEDULED, CHANGING) if disturbances.changes_load else ()
    return (*steppers, *fixed, *changing, learning)


def checked_names(names: Sequence[str], drive: Drive) -> tuple[str, ...]:
    """Names of laws, each once."""
    for place, name in enumerate(names):
        if known_name(name, drive) in names[:place]:
            raise InputRefused(f"controller {name} is given twice: name each once")
    if not names:
        raise InputRefused("controllers: none are named: name at least one, such as lqi,darc-4-damped")
    return tuple(names)


def one_count(drive: Drive) -> float:
    """One count of the load's encoder, else of the one nearest to it, at the load [rad]."""
    return load_count(drive) / load_gear(drive)


def goal_of(drive: Drive) -> float:
    """Error that is to be kept: the drive's own goal, or one count of the load's encoder [rad]."""
    own = drive.goal.tracking_error if drive.goal is not None else None
    return one_count(drive) if own is None else own


def no_runs(name: str, motion: Motion) -> plants.Draws:
    """What runs of a law along a motion are joined to."""
    return plants.Draws(learns=motion.pulses > 1 and name in LEARNS)


@lru_cache(maxsize=8)
def best_law(spec: DesignSpec) -> tuple[LawSetting, dict[str, plants.Draws]]:
    """The law with feedback that ranks first on a drive, tuned, and what each reached on the first plants."""
    disturbances, goal = plants.standard_disturbances(spec.drive), goal_of(spec.drive)
    settings, reached = dict[str, LawSetting](), dict[str, plants.Draws]()
    for name in offered(spec.drive, disturbances):
        if name in OPEN_LOOPS:  # no controller, as which "best" is exported and studied
            continue
        settings[name], reached[name] = setting_of(name, spec, disturbances), no_runs(name, spec.motion)
        if (hertz := settings[name].bandwidth) is not None:
            loop = tuned_loop(name, hertz, settings[name].filter, spec)
            reached[name] = reached[name].joined(plants.scored(loop, disturbances, 0, range(BEST_DRAWS)))
    best = min(reached, key=lambda name: reached[name].rank(goal))
    if settings[best].bandwidth is None:
        raise NotComputed("no law of the comparison can be tuned on this drive: name one, such as pd")
    return settings[best], reached


def best_controller(spec: DesignSpec) -> Controller:
    """The law that ranks first, with the bandwidth and the filter that the comparison tuned."""
    if spec.bandwidth is not None or spec.feedforward != "damped" or not spec.adapt:
        said = "controller = best is tuned as a whole"
        raise InputRefused(f"{said}: leave bandwidth, feedforward and no-adaptation out, or name a law")
    tuned, _ = best_law(_compared(spec))
    name = tuned.controller
    assert tuned.bandwidth is not None
    reason = f"{name} at {tuned.bandwidth:g} Hz, filter {tuned.filter}: ranks first over {BEST_DRAWS} "
    reason += f"plants with friction at the load; the highest bandwidth that keeps {limit_words(spec)}"
    made = law_at(name, tuned.bandwidth, tuned.filter, spec)
    return replace(made, gains=made.gains | {"reasons": [reason]})


def best_words(spec: DesignSpec) -> dict[str, Any]:
    """What each law reached in the comparison that chose: worst and median error [deg], or none."""
    tuned, reached = best_law(_compared(spec))
    return {
        "controller": tuned.controller,
        "draws": BEST_DRAWS,
        "goal_deg": goal_of(spec.drive) / DEGREE,
        "candidates": [
            {"name": name, "worst_deg": one.quantile(1.0), "median_deg": one.quantile(0.5)}
            for name, one in reached.items()
        ],
    }


def _compared(spec: DesignSpec) -> DesignSpec:
    """The spec of a comparison: the drive and the motion, with the options of every comparison."""
    return replace(spec, options=COMPARED, plant=None, best=False)
