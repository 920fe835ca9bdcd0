"""The report of some drives as a file."""

import os
import re
from collections.abc import Callable, Iterator, Sequence
from datetime import UTC, datetime
from html import unescape
from pathlib import Path

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.files import check_writable, write_whole
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.route.two_pulleys import require_own_spans
from cabledrive.report.context import ReportContext, make_context
from cabledrive.report.machine.page import machine_view
from cabledrive.report.machine.route import route_view
from cabledrive.report.overview import overview_figure
from cabledrive.report.page import Page, render
from cabledrive.report.provenance import provenance
from cabledrive.report.views import TOPICS, Card, View
from cabledrive.report.what_moves_them import effect_of_parameters


def write_report(
    drives: Sequence[Drive | RoutedDrive],
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
    drives : sequence of Drive or RoutedDrive
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
    for drive in drives:
        require_own_spans(drive, "`write_report`")
    path = check_writable(path, force=force)
    beside = tuple(linked_page(page, path.parent) for page in links)
    html = report_html(drives, written_at=written_at, progress=progress, links=beside)
    return write_whole(path, html, force=force)


def report_html(
    drives: Sequence[Drive | RoutedDrive],
    *,
    written_at: datetime | None = None,
    progress: Callable[[str], None] | None = None,
    links: tuple[tuple[str, str], ...] = (),
) -> str:
    """The report of some drives as text.

    Parameters
    ----------
    drives : sequence of Drive or RoutedDrive
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
    machines = tuple(machine_view(context, place) for place in range(len(context.drives)))
    routes = tuple(route_view(context, place) for place in range(len(context.routes)))
    views = (*routes, *machines, *_effects(context))
    about_all = "Natural frequencies, internal resonance, tensions and tracking errors"
    one = len(drives) == 1
    methods = tuple(method for view in views for method in view.methods)
    return render(
        Page(
            title=drives[0].name if one else f"{len(drives)} cable drives",
            subtitle=drives[0].title if one else about_all,
            views=views,
            overview=overview_figure(context) if len(drives) > 1 else None,
            links=links,
            provenance=provenance(context, methods, written_at or datetime.now(UTC)),
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
