"""Chapter "Reduced models": Models 1 to 4 beside the distributed cable."""

from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.models import lumped_model
from cabledrive.reduction.quality import ModelQuality, model_quality
from cabledrive.report.blocks import (
    Block,
    Cell,
    Chapter,
    Column,
    Figure,
    Note,
    Paragraph,
    RowGroup,
    Section,
    Table,
)
from cabledrive.report.context import ReportContext
from cabledrive.report.figures.control_runs import models_with_cable, motor_speed_picture, responses_picture
from cabledrive.report.numbers import number

PLACE = 600
WORDS = {
    1: "rigid joint, rigid cable",
    2: "flexible joint, rigid cable",
    3: "rigid joint, flexible cable",
    4: "flexible joint, flexible cable",
}


def chapter(context: ReportContext) -> Chapter | None:
    """The reduced models of every machine that has them."""
    parts = [
        (drive, name)
        for drive, name in zip(context.drives, context.anchors, strict=True)
        if drive.motor is not None and has_models(drive)
    ]
    if not parts:
        return None
    return Chapter(
        title="Reduced models",
        summary="What models of one to four inertias keep of the distributed cable, and what they neglect.",
        anchor="reduced-models",
        blocks=(
            Paragraph(
                text="A control law needs a model of low order. Models 1 to 4 are lumped chains of one to "
                "three inertias: the motor joint and the cable are each rigid or a spring with a "
                "damper. The springs neglect the mass of the cable; a rigid part neglects a whole mode."
            ),
        ),
        sections=tuple(
            Section(title=drive.name, anchor=f"models-{name}", blocks=_about(drive, name))
            for drive, name in parts
        ),
        methods=(
            "Reduced models: exact response of the distributed cable, pulleys and joint, damping included.",
        ),
    )


def has_models(drive: Drive) -> bool:
    """Whether Models 1 to 4 can be made of a drive."""
    try:
        lumped_model(drive)
    except InputRefused:
        return False
    return True


def _about(drive: Drive, name: str) -> tuple[Block, ...]:
    quality = model_quality(drive)
    printed = drive.name == "Dissertation, configuration 3"
    blocks: list[Block] = [_table(quality), _figure(drive, name, quality), _motor_speed(drive, name, printed)]
    if printed:
        blocks.append(
            Note(
                text="The text to Fig. 6.3 reads 7 Hz and 120 Hz off the measured response. Its own Table "
                "6.2 gives 8.27 Hz and 92.2 Hz, with anti-resonances at 5.36 Hz and 73.7 Hz; 7 and "
                "120 Hz would need k = 606 N/m and k_m = 229 N m/rad."
            )
        )
    return tuple(blocks)


def _table(quality: tuple[ModelQuality, ...]) -> Table:
    rows: list[tuple[Cell, ...]] = [
        (
            f"Model {one.model}, {WORDS[one.model]}",
            ", ".join(number(f, 5) for f in one.frequencies) or "none",
            ", ".join(number(f, 5) for f in one.exact) or "none",
            number(one.holds_1, 3),
            number(one.holds_5, 3),
        )
        for one in quality
    ]
    return Table(
        caption="Natural frequencies compared with the distributed cable, and frequency up to which the "
        "response from motor torque to load angle is accurate to 1 % and to 5 %.",
        columns=(
            Column(title="Model"),
            Column(title="Frequencies", unit="Hz"),
            Column(title="Exact", unit="Hz"),
            Column(title="1 %", unit="Hz", numeric=True),
            Column(title="5 %", unit="Hz", numeric=True),
        ),
        groups=(RowGroup(rows=tuple(rows)),),
    )


def _figure(drive: Drive, name: str, quality: tuple[ModelQuality, ...]) -> Figure:
    picture = responses_picture(f"responses-{name}", drive, [one.model for one in quality])
    return Figure(
        name=f"responses-{name}",
        alt=f"Magnitude of the response from motor torque to load angle over frequency for {len(quality)} "
        "models and the distributed cable; each model agrees with it up to the first neglected mode.",
        caption="Load angle per motor torque. Grey: distributed cable; numbered lines: the models.",
        wide=picture.wide,
        narrow=picture.narrow,
    )


def _motor_speed(drive: Drive, name: str, printed: bool) -> Figure:
    picture = motor_speed_picture(f"motor-speed-{name}", drive, (7.0, 120.0) if printed else ())
    like = ", as the theory in Fig. 6.3" if printed else ""
    dotted = " Dotted: the two frequencies that its text reads off it, beside both peaks." if printed else ""
    models = "Models 3 and 4" if len(models_with_cable(drive)) == 2 else "Model 3"
    return Figure(
        name=f"motor-speed-{name}",
        alt="Magnitude of the response from motor torque to motor speed: a dip and a peak of the cable, and "
        "with a flexible joint a second pair; the distributed cable coincides with the model with both "
        "springs.",
        caption=f"Motor speed per motor torque{like}: {models}, the distributed cable in grey.{dotted}",
        wide=picture.wide,
        narrow=picture.narrow,
    )
