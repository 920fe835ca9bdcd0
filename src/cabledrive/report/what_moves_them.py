"""Effect of parameters on the frequencies: pretension, inertia, the place of a carriage."""

from collections.abc import Iterator

import numpy as np

from cabledrive.parameters import Drive, NotComputed, content_hash, load_drive
from cabledrive.report.blocks import Block, Chapter, Note, Paragraph
from cabledrive.report.context import ReportContext
from cabledrive.report.figures.followed import followed_picture
from cabledrive.report.numbers import number, quantity
from cabledrive.studies import frequency_against

VARIED, TRAVELLED = "dissertation-2", "linear-axis"
POINTS, FEWEST = 61, 13
MOST_CARRIAGES = 500


def effect_of_parameters(context: ReportContext) -> Chapter | None:
    """Frequencies of a machine against pretension and load inertia, of another against carriage place."""
    if not context.drives:
        return None
    drive = _packaged(context, VARIED) or context.drives[0]
    travelled = _packaged(context, TRAVELLED)
    blocks = [*_of_one(drive), *(_travel(travelled) if travelled else ())]
    return Chapter(
        title="Effect of parameters on the frequencies",
        summary="How pretension, carriage position and inertia shift the natural frequencies.",
        anchor="what-moves-them",
        blocks=tuple(blocks),
        methods=(
            "Frequencies against a quantity: certified modes at each value, tracked by the overlap of "
            "their shapes; steps are halved until the assignment is unique.",
        ),
    )


def _packaged(context: ReportContext, name: str) -> Drive | None:
    """A packaged drive, if it is among those of the report."""
    digest = content_hash(load_drive(name))
    return context.drives[context.hashes.index(digest)] if digest in context.hashes else None


def _of_one(drive: Drive) -> Iterator[Block]:
    """Pretension and load inertia; what cannot be followed is said and left out."""
    if len(drive.carriage) > MOST_CARRIAGES:
        yield Note(
            text=f"{drive.name} has more than {MOST_CARRIAGES} carriages: tracking its modes would take "
            "minutes and is omitted here; use cabledrive.studies.frequency_against."
        )
        return
    try:
        yield from _pretension(drive)
        if not drive.load_pulley.fixed:
            yield from _inertia(drive)
    except NotComputed as reason:
        yield Note(text=f"The modes of {drive.name} could not be followed further: {reason}.", tone="warning")


def _points(drive: Drive) -> int:
    """Fewer values where every one of them takes longer."""
    return max(FEWEST, POINTS * 50 // max(50, len(drive.carriage)))


def _pretension(drive: Drive) -> Iterator[Block]:
    tension = drive.cable.pretension
    values = tension * np.geomspace(0.1, 10.0, _points(drive))
    data = frequency_against(drive, "cable.pretension", values, modes=3)
    picture = followed_picture("against-pretension", data, "pretension", unit="N", here=tension)
    yield Paragraph(
        text=f"A higher pretension raises the transverse frequencies, nearly with its square root, and "
        f"does not change the longitudinal ones. In {drive.name} the lowest transverse mode crosses "
        "several frequency ratios; at half the lowest longitudinal frequency, the motion of the "
        "pulleys can excite it parametrically."
    )
    yield picture.figure(
        name="against-pretension",
        alt="Frequencies against pretension: the longitudinal modes are horizontal lines, the lowest "
        "transverse one rises.",
        caption=f"{drive.name}: frequencies against pretension, from a tenth to ten times its "
        f"{quantity(tension, 'N')}.",
    )


def _inertia(drive: Drive) -> Iterator[Block]:
    inertia = drive.load_pulley.inertia
    values = inertia * np.geomspace(0.01, 100.0, _points(drive))
    data = frequency_against(drive, "pulley.1.inertia", values, modes=4)
    label = "inertia of the load pulley, relative to this drive's"
    picture = followed_picture("against-inertia", data, label, scale=inertia, here=inertia, across=False)
    ends = data["frequency"].to_numpy()[0]
    yield picture.figure(
        name="against-inertia",
        alt=f"Frequencies of {data.sizes['mode']} modes against the inertia of the load pulley; the lowest "
        f"goes from {number(ends[0], 3)} Hz to {number(ends[-1], 3)} Hz.",
        caption=f"{drive.name}: {data.sizes['mode']} modes tracked by their shapes while the load pulley "
        "grows from a hundredth to a hundred times its inertia.",
    )


def _travel(drive: Drive) -> Iterator[Block]:
    """The carriage on its way along its span."""
    length, here = drive.span_length, drive.carriage[0].position
    data = frequency_against(drive, "carriage.0.position", length * np.linspace(0.03, 0.97, 95), modes=4)
    picture = followed_picture(
        "against-position",
        data,
        "position of the carriage",
        unit="m",
        here=here,
        logarithmic=False,
        across=False,
    )
    yield Paragraph(
        text="With a travelling carriage the frequencies depend on its position. Where two curves approach "
        "each other they veer: they exchange their shapes without touching. Without a symmetry they do "
        "not cross."
    )
    yield picture.figure(
        name="against-position",
        alt=f"Frequencies of {data.sizes['mode']} modes against the position of the carriage, with "
        f"{data.sizes['crossing']} near-crossings marked.",
        caption=f"{drive.name}: modes tracked by their shapes while the carriage goes from one pulley to "
        "the other. Colours: parts that move; rings: veerings.",
    )
