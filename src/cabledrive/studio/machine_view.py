"""Open and see: the form, the text, the machine with a mode on it, the ladder and the table of modes."""

from dataclasses import dataclass
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, RedirectResponse, Response

from cabledrive.mechanics.holding import CONDITIONS
from cabledrive.mechanics.warnings import drive_warnings
from cabledrive.modal import modes
from cabledrive.modal.lowest import derived_with_lowest, how_held
from cabledrive.modal.mode_rows import certificate_line, mode_rows
from cabledrive.parameters import Drive, InputRefused, NotComputed, packaged_drives
from cabledrive.parameters.route import RoutedDrive
from cabledrive.report.datasheet_words import DATASHEET
from cabledrive.report.figures.moving_machine import moving_machine
from cabledrive.report.figures.rungs import rungs
from cabledrive.report.numbers import quantity
from cabledrive.report.style import NARROW, WIDE
from cabledrive.studio import pages
from cabledrive.studio.desk import Desk, bounded_body
from cabledrive.studio.edited_text import text_with
from cabledrive.studio.form import field_of_refusal, groups_of
from cabledrive.studio.library import EMPTY, LONGEST_TEXT
from cabledrive.studio.state import State, command_line, drive_of, edited, state_of, tables_of

COUNT = 8
"""Modes of each kind."""
MOST_COUNT = 60


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """What is looked at: ``motor``: how the rotor is held, empty for the default; ``row``: of the table."""

    motor: str
    row: int
    count: int

    @property
    def options(self) -> list[str]:
        """The same for the command `modes`."""
        return [f"--count={self.count}", *([f"--motor={self.motor}"] if self.motor else [])]


def machine_page(request: Request) -> Response:
    """The whole page."""
    desk: Desk = request.app.state.desk
    state, problem = state_of(request.url.query, desk.first), None
    try:
        tables = tables_of(desk.library, state)
    except InputRefused as refusal:
        state, problem, tables = desk.first, str(refusal), tables_of(desk.library, desk.first)
    return pages.page(
        request,
        "machine.html",
        view="machine",
        state=state,
        groups=groups_of(tables, state.settings),
        listed=packaged_drives(),
        kept=desk.library.kept(),
        empty=EMPTY,
        conditions=CONDITIONS,
        look=_look(request),
        first=_shown(desk, state, _look(request)),
        problem=problem,
    )


def machine_part(request: Request) -> Response:
    """What a change of the form changes."""
    desk: Desk = request.app.state.desk
    return JSONResponse(_shown(desk, state_of(request.url.query, desk.first), _look(request)))


async def take_text(request: Request) -> Response:
    """An edited text, or a file that was dropped: kept, and its address."""
    desk: Desk = request.app.state.desk
    text = (await bounded_body(request, 4 * LONGEST_TEXT)).decode("utf-8-sig", errors="strict")
    try:
        return JSONResponse({"query": edited(desk.library, text).query})
    except InputRefused as refusal:
        return JSONResponse({"refusal": str(refusal)}, 422)


def home(request: Request) -> Response:
    """The start."""
    return RedirectResponse(f"/machine?{request.app.state.desk.first.query}", 303)


def _look(request: Request) -> Look:
    asked = request.query_params
    motor = asked.get("motor", "")
    return Look(
        motor=motor if motor in CONDITIONS else "",
        row=_whole(asked.get("row", "0"), 0, 10_000),
        count=_whole(asked.get("count", str(COUNT)), 1, MOST_COUNT),
    )


def _whole(text: str, low: int, high: int) -> int:
    if not text.isascii() or not text.isdigit() or len(text) > 6:
        return low
    return min(max(int(text), low), high)


def _shown(desk: Desk, state: State, look: Look) -> dict[str, Any]:
    """All that depends on the state; a refusal with the key that it is about."""
    try:
        drive = drive_of(desk.library, state)
        return _seen(drive, look) | {
            "text": text_with(desk.library.text(state.drive), drive, state.settings),
            "command": command_line(desk.library, state, "modes", *look.options),
            "query": state.query,
        }
    except (InputRefused, NotComputed) as refusal:
        try:
            groups = groups_of(tables_of(desk.library, state), state.settings)
        except InputRefused:
            groups = []
        return {"refusal": str(refusal), "key": field_of_refusal(groups, str(refusal))}


def _seen(drive: Drive | RoutedDrive, look: Look) -> dict[str, Any]:
    found = modes(drive, count=look.count, motor=look.motor or None)
    rows = mode_rows(found)
    row = min(look.row, len(rows) - 1)
    wide, narrow = moving_machine(drive, rows[row].modes[0] if rows else None)
    part = pages.fragment(
        "machine_part.html",
        drive=drive,
        wide=wide,
        narrow=narrow,
        ladders=[rungs(rows, row, width) for width in (WIDE, NARROW)] if rows else [],
        rows=rows,
        chosen=row,
        held=how_held(found),
        certificate=certificate_line(found),
        warnings=[*found.warnings, *_warnings(drive)],
        sheet=_sheet(drive),
    )
    return {
        "part": part,
        "frequencies": [[r.kind, r.frequency] for r in rows],
        "title": drive.title or drive.name,
    }


def _warnings(drive: Drive | RoutedDrive) -> tuple[str, ...]:
    if not isinstance(drive, RoutedDrive):
        return drive_warnings(drive)
    from cabledrive.mechanics.network.span_table import route_warnings  # other machines do not wait for it

    return route_warnings(drive)


def _sheet(drive: Drive | RoutedDrive) -> dict[str, list[tuple[str, str]]]:
    """The datasheet: heading, then words and quantities."""
    if isinstance(drive, RoutedDrive):
        from cabledrive.mechanics.network import statics_of
        from cabledrive.mechanics.network.span_table import span_rows

        rows = span_rows(drive, statics_of(drive))
        return {
            "Spans": [
                (row["name"], f"{quantity(row['length'], 'm')}, {quantity(row['tension'], 'N', 4)}")
                for row in rows
            ]
        }
    derived = derived_with_lowest(drive)
    return {
        heading: [
            (words, quantity(value, unit))
            for name, words, unit in section
            if (value := derived.get(name)) is not None
        ]
        for heading, section in DATASHEET.items()
    }
