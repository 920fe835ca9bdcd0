"""Gains of laws without a rule of their own: the setting with the smallest error in trial runs."""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

from cabledrive.rig.laws.controllers import Controller, DesignSpec
from cabledrive.rig.laws.trial_runs import Trial, trial, trial_spec, tried

SETTINGS_HZ = (
    *(0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 15.0, 18.0, 22.0, 26.0, 30.0),
    *(35.0, 42.0, 50.0, 60.0, 75.0, 90.0),
)


def tuned_law(law: Callable[[DesignSpec], Controller], spec: DesignSpec) -> Controller:
    """A law at the setting with the smallest worst error of those that trial runs accept.

    ``law``: makes the controller of a spec; ``spec``: with its motion, without a bandwidth.
    """
    hertz, shown, count = tuned_bandwidth(law, spec)
    made, words = law(replace(spec, bandwidth=hertz)), f"bandwidth {hertz:g} Hz"
    if "torque_weight" in made.gains:
        words += f" (one count weighs as {made.gains['torque_weight']:.3g} N m)"
    why = f"the smallest worst error in the trial runs of {count} settings"
    if not shown.accepted:
        why = "no setting keeps the torque within what is allowed; this one fails and saturates least"
    reason = f"{words}: {why}, up to {shown.torque:.3g} of {shown.allowed:.3g} N m allowed"
    return replace(made, gains=made.gains | {"reasons": [reason]})


@lru_cache(maxsize=64)
def tuned_bandwidth(law: Callable[[DesignSpec], Controller], spec: DesignSpec) -> tuple[float, Trial, int]:
    """Bandwidth of a law by trial runs.

    Returns ``count``: of settings that were tried.
    """
    one, top = trial_spec(spec), 1.0 / (20.0 * spec.interval)
    found: dict[float, Trial] = {}
    for hertz in (value for value in SETTINGS_HZ if value <= top):
        shown = tried(one, law, hertz)
        if shown is not None:
            found[hertz] = shown
    if not found:
        trial(one, law(replace(one, bandwidth=SETTINGS_HZ[0])))  # refuses, with its reason
    hertz = min(found, key=lambda each: found[each].rank)
    return hertz, found[hertz], len(found)
