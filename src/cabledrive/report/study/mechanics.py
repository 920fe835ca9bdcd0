"""Chapters "Modes and models" and "Internal resonance" of a study."""

from collections import Counter
from itertools import chain

from cabledrive.answers.figures import figures_of, number, quantity
from cabledrive.mechanics.holding import released
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.reduction.quality import distributed
from cabledrive.report.animation import animation_svg
from cabledrive.report.blocks import Block, Chapter, Figure, Note, Paragraph, RowGroup, Table, pictured, table
from cabledrive.report.figures.study_runs import responses_picture
from cabledrive.report.words import texts
from cabledrive.rig.setting import DEGREE
from cabledrive.simulation import Recording, Scheme, simulate
from cabledrive.simulation.case import case_of
from cabledrive.simulation.run import whole
from cabledrive.simulation.signals import Sampled
from cabledrive.studies.resonance_detuning import ResonanceSummary
from cabledrive.studies.study import StudyResult
from cabledrive.studies.study.modes_stage import MODEL_WORDS, REPEATED, ModelResult, motion_torque

say_motion = texts("study_motion")
SEGMENTS, FRAMES, RATE = 12, 60, 2000.0
MOST_UPDATES = 5e7
"""Steps of an animation times nodes of its ropes."""


def machine_in_motion(result: StudyResult) -> Block:
    """The nonlinear ropes under the torque of the motion, without feedback; or the reason why not."""
    motion, drive = result.goals.motion, result.known
    duration, motors = motion.trajectory.duration, drive.axis.words["motors"]
    time, torque = motion_torque(drive, motion)
    try:
        machine = released(distributed(drive))
        scheme = Scheme(slack="tension-only", segments=SEGMENTS)
        recording = Recording(rate=RATE, fields=max(1, round(RATE * duration / FRAMES)))
        case = case_of(machine, duration, scheme=scheme, recording=recording)
        if case.grid.steps * case.nodes > MOST_UPDATES:
            return Paragraph(text=say_motion("too_stiff"))
        run = whole(
            simulate(
                machine,
                duration,
                torque={
                    name: Sampled(values=sign * torque / len(motors), rate=(len(time) - 1) / duration)
                    for name, sign in motors.items()
                },
                scheme=scheme,
                recording=recording,
            )
        )
        switch, drawing = animation_svg("in-motion", machine, run)
    except (InputRefused, NotComputed) as failure:
        return Paragraph(text=say_motion("refused", failure=failure))
    return Figure(
        name="in-motion",
        alt=say_motion("seen"),
        caption=say_motion("caption"),
        switch=switch,
        drawing=drawing,
    )


SHOWN_FIGURES = ("frequency_ratio", "detuning", "pulley_frequency_hz", "tuned_pretension", "threshold_torque")
VERDICTS = {"safe": "good", "close": "warning", "resonant": "warning", "unknown": "warning"}
say = texts("study_mechanics")


def modes_chapter(result: StudyResult) -> Chapter:
    """Certified modes, and how far each reduced model holds."""
    found = result.modes
    blocks: list[Block] = [Paragraph(text=say("modes", certified=found.certified)), _rows(result)]
    remarks = [found.certified_reason or "", *found.warnings]
    blocks += [Note(text=f"{line}.", tone="warning") for line in dict.fromkeys(remarks) if line]
    if found.models:
        numbers = [q.model for q in found.models]
        picture = responses_picture("responses", result.known, numbers)
        blocks += [_models(result), pictured(say, "responses", picture, models=found.models)]
        if result.model is not None:
            blocks.append(Note(text=say("chosen_model", reason=result.model.reason)))
    else:
        stated = " ".join((*result.verdict.reasons, *result.verdict.cautions))
        repeated = bool(result.check.missing) and all(line in stated for line in result.check.missing)
        why = "see the verdict" if repeated else found.why_no_models
        blocks.append(Paragraph(text=say("no_models", why=why)))
    return Chapter("Modes and models", "modes", tuple(blocks), methods=(say("modes_method"),))


def _rows(result: StudyResult) -> Table:
    found = Counter[tuple[str, str, str]]()
    for row in result.modes.rows:
        found[row.kind, f"{row.frequency:.4f}", row.family] += row.multiplicity
    groups = []
    for kind in sorted({kind for kind, *_ in found}):
        rows = ((hertz, str(many), family) for (own, hertz, family), many in found.items() if own == kind)
        groups.append(RowGroup(title=kind.capitalize(), rows=tuple(rows)))
    return table("Certified modes of the distributed drive.", "Frequency [Hz] | Modes [] | Family", groups)


def _models(result: StudyResult) -> Table:
    evidence = result.model.evidence if isinstance(result.model, ModelResult) else ()
    windup = {one.model: one.windup for one in evidence}
    rows = (
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
        say("models"),
        "Model | Its modes [Hz] | Exact [Hz] | Right to 5 % up to [Hz] | Neglected [deg]",
        rows,
        note=say("models_note"),
    )


def resonance_chapter(result: StudyResult) -> Chapter:
    """Detuning of the drive from the 1:2 resonance, and whether the motion excites it."""
    found = result.resonance
    tone = "warning" if found.refuses or found.alarm == "unknown" else VERDICTS[found.verdict]
    figures = [row for row in chain(*figures_of(ResonanceSummary).values()) if row.key in SHOWN_FIGURES]
    values = ((row, getattr(found, row.key.removesuffix("_hz"))) for row in figures)
    rows = [(row.words, row.text(value) or "none") for row, value in values]
    rows.append(("Largest torque of the motion", quantity(found.torque, "N m", 4)))
    ripple = "Assumed ripple at the pulley mode's frequency, a twentieth of it"
    rows.append((ripple, quantity(found.ripple, "N m", 3)))
    rows.append(("Verdict for that ripple", found.verdict))
    if found.alarm is not None:
        largest = "none" if found.largest is None else quantity(found.largest, "m", 4)
        rows.append(("Largest transverse displacement along the motion", largest))
        rows.append(("Allowed", quantity(found.limit, "m", 3)))
    blocks = (
        Note(text=say("alarm", verdict=found.alarm), tone=tone),
        table(say("resonance"), "Figure | Value []", rows),
        *(Paragraph(text=f"{line[:1].upper()}{line[1:]}.") for line in found.reasons),
        machine_in_motion(result),
    )
    method = say("resonance_method", repeated=REPEATED)
    return Chapter("Internal resonance", "resonance", blocks, methods=(method,))
