"""Chapter "Acceptance": many plants, the distribution of their errors, and the worst of them."""

from cabledrive.report.blocks import Block, Cell, Chapter, Column, Figure, Note, Paragraph, RowGroup, Table
from cabledrive.report.figures.study_runs import peaks_picture, worst_picture
from cabledrive.report.numbers import number
from cabledrive.report.study.laws_table import laws_table
from cabledrive.report.study.quantity_tables import worst_plant_table
from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study import StudyResult
from cabledrive.studies.study.acceptance_stage import AcceptanceResult, WorstCase
from cabledrive.studies.study.controller_stage import ControllerResult

NAMES = {"lumped": "lumped plants", "cable": "plants on the distributed cable"}


def acceptance_chapter(result: StudyResult) -> Chapter | None:
    """Results of the runs, if there is a controller."""
    if result.laws is None or result.carried:
        return None
    runs = [one for one in (result.runs, result.cable) if one.draws]
    blocks: list[Block] = [
        Paragraph(
            text="All laws are tested on the same plants, sampled from the parameters above: encoders at "
            "random phases, stick-slip friction, a torque loop, the torque limit, the delay of the "
            "drive file. A law that misses the goal too often is stopped early. The figures below are "
            "for "
            f"{_chosen(result)}."
        )
    ]
    for one in (result.runs, result.cable):
        if not one.draws:
            words = f"Not run on {NAMES[one.plant]}: {one.reason}."
            blocks.append(Note(text=words, tone="warning"))
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
        methods=(
            f"Acceptance: hybrid simulation, exact between samples; the cable as a nonlinear mesh; each "
            f"sample has its own random generator from seed {result.goals.seed}. Parameters from a log are "
            "sampled from normal distributions of the interval's width, with the correlations of the "
            "regression; the part of an interval beyond the width of the regression is independent. Others "
            "are uniform and independent.",
        ),
    )


def _chosen(result: StudyResult) -> str:
    chosen = result.laws.chosen if result.laws else None
    return "no law" if chosen is None else f"{chosen.controller} ({chosen.words})"


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
        caption="Largest error of the load in each run, in degrees.",
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
        note=" ".join(_early(one) for one in runs if one.failed),
    )


def _early(one: AcceptanceResult) -> str:
    """What runs that ended early mean for a row of the table."""
    if not one.peaks:
        return f"All {one.draws} runs on {NAMES[one.plant]} ended early: there is no error to report."
    return (
        f"{one.failed} of {one.draws} runs on {NAMES[one.plant]} ended early and count as missed; the "
        f"largest error of the others is {number(one.peaks[-1] / DEGREE, 3)} deg. A field is empty where "
        "too many runs ended early for that share of all runs."
    )


def _below(one: AcceptanceResult) -> str:
    """A curve of the figure in words."""
    median = one.quantile(0.5)
    half = "more than half ended early" if median is None else f"half below {median / DEGREE:.3g} deg"
    lasting = "all" if not one.failed else f"the {len(one.peaks)} of {one.draws} complete runs"
    return f"{NAMES[one.plant]}: {half}, {lasting} below {one.peaks[-1] / DEGREE:.3g} deg"


def _peaks(result: StudyResult, runs: list[AcceptanceResult]) -> Figure:
    control, stated = result.controller, runs[0].inside is not None
    bound = control.bound if stated and isinstance(control, ControllerResult) else None
    picture = peaks_picture("peaks", runs, bound, result.goals.error)
    words = "; ".join(_below(one) for one in runs)
    return Figure(
        name="peaks",
        alt=f"Share of the runs below an error. {words}."
        + ("" if bound is None else f" The stated bound is {bound / DEGREE:.3g} deg."),
        caption="Share of all runs that are complete and whose largest error is below the value on the "
        "axis; vertical lines: the stated bound and the goal, if any.",
        wide=picture.wide,
        narrow=picture.narrow,
    )


def _worst(result: StudyResult, worst: WorstCase) -> Figure:
    picture = worst_picture("worst", worst)
    largest = max(abs(e) for e in worst.error) / DEGREE
    return Figure(
        name="worst",
        alt="Reference, error and torque over time in the worst lumped run; the largest error is "
        f"{largest:.3g} deg.",
        caption=f"The worst lumped run, sample {worst.draw}: the motion, the error of the load, the torque.",
        wide=picture.wide,
        narrow=picture.narrow,
    )
