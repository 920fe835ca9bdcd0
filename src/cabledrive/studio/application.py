"""The routes of the studio, put together."""

import contextlib
import importlib
from collections.abc import AsyncIterator, Callable

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.studio import guard as pages
from cabledrive.studio.guard import Guard, Keys
from cabledrive.studio.jobs import Jobs
from cabledrive.studio.library import LOGS, WORK, Library
from cabledrive.studio.log_store import LogStore
from cabledrive.studio.logs_view import check, curves, log_of_work, logs_page, take_log
from cabledrive.studio.machine_view import home, machine_page, machine_part, take_text
from cabledrive.studio.state import Desk, State, Warm
from cabledrive.studio.work_view import cancel, events, file, job_page, job_part, resume, start, work_page


def application(library: Library, keys: Keys, first: State, *, warm: bool = True) -> Guard:
    """The studio as an ASGI application behind its guard; ``warm``: make kernels ready in the background."""
    desk = Desk(
        library=library,
        first=first,
        jobs=Jobs(library.folder / WORK),
        logs=LogStore(library.folder / LOGS),
        warm=Warm(wanted=warm),
    )

    @contextlib.asynccontextmanager
    async def life(app: Starlette) -> AsyncIterator[None]:
        yield
        desk.warm.end()
        await desk.jobs.end()

    app = Starlette(
        routes=[
            Route("/", home),
            Route("/assets/{name}", pages.asset),
            Route("/machine", machine_page),
            Route("/machine/part", machine_part),
            Route("/machine/text", take_text, methods=["POST"]),
            Route("/resonance", _later("machine_view", "resonance_page")),
            Route("/resonance/map", _later("machine_view", "resonance_map")),
            Route("/logs", logs_page),
            Route("/logs/file", take_log, methods=["POST"]),
            Route("/logs/{log}/curves", curves),
            Route("/logs/{log}/check", check),
            Route("/control", _later("control_view", "control_page")),
            Route("/control/part", _later("control_view", "control_part")),
            Route("/control/best", _later("control_view", "control_best")),
            Route("/studies", work_page),
            Route("/studies/start/{kind}", start, methods=["POST"]),
            Route("/studies/{number}", job_page),
            Route("/studies/{number}/part", job_part),
            Route("/studies/{number}/events", events),
            Route("/studies/{number}/response", _later("logs_view", "response_curves")),
            Route("/studies/{number}/file", file),
            Route("/studies/{number}/log", log_of_work, methods=["POST"]),
            Route("/studies/{number}/cancel", cancel, methods=["POST"]),
            Route("/studies/{number}/resume", resume, methods=["POST"]),
            Route("/ready", _ready),
        ],
        lifespan=life,
        exception_handlers={
            InputRefused: _refused,
            NotComputed: _refused,
            ValueError: _refused,  # bytes of a request that are no text, a query that is none
        },
    )
    app.router.redirect_slashes = False  # an address is one that is listed, or none
    app.state.desk = desk
    return Guard(app, keys)


def _later(module: str, name: str) -> Callable[[Request], Response]:
    """A route whose module is imported when it is first asked for: no other page waits for its libraries."""

    def _endpoint(request: Request) -> Response:
        found: Response = getattr(importlib.import_module(f"cabledrive.studio.{module}"), name)(request)
        return found

    return _endpoint


def _ready(request: Request) -> Response:
    """What is being made ready in the background; empty when all is."""
    return PlainTextResponse(request.app.state.desk.warm.words)


async def _refused(request: Request, error: Exception) -> Response:
    """Why a request is refused: for a script of the page, or for a person who opened the address."""
    if "text/html" in request.headers.get("accept", ""):
        return PlainTextResponse(f"{error}\n", 400)
    return JSONResponse({"refusal": str(error)}, 400)
