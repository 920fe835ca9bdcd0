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
from cabledrive.report.study.verdict import sentences
from cabledrive.studies.study import StudyResult
from cabledrive.studies.study.acceptance_stage import AcceptanceResult, WorstCase
from cabledrive.studies.study.carriage_controller import CarriageCandidate, CarriageController
from cabledrive.studies.study.carriage_demand import CarriageModel
from cabledrive.studies.study.carriage_verdict import NO_BOUND
from cabledrive.studies.study.controller_stage import ControllerResult


def carriage_controller_chapter(result: StudyResult) -> Chapter | None:
    """The scheduled law and its bandwidth, after the model that it is made for.

    Returns none: the drive has no carriage that the law covers.
    """
    found, model = result.controller, result.model
    if not isinstance(model, CarriageModel):
        return None
    assert not isinstance(found, ControllerResult)
    blocks: list[Block] = [_model(model)]
    if model.reason:
        blocks.append(Note(text=sentences((model.reason,)), tone="warning"))
    elif found is None:
        blocks.append(Note(text="No law was designed: the motion exceeds the limits of the drive."))
    elif found.bandwidth is None:
        blocks.append(Note(text=sentences((found.reason,)), tone="warning"))
    else:
        blocks += [_words(found), Note(text=sentences((NO_BOUND,)))]
    if found is not None and found.candidates:
        blocks.append(_candidates(found))
    if found is not None and sum(one.estimate is not None for one in found.candidates) > 1:
        blocks.append(_bandwidths(found))
    if found is not None and found.shares:
        blocks.append(_shares(found))
    return Chapter(
        title="Controller",
        anchor="controller",
        blocks=tuple(blocks),
        methods=(
            "Controller: linear-quadratic feedback and Kalman filter at twelve places of the carriage; "
            "the feedforward is the flat output's. Estimated error: the run at the best values, plus the "
            "root sum of squares of the effects of each parameter at the worse of its bounds, plus encoder "
            "quantisation, plus the neglected dynamics. Stable: no pole of law, observer and plant "
            "grows at nine places, the cable at its best value and both bounds.",
        ),
    )


def _model(model: CarriageModel) -> Table:
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (number(x, 4), number(lumped, 5), number(exact, 5), f"{100 * abs(lumped / exact - 1.0):.2g}")
        for x, lumped, exact in zip(model.positions, model.lumped, model.exact, strict=True)
    )
    return Table(
        caption="The model of the carriage beside the distributed cable: frequency of the carriage on it, "
        "along the way.",
        columns=(
            Column(title="Place", unit="m", numeric=True),
            Column(title="Model", unit="Hz", numeric=True),
            Column(title="Exact", unit="Hz", numeric=True),
            Column(title="Apart", unit="%", numeric=True),
        ),
        groups=(RowGroup(rows=rows),),
        note=""
        if model.left_out == 0.0
        else f"The motor joint is taken as rigid; {1e3 * model.left_out:.3g} mm for its windup and "
        "backlash are added to every error.",
    )


def _words(found: CarriageController) -> Paragraph:
    heard = "of both pulleys" if found.both else "at the motor side only"
    return Paragraph(
        text=f"The law is scheduled over the position of the carriage, its bandwidth {found.bandwidth:g} Hz, "
        f"states by a Kalman filter from the encoders {heard}. {sentences((found.reason,))} The tables stand "
        "as numbers in controller.json beside this page."
    )


def _candidates(found: CarriageController) -> Table:
    rows: tuple[tuple[Cell, ...], ...] = tuple(_row(one, found.chosen) for one in found.candidates)
    refused = [f"{one.bandwidth:g} Hz refused: {one.refused}" for one in found.candidates if one.refused]
    return Table(
        caption="Bandwidths tried, and the parts of the estimated error in millimetres.",
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
        note="; ".join(refused),
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
    words = ", ".join(
        f"{one.bandwidth:g} Hz {1e3 * one.estimate:.3g} mm"
        for one in found.candidates
        if one.estimate is not None
    )
    return Figure(
        name="bandwidths",
        alt=f"The estimated error and its parts over the bandwidth. Estimate: {words}.",
        caption="The estimated error over the bandwidth, and its parts. A ring marks the choice.",
        wide=picture.wide,
        narrow=picture.narrow,
    )


def _shares(found: CarriageController) -> Table:
    caption = "Effect of each parameter on the error within its bounds, at the chosen bandwidth."
    return shares_table(caption, found.shares, "mm", 1e-3)


def carriage_acceptance_chapter(result: StudyResult) -> Chapter | None:
    """What the runs said, if there were any."""
    runs = result.runs
    if not result.carried or not runs.draws:
        return None
    blocks: list[Block] = [
        Paragraph(
            text="The sampled law is tested on plants sampled from the parameters above: strands that "
            "lengthen as the carriage travels, encoders at random phases, a motor with stick-slip "
            "friction, the torque limit. A run ends when a strand goes slack."
        ),
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
        methods=(
            f"Acceptance: {runs.draws} runs of the transporter's plant, every parameter sampled uniformly "
            f"within its bounds, each sample with its own random generator from seed {result.goals.seed}.",
        ),
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
        caption=f"Largest error in each of {runs.draws} runs, in millimetres.",
        columns=(
            Column(title="When"),
            Column(title="Median", numeric=True),
            Column(title="99 %", numeric=True),
            Column(title="Worst", numeric=True),
            Column(title="In goal", numeric=True),
        ),
        groups=(RowGroup(rows=(("All the way", *whole, reached), ("At rest", *rest, ""))),),
        note=f"Largest torque {number(runs.largest_torque, 3)} N m, at its limit in {runs.saturated} runs; "
        f"smallest tension of a strand {number(runs.smallest_tension, 3)} N; {runs.failed} runs ended early.",
    )


def _peaks(result: StudyResult, runs: AcceptanceResult) -> Figure:
    goal = result.goals.carriage_error
    picture = carriage_peaks_picture("peaks", runs, goal)
    stated = "" if goal is None else f" The goal is {1e3 * goal:.3g} mm."
    return Figure(
        name="peaks",
        alt=f"Share of the runs below an error: half below {1e3 * runs.peaks[len(runs.peaks) // 2]:.3g} mm, "
        f"all complete runs below {1e3 * runs.peaks[-1]:.3g} mm.{stated}",
        caption="Share of the runs whose largest error stays below the value on the axis, all the way and at "
        "rest; the goal, where there is one, is an vertical line.",
        wide=picture.wide,
        narrow=picture.narrow,
    )


def _worst(worst: WorstCase) -> Figure:
    picture = carriage_worst_picture("worst", worst)
    return Figure(
        name="worst",
        alt="Position, error and torque over time in the worst run; the largest error is "
        f"{1e3 * max(abs(e) for e in worst.error):.3g} mm.",
        caption=f"The worst run, sample {worst.draw}: position, error, torque.",
        wide=picture.wide,
        narrow=picture.narrow,
    )
