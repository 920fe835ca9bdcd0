"""Chapters "Controller" of a carriage and "Acceptance" of a study."""

from collections.abc import Mapping, Sequence

from cabledrive.parameters.fields import percent
from cabledrive.report.blocks import Block, Cell, Chapter, Figure, Note, Paragraph, Table, table
from cabledrive.report.figures.study_runs import (
    carriage_bandwidths_picture,
    carriage_peaks_picture,
    carriage_worst_picture,
    peaks_picture,
    worst_picture,
)
from cabledrive.report.typesetting import number
from cabledrive.report.words import sentences, texts
from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study import StudyResult
from cabledrive.studies.study.acceptance_stage import AcceptanceResult, LawScore, WorstCase
from cabledrive.studies.study.bandwidth_cost import CarriageCandidate, CarriageController
from cabledrive.studies.study.carriage_case import CarriageModel
from cabledrive.studies.study.controller_stage import ControllerResult
from cabledrive.studies.study.machine import UNITS, WORDS
from cabledrive.studies.study.verdict_stage import NO_BOUND


def laws_table(scores: Sequence[LawScore], unit: str, size: float) -> Table:
    """Every law, simplest first, with its errors and the share of the plants it holds within the goal."""
    rows: tuple[tuple[Cell, ...], ...] = tuple(_row(one, size) for one in scores)
    return table(
        "Laws tried, simplest first.",
        f"Law | Setting | Runs [] | 99 % [{unit}] | Worst [{unit}] | In goal [] | At least [] | "
        "Ended early []",
        rows,
        note="; ".join(f"{one.controller}: {one.reason}" for one in scores if one.reason),
    )


def _row(one: LawScore, size: float) -> tuple[Cell, ...]:
    def shown(error: float | None) -> str:
        return "" if error is None else number(error / size, 3)

    def inside(share: float | None) -> str:
        return "" if share is None else percent(share)

    reached = one.reached.error if one.reached else None
    errors = (shown(reached), shown(one.worst))
    return (
        one.controller,
        one.setting,
        f"{one.runs}",
        *errors,
        inside(one.share),
        inside(one.share_low),
        f"{one.failed}",
    )


def shares_table(caption: str, shares: Mapping[str, float], unit: str, size: float) -> Table:
    """Shares of each quantity, largest first, in a unit of a size in SI."""
    ordered = sorted(shares.items(), key=lambda item: -item[1])
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (named(name), number(share / size, 3)) for name, share in ordered
    )
    return table(caption, f"Quantity | Share [{unit}]", rows)


def worst_plant_table(
    values: Mapping[str, float], best: Mapping[str, float], phases: Sequence[float]
) -> Table:
    """The plant of the worst run beside the best values, in SI; ``phases``: of the encoders, in counts."""
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (
            named(name),
            number(value, 5),
            number(best[name], 5) if name in best else "",
            unit_shown(UNITS[name]),
        )
        for name, value in values.items()
    )
    return table(
        "The plant of the worst run.",
        "Quantity | Its value [] | Best value [] | Unit",
        rows,
        note=f"Encoder phases in counts: {', '.join(f'{phase:+.2f}' for phase in phases)}.",
    )


def named(name: str) -> str:
    """A quantity at the head of a row."""
    return WORDS[name][:1].upper() + WORDS[name][1:]


def unit_shown(unit: str) -> str:
    """A unit in its column; nothing for a plain number."""
    return "" if unit == "1" else unit.replace("^2", "²")


say = texts("study_acceptance")


def acceptance_chapter(result: StudyResult) -> Chapter | None:
    """Results of the runs, if there is a controller."""
    if result.laws is None or result.carried:
        return None
    runs = [one for one in (result.runs, result.cable) if one.draws]
    blocks: list[Block] = [Paragraph(text=say("intro", chosen=result.laws.chosen))]
    for one in (result.runs, result.cable):
        if not one.draws:
            blocks.append(Note(text=say("not_run", one=one), tone="warning"))
    blocks.append(laws_table(result.scores, "deg", DEGREE))
    if runs:
        blocks.append(_table(runs))
    if any(one.peaks for one in runs):
        blocks.append(_peaks(result, [one for one in runs if one.peaks]))
    if result.runs.worst is not None:
        worst = result.runs.worst
        blocks.append(_worst(result, worst))
        blocks.append(worst_plant_table(worst.values, result.knowledge.values, worst.phases))
    return Chapter(
        title="Acceptance",
        anchor="acceptance",
        blocks=tuple(blocks),
        methods=(say("method", seed=result.goals.seed),),
    )


def _table(runs: list[AcceptanceResult]) -> Table:
    def degrees(value: float | None) -> str:
        return "" if value is None else number(value / DEGREE, 3)

    def shares(one: AcceptanceResult) -> str:
        found = (one.inside, one.reached)
        return ", ".join(f"{100 * share:.1f} %" for share in found if share is not None)

    names = {"bound": runs[0].inside, "goal": runs[0].reached}
    asked = ", ".join(name for name, share in names.items() if share is not None)
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (
            one.plant.capitalize(),
            f"{one.draws}",
            degrees(one.quantile(0.5)),
            degrees(one.quantile(0.99)),
            degrees(one.quantile(1.0)),
            shares(one),
            "" if one.largest_torque is None else number(one.largest_torque, 3),
            f"{one.failed}",
        )
        for one in runs
    )
    return table(
        say("table"),
        f"Plants | Runs [] | Median [] | 99 % [] | Worst [] | {f'In {asked}' if asked else ''} [] | "
        "Torque [N m] | Ended early []",
        rows,
        note=" ".join(say("ended_early", one=one) for one in runs if one.failed),
    )


def _peaks(result: StudyResult, runs: list[AcceptanceResult]) -> Figure:
    control, stated = result.controller, runs[0].inside is not None
    bound = control.bound if stated and isinstance(control, ControllerResult) else None
    picture = peaks_picture("peaks", runs, bound, result.goals.error)
    return Figure(
        name="peaks",
        alt=say("peaks_seen", runs=runs, bound=bound),
        caption=say("peaks"),
        drawing=picture,
    )


def _worst(result: StudyResult, worst: WorstCase) -> Figure:
    picture = worst_picture("worst", worst)
    return Figure(
        name="worst",
        alt=say("worst_seen", worst=worst),
        caption=say("worst", draw=worst.draw),
        drawing=picture,
    )


say_carriage = texts("study_carriage")


def carriage_controller_chapter(result: StudyResult) -> Chapter | None:
    """The scheduled law and its bandwidth; None: the drive has no carriage that the law covers."""
    found, model = result.controller, result.model
    if not isinstance(model, CarriageModel):
        return None
    assert not isinstance(found, ControllerResult)
    blocks: list[Block] = [_model(model)]
    if model.reason:
        blocks.append(Note(text=sentences((model.reason,)), tone="warning"))
    elif found is None:
        blocks.append(Note(text=say_carriage("too_far")))
    elif found.bandwidth is None:
        blocks.append(Note(text=sentences((found.reason,)), tone="warning"))
    else:
        blocks += [Paragraph(text=say_carriage("law", found=found)), Note(text=sentences((NO_BOUND,)))]
    if found is not None and found.candidates:
        blocks.append(_candidates(found))
    if found is not None and sum(one.estimate is not None for one in found.candidates) > 1:
        blocks.append(_bandwidths(found))
    if found is not None and found.shares:
        blocks.append(shares_table(say_carriage("shares"), found.shares, "mm", 1e-3))
    return Chapter(
        title="Controller",
        anchor="controller",
        blocks=tuple(blocks),
        methods=(say_carriage("controller_method"),),
    )


def _model(model: CarriageModel) -> Table:
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (number(x, 4), number(lumped, 5), number(exact, 5), f"{100 * abs(lumped / exact - 1.0):.2g}")
        for x, lumped, exact in zip(model.positions, model.lumped, model.exact, strict=True)
    )
    return table(
        say_carriage("model"),
        "Place [m] | Model [Hz] | Exact [Hz] | Apart [%]",
        rows,
        note=say_carriage("left_out", error=model.left_out),
    )


def _candidates(found: CarriageController) -> Table:
    rows: tuple[tuple[Cell, ...], ...] = tuple(_carriage_row(one, found.chosen) for one in found.candidates)
    return table(
        say_carriage("candidates"),
        "Bandwidth | Best values [] | Uncertain [] | Encoders [] | Estimate [] | Torque [N m] | ",
        rows,
        note=say_carriage("refused", candidates=found.candidates),
    )


def _carriage_row(one: CarriageCandidate, chosen: CarriageCandidate | None) -> tuple[Cell, ...]:
    parts = (one.nominal, one.uncertain, one.sensors, one.estimate)
    return (
        f"{one.bandwidth:g} Hz",
        *("" if part is None else number(1e3 * part, 3) for part in parts),
        "" if one.torque is None else number(one.torque, 3),
        "chosen" if one == chosen else "refused" if one.refused else "",
    )


def _bandwidths(found: CarriageController) -> Figure:
    picture = carriage_bandwidths_picture("bandwidths", found)
    return Figure(
        name="bandwidths",
        alt=say_carriage("bandwidths_seen", candidates=found.candidates),
        caption=say_carriage("bandwidths"),
        drawing=picture,
    )


def carriage_acceptance_chapter(result: StudyResult) -> Chapter | None:
    """What the runs said, if there were any."""
    runs = result.runs
    if not result.carried or not runs.draws:
        return None
    blocks: list[Block] = [
        Paragraph(text=say_carriage("acceptance")),
        laws_table(result.scores, "mm", 1e-3),
        _runs(runs),
    ]
    if runs.peaks:
        blocks.append(_carriage_peaks(result, runs))
    if runs.worst is not None:
        blocks += [
            _worst_carriage(runs.worst),
            worst_plant_table(runs.worst.values, result.knowledge.values, runs.worst.phases),
        ]
    return Chapter(
        title="Acceptance",
        anchor="acceptance",
        blocks=tuple(blocks),
        methods=(say_carriage("acceptance_method", draws=runs.draws, seed=result.goals.seed),),
    )


def _runs(runs: AcceptanceResult) -> Table:
    def millimetres(value: float | None) -> str:
        return "" if value is None else number(1e3 * value, 3)

    whole, rest = (
        tuple(millimetres(runs.quantile(share, rest=still)) for share in (0.5, 0.99, 1.0))
        for still in (False, True)
    )
    assert runs.largest_torque is not None
    assert runs.smallest_tension is not None
    reached = "no goal" if runs.reached is None else f"{100 * runs.reached:.1f} %"
    return table(
        say_carriage("runs", draws=runs.draws),
        "When | Median [] | 99 % [] | Worst [] | In goal []",
        (("All the way", *whole, reached), ("At rest", *rest, "")),
        note=say_carriage("runs_note", runs=runs),
    )


def _carriage_peaks(result: StudyResult, runs: AcceptanceResult) -> Figure:
    goal = result.goals.carriage_error
    picture = carriage_peaks_picture("peaks", runs, goal)
    return Figure(
        name="peaks",
        alt=say_carriage("peaks_seen", peaks=runs.peaks, goal=goal),
        caption=say_carriage("peaks"),
        drawing=picture,
    )


def _worst_carriage(worst: WorstCase) -> Figure:
    picture = carriage_worst_picture("worst", worst)
    return Figure(
        name="worst",
        alt=say_carriage("worst_seen", worst=worst),
        caption=say_carriage("worst", draw=worst.draw),
        drawing=picture,
    )
