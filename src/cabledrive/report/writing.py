"""The report of some drives as a file: overview, and what moves the modes."""

import os
import re
from collections.abc import Callable, Iterator, Sequence
from datetime import datetime
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.answers.figures import number, quantity
from cabledrive.parameters import Drive, InputRefused, Machine, NotComputed, content_hash, load_drive
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.files import check_writable, write_whole
from cabledrive.report.blocks import Block, Chapter, Figure, Note, Paragraph
from cabledrive.report.context import ReportContext, make_context, provenance
from cabledrive.report.figures.followed import followed_picture, overview_picture
from cabledrive.report.machine.page import machine_view
from cabledrive.report.page import TOPICS, Card, Page, View, render
from cabledrive.studies import frequency_against


def overview_figure(context: ReportContext) -> Figure:
    """The lowest mode of each kind of every machine on one logarithmic axis."""
    names = [machine.name for machine in context.machines]
    return Figure(
        name="overview-modes",
        alt="Lowest longitudinal and transverse frequency of each machine on a logarithmic axis; the "
        "numbers are on the cards.",
        caption="The lowest longitudinal (along) and transverse (across) mode of each machine. Where the "
        "second is near half the first, longitudinal motion can excite transverse motion parametrically.",
        drawing=overview_picture("overview-modes", names, context.modes),
    )


VARIED = "dissertation-2"
POINTS, FEWEST = 61, 13
MOST_CARRIAGES = 500


def effect_of_parameters(context: ReportContext) -> Chapter | None:
    """Frequencies of a machine against pretension and load inertia."""
    drives = [own.two_pulleys for own in context.machines if own.two_pulleys]
    if not drives:
        return None
    varied = content_hash(load_drive(VARIED))
    drive = next((own for own in drives if content_hash(own) == varied), drives[0])
    return Chapter(
        "Effect of parameters on the frequencies",
        "what-moves-them",
        tuple(_of_one(drive)),
        summary="How pretension and inertia shift the natural frequencies.",
        methods=(
            "Frequencies against a quantity: certified modes at each value, tracked by the overlap of "
            "their shapes; steps are halved until the assignment is unique.",
        ),
    )


def _of_one(drive: Drive) -> Iterator[Block]:
    """Pretension and load inertia; what cannot be followed is said and left out."""
    if len(drive.carriage) > MOST_CARRIAGES:
        yield Note(
            text=f"{drive.name} has more than {MOST_CARRIAGES} carriages: tracking its modes would take "
            "minutes and is omitted here; use cabledrive.studies.frequency_against."
        )
        return
    tension, inertia = drive.cable.pretension, drive.load_pulley.inertia
    # fewer values where every one of them takes longer
    number_of = max(FEWEST, POINTS * 50 // max(50, len(drive.carriage)))
    try:
        figure = _against(
            drive,
            "pretension",
            ("cable.pretension", tension * np.geomspace(0.1, 10.0, number_of), 3),
            "Frequencies against pretension: the longitudinal modes are horizontal lines, the lowest "
            "transverse one rises.",
            f"frequencies against pretension, from a tenth to ten times its {quantity(tension, 'N')}.",
            quantity="pretension",
            unit="N",
            here=tension,
        )
        yield Paragraph(
            text=f"A higher pretension raises the transverse frequencies, nearly with its square root, and "
            f"does not change the longitudinal ones. In {drive.name} the lowest transverse mode crosses "
            "several frequency ratios; at half the lowest longitudinal frequency, the motion of the "
            "pulleys can excite it parametrically."
        )
        yield figure
        if not drive.load_pulley.fixed:
            yield _against(
                drive,
                "inertia",
                ("pulley.1.inertia", inertia * np.geomspace(0.01, 100.0, number_of), 4),
                "Frequencies of {modes} modes against the inertia of the load pulley; the lowest goes from "
                "{first} Hz to {last} Hz.",
                "{modes} modes tracked by their shapes while the load pulley grows from a hundredth to a "
                "hundred times its inertia.",
                quantity="inertia of the load pulley, relative to this drive's",
                scale=inertia,
                here=inertia,
                across=False,
            )
    except NotComputed as reason:
        yield Note(text=f"The modes of {drive.name} could not be followed further: {reason}.", tone="warning")


def _against(
    drive: Drive, name: str, asked: tuple[str, Array, int], alt: str, caption: str, **looks: Any
) -> Figure:
    """Frequencies against a quantity: its key, values and how many modes are asked for."""
    key, values, count = asked
    data = frequency_against(drive.machine, key, values, modes=count)
    first, last = (number(hertz, 3) for hertz in data["frequency"].to_numpy()[0, [0, -1]])
    found = {"modes": data.sizes["mode"], "first": first, "last": last}
    return Figure(
        name=f"against-{name}",
        alt=alt.format(**found),
        caption=" ".join((f"{drive.name}: {caption.format(**found)}", data.attrs["warning"])).strip(),
        drawing=followed_picture(f"against-{name}", data, **looks),
    )


def write_report(
    drives: Sequence[Machine | Drive],
    path: str | Path,
    *,
    force: bool = False,
    written_at: datetime | None = None,
    progress: Callable[[str], None] | None = None,
    links: Sequence[str | Path] = (),
) -> Path:
    """Write the report of some drives as one HTML file that needs nothing else.

    Parameters
    ----------
    drives : sequence of Machine or Drive
        At least one.
    path : path-like
        File to write; it appears whole or not at all.
    force : bool, default False
        Whether an existing file may be replaced.
    written_at : datetime, optional
        Time that the report states; now where it is not given. Everything else follows from the drives.
    progress : callable, optional
        Called with a line of text when a longer part of the work begins.
    links : sequence of path-like, default ()
        Other pages, shown as cards; the file does without them.

    Returns
    -------
    Path
        Where it was written.

    Raises
    ------
    InputRefused
        If there is no drive, the file exists (without `force`), it cannot be written, or a linked page
        cannot be read; before any work.
    NotComputed
        If the modes of a drive could not be computed.
    """
    path = check_writable(path, force=force)
    beside = tuple(linked_page(page, path.parent) for page in links)
    html = report_html(drives, written_at=written_at, progress=progress, links=beside)
    return write_whole(path, html, force=force)


def report_html(
    drives: Sequence[Machine | Drive],
    *,
    written_at: datetime | None = None,
    progress: Callable[[str], None] | None = None,
    links: tuple[tuple[str, str], ...] = (),
) -> str:
    """The report of some drives as text.

    Parameters
    ----------
    drives : sequence of Machine or Drive
        At least one.
    written_at : datetime, optional
        Time that the report states; now where it is not given.
    progress : callable, optional
        Called with a line of text when a longer part of the work begins.
    links : tuple of (str, str), default ()
        Title and address of other pages, shown as cards.

    Returns
    -------
    str
        HTML.

    Raises
    ------
    InputRefused
        If there is no drive.
    NotComputed
        If the modes of a drive could not be computed.
    """
    context = make_context(drives, progress)
    own = (machine_view(context, place) for place in range(len(context.machines)))
    views = (*own, *_effects(context))
    about_all = "Natural frequencies, internal resonance, tensions and tracking errors"
    one = len(drives) == 1
    methods = [method for view in views for method in view.methods]
    hashes = [(own.name, content_hash(own)) for own in context.machines]
    return render(
        Page(
            title=drives[0].name if one else f"{len(drives)} cable drives",
            subtitle=drives[0].title if one else about_all,
            views=views,
            overview=overview_figure(context) if len(drives) > 1 else None,
            links=links,
            provenance=provenance(hashes, methods, written_at),
        )
    )


def _effects(context: ReportContext) -> Iterator[View]:
    """The page on what moves the frequencies, where the report has a drive for it."""
    context.progress("effect of parameters on the frequencies")
    found = effect_of_parameters(context)
    if found is not None:
        yield View(
            anchor=found.anchor,
            title=found.title,
            group=TOPICS,
            card=Card(text=found.summary or found.headline),
            template="topic.html",
            content=found,
            blocks=found.all_blocks,
            methods=found.methods,
        )


def linked_page(page: str | Path, folder: Path) -> tuple[str, str]:
    """Title of another page and its address from the folder of this one; refused without a title."""
    try:
        text = Path(page).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, "strerror", None) or "it is no text"
        raise InputRefused(f"cannot be read ({why}): make the linked page first").at(str(page)) from None
    found = re.search(r"<title>(.*?)</title>", text, re.DOTALL)
    if found is None:
        raise InputRefused("has no title: link a page of HTML").at(str(page))
    return unescape(found[1]).strip(), Path(os.path.relpath(page, folder)).as_posix()
