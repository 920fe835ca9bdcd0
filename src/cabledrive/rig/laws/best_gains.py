"""Gains that the package chooses for the damping-aware law, with the reasons."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from math import pi

import numpy as np

from cabledrive.control.darc import darc_numbers
from cabledrive.control.darc_gains import darc_gains, printed_bounds
from cabledrive.control.flat_output import flat_output
from cabledrive.control.kalman import KalmanTuning, Sampling, kalman_filter
from cabledrive.reduction.lumped_chain import LumpedChain, natural_frequencies_of
from cabledrive.reduction.models import FLEXIBLE_JOINT, highest_model
from cabledrive.rig.closed_loop.linear_loop import assembled
from cabledrive.rig.closed_loop.plant import plant_numbers
from cabledrive.rig.disturbances import control_delay, current_rate, torque_limit
from cabledrive.rig.laws.controllers import Controller, DesignSpec, chain_law
from cabledrive.rig.laws.filter_tuning import filter_chain, read_encoders, tuning_by_uncertainty
from cabledrive.rig.laws.fitting import law_shafts, place
from cabledrive.rig.laws.trial_runs import (
    TORQUE_SHARE,
    Trial,
    highest_accepted,
    needed_torque,
    trial_spec,
)

SIGMAS = 5.0
SAMPLES_PER_PERIOD = 40.0
LOWEST_HZ, HIGHEST_HZ = 5, 80
MEMORY = 0.4


@dataclass(frozen=True, slots=True, kw_only=True)
class BestGains:
    """Bandwidth and filter, and why.

    Attributes
    ----------
    bandwidth : float
        lambda/(2 pi) [Hz].
    tuning : KalmanTuning
    torque_noise : float
        Five standard deviations of the command by rounding [N m].
    reasons : tuple of str
    """

    bandwidth: float
    tuning: KalmanTuning
    torque_noise: float
    reasons: tuple[str, ...]


def damped_law(spec: DesignSpec, name: str, number: int = 4) -> Controller:
    """The damping-aware law at its model's printed gains or the best; its filter by what is not known.

    ``number``, {3, 4}: Model that it is made for.
    """
    if spec.best and spec.bandwidth is None:
        return best_chain_law(spec, name, number)
    counts = np.array(list(read_encoders(spec, number).values()))
    tuning = tuning_by_uncertainty(spec, filter_chain(spec, number), counts)
    return chain_law(spec, number, name, damped=True, tuning=tuning)


def best_chain_law(spec: DesignSpec, name: str, number: int = 4) -> Controller:
    """The damping-aware law of a model with the gains and the filter that the package chooses.

    ``spec``: a bandwidth that it asks for is kept, and the filter chosen for it; ``number``, {3, 4}.
    """
    chosen = best_gains(spec, number)
    same = replace(spec, bandwidth=chosen.bandwidth)
    made = chain_law(same, number, name, damped=True, tuning=chosen.tuning)
    return replace(made, gains=made.gains | {"reasons": list(chosen.reasons)})


@lru_cache(maxsize=64)
def best_gains(spec: DesignSpec, number: int = 4) -> BestGains:
    """Highest bandwidth whose noise leaves most of the torque and that trial runs accept, and its filter.

    ``number``, {1, 2, 3, 4}: Model of the law.
    """
    counts = np.array(list(read_encoders(spec, number).values()))
    tuning = tuning_by_uncertainty(spec, filter_chain(spec, number), counts)
    sampled = int(1.0 / (SAMPLES_PER_PERIOD * spec.interval))
    top = max(LOWEST_HZ, min(HIGHEST_HZ, sampled))
    linear = rounding_counts(spec)

    def noise(hertz: float) -> float:
        return torque_noise(spec, hertz, tuning, number) if linear else 0.0

    shown: Trial | None = None
    why = "asked for"
    if spec.bandwidth is not None:
        hertz = spec.bandwidth
    else:
        allowed = allowed_noise(spec)
        quiet = highest(noise, allowed, top)
        limited = np.isfinite(torque_limit(spec.drive))
        share = "a third of the torque limit" if limited else "what the motion needs"
        why = (
            f"rounding to counts takes {noise(quiet):.3g} N m at five deviations; {share}: {allowed:.3g} N m"
        )
        hertz = float(quiet)
        if quiet == top:
            why = f"{SAMPLES_PER_PERIOD:.0f} samples in a period" if top == sampled else "the highest tried"
        if spec.motion is not None:
            one = trial_spec(spec)
            hertz, shown = highest_accepted(
                one,
                lambda each: chain_law(each, number, "trial", damped=True, tuning=tuning),
                min(LOWEST_HZ, quiet),
                quiet,
            )
            if hertz < quiet:
                why = (
                    f"trial runs on the drive with these options accept no more (rounding alone: {quiet} Hz)"
                )
    return BestGains(
        bandwidth=float(hertz),
        tuning=tuning,
        torque_noise=noise(hertz),
        reasons=_reasons(spec, hertz, tuning, sampled, why, shown),
    )


def rounding_counts(spec: DesignSpec) -> bool:
    """Whether the linear loop predicts the noise of a run: encoders through the Kalman filter, no delay."""
    options = spec.options
    filtered = options is None or (options.observer == "kalman" and not options.ideal_sensors)
    return filtered and control_delay(spec.drive) == 0.0


def allowed_noise(spec: DesignSpec) -> float:
    """Torque that rounding may take: a third of the limit; without one, as much as the motion needs.

    Returns [N m].
    """
    limit = torque_limit(spec.drive)
    return TORQUE_SHARE * limit if np.isfinite(limit) else needed_torque(spec)


def highest(noise: Callable[[float], float], allowed: float, top: int) -> int:
    """Highest whole bandwidth whose noise is allowed, by bisection: noise rises with the bandwidth.

    ``allowed`` [N m]; ``top`` [Hz].
    Returns 1 where not even that is quiet enough; trial runs show what it costs.
    """
    low, high = 1, top + 1
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if noise(middle) <= allowed else (low, middle)
    return low


def torque_noise(spec: DesignSpec, hertz: float, tuning: KalmanTuning, number: int = 4) -> float:
    """Five standard deviations of the command by rounding, at a bandwidth.

    ``number``, {1, 2, 3, 4}: Model of the law.
    Returns [N m].
    """
    interval, rate = spec.interval, current_rate(spec.drive)
    seen_by, plant, law_chain = filter_chain(spec, number), _highest(spec), spec.model(number)
    fitted = read_encoders(spec, number)
    places = [place(seen_by, shaft) for shaft in fitted]
    chosen = [place(seen_by, shaft) for shaft in law_shafts(number, spec.feedback)]
    counts = np.array(list(fitted.values()))
    sampling = Sampling(interval=interval, current_rate=rate)
    if spec.options is not None and spec.options.encoder_phase == "centred":
        tuning = replace(tuning, offsets=())
    seen = kalman_filter(seen_by, places, list(counts), sampling, chosen=chosen, tuning=tuning, settled=True)
    flat, bounds = flat_output(law_chain), printed_bounds(law_chain, flexible_joint=FLEXIBLE_JOINT[number])
    row = np.zeros((1, 2 * law_chain.size + 3))
    law = darc_numbers(flat, darc_gains(number, hertz, least=0.0), bounds, row, interval, desired=True)
    encoders = np.array([place(plant, shaft) for shaft in fitted], dtype=np.int64)
    loop = assembled(plant_numbers(plant, interval, current_rate=rate), seen, law, encoders)
    return SIGMAS * loop.noise(counts, round(MEMORY / interval))[1]


def _highest(spec: DesignSpec) -> LumpedChain:
    return spec.model(highest_model(spec.drive))


def _reasons(
    spec: DesignSpec, hertz: float, tuning: KalmanTuning, sampled: int, why: str, shown: Trial | None
) -> tuple[str, ...]:
    modes = ", ".join(f"{w / (2.0 * pi):.1f}" for w in natural_frequencies_of(_highest(spec)) if w > 1.0)
    trials: tuple[str, ...] = ()
    if shown is not None:
        words = f"up to {shown.torque:.3g} N m of {shown.allowed:.3g} N m allowed, {shown.failed} ended early"
        short = "" if shown.accepted else ": no bandwidth keeps the torque within what is allowed"
        trials = (f"trial runs, cable and load as believed and at two corners: {words}{short}",)
    return (
        f"bandwidth {hertz:.0f} Hz: {why}",
        *trials,
        f"sample rate: allows {sampled} Hz, {SAMPLES_PER_PERIOD:.0f} samples in a period",
        f"modes at {modes} Hz: their poles are placed, not avoided, so that they set no limit",
        "uncertain cable and load: noise of the load's acceleration in the filter "
        f"{tuning.load_acceleration:.2g} (rad/s^2)^2 s",
        f"friction: disturbance walks by {tuning.disturbance:.2g} (N m)^2 in a second",
        "encoder zeros unknown: offsets walk by "
        + " and ".join(f"{value:.1g}" for value in tuning.offsets)
        + " rad^2 in a second",
    )
