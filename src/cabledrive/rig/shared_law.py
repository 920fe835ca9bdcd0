"""Many plants under one law, as `track` runs them one by one: where the plant has no part in the design."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive, InputRefused
from cabledrive.rig.closed_loop.loop import Loop, close_loop, plant_chain
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY, Array
from cabledrive.rig.closed_loop.plant_batch import fits_batch, run_batch
from cabledrive.rig.disturbances import slack_twist
from cabledrive.rig.laws.registry import design, known_name, needed_order
from cabledrive.rig.setting import CABLE, DEGREE, Motion, RigOptions
from cabledrive.rig.trial import GAINS, check_motion, plant_number, spec_for

LAWS = {f"darc-{model}{kind}" for model in (1, 2, 3, 4) for kind in ("", "-damped")}
"""Laws of the chain that are designed once, before the run."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SharedLaw:
    """A law in a loop whose plant is the drive that the law was designed for.

    Attributes
    ----------
    loop : Loop
    motion : Motion
        With the order that the law needs.
    model : int or None
        Model that is the plant; None: the highest that the drive's data allow.
    """

    loop: Loop
    motion: Motion
    model: int | None


@lru_cache(maxsize=4)
def shared_law(
    drive: Drive,
    motion: Motion,
    options: RigOptions,
    *,
    controller: str | None = None,
    bandwidth: float | None = None,
    gains: str = "best",
    plant: str | None = None,
    adapt: bool = True,
) -> SharedLaw | None:
    """The law and the loop of `track` with these settings, with the drive itself as the plant.

    Returns none where the design depends on the plant (gains found by trial runs on it), or where many
    plants cannot be integrated at once.
    """
    tuned = gains == "best" and bandwidth is None
    try:
        name = known_name(controller, drive)
        if tuned or gains not in GAINS or name not in LAWS or plant == CABLE or options.load_change:
            return None
        if motion.order is None:
            motion = replace(motion, order=needed_order(name, drive))
        choices = {"bandwidth": bandwidth, "feedback": options.feedback, "adapt": adapt, "options": options}
        made = design(name, spec_for(drive, motion, **choices))
        generator = np.random.default_rng(0)  # draws encoder phases, which a batch does not have
        number = plant_number(plant)
        loop = close_loop(drive, drive, made, motion, options, generator, plant_model=number)
    except InputRefused:
        return None  # each run is refused, with its own reason
    return SharedLaw(loop=loop, motion=motion, model=number) if fits_batch(loop) else None


def track_plants(
    law: SharedLaw, drives: Sequence[Drive | None]
) -> tuple[NDArray[np.bool_], dict[str, Array]]:
    """Run a law on drives that differ from its own in the lumped chain alone.

    ``drives``: None: left out.
    Returns which runs came to their end, and their scores by the names of `track`, each of shape (drives,);
    a run that the motion is too fast for, that diverges, or whose cable goes slack is left to `track`.
    """
    chains, limits, done = [], [], np.zeros(len(drives), dtype=bool)
    for i, drive in enumerate(drives):
        if drive is None:
            continue
        try:
            check_motion(drive, law.motion)
            chain = plant_chain(drive, law.model)
        except InputRefused:
            continue
        if chain.names == law.loop.chain.names:
            chains.append(chain)
            limits.append(slack_twist(drive, chain))
            done[i] = True
    scores = np.full((len(drives), len(SUMMARY)), np.nan)
    if chains:
        scores[done], failed = run_batch(law.loop, chains, threads=1, twist_limits=np.array(limits))
        done[done] = np.logical_not(failed)
    return done, _named(law, scores)


def _named(law: SharedLaw, scores: Array) -> dict[str, Array]:
    """Scores of whole runs by the names of `track`, in its units."""
    score = dict(zip(SUMMARY, scores.T, strict=True))
    samples, per_degree = len(law.loop.target), 1.0 / law.loop.gear / DEGREE
    return {
        "peak_error_deg": score["peak"] * per_degree,
        "first_pulse_error_deg": score["first_peak"] * per_degree,
        "later_pulses_error_deg": score["later_peak"] * (per_degree if law.motion.pulses > 1 else np.nan),
        "rms_error_deg": np.sqrt(score["square"]) * (per_degree / sqrt(samples)),
        "peak_torque": score["peak_torque"],
        "saturated_fraction": score["saturated"] / samples,
        "slack_samples": score["slack"],
    }
