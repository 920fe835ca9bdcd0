"""Long work: started, watched, cancelled, resumed; its pages shown in a frame, its files taken."""

import mimetypes
import re
import shutil
from typing import Any
from urllib.parse import parse_qsl

from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response, StreamingResponse

from cabledrive.identification.logs.reading import FORMATS as FORMATS_OF_LOGS
from cabledrive.parameters import InputRefused
from cabledrive.studio import guard as pages
from cabledrive.studio.commands import FORMATS, asked
from cabledrive.studio.form import groups_of
from cabledrive.studio.jobs import RUNNING, Job
from cabledrive.studio.state import Desk, bounded_body, command_line, drive_of, state_of, tables_of

FRAMED = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; "
    "font-src data:; sandbox allow-scripts; frame-ancestors 'self'"
)
"""A page that a command wrote runs its own scripts as from another origin: it reaches nothing here."""
MOST_FIELDS = 200
LONGEST_FORM = 100_000
SHOWN = (".html", ".svg", ".png")


def work_page(request: Request) -> Response:
    """Forms for what is started here, and all that was started."""
    from cabledrive.rig.laws.registry import CONTROLLERS  # brings libraries that a start does not wait for

    desk: Desk = request.app.state.desk
    state = state_of(request.url.query, desk.first)
    return pages.page(
        request,
        "work.html",
        view="studies",
        state=state,
        jobs=sorted(desk.jobs.all.values(), key=lambda job: -job.number),
        logs=desk.logs.listed(),
        laws=list(CONTROLLERS),
        formats=FORMATS,
        keys=_keys(desk, request),
        command=command_line(desk.library, state, "study", "--quick", "-o", "study"),
    )


def job_page(request: Request) -> Response:
    """One piece of work."""
    desk: Desk = request.app.state.desk
    job = job_of(request)
    return pages.page(
        request,
        "job.html",
        view="studies",
        state=state_of(request.url.query, desk.first),
        job=job,
        running=job.status == RUNNING,
    )


def job_part(request: Request) -> Response:
    """What is known of one piece of work: status, numbers, pages, files."""
    job = job_of(request)
    found = pages.fragment(
        "job_part.html",
        job=job,
        running=job.status == RUNNING,
        answer=_numbers(job.answer),
        shown=[name for name in job.files if name.endswith(SHOWN)],
        formats=tuple(FORMATS_OF_LOGS),
    )
    return JSONResponse({"part": found, "status": job.status, "lines": job.lines, "answer": job.answer})


async def start(request: Request) -> Response:
    """Start a command."""
    desk: Desk = request.app.state.desk
    form = dict(parse_qsl((await bounded_body(request, LONGEST_FORM)).decode(), max_num_fields=MOST_FIELDS))
    state = state_of(request.url.query, desk.first)
    desk.jobs.check_room()
    number, folder = desk.jobs.new_folder()
    try:
        wanted = asked(desk, request.path_params["kind"], state, form, folder)
    except InputRefused:
        shutil.rmtree(folder)
        raise
    job = await desk.jobs.start((number, folder), wanted.title, wanted.arguments)
    return JSONResponse({"number": job.number, "shown": job.shown})


async def cancel(request: Request) -> Response:
    """Cancel one piece of work; answered when no process of it is left."""
    job = job_of(request)
    await request.app.state.desk.jobs.cancel(job)
    return JSONResponse({"status": job.status})


async def resume(request: Request) -> Response:
    """Give the same command again: what is finished is kept."""
    job = job_of(request)
    await request.app.state.desk.jobs.resume(job)
    return JSONResponse({"status": job.status})


async def events(request: Request) -> Response:
    """Progress, as it comes."""
    seen = request.headers.get("last-event-id", "0")
    found = request.app.state.desk.jobs.events(
        job_of(request), int(seen) if seen.isdigit() and len(seen) < 9 else 0
    )
    return StreamingResponse(found, media_type="text/event-stream")


def file(request: Request) -> Response:
    """A file of one piece of work: a page in a frame of its own, anything else to be taken."""
    job, name = job_of(request), request.query_params.get("name", "")
    if name not in job.files:
        return PlainTextResponse("no such file\n", 404)
    path = job.folder / name
    if name.endswith(SHOWN) and not request.query_params.get("take"):
        kind = mimetypes.guess_type(name)[0] or "application/octet-stream"
        return FileResponse(path, media_type=kind, headers={"content-security-policy": FRAMED})
    plain = re.sub(r"[^A-Za-z0-9._-]", "_", path.name)
    return FileResponse(path, media_type="application/octet-stream", filename=plain)


def job_of(request: Request) -> Job:
    """The piece of work that an address names. Raises `InputRefused` if there is none."""
    number = request.path_params["number"]
    job = request.app.state.desk.jobs.all.get(int(number) if number.isdigit() and len(number) < 9 else -1)
    if job is None:
        raise InputRefused(f"there is no work {number[:20]} in this studio: see the list")
    return job


def _numbers(answer: dict[str, Any]) -> list[tuple[str, str]]:
    """The plain values of an answer, a level deep."""
    found = []
    for key, value in answer.items():
        inside = value.items() if isinstance(value, dict) and key != "provenance" else [("", value)]
        found += [(f"{key} {name}".strip().replace("_", " "), _words(one)) for name, one in inside]
    return [row for row in found if row[1]][:80]


def _words(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, str | int):
        return str(value)
    if isinstance(value, dict) and isinstance(value.get("value"), float):
        low, high = value.get("low"), value.get("high")
        interval = f" ({low:.4g} to {high:.4g})" if isinstance(low, float) and isinstance(high, float) else ""
        return f"{value['value']:.6g} {value.get('unit', '')}{interval}"
    if isinstance(value, list) and value and all(isinstance(one, str) for one in value):
        return "; ".join(value)
    return ""


def _keys(desk: Desk, request: Request) -> list[str]:
    """Keys that a sweep can vary: those that the file gives."""
    state = state_of(request.url.query, desk.first)
    try:
        drive_of(desk.library, state)
        groups = groups_of(tables_of(desk.library, state), state.settings)
    except InputRefused:
        return []
    return [field.key for group in groups for field in group.fields if field.number is not None]
