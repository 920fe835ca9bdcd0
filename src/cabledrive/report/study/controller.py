"""Chapters "Modes and models", "Internal resonance" and "Controller" of a study."""

from markupsafe import Markup

from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.route.two_pulleys import AxisDrive
from cabledrive.reduction.quality import with_measured_stiffness
from cabledrive.report.animation import animation_svg
from cabledrive.report.blocks import (
    Block,
    Cell,
    Chapter,
    Equation,
    Figure,
    Note,
    Paragraph,
    RowGroup,
    Table,
    table,
)
from cabledrive.report.figures.study_runs import bandwidths_picture, responses_picture
from cabledrive.report.study.acceptance import shares_table
from cabledrive.report.study.verdict import listed
from cabledrive.report.typesetting import number, quantity
from cabledrive.report.words import sentences, texts
from cabledrive.rig.setting import DEGREE
from cabledrive.simulation import Recording, Scheme, simulate
from cabledrive.simulation.run import whole
from cabledrive.simulation.signals import Sampled
from cabledrive.studies.study import StudyResult
from cabledrive.studies.study.controller_stage import ControllerResult
from cabledrive.studies.study.modes_stage import MODEL_WORDS, REPEATED, ModelResult, motion_torque

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
        formula = Equation(formula=Markup(say("formula")), words=say("equation"))
        blocks += [Paragraph(text=say("law", found=found)), formula, _bounds(found)]
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


def _bounds(found: ControllerResult) -> Table:
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (name, number(low, 4), number(high, 4), unit)
        for name, low, high, unit in zip(ESTIMATES, found.lower, found.upper, UNITS, strict=True)
    )
    return table(say("bounds"), "Estimate | Low [] | High [] | Unit", rows)


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
    return table(
        say("candidates"),
        "Law | Theorem [] | Unmatched [] | Encoders [] | Bound [] | Torque [N m] | Outcome",
        rows,
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
    return Figure(
        name="bandwidths",
        alt=say("bandwidths_seen", candidates=found.candidates),
        caption=say("bandwidths"),
        drawing=picture,
    )


say_motion = texts("study_loop")
SEGMENTS, FRAMES, RATE = 12, 60, 2000.0
MOST_STEPS = 2e6


def loop_in_motion(result: StudyResult) -> Block:
    """The nonlinear loop under the torque of the motion, without feedback; or the reason why not."""
    if isinstance(result.known, AxisDrive):
        return Paragraph(text=say_motion("axis", load=result.known.load))
    machine, motion = with_measured_stiffness(result.known), result.goals.motion
    duration = motion.trajectory.duration
    waves = (machine.cable.axial_rigidity / machine.cable.mass_per_length) ** 0.5 / machine.span_length
    if duration * waves * SEGMENTS > MOST_STEPS:
        return Paragraph(text=say_motion("too_stiff"))
    time, torque = motion_torque(machine, motion)
    try:
        run = whole(
            simulate(
                machine,
                duration,
                torque=Sampled(values=torque, rate=(len(time) - 1) / duration),
                scheme=Scheme(slack="tension-only", segments=SEGMENTS),
                recording=Recording(rate=RATE, fields=max(1, round(RATE * duration / FRAMES))),
            )
        )
        switch, drawing = animation_svg("loop-in-motion", machine, run)
    except (InputRefused, NotComputed) as failure:
        return Paragraph(text=say_motion("refused", failure=failure))
    return Figure(
        name="loop-in-motion",
        alt=say_motion("seen"),
        caption=say_motion("caption"),
        switch=switch,
        drawing=drawing,
    )


VERDICTS = {"safe": "good", "close": "warning", "resonant": "warning", "unknown": "warning"}
say_mechanics = texts("study_mechanics")


def modes_chapter(result: StudyResult) -> Chapter:
    """Certified modes, and how far each reduced model holds."""
    found = result.modes
    blocks: list[Block] = [
        Paragraph(text=say_mechanics("modes", certified=found.certified)),
        _rows(result),
    ]
    remarks = [found.certified_reason or "", *found.warnings]
    blocks += [Note(text=f"{line}.", tone="warning") for line in dict.fromkeys(remarks) if line]
    if found.models:
        blocks += [_models(result), _responses(result)]
        if result.model is not None:
            blocks.append(Note(text=say_mechanics("chosen_model", reason=result.model.reason)))
    else:
        stated = " ".join((*result.verdict.reasons, *result.verdict.cautions))
        repeated = bool(result.check.missing) and all(line in stated for line in result.check.missing)
        why = "see the verdict" if repeated else found.why_no_models
        blocks.append(Paragraph(text=say_mechanics("no_models", why=why)))
    return Chapter(
        title="Modes and models",
        anchor="modes",
        blocks=tuple(blocks),
        methods=(say_mechanics("modes_method"),),
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
    return table("Certified modes of the distributed drive.", "Frequency [Hz] | Modes [] | Family", groups)


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
    return table(
        say_mechanics("models"),
        "Model | Its modes [Hz] | Exact [Hz] | Right to 5 % up to [Hz] | Neglected [deg]",
        rows,
        note=say_mechanics("models_note"),
    )


def _responses(result: StudyResult) -> Figure:
    numbers = [q.model for q in result.modes.models]
    picture = responses_picture("responses", result.known, numbers)
    return Figure(
        name="responses",
        alt=say_mechanics("responses_seen", models=result.modes.models),
        caption=say_mechanics("responses"),
        drawing=picture,
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
            Note(text=say_mechanics("alarm", verdict=found.alarm), tone=tone),
            table(say_mechanics("resonance"), "Figure | Value []", rows),
            *(Paragraph(text=f"{line[:1].upper()}{line[1:]}.") for line in lines),
            loop_in_motion(result),
        ),
        methods=(say_mechanics("resonance_method", repeated=REPEATED),),
    )


def _maybe(value: float | None, unit: str) -> str:
    return "none" if value is None else quantity(value, unit, 4)
