"""Chapter "Acceptance": many plants, the distribution of their errors, and the worst of them."""

from cabledrive.report.blocks import Block, Cell, Chapter, Column, Figure, Note, Paragraph, RowGroup, Table
from cabledrive.report.figures.study_runs import peaks_picture, worst_picture
from cabledrive.report.numbers import number
from cabledrive.report.study.laws_table import laws_table
from cabledrive.report.study.quantity_tables import worst_plant_table
from cabledrive.report.wording import texts
from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study import StudyResult
from cabledrive.studies.study.acceptance_stage import AcceptanceResult, WorstCase
from cabledrive.studies.study.controller_stage import ControllerResult

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
    return Table(
        caption=say("table"),
        columns=(
            Column(title="Plants"),
            Column(title="Runs", numeric=True),
            Column(title="Median", numeric=True),
            Column(title="99 %", numeric=True),
            Column(title="Worst", numeric=True),
            Column(title=f"In {asked}" if asked else "", numeric=True),
            Column(title="Torque", unit="N m", numeric=True),
            Column(title="Ended early", numeric=True),
        ),
        groups=(RowGroup(rows=rows),),
        note=" ".join(say("ended_early", one=one) for one in runs if one.failed),
    )


def _peaks(result: StudyResult, runs: list[AcceptanceResult]) -> Figure:
    control, stated = result.controller, runs[0].inside is not None
    bound = control.bound if stated and isinstance(control, ControllerResult) else None
    picture = peaks_picture("peaks", runs, bound, result.goals.error)
    return picture.figure(
        name="peaks",
        alt=say("peaks_seen", runs=runs, bound=bound),
        caption=say("peaks"),
    )


def _worst(result: StudyResult, worst: WorstCase) -> Figure:
    picture = worst_picture("worst", worst)
    return picture.figure(
        name="worst",
        alt=say("worst_seen", worst=worst),
        caption=say("worst", draw=worst.draw),
    )
