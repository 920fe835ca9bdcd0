"""Templates and fixed files of the studio: escaped throughout, read once."""

from functools import cache
from importlib import resources
from typing import Any

import jinja2
from starlette.background import BackgroundTask
from starlette.requests import Request
from starlette.responses import HTMLResponse, Response

from cabledrive.parameters.version import __version__
from cabledrive.report.numbers import number, quantity, unit_name
from cabledrive.report.style import theme_css

VIEWS = (
    ("machine", "Machine"),
    ("resonance", "Resonance"),
    ("logs", "Logs"),
    ("control", "Control"),
    ("studies", "Studies"),
)
_OWN = resources.files("cabledrive.studio") / "templates"
_UPLOT = resources.files("cabledrive.report") / "vendor" / "uplot"
_SCRIPTS = ("studio", "machine", "resonance", "curves", "logs", "control", "work", "response", "tour")
_FILES = {
    **{f"{name}.js": ("text/javascript", (_OWN, f"{name}.js")) for name in _SCRIPTS},
    "studio.css": ("text/css", (_OWN, "studio.css")),
    "uPlot.js": ("text/javascript", (_UPLOT, "uPlot.iife.min.js")),
    "uPlot.css": ("text/css", (_UPLOT, "uPlot.min.css")),
}


def page(request: Request, template: str, **values: Any) -> HTMLResponse:
    """A page; kernels are made ready when the first one has gone out."""
    warm = request.app.state.desk.warm
    shared = {"nonce": request.scope["nonce"], "views": VIEWS, "version": __version__, "warm": warm.words}
    return HTMLResponse(fragment(template, **shared, **values), background=BackgroundTask(warm.begin))


def fragment(template: str, **values: Any) -> str:
    """A template with values."""
    return _environment().get_template(template).render(**values)


def asset(request: Request) -> Response:
    """A fixed file, by its name in the table."""
    name = request.path_params["name"]
    if name not in _FILES:
        return Response("no such file\n", 404, media_type="text/plain")
    return Response(_content(name), media_type=_FILES[name][0], headers={"cache-control": "no-cache"})


@cache
def _content(name: str) -> str:
    folder, file = _FILES[name][1]
    text = (folder / file).read_text(encoding="utf-8")
    return theme_css() + text if name == "studio.css" else text


@cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(lambda name: (_OWN / name).read_text(encoding="utf-8")),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals |= {"unit_name": unit_name}
    environment.filters |= {"number": number, "quantity": quantity}
    return environment
