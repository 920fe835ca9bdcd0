"""Stage 7: the sampled controller on many plants drawn from what is known, lumped and on the cable."""

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.rig.closed_loop.loop import Loop, run
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY
from cabledrive.rig.laws.controllers import Controller
from cabledrive.rig.setting import Motion
from cabledrive.studies.study.candidates import lost
from cabledrive.studies.study.closed_loop import joined_loop, with_values
from cabledrive.studies.study.knowledge_stage import Knowledge
from cabledrive.studies.study.lasting_runs import quantile_of_all
from cabledrive.studies.study.sampled_plants import sampled_plant
from cabledrive.studies.study.stage_cache import StageCache

BLOCK, CABLE_BLOCK = 50, 5
KEPT = 400
"""Points of the worst run that are kept."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleBlock:
    """Runs on some plants.

    Attributes
    ----------
    peaks, torques : tuple of float or None
        Largest error [rad] and torque [N m] of each run; None where it ended before its time. Eccentricity of
        the load encoder is added to the error, since the law follows what it reads.
    saturated : tuple of float
        Share of the samples at the torque's limit.
    """

    peaks: tuple[float | None, ...]
    torques: tuple[float | None, ...]
    saturated: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class WorstCase:
    """The run with the largest error.

    Attributes
    ----------
    draw : int
    values : dict of str to float
        Quantities of its plant.
    phases : tuple of float
        Of its encoders, in counts.
    time, reference, error, torque : tuple of float
        Thinned course [s], [rad], [rad], [N m].
    """

    draw: int
    values: dict[str, float]
    phases: tuple[float, ...]
    time: tuple[float, ...]
    reference: tuple[float, ...]
    error: tuple[float, ...]
    torque: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class AcceptanceResult:
    """What many runs said.

    Attributes
    ----------
    plant : {"lumped", "cable"}
    draws : int
    peaks : tuple of float
        Largest error of each run that lasted, ascending [rad].
    inside : float or None
        Share of all runs whose error stayed inside the stated bound; None: no bound is stated for the law.
    reached : float or None
        Share of all runs whose error stayed inside the goal; None without one.
    failed : int
        Runs that ended before their time.
    saturated : int
        Runs in which the torque met its limit.
    largest_torque : float or None
        Of the runs that lasted [N m]; None: none did, or none was made.
    worst : WorstCase or None
        None: every run failed, or none was made.
    reason : str
        Why there are no runs, where there are none.
    """

    plant: str
    draws: int
    peaks: tuple[float, ...]
    inside: float | None
    reached: float | None
    failed: int
    saturated: int
    largest_torque: float | None
    worst: WorstCase | None
    reason: str

    def quantile(self, share: float) -> float | None:
        """Error that a share of all runs kept below.

        Returns [rad]; None where too many runs ended early, or without runs.
        """
        return quantile_of_all(self.peaks, self.draws, share)


def accept(
    drive: Drive,
    motion: Motion,
    known: Knowledge,
    law: Controller,
    *,
    draws: int,
    seed: int,
    torque: float | None,
    error: float | None,
    cable: bool,
    cache: StageCache,
    inputs: Mapping[str, object],
    bound: float | None = None,
) -> AcceptanceResult:
    """Run a law on many plants, block by block; each finished block is kept.

    A law that has missed the goal more often than all the runs allow is not run further. Blocks of a
    controller of the user's own are not kept: a changed step could not be distinguished from the one before.

    ``drive``: with the best values; ``torque``, ``error``: goals [N m], [rad]; ``cable``: whether the plants
    are distributed nonlinear cables; ``inputs``: all that the stage depends on, for the blocks' keys;
    ``bound``: stated for the law [rad].
    """
    loop = joined_loop(drive, drive, law, motion, torque, cable=cable)
    cache = cache if law.own is None else replace(cache, folder=None)
    plant, size = ("cable", CABLE_BLOCK) if cable else ("lumped", BLOCK)
    blocks: list[SampleBlock] = []
    for first in range(0, draws, size):
        last = min(first + size, draws)
        blocks.append(
            cache.staged(
                f"acceptance-{plant}-{law.name}-{first:05d}",
                SampleBlock,
                {**inputs, "first": first, "last": last},
                _block(loop, drive, known, seed, range(first, last)),
            )
        )
        cache.note(f"      {law.name}, {plant} plants: {last} of {draws}")
        if error is not None and lost(_misses(blocks, error), draws, plant):
            break
    return _summed(loop, drive, known, seed, blocks, bound, error, plant)


def _misses(blocks: list[SampleBlock], error: float) -> int:
    return sum(peak is None or peak > error for block in blocks for peak in block.peaks)


def _block(loop: Loop, drive: Drive, known: Knowledge, seed: int, draws: range) -> Callable[[], SampleBlock]:
    def compute() -> SampleBlock:
        def one(draw: int) -> tuple[float | None, float | None, float]:
            values, phases = sampled_plant(
                known.quantities, len(loop.rig.phases), seed, draw, known.correlations
            )
            moved = with_values(loop, drive, values, phases)
            done = run(moved, log=False)
            score = dict(zip(SUMMARY, (float(v) for v in done.state.summary), strict=False))
            share = score["saturated"] / len(moved.target)
            if done.failed:
                return None, None, share
            peak = score["peak"] / moved.gear + values.get("eccentricity", 0.0)
            return peak, score["peak_torque"], share

        with ThreadPoolExecutor(2) as pool:
            peaks, torques, saturated = zip(*pool.map(one, draws), strict=True)
        return SampleBlock(peaks=peaks, torques=torques, saturated=saturated)

    return compute


def _summed(
    loop: Loop,
    drive: Drive,
    known: Knowledge,
    seed: int,
    blocks: list[SampleBlock],
    bound: float | None,
    error: float | None,
    plant: str,
) -> AcceptanceResult:
    peaks = [p for block in blocks for p in block.peaks]
    lasting = sorted((p, draw) for draw, p in enumerate(peaks) if p is not None)
    torques = [t for block in blocks for t in block.torques if t is not None]

    def within(limit: float) -> float:
        return sum(p <= limit for p, _ in lasting) / len(peaks)

    return AcceptanceResult(
        plant=plant,
        draws=len(peaks),
        peaks=tuple(p for p, _ in lasting),
        inside=None if bound is None else within(bound),
        reached=None if error is None else within(error),
        failed=len(peaks) - len(lasting),
        saturated=sum(s > 0.0 for block in blocks for s in block.saturated),
        largest_torque=max(torques) if torques else None,
        worst=_worst(loop, drive, known, seed, lasting[-1][1]) if lasting else None,
        reason="",
    )


def _worst(loop: Loop, drive: Drive, known: Knowledge, seed: int, draw: int) -> WorstCase:
    values, phases = sampled_plant(known.quantities, len(loop.rig.phases), seed, draw, known.correlations)
    moved = with_values(loop, drive, values, phases)
    done = run(moved)
    n, rig = moved.chain.size, moved.rig
    error = moved.load_error(done.log)
    step = max(1, len(error) // KEPT)
    shown = np.unique(np.append(np.arange(0, len(error), step), np.argmax(np.abs(error))))
    command = done.log[shown, 2 * n + 1 + len(rig.encoders)]
    return WorstCase(
        draw=draw,
        values=values,
        phases=tuple(float(p) for p in phases),
        time=tuple(float(t) for t in rig.interval * shown),
        reference=tuple(float(r) for r in moved.target[shown] / moved.gear),
        error=tuple(float(e) for e in error[shown]),
        torque=tuple(float(u) for u in command),
    )


def no_runs(plant: str, reason: str) -> AcceptanceResult:
    """An acceptance that was not made, with its reason.

    ``plant``, {"lumped", "cable"}.
    """
    return AcceptanceResult(
        plant=plant,
        draws=0,
        peaks=(),
        inside=None,
        reached=None,
        failed=0,
        saturated=0,
        largest_torque=None,
        worst=None,
        reason=reason,
    )
