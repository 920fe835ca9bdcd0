"""Which laws are compared on a drive, what each reaches on many plants, and which of them is best."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.fields import nearest
from cabledrive.rig.laws.controllers import Controller, DesignSpec, load_count, load_gear
from cabledrive.rig.laws.indirect import NAME as INDIRECT
from cabledrive.rig.laws.indirect import run_indirect
from cabledrive.rig.laws.load_learning import CHANGING, LOAD_LEARNING, SCHEDULED
from cabledrive.rig.laws.registry import CONTROLLERS, OPEN_LOOPS, main_laws
from cabledrive.rig.plant_samples import Disturbances, Draws, disturbed_loops, over, standard_disturbances
from cabledrive.rig.setting import DEGREE, RigOptions
from cabledrive.rig.tuning import TunedLaw, law_as_tuned, law_at, limit_words, tuned


def scored(tuned: TunedLaw, spec: DesignSpec, disturbances: Disturbances, seed: int, draws: range) -> Draws:
    """Run a law on plants, the same for every law."""
    plants = disturbed_loops(tuned.loop, disturbances, seed, draws)
    if tuned.name != INDIRECT:
        return over(plants)
    asked = replace(spec, bandwidth=tuned.bandwidth)
    return over(plants, lambda plant: run_indirect(asked, plant)[1])


BEST = "best"
LEARNS = (INDIRECT, LOAD_LEARNING, CHANGING)
"""Laws whose first pulse is for learning, where there are more."""
BEST_DRAWS = 20
COMPARED = RigOptions(forbid_slack=False)
"""Options of a comparison: random encoder phases, Kalman filter, spans that may go slack and go on."""


def offered(drive: Drive, disturbances: Disturbances) -> tuple[str, ...]:
    """Laws compared where none are named, simplest first; more where the load changes, or for a stepper."""
    *fixed, learning = main_laws(drive)
    steppers = OPEN_LOOPS if drive.motor is not None and drive.motor.holding_stiffness else ()
    changing = (SCHEDULED, CHANGING) if disturbances.changes_load else ()
    return (*steppers, *fixed, *changing, learning)


def checked_names(names: Sequence[str]) -> tuple[str, ...]:
    """Names of laws, each once."""
    for place, name in enumerate(names):
        if name not in CONTROLLERS:
            raise InputRefused(
                f"controller = {name!r} is not known{nearest(name, CONTROLLERS)}: see docs/control"
            )
        if name in names[:place]:
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


@lru_cache(maxsize=8)
def best_law(spec: DesignSpec) -> tuple[TunedLaw, tuple[tuple[str, Draws | None], ...]]:
    """The law with feedback that ranks first on a drive, tuned, and what each reached on the first plants."""
    disturbances, goal = standard_disturbances(spec.drive), goal_of(spec.drive)
    several = spec.motion.pulses > 1
    found: list[tuple[tuple[float, float], TunedLaw]] = []
    reached: list[tuple[str, Draws | None]] = []
    for name in offered(spec.drive, disturbances):
        if name in OPEN_LOOPS:  # no controller, as which "best" is exported and studied
            continue
        try:
            one = tuned(name, spec, disturbances)
            law = law_as_tuned(name, one.bandwidth, one.filter, spec)
            scores = scored(law, spec, disturbances, 0, range(BEST_DRAWS)) if one.accepted else None
        except (NotComputed, InputRefused):
            scores = None
        reached.append((name, scores))
        if scores is not None:
            found.append((scores.rank(goal, learns=several and name in LEARNS), law))
    if not found:
        raise NotComputed("no law of the comparison can be tuned on this drive: name one, such as pd")
    return min(found, key=lambda pair: pair[0])[1], tuple(reached)


__all__ = ["BEST", "best_controller", "best_words"]


def best_controller(spec: DesignSpec) -> Controller:
    """The law that ranks first, with the bandwidth and the filter that the comparison tuned."""
    if spec.bandwidth is not None or spec.feedforward != "damped" or not spec.adapt:
        raise InputRefused(
            "controller = best is tuned as a whole: leave bandwidth, feedforward and no-adaptation out, or "
            "name a law"
        )
    tuned, _ = best_law(_compared(spec))
    reason = (
        f"{tuned.name} at {tuned.bandwidth:g} Hz, filter {tuned.filter}: ranks first over {BEST_DRAWS} "
        f"plants with friction at the load; the highest bandwidth that keeps {limit_words(spec)}"
    )
    made = law_at(tuned.name, tuned.bandwidth, tuned.filter, spec)
    return replace(made, gains=made.gains | {"reasons": [reason]})


def best_words(spec: DesignSpec) -> dict[str, Any]:
    """What each law reached in the comparison that chose: worst and median error [deg], or none."""
    tuned, reached = best_law(_compared(spec))
    several, found = spec.motion.pulses > 1, []
    for name, scores in reached:
        words: dict[str, Any] = {"name": name, "worst_deg": None, "median_deg": None}
        if scores is not None:
            errors = scores.errors(learns=several and name in LEARNS) / DEGREE
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
