"""`track`: run a law on the rig, or two laws one after the other, and judge it by its bounds."""

from dataclasses import replace
from typing import Any

import numpy as np

from cabledrive.control.numbers import HIGH, LOW
from cabledrive.control.own_controller import checked_controller
from cabledrive.parameters import Drive, InputRefused
from cabledrive.rig.bounds import bound_along
from cabledrive.rig.closed_loop.loop import Loop, Run
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.laws.indirect import NAME, run_indirect
from cabledrive.rig.laws.registry import CONTROLLERS, known_name
from cabledrive.rig.margins import bound_over_draws
from cabledrive.rig.plant_samples import draw_words, run_samples
from cabledrive.rig.setting import CABLE, DEGREE, Motion, sample_interval
from cabledrive.rig.tracking import Tracking, within
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


def over_draws(loop: Loop, spec: DesignSpec, draws: int, seed: int) -> dict[str, Any]:
    """Peaks over many plants; of a law that learns on each, and has a second pulse for it, the later ones."""
    if loop.controller.name == NAME and loop.controller.own is None and loop.motion.pulses > 1:
        found = run_samples(loop, draws, seed, each=lambda one: run_indirect(spec, one)[1])
        words = draw_words(found, "later_peak")
    else:
        found = run_samples(loop, draws, seed)
        words = draw_words(found)
    if loop.pair is not None:
        words["flanks_closed"] = int(np.count_nonzero(found.scores[:, SUMMARY.index("loose")] == 0.0))
    return words | bound_over_draws(loop)


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
