"""Chapters "Controller" and "Acceptance" of a study with a carriage."""

from cabledrive.report.blocks import Block, Cell, Chapter, Column, Figure, Note, Paragraph, RowGroup, Table
from cabledrive.report.figures.carriage_runs import (
    carriage_bandwidths_picture,
    carriage_peaks_picture,
    carriage_worst_picture,
)
from cabledrive.report.numbers import number
from cabledrive.report.study.laws_table import laws_table
from cabledrive.report.study.quantity_tables import shares_table, worst_plant_table
from cabledrive.report.wording import sentences, texts
from cabledrive.studies.study import StudyResult
from cabledrive.studies.study.acceptance_stage import AcceptanceResult, WorstCase
from cabledrive.studies.study.carriage_controller import CarriageCandidate, CarriageController
from cabledrive.studies.study.carriage_demand import CarriageModel
from cabledrive.studies.study.carriage_verdict import NO_BOUND
from cabledrive.studies.study.controller_stage import ControllerResult

say = texts("study_carriage")


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
        blocks.append(Note(text=say("too_far")))
    elif found.bandwidth is None:
        blocks.append(Note(text=sentences((found.reason,)), tone="warning"))
    else:
        blocks += [Paragraph(text=say("law", found=found)), Note(text=sentences((NO_BOUND,)))]
    if found is not None and found.candidates:
        blocks.append(_candidates(found))
    if found is not None and sum(one.estimate is not None for one in found.candidates) > 1:
        blocks.append(_bandwidths(found))
    if found is not None and found.shares:
        blocks.append(shares_table(say("shares"), found.shares, "mm", 1e-3))
    return Chapter(
        title="Controller",
        anchor="controller",
        blocks=tuple(blocks),
        methods=(say("controller_method"),),
    )


def _model(model: CarriageModel) -> Table:
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (number(x, 4), number(lumped, 5), number(exact, 5), f"{100 * abs(lumped / exact - 1.0):.2g}")
        for x, lumped, exact in zip(model.positions, model.lumped, model.exact, strict=True)
    )
    return Table(
        caption=say("model"),
        columns=(
            Column(title="Place", unit="m", numeric=True),
            Column(title="Model", unit="Hz", numeric=True),
            Column(title="Exact", unit="Hz", numeric=True),
            Column(title="Apart", unit="%", numeric=True),
        ),
        groups=(RowGroup(rows=rows),),
        note=say("left_out", error=model.left_out),
    )


def _candidates(found: CarriageController) -> Table:
    rows: tuple[tuple[Cell, ...], ...] = tuple(_row(one, found.chosen) for one in found.candidates)
    return Table(
        caption=say("candidates"),
        columns=(
            Column(title="Bandwidth"),
            Column(title="Best values", numeric=True),
            Column(title="Uncertain", numeric=True),
            Column(title="Encoders", numeric=True),
            Column(title="Estimate", numeric=True),
            Column(title="Torque", unit="N m", numeric=True),
            Column(title=""),
        ),
        groups=(RowGroup(rows=rows),),
        note=say("refused", candidates=found.candidates),
    )


def _row(one: CarriageCandidate, chosen: CarriageCandidate | None) -> tuple[Cell, ...]:
    parts = (one.nominal, one.uncertain, one.sensors, one.estimate)
    return (
        f"{one.bandwidth:g} Hz",
        *("" if part is None else number(1e3 * part, 3) for part in parts),
        "" if one.torque is None else number(one.torque, 3),
        "chosen" if one == chosen else "refused" if one.refused else "",
    )


def _bandwidths(found: CarriageController) -> Figure:
    picture = carriage_bandwidths_picture("bandwidths", found)
    return picture.figure(
        name="bandwidths",
        alt=say("bandwidths_seen", candidates=found.candidates),
        caption=say("bandwidths"),
    )


def carriage_acceptance_chapter(result: StudyResult) -> Chapter | None:
    """What the runs said, if there were any."""
    runs = result.runs
    if not result.carried or not runs.draws:
        return None
    blocks: list[Block] = [
        Paragraph(text=say("acceptance")),
        laws_table(result.scores, "mm", 1e-3),
        _runs(runs),
    ]
    if runs.peaks:
        blocks.append(_peaks(result, runs))
    if runs.worst is not None:
        blocks += [
            _worst(runs.worst),
            worst_plant_table(runs.worst.values, result.knowledge.values, runs.worst.phases),
        ]
    return Chapter(
        title="Acceptance",
        anchor="acceptance",
        blocks=tuple(blocks),
        methods=(say("acceptance_method", draws=runs.draws, seed=result.goals.seed),),
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
    return Table(
        caption=say("runs", draws=runs.draws),
        columns=(
            Column(title="When"),
            Column(title="Median", numeric=True),
            Column(title="99 %", numeric=True),
            Column(title="Worst", numeric=True),
            Column(title="In goal", numeric=True),
        ),
        groups=(RowGroup(rows=(("All the way", *whole, reached), ("At rest", *rest, ""))),),
        note=say("runs_note", runs=runs),
    )


def _peaks(result: StudyResult, runs: AcceptanceResult) -> Figure:
    goal = result.goals.carriage_error
    picture = carriage_peaks_picture("peaks", runs, goal)
    return picture.figure(
        name="peaks",
        alt=say("peaks_seen", peaks=runs.peaks, goal=goal),
        caption=say("peaks"),
    )


def _worst(worst: WorstCase) -> Figure:
    picture = carriage_worst_picture("worst", worst)
    return picture.figure(
        name="worst",
        alt=say("worst_seen", worst=worst),
        caption=say("worst", draw=worst.draw),
    )
