"""Chapter "Controller": the law, its bandwidth, its projection bounds, and the bound that is stated."""

from cabledrive.report.blocks import (
    Block,
    Cell,
    Chapter,
    Column,
    Equation,
    Figure,
    Note,
    Paragraph,
    RowGroup,
    Table,
)
from cabledrive.report.figures.study_runs import bandwidths_picture
from cabledrive.report.formula import fraction, row, sub, total
from cabledrive.report.numbers import number
from cabledrive.report.study.quantity_tables import shares_table
from cabledrive.report.study.verdict import listed
from cabledrive.report.wording import sentences, texts
from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study import StudyResult
from cabledrive.studies.study.controller_stage import ControllerResult

ESTIMATES = ("Inertia at the motor", "Viscous friction", "Coulomb friction", "Offset torque")
say = texts("study_controller")
UNITS = ("kg m²", "N m s/rad", "N m", "N m")


def controller_chapter(result: StudyResult) -> Chapter | None:
    """The controller, if one was designed."""
    found = result.controller
    if not isinstance(found, ControllerResult):
        return None
    blocks: list[Block] = []
    if found.bandwidth is None:
        blocks.append(Note(text=sentences((found.reason,)), tone="warning"))
    else:
        blocks += [Paragraph(text=say("law", found=found)), _equation(), _bounds(found)]
    if found.candidates:
        blocks.append(_candidates(found))
    if sum(one.bound is not None for one in found.candidates if one.model == found.model) > 1:
        blocks.append(_picture(found))
    if found.shares:
        blocks.append(shares_table(say("shares"), found.shares, "deg", DEGREE))
    if found.broken:
        blocks.append(Note(text=listed(say("broken"), found.broken)))
    return Chapter(
        title="Controller",
        anchor="controller",
        blocks=tuple(blocks),
        methods=(say("method"),),
    )


def _equation() -> Equation:
    tube = row(sub("h", "θ"), "(", "t", ")")
    moved = total("i", "|", "Δ", sub("e", "i"), "(", "t", ")", "|")
    norm = row("‖", sub("g", "j"), "‖", "+", "max", "|", sub("s", "j"), "|")
    counts = total("j", fraction(sub("q", "j"), "2"), "(", norm, ")")
    return Equation(
        formula=row(sub("e", "max"), "≤", sub("max", "t"), "(", tube, "+", moved, ")", "+", counts),
        words=say("equation"),
    )


def _bounds(found: ControllerResult) -> Table:
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (name, number(low, 4), number(high, 4), unit)
        for name, low, high, unit in zip(ESTIMATES, found.lower, found.upper, UNITS, strict=True)
    )
    return Table(
        caption=say("bounds"),
        columns=(
            Column(title="Estimate"),
            Column(title="Low", numeric=True),
            Column(title="High", numeric=True),
            Column(title="Unit"),
        ),
        groups=(RowGroup(rows=rows),),
    )


def _candidates(found: ControllerResult) -> Table:
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (
            f"Model {one.model}, {one.bandwidth:g} Hz",
            *("" if v is None else number(v / DEGREE, 3) for v in (one.theorem, one.unmatched, one.sensors)),
            "" if one.bound is None else number(one.bound / DEGREE, 3),
            "" if one.torque is None else number(one.torque, 3),
            "chosen" if one == found.chosen else "refused" if one.refused else "",
        )
        for one in found.candidates
    )
    return Table(
        caption=say("candidates"),
        columns=(
            Column(title="Law"),
            Column(title="Theorem", numeric=True),
            Column(title="Unmatched", numeric=True),
            Column(title="Encoders", numeric=True),
            Column(title="Bound", numeric=True),
            Column(title="Torque", unit="N m", numeric=True),
            Column(title="Outcome"),
        ),
        groups=(RowGroup(rows=rows),),
        note=say("refused", reasons=_refusals(found)),
    )


def _refusals(found: ControllerResult) -> dict[str, str]:
    """Bandwidths by why they were refused."""
    reasons: dict[str, str] = {}
    for one in found.candidates:
        if one.refused:
            before, now = reasons.get(one.refused), f"Model {one.model} at {one.bandwidth:g}"
            reasons[one.refused] = f"{before}, {now}" if before else now
    return reasons


def _picture(found: ControllerResult) -> Figure:
    picture = bandwidths_picture("bandwidths", found)
    return picture.figure(
        name="bandwidths",
        alt=say("bandwidths_seen", candidates=found.candidates),
        caption=say("bandwidths"),
    )
