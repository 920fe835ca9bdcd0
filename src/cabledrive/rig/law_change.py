"""A run under two laws, one after the other: each judged by its own bounds."""

from dataclasses import replace

import numpy as np

from cabledrive.control.numbers import HIGH, LOW
from cabledrive.rig.closed_loop.loop import Loop, Run
from cabledrive.rig.setting import DEGREE
from cabledrive.rig.theorem import bound_along
from cabledrive.rig.tracking import Tracking, within


def judged_apart(found: Tracking, first: Loop, last: Loop, done: Run) -> Tracking:
    """A run as `cabledrive.rig.tracking.summarize` puts it, its first part held to the first law's bounds.

    ``found``: of the whole run, by the last law; ``first``, ``last``: of the laws before and after the first
    pulse with its dwell.
    """
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
