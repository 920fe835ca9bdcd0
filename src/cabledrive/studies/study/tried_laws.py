"""Stage 7: every law under one acceptance test, and the simplest that holds the goal."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from cabledrive.studies.study.acceptance_stage import (
    AcceptanceResult,
    LawScore,
    accept,
    closest,
    lost,
    no_runs,
    score,
)
from cabledrive.studies.study.controller_stage import LawSetting
from cabledrive.studies.study.goals import Goals, goal_of
from cabledrive.studies.study.knowledge_stage import Knowledge
from cabledrive.studies.study.plants import Plant
from cabledrive.studies.study.stage_cache import StageCache

NONE_ASKED = "no runs on the distributed cable were requested"
NOT_HELD = "none of the laws meets the goal on the lumped plants"
FIRST = 50
"""Plants that every law meets, where there are several."""
NEAR = 1.5
"""Over the smallest error on these: laws up to it are run to the end where there is no goal."""


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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trial:
    """What the acceptance of every law shares; ``bound``: stated for the law of the chain [rad]."""

    plant: Plant
    goals: Goals
    known: Knowledge
    bound: float | None
    cache: StageCache

    @property
    def draws(self) -> int:
        """Plants on which a law is run to the end."""
        return self.goals.carriage_draws if self.plant.kind == "carriage" else self.goals.draws

    @property
    def no_cable(self) -> str:
        """Why there are no plants on the distributed cable; empty where there are."""
        return NONE_ASKED if self.goals.cable_draws == 0 else self.plant.no_cable


def try_laws(trial: Trial, settings: Sequence[LawSetting]) -> TriedLaws:
    """Run every law on the first plants, and to the end those that may be chosen.

    With a goal these are the laws from the simplest on, until one holds it; without one, those whose largest
    error comes near the smallest. A law that is alone is run to the end.
    """
    kind, goal, draws, why = trial.plant.kind, goal_of(trial.goals), trial.draws, trial.no_cable
    alone = len(settings) == 1
    first = draws if alone else min(FIRST, draws)
    runs = [_accepted(trial, one, kind, first, to_the_end=alone) for one in settings]
    scores = [_scored(one, result, goal) for one, result in zip(settings, runs, strict=True)]
    if closest(scores) is None:
        none = "; ".join(f"{one.controller}: {one.reason}" for one in settings)
        nothing = no_runs(kind, f"no law is applicable: {none}")
        return TriedLaws(
            scores=tuple(scores), cable_scores=(), chosen=None, runs=nothing, cable=no_runs("cable", none)
        )
    found: dict[int, AcceptanceResult] = {}
    cable_scores: list[LawScore] = []
    held = None
    for place in _promising(scores, goal, draws, kind):
        one = settings[place]
        if runs[place].draws < draws:
            runs[place] = _accepted(trial, one, kind, draws)
        scores[place] = _scored(one, runs[place], goal)
        if goal is None or not scores[place].holds:
            continue
        if not why:
            found[place] = _accepted(trial, one, "cable", trial.goals.cable_draws)
            cable_scores.append(_scored(one, found[place], goal))
        if why or cable_scores[-1].holds:
            held = place
            break
    chosen = held
    scores = [_left_off(one, goal, draws) for one in scores]
    if chosen is None:
        near = [one for k, one in enumerate(scores) if k in found] or scores
        chosen = scores.index(closest(near))  # type: ignore[arg-type]
    if goal is None and not why:
        found[chosen] = _accepted(trial, settings[chosen], "cable", trial.goals.cable_draws)
        cable_scores.append(_scored(settings[chosen], found[chosen], None))
    return TriedLaws(
        scores=tuple(scores),
        cable_scores=tuple(cable_scores),
        chosen=settings[chosen],
        runs=runs[chosen],
        cable=found.get(chosen, no_runs("cable", why or NOT_HELD)),
    )


def _promising(scores: Sequence[LawScore], goal: float | None, draws: int, kind: str) -> list[int]:
    """Laws that are run to the end, by place, simplest first."""
    made = [k for k, one in enumerate(scores) if one.runs]
    if goal is not None:
        left = [k for k in made if not lost(_missed(scores[k]), draws, kind)]
        best = closest(scores)
        return left or [k for k in made if scores[k] is best]
    errors = {k: scores[k].worst for k in made}
    least = min((e for k, e in errors.items() if e is not None and not scores[k].failed), default=None)
    if least is None:
        return made
    return [k for k, e in errors.items() if e is not None and e <= NEAR * least and not scores[k].failed]


def _left_off(one: LawScore, goal: float | None, draws: int) -> LawScore:
    """A law that might hold and was not run to the end says so, and claims nothing."""
    missed = one.share is not None and lost(_missed(one), draws, one.plant)
    if missed or not 0 < one.runs < draws:
        return one
    why = "a simpler law meets the goal" if goal is not None else "another law has a smaller error"
    return replace(one, holds=None, reason=f"stopped early: {why}")


def _missed(one: LawScore) -> int:
    assert one.share is not None
    return round((1.0 - one.share) * one.runs)


def _scored(setting: LawSetting, result: AcceptanceResult, goal: float | None) -> LawScore:
    return score(
        setting.controller, setting.words, result.plant, result.peaks, result.draws, goal, result.reason
    )


def _accepted(
    trial: Trial, law: LawSetting, plant: str, draws: int, *, to_the_end: bool = False
) -> AcceptanceResult:
    """A law on so many plants of a kind; the bound is that of the law of the chain alone."""
    if law.value is None:
        return no_runs(plant, law.reason)
    return accept(
        trial.plant.closed_loop(law, cable=plant == "cable"),
        trial.known,
        plant=plant,
        law=law.controller,
        draws=draws,
        seed=trial.goals.seed,
        cache=trial.cache,
        error=goal_of(trial.goals),
        bound=None if law.model is None else trial.bound,
        to_the_end=to_the_end,
    )
