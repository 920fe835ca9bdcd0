"""Chapter "What moves the frequencies": pretension and inertia, for one machine."""

import numpy as np

from cabledrive.parameters import Drive, NotComputed, content_hash, load_drive
from cabledrive.report.blocks import Block, Chapter, Figure, Note, Paragraph
from cabledrive.report.context import ReportContext
from cabledrive.report.figures.followed import followed_picture
from cabledrive.report.numbers import number, quantity
from cabledrive.studies import frequency_against

PLACE = 300
EXAMPLE = "dissertation-2"
POINTS = 61


def chapter(context: ReportContext) -> Chapter:
    """Frequencies of one machine against its pretension and its load inertia.

    Parameters
    ----------
    context : ReportContext

    Returns
    -------
    Chapter
    """
    drive = _example(context)
    return Chapter(
        title="What moves the frequencies",
        anchor="what-moves-them",
        blocks=(*_pretension(drive), *_inertia(drive)),
        methods=(
            "Frequencies against a quantity: certified modes at every value, followed by the overlap of "
            "their shapes; steps are halved until there is no doubt which is which.",
        ),
    )


def _example(context: ReportContext) -> Drive:
    """The machine that is varied: the rig of the resonance if it is among them, else the first."""
    digest = content_hash(load_drive(EXAMPLE))
    return context.drives[context.hashes.index(digest)] if digest in context.hashes else context.drives[0]


def _pretension(drive: Drive) -> tuple[Block, ...]:
    tension = drive.cable.pretension
    data = frequency_against(drive, "cable.pretension", tension * np.geomspace(0.1, 10.0, POINTS), modes=3)
    picture = followed_picture("against-pretension", data, "pretension", unit="N", here=tension)
    return (
        Paragraph(
            text="Tightening the cable raises the modes across it, as the square root of the pretension, "
            f"and leaves those along it where they are. {drive.name} shows what follows from that: its "
            "lowest mode across passes one frequency ratio after another, and at a ratio of one half the "
            "pulleys' motion feeds it."
        ),
        Figure(
            name="against-pretension",
            alt="Frequencies against pretension: the modes along the cable are level lines, the lowest "
            "across rises.",
            caption=f"{drive.name}: frequencies against pretension, from a tenth to ten times its "
            f"{quantity(tension, 'N')}.",
            wide=picture.wide,
            narrow=picture.narrow,
        ),
    )


def _inertia(drive: Drive) -> tuple[Block, ...]:
    inertia = drive.load_pulley.inertia
    try:
        data = frequency_against(
            drive, "pulley.1.inertia", inertia * np.geomspace(0.01, 100.0, POINTS), modes=4
        )
    except NotComputed as reason:
        return (
            Note(
                text=f"Frequencies against the load inertia could not be followed: {reason}", tone="warning"
            ),
        )
    label = "inertia of the load pulley, relative to this drive's"
    picture = followed_picture("against-inertia", data, label, scale=inertia, here=inertia, across=False)
    return (
        Figure(
            name="against-inertia",
            alt="Frequencies against the inertia of the load pulley.",
            caption=f"{drive.name}: {number(data.sizes['mode'])} modes followed by their shapes while the "
            "load pulley grows from a hundredth to a hundred times its inertia.",
            wide=picture.wide,
            narrow=picture.narrow,
        ),
    )
