"""`--controller best`: what a comparison ranks first on a drive, ready to run along a motion."""

from dataclasses import replace
from typing import Any

import numpy as np

from cabledrive.parameters import InputRefused
from cabledrive.rig.laws.controllers import Controller, DesignSpec
from cabledrive.rig.ranking.ranked import BEST, BEST_DRAWS, COMPARED, LEARNS, best_law, goal_of
from cabledrive.rig.ranking.scores import counted
from cabledrive.rig.setting import DEGREE
from cabledrive.rig.tuning import LEAST_DISK, law_at, ripple_limit

__all__ = ["BEST", "best_controller", "best_words"]


def best_controller(spec: DesignSpec) -> Controller:
    """The law that ranks first, with the bandwidth and the filter that the comparison tuned.

    Raises `InputRefused` if a bandwidth or another feedforward is asked for, or estimates are to keep still.
    """
    if spec.bandwidth is not None or spec.feedforward != "damped" or not spec.adapt:
        raise InputRefused(
            "controller = best is tuned as a whole: leave bandwidth, feedforward and no-adaptation out, or "
            "name a law"
        )
    tuned, _ = best_law(_compared(spec))
    reason = (
        f"{tuned.name} at {tuned.bandwidth:g} Hz, filter {tuned.filter}: ranks first over {BEST_DRAWS} "
        f"plants with friction at the load; the highest bandwidth with a disk margin of {LEAST_DISK:g} and a "
        f"torque ripple of {ripple_limit(spec):.3g} N m"
    )
    made = law_at(tuned.name, tuned.bandwidth, tuned.filter, spec)
    return replace(made, gains=made.gains | {"reasons": [reason]})


def best_words(spec: DesignSpec) -> dict[str, Any]:
    """What each law reached in the comparison that chose: worst and median error [deg], or none."""
    assert spec.motion is not None
    tuned, reached = best_law(_compared(spec))
    several, found = spec.motion.pulses > 1, []
    for name, scores in reached:
        words: dict[str, Any] = {"name": name, "worst_deg": None, "median_deg": None}
        if scores is not None:
            errors = np.array(counted(scores, learns=several and name in LEARNS)) / DEGREE
            worst, median = float(errors.max()), float(np.median(errors))
            words["worst_deg"] = worst if np.isfinite(worst) else None
            words["median_deg"] = median if np.isfinite(median) else None
        found.append(words)
    return {
        "controller": tuned.name,
        "draws": BEST_DRAWS,
        "goal_deg": goal_of(spec.drive) / DEGREE,
        "candidates": found,
    }


def _compared(spec: DesignSpec) -> DesignSpec:
    """The spec of a comparison: the drive and the motion, with the options of every comparison."""
    return replace(spec, options=COMPARED, plant=None, best=False, feedback="motor")
