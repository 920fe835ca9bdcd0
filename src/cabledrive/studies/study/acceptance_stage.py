"""Stage 7: every law on many plants drawn from what is known, and the simplest that holds the goal."""

import json
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.parameters import content_hash
from cabledrive.rig.front_door import law_from_file
from cabledrive.rig.laws.controller_file import FILE, controller_from, controller_numbers
from cabledrive.rig.plant_samples import CONFIDENCE, error_kept, share_low
from cabledrive.rig.tuning import LawSetting
from cabledrive.studies.study.goals import Goals, goal_of
from cabledrive.studies.study.machine import Quantity
from cabledrive.studies.study.plants import ClosedLoop, Plant
from cabledrive.studies.study.sampled_plants import Correlation, LoadCase, LoadLoop, Score, sampled_plant

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


NO_LAW = LawSetting(controller="")


@dataclass(frozen=True, slots=True, kw_only=True)
class AcceptanceResult:
    """What many runs of a law said."""

    plant: str  # {"lumped", "carriage", "cable"}
    law: LawSetting = NO_LAW
    goal: float | None = None  # largest error allowed [rad] or [m]
    draws: int = 0
    # peaks, rests: largest error of each run that lasted, and of a carriage the largest while it is to stand,
    # both ascending [rad] or [m]
    peaks: tuple[float, ...] = ()
    rests: tuple[float, ...] = ()
    # share of all runs whose error stayed inside the stated bound; None: no bound is stated for the law
    inside: float | None = None
    saturated: int = 0  # runs in which the torque met its limit
    largest_torque: float | None = None  # [N m]; of loads only in the runs that lasted; None: there is none
    smallest_tension: float | None = None  # of a strand with a carriage [N]
    worst: WorstCase | None = None  # None: every run failed, or none was made
    reason: str = ""  # why there are no runs, or not all of them

    @property
    def failed(self) -> int:
        """Runs that ended before their time."""
        return self.draws - len(self.peaks)

    @property
    def misses(self) -> int:
        """Runs outside the goal, those that ended early among them; all without a goal."""
        return self.draws - sum(self.goal is not None and peak <= self.goal for peak in self.peaks)

    @property
    def share(self) -> float | None:
        """Of all runs those inside the goal; None without a goal or runs."""
        return (self.draws - self.misses) / self.draws if self.goal is not None and self.draws else None

    @property
    def share_low(self) -> float | None:
        """Its lower limit, see `cabledrive.rig.plant_samples.share_low`."""
        return None if self.share is None else share_low(self.draws - self.misses, self.draws)

    @property
    def holds(self) -> bool | None:
        """Whether that is enough; None without a goal, or where not all runs were made."""
        return None if self.share_low is None or self.reason else self.share_low >= ENOUGH[self.plant]

    @property
    def reached(self) -> ReachedError | None:
        """The error below which the share asked for stays, or what so few can show; None without runs."""
        if not self.draws:
            return None
        misses = misses_allowed(self.draws, ENOUGH[self.plant])
        shown = ENOUGH[self.plant] if misses >= 0 else share_low(self.draws, self.draws)
        return ReachedError(error=self.quantile(1.0 - max(misses, 0) / self.draws), share=shown)

    def quantile(self, share: float, *, rest: bool = False) -> float | None:
        """Error that a share of all runs kept below [rad] or [m]; None where too many ended early."""
        return error_kept(self.rests if rest else self.peaks, share, self.draws)


@dataclass(frozen=True, slots=True, kw_only=True)
class TriedLaws:
    """All laws of a study."""

    scores: tuple[AcceptanceResult, ...]  # on the plants that decide first, simplest law first
    cable_scores: tuple[AcceptanceResult, ...]  # on the distributed cable, of those that came to it
    # the simplest that holds the goal; without one that does, or without a goal, the one that came closest
    chosen: LawSetting | None
    # runs, cable: of the chosen law; without runs, why there are none
    runs: AcceptanceResult
    cable: AcceptanceResult


def no_laws(plant: str, reason: str, cable: str, scores: Sequence[AcceptanceResult] = ()) -> TriedLaws:
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


def closest(scores: Sequence[AcceptanceResult]) -> AcceptanceResult | None:
    """The law with the smallest error, with a goal the largest share first; None: no law has runs.

    Where no error can be named, the law of which the fewest runs ended early.
    """

    def rank(one: AcceptanceResult) -> tuple[float, float, float]:
        error = one.reached.error if one.reached else None
        return -(one.share or 0.0), float("inf") if error is None else error, one.failed / one.draws

    return min((one for one in scores if one.draws), key=rank, default=None)


def accept(
    plant: Plant, law: LawSetting, kind: str, draws: int, *, bound: float | None, to_the_end: bool = False
) -> AcceptanceResult:
    """Run a law on many plants of a kind, block by block, until so many miss the goal that it is lost.

    Each finished block is kept; ``bound``: stated for the law of the chain [rad].
    """
    goal, cache, known = goal_of(plant.goals), plant.cache, plant.known
    if law.bandwidth is None:
        return AcceptanceResult(plant=kind, law=law, goal=goal, reason=law.reason)
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
    stated = None if law.model is None else bound
    return AcceptanceResult(
        plant=kind,
        law=law,
        goal=goal,
        draws=len(scores),
        peaks=peaks,
        rests=tuple(sorted(one.rest for one in scores if one.rest is not None)),
        inside=None if stated is None else sum(peak <= stated for peak in peaks) / len(scores),
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


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportedRuns:
    """What the law as `export` writes it says on the lumped plants: with the last gain of its filter."""

    draws: int
    misses: int
    holds: bool


def run_as_exported(case: LoadCase, law: LawSetting, goals: Goals) -> ExportedRuns | None:
    """The law of a file on the plants of the acceptance; None without a goal."""
    made, goal = LoadLoop(case, law, cable=False), goal_of(goals)
    if goal is None:
        return None
    numbers = controller_numbers(made.loop, case.drive, case.spec.feedback)
    written = json.loads(json.dumps(numbers)) | {"drive_hash": content_hash(case.drive)}
    made.loop = case.loop(law_from_file(controller_from(written, FILE), case.spec))
    known = dict(case.quantities), case.correlations
    scores = sampled_block(made, known, goals.seed, 0, goals.draws)
    misses = sum(one.peak is None or one.peak > goal for one in scores)
    return ExportedRuns(draws=goals.draws, misses=misses, holds=not lost(misses, goals.draws, "lumped"))


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
    if closest(runs) is None:
        none = "; ".join(f"{one.controller}: {one.reason}" for one in settings)
        return no_laws(kind, f"no law is applicable: {none}", none, runs)
    found: dict[int, AcceptanceResult] = {}
    chosen: int | None = None

    def on_the_cable(place: int) -> bool | None:
        found[place] = accept(plant, settings[place], "cable", goals.cable_draws, bound=bound)
        return found[place].holds

    for place in _promising(runs, goal, draws, kind):
        if runs[place].draws < draws:
            runs[place] = accept(plant, settings[place], kind, draws, bound=bound)
        if goal is not None and runs[place].holds and (why or on_the_cable(place)):
            chosen = place
            break
    left_off = "a simpler law meets the goal" if goal is not None else "another law has a smaller error"
    for place, one in enumerate(runs):  # a law that might hold and was not run to the end claims nothing
        if 0 < one.draws < draws and (goal is None or not lost(one.misses, draws, kind)):
            runs[place] = replace(one, reason=f"stopped early: {left_off}")
    if chosen is None:
        near = closest([one for k, one in enumerate(runs) if k in found] or runs)
        chosen = next(k for k, one in enumerate(runs) if one is near)
    if goal is None and not why:
        on_the_cable(chosen)
    return TriedLaws(
        scores=tuple(runs),
        cable_scores=tuple(found.values()),
        chosen=settings[chosen],
        runs=runs[chosen],
        cable=found.get(chosen, AcceptanceResult(plant="cable", reason=why or NOT_HELD)),
    )


def _promising(runs: Sequence[AcceptanceResult], goal: float | None, draws: int, kind: str) -> list[int]:
    """Laws that are run to the end, by place, simplest first."""
    made = [k for k, one in enumerate(runs) if one.draws]
    if goal is not None:
        left = [k for k in made if not lost(runs[k].misses, draws, kind)]
        best = closest(runs)
        return left or [k for k in made if runs[k] is best]
    errors = {k: one.peaks[-1] for k, one in enumerate(runs) if one.peaks and not one.failed}
    return [k for k, error in errors.items() if error <= NEAR * min(errors.values())] if errors else made
