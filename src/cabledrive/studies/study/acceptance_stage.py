"""Stage 7: every law on many plants drawn from what is known, and the simplest that holds the goal."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from cabledrive.rig.plant_samples import CONFIDENCE, share_low
from cabledrive.rig.tuning import LawSetting
from cabledrive.studies.study.goals import goal_of
from cabledrive.studies.study.machine import Quantity
from cabledrive.studies.study.plants import ClosedLoop, Plant
from cabledrive.studies.study.sampled_plants import Correlation, Score, sampled_plant

ENOUGH = {"lumped": 0.99, "carriage": 0.99, "cable": 0.95}
"""Share of the plants that must keep within the goal, by the kind of plant."""
NONE_ASKED = "no runs on the distributed cable were requested"
NOT_HELD = "none of the laws meets the goal on the lumped plants"
FIRST = 50
"""Plants that every law meets, where there are several."""
NEAR = 1.5
"""Over the smallest error on these: laws up to it are run to the end where there is no goal."""
BLOCKS = {"lumped": 50, "carriage": 25, "cable": 5}
"""Runs that are kept together, by the kind of plant."""
KEPT = 400
"""Points of the worst run that are kept."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReachedError:
    """An error that a share of the plants keeps below."""

    error: float | None  # [rad] or [m]; None: too many runs ended early to name one
    # lower limit of the share that keeps below it; the share that is asked for, or what the number of runs
    # can show where it is too small for that
    share: float
    confidence: float = CONFIDENCE


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
        lasting, needed = self.rests if rest else self.peaks, max(ceil(share * self.draws - 1e-9), 1)
        return lasting[needed - 1] if needed <= len(lasting) else None


@dataclass(frozen=True, slots=True, kw_only=True)
class TriedLaws:
    """All laws of a study."""

    scores: tuple[LawScore, ...]  # on the plants that decide first, simplest law first
    cable_scores: tuple[LawScore, ...]  # on the distributed cable, of those that came to it
    # the simplest that holds the goal; without one that does, or without a goal, the one that came closest
    chosen: LawSetting | None
    # runs, cable: of the chosen law
    runs: AcceptanceResult
    cable: AcceptanceResult

    @property
    def score(self) -> LawScore | None:
        """Of the chosen law on the plants that decide first; None: no law was run."""
        return self._of_the_chosen(self.scores)

    @property
    def cable_score(self) -> LawScore | None:
        """Of the chosen law on the distributed cable; None: it was not run there."""
        return self._of_the_chosen(self.cable_scores)

    def _of_the_chosen(self, scores: Sequence[LawScore]) -> LawScore | None:
        return next((one for one in scores if self.chosen and one.controller == self.chosen.controller), None)


def no_laws(plant: str, reason: str, cable: str, scores: Sequence[LawScore] = ()) -> TriedLaws:
    """No law is chosen; ``reason``, ``cable``: why there are no runs on either kind of plant."""
    runs = [AcceptanceResult(plant=kind, reason=why) for kind, why in ((plant, reason), ("cable", cable))]
    return TriedLaws(scores=tuple(scores), cable_scores=(), chosen=None, runs=runs[0], cable=runs[1])


def misses_allowed(runs: int, share: float) -> int:
    """Most runs that may miss while `share_low` keeps a share; -1: so few runs cannot show it."""
    misses = -1
    while misses + 1 < runs and share_low(runs - misses - 1, runs) >= share:
        misses += 1
    return misses


def lost(misses: int, runs: int, plant: str) -> bool:
    """Whether a law has missed the goal so often that the rest of the runs cannot mend it."""
    return misses > max(misses_allowed(runs, ENOUGH[plant]), 0)


def score(law: LawSetting, found: AcceptanceResult, goal: float | None) -> LawScore:
    """What many runs of a law say; ``goal``: [rad] or [m]."""
    runs, enough = found.draws, ENOUGH[found.plant]
    share = low = reached = None
    if goal is not None and runs:
        inside = sum(error <= goal for error in found.peaks)
        share, low = inside / runs, share_low(inside, runs)
    if runs:  # the share asked for, or what so few runs can show
        misses = misses_allowed(runs, enough)
        shown = enough if misses >= 0 else share_low(runs, runs)
        place = runs - max(misses, 0) - 1
        reached = ReachedError(error=found.peaks[place] if place < len(found.peaks) else None, share=shown)
    return LawScore(
        controller=law.controller,
        setting=law.words,
        plant=found.plant,
        runs=runs,
        failed=runs - len(found.peaks),
        worst=found.peaks[-1] if found.peaks else None,
        reached=reached,
        share=share,
        share_low=low,
        holds=None if low is None else low >= enough,
        reason=found.reason,
    )


def closest(scores: Sequence[LawScore]) -> LawScore | None:
    """The law with the smallest error, with a goal the largest share first; None: no law has runs."""

    def rank(one: LawScore) -> tuple[float, float]:
        error = one.reached.error if one.reached else None
        return -(one.share or 0.0), float("inf") if error is None else error

    return min((one for one in scores if one.runs), key=rank, default=None)


def accept(
    plant: Plant, law: LawSetting, kind: str, draws: int, *, bound: float | None, to_the_end: bool = False
) -> AcceptanceResult:
    """Run a law on many plants of a kind, block by block, until so many miss the goal that it is lost.

    Each finished block is kept; ``bound``: stated for the law of the chain [rad].
    """
    if law.bandwidth is None:
        return AcceptanceResult(plant=kind, reason=law.reason)
    goal, cache, known = goal_of(plant.goals), plant.cache, plant.known
    assert known is not None
    loop, name = plant.closed_loop(law, cable=kind == "cable"), law.controller
    about = loop, (known.quantities, known.correlations), plant.goals.seed
    scores: list[Score] = []
    for first in range(0, draws, BLOCKS[kind]):
        last, stage = min(first + BLOCKS[kind], draws), f"acceptance-{kind}-{name}-{first:05d}"
        scores += cache.staged(stage, sampled_block, *about, first, last)
        cache.note(f"      {name}, {kind} plants: {last} of {draws}")
        misses = sum(one.peak is None or (goal is not None and one.peak > goal) for one in scores)
        if goal is not None and not to_the_end and lost(misses, draws, kind):
            break
    lasting = sorted((one.peak, draw) for draw, one in enumerate(scores) if one.peak is not None)
    peaks, worst = tuple(peak for peak, _ in lasting), None
    if lasting:
        worst = cache.staged(f"acceptance-{kind}-{name}-worst", worst_case, *about, lasting[-1][1])

    def within(limit: float | None) -> float | None:
        return None if limit is None else sum(p <= limit for p in peaks) / len(scores)

    return AcceptanceResult(
        plant=kind,
        draws=len(scores),
        peaks=peaks,
        rests=tuple(sorted(one.rest for one in scores if one.rest is not None)),
        inside=None if law.model is None else within(bound),
        reached=within(goal),
        failed=len(scores) - len(peaks),
        saturated=sum(one.saturated > 0.0 for one in scores),
        largest_torque=max((one.torque for one in scores if one.torque is not None), default=None),
        smallest_tension=min((one.tension for one in scores if one.tension is not None), default=None),
        worst=worst,
    )


Known = tuple[dict[str, Quantity], Sequence[Correlation]]
"""What plants are drawn from."""


def sampled_block(loop: ClosedLoop, known: Known, seed: int, first: int, last: int) -> tuple[Score, ...]:
    """The runs of some draws, two at a time."""

    def one(draw: int) -> Score:
        return loop.run(*sampled_plant(known[0], loop.encoders, seed, draw, known[1]))

    with ThreadPoolExecutor(2) as pool:
        return tuple(pool.map(one, range(first, last)))


def worst_case(loop: ClosedLoop, known: Known, seed: int, draw: int) -> WorstCase:
    """The run of one draw over time, thinned to what is shown."""
    values, phases = sampled_plant(known[0], loop.encoders, seed, draw, known[1])
    history = loop.history(values, phases)
    n = len(history["error"])
    shown = np.unique(np.append(np.arange(0, n, max(1, n // KEPT)), np.argmax(np.abs(history["error"]))))
    thinned = {name: tuple(column[shown].tolist()) for name, column in history.items()}
    return WorstCase(draw=draw, values=values, phases=tuple(phases.tolist()), **thinned)


def try_laws(plant: Plant, settings: Sequence[LawSetting], bound: float | None) -> TriedLaws:
    """Run laws on the same plants and choose; ``settings``: simplest first.

    All run on the first few; those that can still hold the goal run on, and on the cable, until one holds it;
    without a goal those near the smallest error.
    """
    goals, kind, goal = plant.goals, plant.kind, goal_of(plant.goals)
    draws = goals.carriage_draws if kind == "carriage" else goals.draws
    why = NONE_ASKED if goals.cable_draws == 0 else plant.no_cable
    alone = len(settings) == 1
    first = draws if alone else min(FIRST, draws)
    runs = [accept(plant, one, kind, first, bound=bound, to_the_end=alone) for one in settings]
    scores = [score(one, result, goal) for one, result in zip(settings, runs, strict=True)]
    if closest(scores) is None:
        none = "; ".join(f"{one.controller}: {one.reason}" for one in settings)
        return no_laws(kind, f"no law is applicable: {none}", none, scores)
    found: dict[int, AcceptanceResult] = {}
    cable_scores: list[LawScore] = []
    chosen: int | None = None

    def on_the_cable(place: int) -> bool | None:
        found[place] = accept(plant, settings[place], "cable", goals.cable_draws, bound=bound)
        cable_scores.append(score(settings[place], found[place], goal))
        return cable_scores[-1].holds

    for place in _promising(scores, goal, draws, kind):
        if runs[place].draws < draws:
            runs[place] = accept(plant, settings[place], kind, draws, bound=bound)
        scores[place] = score(settings[place], runs[place], goal)
        if goal is not None and scores[place].holds and (why or on_the_cable(place)):
            chosen = place
            break
    left_off = "a simpler law meets the goal" if goal is not None else "another law has a smaller error"
    for place, one in enumerate(scores):  # a law that might hold and was not run to the end claims nothing
        if 0 < one.runs < draws and not (one.share is not None and lost(_missed(one), draws, kind)):
            scores[place] = replace(one, holds=None, reason=f"stopped early: {left_off}")
    if chosen is None:
        near = closest([one for k, one in enumerate(scores) if k in found] or scores)
        chosen = next(k for k, one in enumerate(scores) if one is near)
    if goal is None and not why:
        on_the_cable(chosen)
    return TriedLaws(
        scores=tuple(scores),
        cable_scores=tuple(cable_scores),
        chosen=settings[chosen],
        runs=runs[chosen],
        cable=found.get(chosen, AcceptanceResult(plant="cable", reason=why or NOT_HELD)),
    )


def _promising(scores: Sequence[LawScore], goal: float | None, draws: int, kind: str) -> list[int]:
    """Laws that are run to the end, by place, simplest first."""
    made = [k for k, one in enumerate(scores) if one.runs]
    if goal is not None:
        left = [k for k in made if not lost(_missed(scores[k]), draws, kind)]
        best = closest(scores)
        return left or [k for k in made if scores[k] is best]
    errors = {k: one.worst for k, one in enumerate(scores) if one.worst is not None and not one.failed}
    return [k for k, error in errors.items() if error <= NEAR * min(errors.values())] if errors else made


def _missed(one: LawScore) -> int:
    assert one.share is not None
    return round((1.0 - one.share) * one.runs)
