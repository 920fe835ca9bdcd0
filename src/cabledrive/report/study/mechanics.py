"""Chapters "Modes and models" and "Internal resonance"."""

from cabledrive.report.blocks import Block, Cell, Chapter, Column, Figure, Note, Paragraph, RowGroup, Table
from cabledrive.report.figures.control_runs import responses_picture
from cabledrive.report.numbers import number, quantity
from cabledrive.report.study.loop_in_motion import loop_in_motion
from cabledrive.report.wording import texts
from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study import StudyResult
from cabledrive.studies.study.modes_stage import MODEL_WORDS, ModelResult
from cabledrive.studies.study.resonance_stage import REPEATED

VERDICTS = {"safe": "good", "close": "warning", "resonant": "warning", "unknown": "warning"}
say = texts("study_mechanics")


def modes_chapter(result: StudyResult) -> Chapter:
    """Certified modes, and how far each reduced model holds."""
    found = result.modes
    blocks: list[Block] = [
        Paragraph(text=say("modes", certified=found.certified)),
        _rows(result),
    ]
    remarks = [found.certified_reason or "", *found.warnings]
    blocks += [Note(text=f"{line}.", tone="warning") for line in dict.fromkeys(remarks) if line]
    if found.models:
        blocks += [_models(result), _responses(result)]
        if result.model is not None:
            blocks.append(Note(text=say("chosen_model", reason=result.model.reason)))
    else:
        stated = " ".join((*result.verdict.reasons, *result.verdict.cautions))
        repeated = bool(result.check.missing) and all(line in stated for line in result.check.missing)
        why = "see the verdict" if repeated else found.why_no_models
        blocks.append(Paragraph(text=say("no_models", why=why)))
    return Chapter(
        title="Modes and models",
        anchor="modes",
        blocks=tuple(blocks),
        methods=(say("modes_method"),),
    )


def _rows(result: StudyResult) -> Table:
    groups = []
    for kind in ("longitudinal", "transverse"):
        rows: tuple[tuple[Cell, ...], ...] = tuple(
            (f"{row.frequency:.4f}", f"{row.multiplicity}", row.family)
            for row in result.modes.rows
            if row.kind == kind
        )
        if rows:
            groups.append(RowGroup(title=kind.capitalize(), rows=rows))
    return Table(
        caption="Certified modes of the distributed drive.",
        columns=(
            Column(title="Frequency", unit="Hz", numeric=True),
            Column(title="Modes", numeric=True),
            Column(title="Family"),
        ),
        groups=tuple(groups),
    )


def _models(result: StudyResult) -> Table:
    evidence = result.model.evidence if isinstance(result.model, ModelResult) else ()
    windup = {one.model: one.windup for one in evidence}
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (
            f"{q.model}: {MODEL_WORDS[q.model]}",
            ", ".join(f"{f:.4g}" for f in q.frequencies) or "none",
            ", ".join(f"{f:.4g}" for f in q.exact) or "none",
            number(q.holds_5, 3),
            number(windup[q.model] / DEGREE, 3) if q.model in windup else "",
        )
        for q in result.modes.models
    )
    return Table(
        caption=say("models"),
        columns=(
            Column(title="Model"),
            Column(title="Its modes", unit="Hz", numeric=True),
            Column(title="Exact", unit="Hz", numeric=True),
            Column(title="Right to 5 % up to", unit="Hz", numeric=True),
            Column(title="Neglected", unit="deg", numeric=True),
        ),
        groups=(RowGroup(rows=rows),),
        note=say("models_note"),
    )


def _responses(result: StudyResult) -> Figure:
    numbers = [q.model for q in result.modes.models]
    picture = responses_picture("responses", result.known, numbers)
    return picture.figure(
        name="responses",
        alt=say("responses_seen", models=result.modes.models),
        caption=say("responses"),
    )


def resonance_chapter(result: StudyResult) -> Chapter:
    """Detuning of the drive from the 1:2 resonance, and whether the motion excites it."""
    found = result.resonance
    tone = "warning" if found.refuses or found.alarm == "unknown" else VERDICTS[found.verdict]
    rows: list[tuple[Cell, ...]] = [
        (
            "Frequency ratio: lowest transverse mode of a span over the pulley mode",
            _maybe(found.frequency_ratio, "1"),
        ),
        ("Detuning: ratio - 1/2", _maybe(found.detuning, "1")),
        ("Pulley mode", _maybe(found.pulley_frequency, "Hz")),
        ("Tuned pretension (ratio 1/2)", _maybe(found.tuned_pretension, "N")),
        ("Threshold torque at the tuned pretension", _maybe(found.threshold_torque, "N m")),
        ("Largest torque of the motion", quantity(found.torque, "N m", 4)),
        (
            "Assumed ripple at the pulley mode's frequency, a twentieth of it",
            quantity(found.ripple, "N m", 3),
        ),
        ("Verdict for that ripple", found.verdict),
    ]
    if found.alarm is not None:
        rows.append(("Largest transverse displacement along the motion", _maybe(found.largest, "m")))
        rows.append(("Allowed", quantity(found.limit, "m", 3)))
    lines = tuple(found.reasons)
    return Chapter(
        title="Internal resonance",
        anchor="resonance",
        blocks=(
            Note(text=say("alarm", verdict=found.alarm), tone=tone),
            Table(
                caption=say("resonance"),
                columns=(Column(title="Figure"), Column(title="Value", numeric=True)),
                groups=(RowGroup(rows=tuple(rows)),),
            ),
            *(Paragraph(text=f"{line[:1].upper()}{line[1:]}.") for line in lines),
            loop_in_motion(result),
        ),
        methods=(say("resonance_method", repeated=REPEATED),),
    )


def _maybe(value: float | None, unit: str) -> str:
    return "none" if value is None else quantity(value, unit, 4)
