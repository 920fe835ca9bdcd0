"""What a tuned law reaches on many plants, each drawn with its disturbances, and the order of the laws."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.rig.closed_loop.loop import run
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY, Array
from cabledrive.rig.disturbed.disturbances_file import Disturbances
from cabledrive.rig.disturbed.disturbed_plants import disturbed_loop
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.laws.indirect import NAME as INDIRECT
from cabledrive.rig.laws.indirect import run_indirect
from cabledrive.rig.setting import RigOptions
from cabledrive.rig.tuning import TunedLaw

COLUMNS = ("peak", "later_peak", "peak_torque", "saturated", "failed")


@dataclass(frozen=True, slots=True, kw_only=True)
class Scores:
    """Runs of one law, one entry a plant.

    Attributes
    ----------
    peaks, later : tuple of float
        Largest error of the whole run, and after its first pulse and dwell [rad at the load].
    torques : tuple of float
        [N m].
    saturated : tuple of float
        Samples at the torque limit.
    failed : tuple of bool
        Whether the run ended before its time.
    """

    peaks: tuple[float, ...]
    later: tuple[float, ...]
    torques: tuple[float, ...]
    saturated: tuple[float, ...]
    failed: tuple[bool, ...]

    def joined(self, other: "Scores") -> "Scores":
        """These runs and others."""
        names = ("peaks", "later", "torques", "saturated", "failed")
        return Scores(**{name: (*getattr(self, name), *getattr(other, name)) for name in names})


def scored(
    tuned: TunedLaw,
    spec: DesignSpec,
    disturbances: Disturbances,
    options: RigOptions,
    seed: int,
    draws: range,
) -> Scores:
    """Run a law on plants, the same for every law.

    ``draws``: numbers of the plants; each has a generator of its own.
    """
    columns = [SUMMARY.index(name) for name in COLUMNS[:-1]]

    def one(draw: int) -> Array:
        plant = disturbed_loop(tuned.loop, disturbances, options, np.random.default_rng([seed, draw]))
        if tuned.name == INDIRECT:
            _, done, _ = run_indirect(replace(spec, bandwidth=tuned.bandwidth), plant, options)
        else:
            done = run(plant, log=False)
        return np.append(done.state.summary[columns], done.failed)

    with ThreadPoolExecutor(2) as pool:
        rows = np.array(list(pool.map(one, draws)))
    rows[:, :2] /= tuned.loop.gear
    peaks, later, torques, saturated, failed = (tuple(column.tolist()) for column in rows.T)
    return Scores(
        peaks=peaks, later=later, torques=torques, saturated=saturated, failed=tuple(map(bool, failed))
    )


def rank(scores: Scores, goal: float, *, learns: bool) -> tuple[float, float]:
    """Smaller is better: share of plants outside the goal, then the largest error.

    ``goal``: largest error allowed [rad]; ``learns``: whether the first pulse is for learning and does not
    count.
    """
    errors = counted(scores, learns=learns)
    return float(np.mean([error > goal for error in errors])), max(errors)


def counted(scores: Scores, *, learns: bool) -> Sequence[float]:
    """Error of each run; infinite where it ended early [rad]."""
    errors = scores.later if learns else scores.peaks
    return [float("inf") if failed else error for error, failed in zip(errors, scores.failed, strict=True)]
