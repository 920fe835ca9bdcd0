"""Stage 7 for a carriage: the scheduled law on many plants drawn from what is known."""

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.rig.carriage.carriage_loop import FORCE, TENSIONS, CarriageLoop
from cabledrive.studies.study.acceptance_stage import KEPT
from cabledrive.studies.study.carriage_case import (
    CarriageCase,
    case_of,
    errors,
    loop_at,
    torque_of,
    whole_run,
)
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.lasting_runs import quantile_of_all
from cabledrive.studies.study.machine import Quantity
from cabledrive.studies.study.sampled_plants import sampled_plant
from cabledrive.studies.study.stage_cache import StageCache

BLOCK = 25


@dataclass(frozen=True, slots=True, kw_only=True)
class CarriageBlock:
    """Runs on some plants.

    Attributes
    ----------
    peaks, rests : tuple of float
        Largest error of each run, and the largest while the carriage is to stand [m]; of a run that ended
        early, until then.
    torques, tensions : tuple of float
        Largest torque [N m] and smallest tension of a strand [N] of each run.
    saturated : tuple of float
        Share of the samples at the torque's limit.
    failed : tuple of bool
        Runs that ended before their time.
    """

    peaks: tuple[float, ...]
    rests: tuple[float, ...]
    torques: tuple[float, ...]
    tensions: tuple[float, ...]
    saturated: tuple[float, ...]
    failed: tuple[bool, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class CarriageWorst:
    """The run with the largest error.

    Attributes
    ----------
    draw : int
    values : dict of str to float
        Quantities of its plant.
    phases : tuple of float
        Of its encoders, in counts.
    time, course, error, torque : tuple of float
        Thinned course [s], [m], [m], [N m]; the error of the carriage, or of the hanging mass where that is
        the larger.
    """

    draw: int
    values: dict[str, float]
    phases: tuple[float, ...]
    time: tuple[float, ...]
    course: tuple[float, ...]
    error: tuple[float, ...]
    torque: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class CarriageAcceptance:
    """What many runs said.

    Attributes
    ----------
    draws : int
    peaks, rests : tuple of float
        Largest error of each whole run, and while the carriage is to stand, both ascending [m]; what the
        model leaves out is added.
    reached : float or None
        Share of all runs whose error stayed inside the goal; None without one.
    failed, saturated : int
        Runs that ended early, and runs whose torque met its limit.
    largest_torque, smallest_tension : float
        [N m], [N].
    worst : CarriageWorst or None
        None: every run failed.
    """

    draws: int
    peaks: tuple[float, ...]
    rests: tuple[float, ...]
    reached: float | None
    failed: int
    saturated: int
    largest_torque: float
    smallest_tension: float
    worst: CarriageWorst | None

    def quantile(self, share: float, *, rest: bool = False) -> float | None:
        """Error that a share of all runs kept below.

        ``rest``: only while the carriage is to stand.
        Returns [m]; None where too many runs ended early.
        """
        return quantile_of_all(self.rests if rest else self.peaks, self.draws, share)


def accept_carriage(
    drive: Drive,
    goals: Goals,
    quantities: Mapping[str, Quantity],
    bandwidth: float,
    left_out: float,
    *,
    cache: StageCache,
    inputs: Mapping[str, Any],
) -> CarriageAcceptance:
    """Run the law on many plants, block by block; each finished block is kept.

    ``bandwidth``, ``left_out`` [Hz], [m]; ``inputs``: all that a block depends on, but which draws it holds.
    """
    case = case_of(drive, goals)
    loop, blocks = loop_at(case, bandwidth), []
    for first in range(0, goals.carriage_draws, BLOCK):
        last = min(first + BLOCK, goals.carriage_draws)
        blocks.append(
            cache.staged(
                f"acceptance-carriage-{first:05d}",
                CarriageBlock,
                {**inputs, "first": first, "last": last},
                _block(case, loop, quantities, range(first, last)),
            )
        )
        cache.note(f"      plants with a carriage: {last} of {goals.carriage_draws}")
    return _summed(case, loop, quantities, blocks, left_out)


def _block(
    case: CarriageCase, loop: CarriageLoop, quantities: Mapping[str, Quantity], draws: range
) -> Callable[[], CarriageBlock]:
    def one(draw: int) -> tuple[float, float, float, float, float, bool]:
        values, phases = sampled_plant(quantities, 2, case.goals.seed, draw)
        log = whole_run(case, loop, values, phases)
        off, standing = np.abs(errors(case, log)).max(axis=0), case.standing[: len(log)]
        rest = float(off[standing].max()) if standing.any() else 0.0
        torque, saturated = torque_of(case, log)
        tension = float(log[:, TENSIONS : TENSIONS + 3].min())
        return float(off.max()), rest, torque, tension, saturated, len(log) < len(case.reference)

    def compute() -> CarriageBlock:
        with ThreadPoolExecutor(2) as pool:
            peaks, rests, torques, tensions, saturated, failed = zip(*pool.map(one, draws), strict=True)
        return CarriageBlock(
            peaks=peaks, rests=rests, torques=torques, tensions=tensions, saturated=saturated, failed=failed
        )

    return compute


def _summed(
    case: CarriageCase,
    loop: CarriageLoop,
    quantities: Mapping[str, Quantity],
    blocks: list[CarriageBlock],
    left_out: float,
) -> CarriageAcceptance:
    peaks, rests = (
        np.array([e + left_out for block in blocks for e in getattr(block, name)])
        for name in ("peaks", "rests")
    )
    failed = np.array([f for block in blocks for f in block.failed])
    goal = case.goals.carriage_error
    worst = int(np.argmax(np.where(failed, -1.0, peaks)))
    return CarriageAcceptance(
        draws=len(peaks),
        peaks=tuple(float(e) for e in np.sort(peaks[~failed])),
        rests=tuple(float(e) for e in np.sort(rests[~failed])),
        reached=None if goal is None else float(np.mean((peaks <= goal) & ~failed)),
        failed=int(failed.sum()),
        saturated=sum(s > 0.0 for block in blocks for s in block.saturated),
        largest_torque=max(t for block in blocks for t in block.torques),
        smallest_tension=min(t for block in blocks for t in block.tensions),
        worst=None if failed.all() else _worst(case, loop, quantities, worst),
    )


def _worst(
    case: CarriageCase, loop: CarriageLoop, quantities: Mapping[str, Quantity], draw: int
) -> CarriageWorst:
    values, phases = sampled_plant(quantities, 2, case.goals.seed, draw)
    log = whole_run(case, loop, values, phases)
    both = errors(case, log)
    error = both[int(np.argmax(np.abs(both).max(axis=1)))]
    step = max(1, len(error) // KEPT)
    shown = np.unique(np.append(np.arange(0, len(error), step), np.argmax(np.abs(error))))
    return CarriageWorst(
        draw=draw,
        values=values,
        phases=tuple(float(p) for p in phases),
        time=tuple(float(t) for t in case.interval * shown),
        course=tuple(float(y) for y in case.wanted[shown]),
        error=tuple(float(e) for e in error[shown]),
        torque=tuple(float(u) for u in log[shown, FORCE] * case.design.radius),
    )
