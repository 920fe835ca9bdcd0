"""Chapters "Controller" and "Acceptance" of a study: of a load and of a carriage."""

from collections.abc import Iterable, Mapping

from markupsafe import Markup

from cabledrive.answers.figures import number, percent, stated
from cabledrive.report.blocks import Block, Cell, Chapter, Note, Paragraph, Table, pictured, table
from cabledrive.report.figures.study_runs import (
    CARRIAGE,
    LOAD,
    Errors,
    bandwidths_picture,
    peaks_picture,
    worst_picture,
)
from cabledrive.report.study.verdict import listed, named, unit_shown
from cabledrive.report.words import sentences, texts
from cabledrive.studies.study import StudyResult
from cabledrive.studies.study.acceptance_stage import AcceptanceResult, WorstCase
from cabledrive.studies.study.bandwidth_cost import Candidate, CarriageCandidate, CarriageController
from cabledrive.studies.study.carriage import CarriageModel
from cabledrive.studies.study.machine import UNITS
from cabledrive.studies.study.plants import ControllerResult
from cabledrive.studies.study.verdict_stage import NO_BOUND

ESTIMATES = ("Inertia at the motor", "Viscous friction", "Coulomb friction", "Offset torque")
ESTIMATE_UNITS = ("kg m²", "N m s/rad", "N m", "N m")
say = texts("study_controller")


def controller_chapter(result: StudyResult) -> Chapter | None:
    """The law with its bandwidth and bound, of a carriage with its model; None without either."""
    found, model = result.controller, result.model
    if isinstance(model, CarriageModel):
        assert not isinstance(found, ControllerResult)
        kind, errors, blocks = "carriage", CARRIAGE, _of_carriage(model, found)
    elif isinstance(found, ControllerResult):
        kind, errors, blocks = "load", LOAD, _of_load(found)
    else:
        return None
    candidates = () if found is None else found.candidates
    if found is not None and candidates:
        heads = say(f"candidate_heads_{kind}")
        rows = (_candidate(one, found.chosen, errors) for one in candidates)
        refused = say("refused", reasons=_refusals(candidates))
        blocks.append(table(say(f"candidates_{kind}"), heads, rows, note=refused))
        if len(errors.usable(found)) > 1:
            seen = [(one.bandwidth, getattr(one, errors.whole)) for one in errors.usable(found)]
            picture = bandwidths_picture(found, errors)
            words = {"whole": errors.whole, "seen": seen, "unit": errors.unit}
            blocks.append(pictured(say, "bandwidths", picture, **words))
        if found.shares:
            ordered = sorted(found.shares.items(), key=lambda item: -item[1])
            shares = ((named(name), errors.shown(share)) for name, share in ordered)
            blocks.append(table(say(f"shares_{kind}"), f"Quantity | Share [{errors.unit}]", shares))
    if isinstance(found, ControllerResult) and found.broken:
        blocks.append(Note(text=listed(say("broken"), found.broken)))
    method = say(f"method_{kind}")
    return Chapter("Controller", "controller", tuple(blocks), methods=(method,))


def _of_load(found: ControllerResult) -> list[Block]:
    if found.bandwidth is None:
        return [Note(text=sentences((found.reason,)), tone="warning")]
    shown = '<span class="equation"><math display="block" aria-label="{}">{}</math></span>'
    formula = Paragraph(text=Markup(shown).format(say("equation"), Markup(say("formula"))))
    ends = zip(ESTIMATES, found.lower, found.upper, ESTIMATE_UNITS, strict=True)
    rows = ((name, number(low, 4), number(high, 4), unit) for name, low, high, unit in ends)
    bounds = table(say("bounds"), "Estimate | Low [] | High [] | Unit", rows)
    return [Paragraph(text=say("law_load", found=found)), formula, bounds]


def _of_carriage(model: CarriageModel, found: CarriageController | None) -> list[Block]:
    places = zip(model.positions, model.lumped, model.exact, strict=True)
    rows = (
        (number(x, 4), number(lumped, 5), number(exact, 5), f"{100 * abs(lumped / exact - 1.0):.2g}")
        for x, lumped, exact in places
    )
    heads = "Place [m] | Model [Hz] | Exact [Hz] | Apart [%]"
    first = table(say("model"), heads, rows, note=say("left_out", error=model.left_out))
    if model.reason:
        return [first, Note(text=sentences((model.reason,)), tone="warning")]
    if found is None:
        return [first, Note(text=say("too_far"))]
    if found.bandwidth is None:
        return [first, Note(text=sentences((found.reason,)), tone="warning")]
    law = Paragraph(text=say("law_carriage", found=found))
    return [first, law, Note(text=sentences((NO_BOUND,)))]


def _candidate(
    one: Candidate | CarriageCandidate, chosen: Candidate | CarriageCandidate | None, errors: Errors
) -> tuple[Cell, ...]:
    """A bandwidth, the parts of its error, their sum, its torque, what became of it."""
    model = f"Model {one.model}, " if isinstance(one, Candidate) else ""
    return (
        f"{model}{one.bandwidth:g} Hz",
        *(errors.shown(getattr(one, part)) for part in (*errors.parts, errors.whole)),
        stated(one.torque, 3),
        "chosen" if one == chosen else "refused" if one.refused else "",
    )


def _refusals(candidates: Iterable[Candidate | CarriageCandidate]) -> dict[str, str]:
    """Bandwidths by why they were refused."""
    reasons: dict[str, list[str]] = {}
    for one in candidates:
        if one.refused:
            model = f"Model {one.model} at " if isinstance(one, Candidate) else ""
            reasons.setdefault(one.refused, []).append(f"{model}{one.bandwidth:g}")
    return {why: ", ".join(hertz) for why, hertz in reasons.items()}


say_runs = texts("study_acceptance")


def acceptance_chapter(result: StudyResult) -> Chapter | None:
    """Results of the runs, if there were any."""
    carried = result.carried
    if not result.laws.scores or (carried and not result.runs.draws):
        return None
    errors, kind = (CARRIAGE, "carriage") if carried else (LOAD, "load")
    asked = (result.runs,) if carried else (result.runs, result.cable)
    runs = [one for one in asked if one.draws]
    goal = result.goals.carriage_error if carried else result.goals.error
    blocks: list[Block] = [Paragraph(text=say_runs(f"intro_{kind}", chosen=result.laws.chosen))]
    blocks += [Note(text=say_runs("not_run", one=one), tone="warning") for one in asked if not one.draws]
    blocks.append(_laws(result.laws.scores, errors))
    if runs:
        blocks.append(_runs(runs, errors))
    if lasting := [one for one in runs if one.peaks]:
        control, stated = result.controller, runs[0].inside is not None
        bound = control.bound if stated and isinstance(control, ControllerResult) else None
        picture = peaks_picture(lasting, {"bound": bound, "goal": goal}, errors)
        words = {"runs": lasting, "bound": bound, "unit": errors.unit}
        blocks.append(pictured(say_runs, "peaks", picture, **words))
    if (worst := result.runs.worst) is not None:
        picture = worst_picture(worst, "position" if carried else "motion", errors)
        blocks.append(pictured(say_runs, "worst", picture, worst=worst, unit=errors.unit))
        blocks.append(_worst_plant(worst, result.knowledge.values))
    method = say_runs(f"method_{kind}", draws=result.runs.draws, seed=result.goals.seed)
    return Chapter("Acceptance", "acceptance", tuple(blocks), methods=(method,))


def _laws(scores: Iterable[AcceptanceResult], errors: Errors) -> Table:
    """Every law, simplest first, with its errors and the share of the plants it holds within the goal."""
    rows = (
        (
            one.law.controller,
            one.law.words,
            f"{one.draws}",
            errors.shown(one.reached.error if one.reached else None),
            errors.shown(one.peaks[-1] if one.peaks else None),
            *("" if share is None else percent(share) for share in (one.share, one.share_low)),
            f"{one.failed}",
        )
        for one in scores
    )
    unit = errors.unit
    return table(
        "Laws tried, simplest first.",
        f"Law | Setting | Runs [] | 99 % [{unit}] | Worst [{unit}] | In goal [] | At least [] | "
        "Ended early []",
        rows,
        note="; ".join(f"{one.law.controller}: {one.reason}" for one in scores if one.reason),
    )


def _runs(runs: list[AcceptanceResult], errors: Errors) -> Table:
    """Quantiles of the largest error, of a carriage also of that at rest; shares within bound and goal."""
    names = {"bound": runs[0].inside, "goal": runs[0].share}
    asked, unit = ", ".join(name for name, share in names.items() if share is not None), errors.unit
    rows: list[tuple[Cell, ...]] = []
    for one in runs:
        inside = ", ".join(f"{100 * s:.1f} %" for s in (one.inside, one.share) if s is not None)
        for words, still in ((one.plant.capitalize(), False), ("The same, at rest", True)):
            if not still or one.rests:
                quantiles = (errors.shown(one.quantile(share, rest=still)) for share in (0.5, 0.99, 1.0))
                rest = ("", "", "") if still else (inside, stated(one.largest_torque, 3), f"{one.failed}")
                rows.append((words, f"{one.draws}", *quantiles, *rest))
    return table(
        say_runs("table"),
        f"Plants | Runs [] | Median [{unit}] | 99 % [{unit}] | Worst [{unit}] | "
        f"{f'In {asked}' if asked else ''} [] | Torque [N m] | Ended early []",
        rows,
        note=" ".join(say_runs("runs_note", one=one, unit=unit) for one in runs),
    )


def _worst_plant(worst: WorstCase, best: Mapping[str, float]) -> Table:
    """The plant of the worst run beside the best values, in SI."""
    rows = []
    for name, value in worst.values.items():
        beside = number(best[name], 5) if name in best else ""
        rows.append((named(name), number(value, 5), beside, unit_shown(UNITS[name])))
    return table(
        f"The plant of the worst run, sample {worst.draw}.",
        "Quantity | Its value [] | Best value [] | Unit",
        rows,
        note=f"Encoder phases in counts: {', '.join(f'{phase:+.2f}' for phase in worst.phases)}.",
    )
