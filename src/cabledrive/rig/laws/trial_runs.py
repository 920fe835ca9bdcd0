"""Trial runs that a law's gains must pass on the machine that it is for, with the options of the run.

A trial is one pulse, on the plant of the run and on two more whose cable and load lie on opposite sides of
their intervals. Delay, sample rate, sensors, observer, torque loop, backlash, friction and disturbances are
those of the run, so that whatever changes the loop changes the gains that are chosen for it.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from cabledrive.control.flat_output import flat_output
from cabledrive.control.linear_laws import feedforward
from cabledrive.control.reference import flat_reference
from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.reduction.models import highest_model
from cabledrive.rig.closed_loop.loop import close_loop, run
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY
from cabledrive.rig.closed_loop.other_plants import with_plant
from cabledrive.rig.laws.controllers import Controller, DesignSpec
from cabledrive.rig.plant_samples import Spreads
from cabledrive.rig.setting import RigOptions

TORQUE_SHARE, STEP = 1.0 / 3.0, 0.8
WORSE = 2.0
"""An error so many times that of a lower bandwidth means that the loop rings."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """What the trial runs of one setting showed.

    Attributes
    ----------
    failed : int
        Runs that ended before their time.
    saturated : float
        Largest share of the samples at the torque limit.
    torque : float
        Largest torque [N m].
    allowed : float
        Two thirds of the limit, or what the motion needs and a third of it where that is more [N m].
    error : float
        Largest error of the load, at the first shaft [rad].
    """

    failed: int
    saturated: float
    torque: float
    allowed: float
    error: float

    @property
    def accepted(self) -> bool:
        """Whether every run ended, without saturation and with torque to spare."""
        return self.failed == 0 and self.saturated == 0.0 and self.torque <= self.allowed

    @property
    def rank(self) -> tuple[bool, int, float, float]:
        """Smaller is better."""
        return (not self.accepted, self.failed, self.saturated, self.error)


def trial_spec(spec: DesignSpec) -> DesignSpec:
    """The spec for a trial: one pulse of the motion, with the drive's own load.

    ``spec``: with its motion.
    """
    assert spec.motion is not None
    motion = replace(spec.motion, pulses=1, payload=())
    trajectory = motion.trajectory
    samples = round(trajectory.duration / spec.interval) + 1
    options = None if spec.options is None else replace(spec.options, load_change=None)
    return replace(spec, motion=motion, trajectory=trajectory, samples=samples, options=options)


@lru_cache(maxsize=16)
def needed_torque(spec: DesignSpec) -> float:
    """Largest torque of the exact inverse along the motion, friction included.

    Returns [N m].
    """
    chain = spec.model(highest_model(spec.drive))
    flat = flat_output(chain)
    reference = flat_reference(flat, spec.wanted(2 * chain.size), spec.interval)
    return float(np.abs(feedforward(chain, flat, reference)[:, -1]).max())


def trial(spec: DesignSpec, made: Controller) -> Trial:
    """Run a law on the plant and at two corners of cable and load.

    ``spec``: from `trial_spec`; ``made``: designed for it.
    """
    assert spec.motion is not None
    options = spec.options or RigOptions()
    plant = spec.plant or spec.drive
    loop = close_loop(spec.drive, plant, made, spec.motion, options, np.random.default_rng(0))
    limit, need = loop.rig.torque_limit, needed_torque(spec)
    spare = TORQUE_SHARE * limit if np.isfinite(limit) else need
    need += sum(abs(one.torque) for one in options.disturbances)
    failed, scores = 0, []
    for chain in (loop.chain, *corners(loop.chain)):
        done = run(loop if chain is loop.chain else with_plant(loop, chain, options), log=False)
        failed += done.failed
        scores.append(done.state.summary)
    worst = dict(zip(SUMMARY, np.max(scores, axis=0).tolist(), strict=True))
    return Trial(
        failed=failed,
        saturated=worst["saturated"] / len(loop.target),
        torque=worst["peak_torque"],
        allowed=min(max(need + spare, 2.0 * spare), limit),
        error=worst["peak"],
    )


def corners(chain: LumpedChain) -> list[LumpedChain]:
    """Two rows whose cable and load are off to opposite sides.

    Returns none for a row without a flexible link.
    """
    if chain.size < 2:
        return []
    spreads = Spreads()
    return [
        replace(
            chain,
            stiffness=(*chain.stiffness[:-1], chain.stiffness[-1] * (1.0 + sign * spreads.cable_stiffness)),
            inertias=(*chain.inertias[:-1], chain.inertias[-1] * (1.0 - sign * spreads.load_inertia)),
        )
        for sign in (-1.0, 1.0)
    ]


def tried(spec: DesignSpec, law: Callable[[DesignSpec], Controller], hertz: float) -> Trial | None:
    """Trial of a law at a bandwidth; None where the law refuses it.

    ``spec``: from `trial_spec`; ``law``: makes the controller of a spec.
    """
    try:
        return trial(spec, law(replace(spec, bandwidth=hertz)))
    except InputRefused:
        return None


def highest_accepted(
    spec: DesignSpec, law: Callable[[DesignSpec], Controller], low: int, start: int
) -> tuple[float, Trial]:
    """Highest whole bandwidth that the trial runs accept: downwards until one is, then by bisection.

    Where none is accepted, the one whose runs fail and saturate least.

    ``spec``: from `trial_spec`; ``low``, ``start`` [Hz].
    Raises `InputRefused` if the law can be made at no bandwidth.
    """
    known: dict[int, Trial | None] = {}

    def at(hertz: int) -> Trial | None:
        if hertz not in known:
            known[hertz] = tried(spec, law, float(hertz))
        return known[hertz]

    def good(hertz: int) -> bool:
        found, lower = at(hertz), at(max(low, round(0.75 * hertz)))
        if found is None or not found.accepted:
            return False
        return lower is None or not lower.accepted or found.error <= WORSE * lower.error

    bottom, top = start, start + 1
    while not good(bottom):
        if bottom <= low:
            ranked = sorted((one.rank, hertz) for hertz, one in known.items() if one is not None)
            if not ranked:
                law(replace(spec, bandwidth=float(low)))  # refuses, with its reason
            return float(ranked[0][1]), _sure(known[ranked[0][1]])
        bottom, top = max(low, min(bottom - 1, round(STEP * bottom))), bottom
    while top - bottom > 1:
        middle = (bottom + top) // 2
        bottom, top = (middle, top) if good(middle) else (bottom, middle)
    return float(bottom), _sure(at(bottom))


def _sure(found: Trial | None) -> Trial:
    assert found is not None
    return found
