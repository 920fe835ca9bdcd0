"""Logs: dropped, drawn with zoom, checked; a measured response over that of the drive."""

from collections.abc import AsyncIterator
from math import pi
from pathlib import Path
from typing import Any

import anyio
import numpy as np
from numpy.typing import NDArray
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from cabledrive.identification.logs.log import ColumnMap, recognise, with_choices
from cabledrive.identification.logs.reading import open_log, read_log
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.reduction.network_axis import as_axis
from cabledrive.reduction.quality import distributed_response
from cabledrive.studio import guard as pages
from cabledrive.studio.jobs import Job
from cabledrive.studio.log_store import SOUND, plain, shown_columns, time_column, unit_of
from cabledrive.studio.state import Desk, State, drive_of, state_of
from cabledrive.studio.work_view import job_of

MOST_CHECKED = 8_000_000
"""Rows of a log that is checked for the page; a longer one is checked by what identifies from it."""
MOST_MARKS = 200


def logs_page(request: Request) -> Response:
    """All logs, and one of them."""
    desk: Desk = request.app.state.desk
    state, log = state_of(request.url.query, desk.first), request.query_params.get("log", "")
    words: dict[str, Any] = {
        "refusal": "",
        "name": "",
        "columns": [],
        "shown": [],
        "time": None,
        "sound": False,
    }
    if log:
        try:
            words |= _columns(desk, log)
        except InputRefused as refusal:
            words["refusal"] = str(refusal)
    command = f"cabledrive identify {words['name']}" if words["name"] else ""
    return pages.page(
        request,
        "logs.html",
        view="logs",
        state=state,
        log=log,
        logs=desk.logs.listed(),
        command=command,
        spans=_spans(desk, state),
        **words,
    )


def _spans(desk: Desk, state: State) -> list[str]:
    """Spans that can be plucked; none where the drive is refused."""
    try:
        drive = drive_of(desk.library, state)
        return [*drive.spans, *(["both"] if len(drive.spans) == 2 else [])]
    except (InputRefused, NotComputed):
        return []


def _columns(desk: Desk, log: str) -> dict[str, Any]:
    path = desk.logs.path(log)
    if path.suffix.lower() == SOUND:
        return {"name": path.name, "sound": True}
    table = desk.logs.table(log)
    columns = [
        {"name": name, "unit": unit_of(table, name), "channel": recognise(name)} for name in table.names[:400]
    ]
    return {"name": path.name, "columns": columns, "shown": shown_columns(table), "time": time_column(table)}


async def log_of_work(request: Request) -> Response:
    """A file that work here has written, kept as a log."""
    desk: Desk = request.app.state.desk
    job, name = job_of(request), request.query_params.get("name", "")
    if name not in job.files:
        return JSONResponse({"refusal": "no such file"}, 404)
    return JSONResponse({"log": await desk.logs.receive(name, _parts(job.folder / name))})


async def _parts(path: Path) -> AsyncIterator[bytes]:
    async with await anyio.open_file(path, "rb") as file:
        while part := await file.read(1 << 20):
            yield part


async def take_log(request: Request) -> Response:
    """A file, streamed to disk."""
    desk: Desk = request.app.state.desk
    name = request.query_params.get("name", "")
    return JSONResponse({"log": await desk.logs.receive(name, request.stream())})


def curves(request: Request) -> Response:
    """Least and largest values of columns of a part of a log."""
    desk: Desk = request.app.state.desk
    asked, found = request.query_params, desk.logs.curves(request.path_params["log"])
    names = tuple(dict.fromkeys(asked.getlist("column")))[:8] or tuple(shown_columns(found.table))
    points = int(asked.get("points", "1000")[:6])
    window = found.window(names, _place(asked.get("start")), _place(asked.get("end")), max(points, 2))
    units = {name: unit_of(found.table, name) for name in names}
    time_unit = "" if found.time is None else unit_of(found.table, found.time)
    return JSONResponse(window | {"units": units, "time": found.time, "time_unit": time_unit})


def check(request: Request) -> Response:
    """What the check of the log found, with the places where it is known."""
    desk: Desk = request.app.state.desk
    log = request.path_params["log"]
    rows, path = desk.logs.table(log).rows or 0, desk.logs.path(log)
    if rows > MOST_CHECKED:
        raise InputRefused(
            f"not checked here: about {rows} rows, at most {MOST_CHECKED}; `identify` checks it whole"
        )
    columns = with_choices(ColumnMap(), [one for one in request.query_params.getlist("column") if one])
    found, opened = read_log(path, columns), open_log(path, columns)
    report, tick = found.report, opened.factors.get("time", 1.0)  # the plot keeps the file's unit
    said = [
        f"{report.rows} rows, {report.duration:.6g} s at {1.0 / report.interval:.6g} Hz",
        *report.repaired,
        *report.findings,
    ]
    marks = [
        {"channel": name, "start": float(found.time[first]) / tick, "end": float(found.time[last]) / tick}
        for name, flags in found.saturated.items()
        for first, last in _runs(np.asarray(flags))
    ]
    return JSONResponse({"said": said, "marks": marks[:MOST_MARKS]})


def _runs(flags: Any) -> list[tuple[int, int]]:
    """First and last place of every run of flags."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(np.int8), [0]))))
    return [(int(first), int(last) - 1) for first, last in edges.reshape(-1, 2)]


def _place(text: str | None) -> float | None:
    if not text:
        return None
    value = float(text[:40])
    return value if np.isfinite(value) else None


OUTPUTS = ("motor angle", "motor speed", "load angle", "load speed")


def response_curves(request: Request) -> Response:
    """Magnitude, phase and coherence of a measured response, and magnitude and phase of the computed one."""
    desk: Desk = request.app.state.desk
    job = job_of(request)
    answer = job.answer
    if "coherence" not in answer:
        raise InputRefused(f"{job.title}: holds no measured response: run Response on a log")
    names = ("frequency_hz", "magnitude", "phase_deg", "coherence")
    above = np.array(answer["frequency_hz"], dtype=float) > 0.0
    lines = {name: np.array(answer[name], dtype=float)[above] for name in names}
    output = request.query_params.get("output", "")
    output = output if output in OUTPUTS else _output(job)
    lines["phase_deg"] = _below_zero(lines["phase_deg"])
    found: dict[str, Any] = {name: plain(values) for name, values in lines.items()}
    found |= {"output": output, "outputs": OUTPUTS, "computed": [], "computed_phase": [], "words": ""}
    try:
        drive = as_axis(drive_of(desk.library, state_of(request.url.query, desk.first)))
        computed = _computed(drive, 2.0 * pi * lines["frequency_hz"], output)
        found["computed"] = plain(np.abs(computed))
        found["computed_phase"] = plain(_below_zero(np.degrees(np.angle(computed))))
        found["words"] = f"Dashed: computed of {drive.name}, from motor torque to {output}, friction viscous."
    except (InputRefused, NotComputed) as refusal:
        found["words"] = f"No computed response beside it: {refusal}"
    return JSONResponse(found)


def _computed(drive: Drive, omega: NDArray[np.float64], output: str) -> NDArray[np.complex128]:
    """Of the linear distributed machine; ``omega`` [rad/s]. Returns [rad/(N m)] or [rad/(s N m)]."""
    shaft, quantity = output.split()
    angle = distributed_response(drive, omega, angle_of=shaft)
    return angle * 1j * omega if quantity == "speed" else angle


def _output(job: Job) -> str:
    """What the output of a response most likely is, by the name of its column."""
    name = next((a.partition("=")[2] for a in job.arguments if a.startswith("--response=")), "").lower()
    quantity = "speed" if any(word in name for word in ("speed", "vel", "rate")) else "angle"
    return f"{'load' if 'load' in name else 'motor'} {quantity}"


def _below_zero(degrees: NDArray[np.float64]) -> NDArray[np.float64]:
    """Phases from -270 to 90 deg: that of an inertia, -180 deg, lies inside and does not jump."""
    return (degrees + 270.0) % 360.0 - 270.0
