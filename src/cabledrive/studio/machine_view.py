"""Open and see: the form, the text, the machine with a mode on it, its internal resonance."""

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, RedirectResponse, Response

from cabledrive.answers.figures import quantity
from cabledrive.mechanics.holding import CONDITIONS
from cabledrive.modal import modes
from cabledrive.modal.lowest import how_held
from cabledrive.modal.mode_rows import mode_rows
from cabledrive.parameters import InputRefused, Machine, NotComputed, packaged_drives
from cabledrive.parameters.units import to_si
from cabledrive.report.blocks import Cell
from cabledrive.report.figures.ladder import rungs
from cabledrive.report.figures.moving_machine import moving_machine
from cabledrive.report.machine.data import data_sheet, derived_table, machine_warnings
from cabledrive.report.machine.tables import pairs_table
from cabledrive.report.map_page import resonance_map_page
from cabledrive.report.picture import WIDE
from cabledrive.report.typesetting import typeset_words
from cabledrive.report.words import certificate_line
from cabledrive.studies.planned_motion import read_motion
from cabledrive.studies.resonance import resonance
from cabledrive.studies.resonance_map import growth_map
from cabledrive.studio import guard as pages
from cabledrive.studio.commands import map_option
from cabledrive.studio.form import field_of_refusal, groups_of, text_with
from cabledrive.studio.library import EMPTY, LONGEST_TEXT
from cabledrive.studio.state import (
    Desk,
    State,
    bounded_body,
    command_line,
    drive_of,
    edited,
    state_of,
    tables_of,
)
from cabledrive.studio.work_view import FRAMED

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
    return JSONResponse({"query": edited(desk.library, text).query})


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


def _seen(drive: Machine, look: Look) -> dict[str, Any]:
    found = modes(drive, count=look.count, motor=look.motor or None)
    rows = mode_rows(found)
    row = min(look.row, len(rows) - 1)
    part = pages.fragment(
        "machine_part.html",
        drive=drive,
        drawing=moving_machine(drive, rows[row].modes[0] if rows else None),
        ladder=rungs(rows, row, WIDE) if rows else "",
        rows=rows,
        chosen=row,
        held=how_held(found),
        certificate=certificate_line(found),
        warnings=[*found.warnings, *machine_warnings(drive)],
        sheet=_sheet(drive),
    )
    return {
        "part": part,
        "frequencies": [[r.kind, r.frequency] for r in rows],
        "title": drive.title or drive.name,
    }


def _sheet(drive: Machine) -> dict[str, Sequence[Sequence[Cell]]]:
    """The datasheet: heading, then words and quantities."""
    sheet = data_sheet(drive)
    spans = [
        (row["name"], f"{quantity(row['length'], 'm')}, {quantity(row['tension'], 'N', 4)}")
        for row in sheet.spans
    ]
    return {"Spans": spans} | {group.title: group.rows for group in derived_table(sheet.derived).groups}


KEPT, MOST_PAIRS = 4, 12
NONE_HERE = "This machine has no internal resonance to show"
NO_MAP = (
    "The map is that of a cable round two pulleys; on this machine the verdict rests on its pairs of modes."
)
TELLS_HEIGHT = """<script>
new ResizeObserver(() => parent.postMessage(document.body.scrollHeight, "*")).observe(document.body);
</script>"""
"""The frame of the map is as high as what it shows."""
_ONE_AT_A_TIME = threading.Lock()
_map = lru_cache(maxsize=KEPT)(growth_map)


def resonance_page(request: Request) -> Response:
    """Verdict and pairs; the map is a page of its own inside."""
    desk: Desk = request.app.state.desk
    state = state_of(request.url.query, desk.first)
    torque = request.query_params.get("torque", "")[:40]
    words: dict[str, Any] = {"refusal": "", "why_none": "", "facts": [], "pairs": None, "verdict": ""}
    try:
        drive, amplitude = drive_of(desk.library, state), to_si(torque, "N m") if torque else None
    except (InputRefused, NotComputed) as refusal:
        words["refusal"] = str(refusal)
    else:
        try:
            found = resonance(drive, torque=amplitude)
            words |= {
                "verdict": found.verdict,
                "reasons": [typeset_words(line) for line in found.reasons],
                "facts": found.figures,
                "pairs": pairs_table(found, MOST_PAIRS),
                "why_none": NO_MAP if found.nearest_span else "",
            }
        except (InputRefused, NotComputed) as refusal:
            words["why_none"] = f"{NONE_HERE}: {refusal}."
    options = [f"--torque={torque}"] if torque else []
    options += map_option(desk, state)
    return pages.page(
        request,
        "resonance.html",
        view="resonance",
        state=state,
        torque=torque,
        motion=request.query_params.get("motion", ""),
        logs=[log for log in desk.logs.listed() if log[1].endswith((".csv", ".tsv"))],
        command=command_line(desk.library, state, "resonance", *options),
        **words,
    )


def resonance_map(request: Request) -> Response:
    """The map, as the command `resonance --map` draws it; with a motion, its path."""
    desk: Desk = request.app.state.desk
    drive = drive_of(desk.library, state_of(request.url.query, desk.first))
    torque = request.query_params.get("torque", "")[:40]
    found = resonance(drive, torque=to_si(torque, "N m") if torque else None)
    chosen = request.query_params.get("motion")
    motion = read_motion(desk.logs.path(chosen)) if chosen else None
    with _ONE_AT_A_TIME:
        html = resonance_map_page(_map(drive, torque=found.torque or 0.0), motion=motion)
    return HTMLResponse(html + TELLS_HEIGHT, headers={"content-security-policy": FRAMED})
