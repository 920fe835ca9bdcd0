"""Stage 7: every law under one acceptance test, and the simplest that holds the goal."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from cabledrive.parameters import Drive
from cabledrive.studies.study.acceptance_stage import AcceptanceResult, accept, no_runs
from cabledrive.studies.study.candidates import LawScore, closest, lost, score
from cabledrive.studies.study.controller_stage import ControllerResult
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.knowledge_stage import Knowledge
from cabledrive.studies.study.law_settings import LawSetting, law_of
from cabledrive.studies.study.stage_cache import StageCache

NONE_ASKED = "no runs on the distributed cable were requested"
NOT_HELD = "none of the laws meets the goal on the lumped plants"
FIRST = 50
"""Plants that every law meets."""
NEAR = 1.5
"""Over the smallest error on these: laws up to it are run to the end where there is no goal."""
LINE = "the cable plant is a loop round two pulleys, this drive is a line"
BACKLASH = "the distributed cable does not support motor.backlash"


@dataclass(frozen=True, slots=True, kw_only=True)
class TriedLaws:
    """All laws of a study.

    Attributes
    ----------
    scores : tuple of LawScore
        On the lumped plants, simplest law first.
    cable_scores : tuple of LawScore
        On the distributed cable, of those that came to it.
    chosen : LawSetting or None
        The simplest that holds the goal; without one that does, or without a goal, the one that came closest.
    lumped, cable : AcceptanceResult
        Of the chosen law.
    """

    scores: tuple[LawScore, ...]
    cable_scores: tuple[LawScore, ...]
    chosen: LawSetting | None
    lumped: AcceptanceResult
    cable: AcceptanceResult


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trial:
    """What the acceptance of every law shares.

    Attributes
    ----------
    drive : Drive
        With the best values.
    goals : Goals
    known : Knowledge
    chain_law : ControllerResult
        Whose bound is stated for the damped law of the chain.
    cache : StageCache
    inputs : mapping
        All that a run depends on, but the law and the draw.
    """

    drive: Drive
    goals: Goals
    known: Knowledge
    chain_law: ControllerResult
    cache: StageCache
    inputs: Mapping[str, object]


def try_laws(trial: Trial, settings: Sequence[LawSetting]) -> TriedLaws:
    """Run every law on the first plants, and to the end those that may be chosen.

    With a goal these are the laws from the simplest on, until one holds it; without one, those whose largest
    error comes near the smallest.

    ``settings``: simplest law first.
    """
    goals = trial.goals
    first = min(FIRST, goals.draws)
    runs = [_accepted(trial, one, first, cable=False) for one in settings]
    scores = [_scored(one, result, goals.error) for one, result in zip(settings, runs, strict=True)]
    if closest(scores) is None:
        why = "; ".join(f"{one.controller}: {one.reason}" for one in settings)
        nothing = no_runs("lumped", f"no law is applicable: {why}")
        return TriedLaws(
            scores=tuple(scores), cable_scores=(), chosen=None, lumped=nothing, cable=no_runs("cable", why)
        )
    why = _no_cable(trial)
    found: dict[int, AcceptanceResult] = {}
    cable_scores: list[LawScore] = []
    held = None
    for place in _promising(scores, goals):
        one = settings[place]
        runs[place] = _accepted(trial, one, goals.draws, cable=False)
        scores[place] = _scored(one, runs[place], goals.error)
        if goals.error is None or not scores[place].holds:
            continue
        if not why:
            found[place] = _accepted(trial, one, goals.cable_draws, cable=True)
            cable_scores.append(_scored(one, found[place], goals.error))
        if why or cable_scores[-1].holds:
            held = place
            break
    chosen = held
    scores = [_left_off(one, goals) for one in scores]
    if chosen is None:
        near = [one for k, one in enumerate(scores) if k in found] or scores
        chosen = scores.index(closest(near))  # type: ignore[arg-type]
    if goals.error is None and not why:
        found[chosen] = _accepted(trial, settings[chosen], goals.cable_draws, cable=True)
        cable_scores.append(_scored(settings[chosen], found[chosen], None))
    return TriedLaws(
        scores=tuple(scores),
        cable_scores=tuple(cable_scores),
        chosen=settings[chosen],
        lumped=runs[chosen],
        cable=found.get(chosen, no_runs("cable", why or NOT_HELD)),
    )


def _promising(scores: Sequence[LawScore], goals: Goals) -> list[int]:
    """Laws that are run to the end, by place, simplest first."""
    made = [k for k, one in enumerate(scores) if one.runs]
    if goals.error is not None:
        left = [k for k in made if not lost(_missed(scores[k]), goals.draws, "lumped")]
        best = closest(scores)
        return left or [k for k in made if scores[k] is best]
    errors = {k: scores[k].worst for k in made}
    least = min((e for k, e in errors.items() if e is not None and not scores[k].failed), default=None)
    if least is None:
        return made
    return [k for k, e in errors.items() if e is not None and e <= NEAR * least and not scores[k].failed]


def _left_off(one: LawScore, goals: Goals) -> LawScore:
    """A law that might hold and was not run to the end says so, and claims nothing."""
    missed = one.share is not None and lost(_missed(one), goals.draws, "lumped")
    if missed or not 0 < one.runs < goals.draws:
        return one
    why = "a simpler law meets the goal" if goals.error is not None else "another law has a smaller error"
    return replace(one, holds=None, reason=f"stopped early: {why}")


def _missed(one: LawScore) -> int:
    assert one.share is not None
    return round((1.0 - one.share) * one.runs)


def _no_cable(trial: Trial) -> str:
    """Why there are no plants on the distributed cable; empty where there are."""
    if trial.goals.cable_draws == 0:
        return NONE_ASKED
    if trial.drive.kind != "loop":
        return LINE
    motor = trial.drive.motor
    return BACKLASH if motor is not None and motor.backlash > 0.0 else ""


def _scored(setting: LawSetting, result: AcceptanceResult, goal: float | None) -> LawScore:
    return score(
        setting.controller, setting.words, result.plant, result.peaks, result.draws, goal, result.reason
    )


def _accepted(trial: Trial, setting: LawSetting, draws: int, *, cable: bool) -> AcceptanceResult:
    goals, plant = trial.goals, "cable" if cable else "lumped"
    if setting.value is None:
        return no_runs(plant, setting.reason)
    own = setting.model is not None
    bound = trial.chain_law.bound if own else None
    about = {**trial.inputs, "law": setting, "seed": goals.seed, "cable": cable}
    result: AcceptanceResult = trial.cache.staged(
        f"acceptance-{plant}-{setting.controller}",
        AcceptanceResult,
        {**about, "draws": draws, "bound": bound, "error": goals.error},
        lambda: accept(
            trial.drive,
            goals.motion,
            trial.known,
            law_of(setting, trial.drive, goals.motion, trial.known),
            draws=draws,
            seed=goals.seed,
            torque=goals.torque,
            error=goals.error,
            cable=cable,
            cache=trial.cache,
            inputs=about,
            bound=bound,
        ),
    )
    return result
