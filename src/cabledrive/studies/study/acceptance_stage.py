"""Stage 7: a sampled law on many plants drawn from what is known."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from math import ceil

import numpy as np
from scipy.stats import beta

from cabledrive.studies.study.knowledge_stage import Knowledge
from cabledrive.studies.study.machine import Quantity
from cabledrive.studies.study.plants import ClosedLoop, Score
from cabledrive.studies.study.sampled_plants import Correlation, sampled_plant
from cabledrive.studies.study.stage_cache import Made, StageCache

CONFIDENCE = 0.95
ENOUGH = {"lumped": 0.99, "carriage": 0.99, "cable": 0.95}
"""Share of the plants that must keep within the goal, by the kind of plant."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReachedError:
    """An error that a share of the plants keeps below."""

    error: float | None  # [rad] or [m]; None: too many runs ended early to name one
    # lower limit of the share that keeps below it; the share that is asked for, or what the number of runs
    # can show where it is too small for that
    share: float
    confidence: float = CONFIDENCE


def share_low(inside: int, runs: int) -> float:
    """Lower limit of the share of plants inside, with `CONFIDENCE`."""
    if inside == 0:
        return 0.0
    return float(beta.ppf(1.0 - CONFIDENCE, inside, runs - inside + 1))


def misses_allowed(runs: int, share: float) -> int:
    """Most runs that may miss while `share_low` keeps a share; -1: so few runs cannot show it."""
    misses = -1
    while misses + 1 < runs and share_low(runs - misses - 1, runs) >= share:
        misses += 1
    return misses


def reached_error(lasting: Sequence[float], runs: int, share: float) -> ReachedError:
    """Error below which runs show that a share of plants stays, or the share that so many runs can show."""
    misses = misses_allowed(runs, share)
    shown = share
    if misses < 0:
        misses, shown = 0, share_low(runs, runs)
    place = runs - misses - 1
    return ReachedError(error=lasting[place] if place < len(lasting) else None, share=shown)


@dataclass(frozen=True, slots=True, kw_only=True)
class LawScore:
    """One law on many plants."""

    controller: str
    setting: str  # in words
    plant: str  # {"lumped", "carriage", "cable"}
    # runs, failed: runs made, and those that ended before their time
    runs: int
    failed: int
    worst: float | None  # largest error of the runs that lasted [rad] or [m]; None: there is none
    reached: ReachedError | None  # None: no runs were made
    # share, share_low: of all runs inside the goal, and its lower limit with 95 % confidence; None without a
    # goal or runs
    share: float | None
    share_low: float | None
    holds: bool | None  # whether `share_low` is enough; None without a goal, or where not all runs were made
    reason: str  # why runs were not made


def score(
    controller: str,
    setting: str,
    plant: str,
    lasting: Sequence[float],
    runs: int,
    goal: float | None,
    reason: str = "",
) -> LawScore:
    """What many runs of a law say; ``lasting``: their errors, ascending; ``goal``: [rad] or [m]."""
    share = low = None
    if goal is not None and runs:
        inside = sum(error <= goal for error in lasting)
        share, low = inside / runs, share_low(inside, runs)
    return LawScore(
        controller=controller,
        setting=setting,
        plant=plant,
        runs=runs,
        failed=runs - len(lasting),
        worst=lasting[-1] if lasting else None,
        reached=reached_error(lasting, runs, ENOUGH[plant]) if runs else None,
        share=share,
        share_low=low,
        holds=None if low is None else low >= ENOUGH[plant],
        reason=reason,
    )


def lost(misses: int, runs: int, plant: str) -> bool:
    """Whether a law has missed the goal so often that the rest of the runs cannot mend it."""
    return misses > max(misses_allowed(runs, ENOUGH[plant]), 0)


def closest(scores: Sequence[LawScore]) -> LawScore | None:
    """The law with the smallest error, with a goal the largest share first; None: no law has runs."""
    made = [one for one in scores if one.runs]
    if not made:
        return None

    def rank(one: LawScore) -> tuple[float, float]:
        error = one.reached.error if one.reached else None
        return -(one.share or 0.0), float("inf") if error is None else error

    return min(made, key=rank)


def quantile_of_all(lasting: Sequence[float], runs: int, share: float) -> float | None:
    """Error that a share of all runs kept below; None where too many ended early, or none was made."""
    needed = max(ceil(share * runs - 1e-9), 1)
    return lasting[needed - 1] if needed <= len(lasting) else None


BLOCKS = {"lumped": 50, "carriage": 25, "cable": 5}
"""Runs that are kept together, by the kind of plant."""
KEPT = 400
"""Points of the worst run that are kept."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleBlock:
    """Runs on some plants, in the order of their draws."""

    scores: tuple[Score, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class WorstCase:
    """The run with the largest error."""

    draw: int
    values: dict[str, float]  # quantities of its plant
    phases: tuple[float, ...]  # of its encoders, in counts
    # time, reference, error, torque: thinned history [s], [rad] or [m], the same, [N m]
    time: tuple[float, ...]
    reference: tuple[float, ...]
    error: tuple[float, ...]
    torque: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class AcceptanceResult:
    """What many runs said."""

    plant: str  # {"lumped", "carriage", "cable"}
    draws: int = 0
    # peaks, rests: largest error of each run that lasted, and of a carriage the largest while it is to stand,
    # both ascending [rad] or [m]
    peaks: tuple[float, ...] = ()
    rests: tuple[float, ...] = ()
    # share of all runs whose error stayed inside the stated bound; None: no bound is stated for the law
    inside: float | None = None
    reached: float | None = None  # share of all runs whose error stayed inside the goal; None without one
    failed: int = 0  # runs that ended before their time
    saturated: int = 0  # runs in which the torque met its limit
    largest_torque: float | None = None  # [N m]; of loads only in the runs that lasted; None: there is none
    smallest_tension: float | None = None  # of a strand with a carriage [N]
    worst: WorstCase | None = None  # None: every run failed, or none was made
    reason: str = ""  # why there are no runs, where there are none

    def quantile(self, share: float, *, rest: bool = False) -> float | None:
        """Error that a share of all runs kept below [rad] or [m]; None where too many ended early."""
        return quantile_of_all(self.rests if rest else self.peaks, self.draws, share)


def accept(
    loop: ClosedLoop | Made[ClosedLoop],
    known: Knowledge,
    *,
    plant: str,
    law: str,
    draws: int,
    seed: int,
    cache: StageCache,
    error: float | None = None,
    bound: float | None = None,
    to_the_end: bool = False,
) -> AcceptanceResult:
    """Run a law on many plants, block by block; each finished block is kept.

    ``plant``, {"lumped", "carriage", "cable"}; ``error``, ``bound``: goal, stated for the law [rad] or [m]. A
    law that has missed the goal more often than all the runs allow is not run further. Blocks of a loop that
    is not `Made`, such as one with a controller of the user's own, are not kept: a changed step could not be
    distinguished from the one before.
    """
    keep = cache if isinstance(loop, Made) else StageCache(folder=None, note=cache.note)
    about, name = (loop, known.quantities, known.correlations, seed), f"acceptance-{plant}-{law}"
    scores: list[Score] = []
    for first in range(0, draws, BLOCKS[plant]):
        last = min(first + BLOCKS[plant], draws)
        scores += keep.staged(f"{name}-{first:05d}", sampled_block, *about, first, last).scores
        cache.note(f"      {law}, {plant} plants: {last} of {draws}")
        misses = sum(one.peak is None or (error is not None and one.peak > error) for one in scores)
        if error is not None and not to_the_end and lost(misses, draws, plant):
            break
    lasting = sorted((one.peak, draw) for draw, one in enumerate(scores) if one.peak is not None)
    worst = keep.staged(f"{name}-worst", worst_case, *about, lasting[-1][1]) if lasting else None
    return _summed(scores, worst, plant=plant, error=error, bound=bound)


def sampled_block(
    loop: ClosedLoop,
    quantities: dict[str, Quantity],
    correlations: Sequence[Correlation],
    seed: int,
    first: int,
    last: int,
) -> SampleBlock:
    """The runs of some draws, two at a time."""

    def one(draw: int) -> Score:
        return loop.run(*sampled_plant(quantities, loop.encoders, seed, draw, correlations))

    with ThreadPoolExecutor(2) as pool:
        return SampleBlock(scores=tuple(pool.map(one, range(first, last))))


def _summed(
    scores: Sequence[Score], worst: WorstCase | None, *, plant: str, error: float | None, bound: float | None
) -> AcceptanceResult:
    peaks = sorted(one.peak for one in scores if one.peak is not None)
    torques = [one.torque for one in scores if one.torque is not None]

    def within(limit: float | None) -> float | None:
        return None if limit is None else sum(p <= limit for p in peaks) / len(scores)

    return AcceptanceResult(
        plant=plant,
        draws=len(scores),
        peaks=tuple(peaks),
        rests=tuple(sorted(one.rest for one in scores if one.rest is not None)),
        inside=within(bound),
        reached=within(error),
        failed=len(scores) - len(peaks),
        saturated=sum(one.saturated > 0.0 for one in scores),
        largest_torque=max(torques, default=None),
        smallest_tension=min((one.tension for one in scores if one.tension is not None), default=None),
        worst=worst,
    )


def worst_case(
    loop: ClosedLoop,
    quantities: dict[str, Quantity],
    correlations: Sequence[Correlation],
    seed: int,
    draw: int,
) -> WorstCase:
    """The run of one draw over time, thinned to what is shown."""
    values, phases = sampled_plant(quantities, loop.encoders, seed, draw, correlations)
    history = loop.history(values, phases)
    n = len(history.error)
    shown = np.unique(np.append(np.arange(0, n, max(1, n // KEPT)), np.argmax(np.abs(history.error))))
    return WorstCase(
        draw=draw,
        values=values,
        phases=tuple(float(p) for p in phases),
        time=tuple(float(t) for t in history.time[shown]),
        reference=tuple(float(r) for r in history.reference[shown]),
        error=tuple(float(e) for e in history.error[shown]),
        torque=tuple(float(u) for u in history.torque[shown]),
    )


def no_runs(plant: str, reason: str) -> AcceptanceResult:
    """An acceptance that was not made, with its reason."""
    return AcceptanceResult(plant=plant, reason=reason)
