"""What a request must show before a route sees it, and the templates that answer it."""

import hmac
import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass, field
from functools import cache
from http.cookies import CookieError, SimpleCookie
from importlib import resources
from typing import Any
from urllib.parse import parse_qs

import jinja2
from starlette.background import BackgroundTask
from starlette.requests import Request
from starlette.responses import HTMLResponse, Response

from cabledrive.answers.figures import number, quantity
from cabledrive.parameters.version import __version__
from cabledrive.report.blocks import UPLOT
from cabledrive.report.page import page_environment
from cabledrive.report.picture import theme_css

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

SAFE = ("GET", "HEAD")
POLICY = (
    "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; "
    "style-src-attr 'unsafe-inline'; img-src 'self' data:; connect-src 'self'; frame-src 'self'; "
    "form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
)
"""Styles of single elements come with the drawings; they load nothing that `img-src` does not allow."""
HEADERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), microphone=(), geolocation=()",
    "cache-control": "no-store",
}


@dataclass(slots=True)
class Keys:
    """What opens the studio: a token, used up by the first request that it opens, and the cookie after it."""

    port: int
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))  # empty once it has been used
    cookie: str = field(default_factory=lambda: secrets.token_urlsafe(32))

    @property
    def cookie_name(self) -> str:
        """Cookies know no ports: each studio has its own name."""
        return f"cabledrive_{self.port}"

    @property
    def hosts(self) -> tuple[str, ...]:
        """What a browser on this machine calls this server."""
        return f"127.0.0.1:{self.port}", f"localhost:{self.port}"


class Guard:
    """The outermost layer of an ASGI application: host, origin and key are looked at before any route."""

    def __init__(self, app: App, keys: Keys) -> None:
        self._app, self._keys = app, keys

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or hand it on."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        if scope["type"] != "http":
            await send({"type": "websocket.close", "code": 1008})
            return
        headers = _headers(scope)
        fault = self._fault(scope, headers)
        if fault:
            await _answer(send, 403, fault)
        elif scope["path"] == "/" and (token := _token(scope)) is not None:
            await self._exchange(scope, headers, token, send)
        elif not self._has_cookie(headers):
            await _answer(send, 403, "This page needs the address that the studio printed when it started.")
        else:
            scope["nonce"] = nonce = secrets.token_urlsafe(16)
            await self._app(scope, receive, _with_headers(send, nonce))

    def _fault(self, scope: Scope, headers: dict[str, list[str]]) -> str:
        """Why a request is refused whoever sends it; empty if it is not."""
        hosts = headers.get("host", [])
        if len(hosts) != 1 or hosts[0].lower() not in self._keys.hosts:
            return "Refused: the request names another host."
        own = [f"http://{host}" for host in self._keys.hosts]
        origins = headers.get("origin", [])
        if any(origin.lower() not in own for origin in origins):
            return "Refused: the request comes from another page."
        site = "".join(headers.get("sec-fetch-site", []))
        navigates = headers.get("sec-fetch-mode") == ["navigate"] and scope["method"] in SAFE
        if site in ("cross-site", "same-site") and not navigates:
            return "Refused: the request comes from another page."
        if scope["method"] not in SAFE and not origins and site != "same-origin":
            return "Refused: the request does not say which page it comes from."
        return ""

    async def _exchange(self, scope: Scope, headers: dict[str, list[str]], token: str, send: Send) -> None:
        """The token for the cookie, and the address without it."""
        keys = self._keys
        if self._has_cookie(headers):
            await _answer(send, 303, "", {"location": "/"})
        elif scope["method"] == "GET" and keys.token and _equal(token, keys.token):
            keys.token = ""
            cookie = f"{keys.cookie_name}={keys.cookie}; Path=/; HttpOnly; SameSite=Strict"
            await _answer(send, 303, "", {"location": "/", "set-cookie": cookie})
        else:
            await _answer(
                send,
                403,
                "This address is not valid, or has been used in another browser: end the studio with Ctrl-C "
                "and start it again.",
            )

    def _has_cookie(self, headers: dict[str, list[str]]) -> bool:
        try:
            found = SimpleCookie("; ".join(headers.get("cookie", []))).get(self._keys.cookie_name)
        except CookieError:
            return False
        return found is not None and _equal(found.value, self._keys.cookie)


def _equal(given: str, wanted: str) -> bool:
    return hmac.compare_digest(given.encode(), wanted.encode())


def _headers(scope: Scope) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for name, value in scope["headers"]:
        found.setdefault(name.decode("latin-1").lower(), []).append(value.decode("latin-1"))
    return found


def _token(scope: Scope) -> str | None:
    """The token that an address carries."""
    try:
        given = parse_qs(scope["query_string"].decode("latin-1"), max_num_fields=100).get("token")
    except ValueError:
        return None
    return None if given is None else given[0]


async def _answer(send: Send, status: int, words: str, more: dict[str, str] | None = None) -> None:
    """A response of the guard's own: plain text."""
    headers = {"content-type": "text/plain; charset=utf-8", "content-security-policy": "default-src 'none'"}
    headers |= HEADERS | (more or {})
    content = f"{words}\n".encode() if words else b""
    headers["content-length"] = str(len(content))
    await send({"type": "http.response.start", "status": status, "headers": _encoded(headers)})
    await send({"type": "http.response.body", "body": content})


def _with_headers(send: Send, nonce: str) -> Send:
    """Add the headers of every response; a response's own policy is kept."""

    async def _send(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            given = {name.lower() for name, _ in message["headers"]}
            wanted = HEADERS | {"content-security-policy": POLICY.format(nonce=nonce)}
            more = {name: value for name, value in wanted.items() if name.encode() not in given}
            message["headers"] = [*message["headers"], *_encoded(more)]
        await send(message)

    return _send


def _encoded(headers: dict[str, str]) -> list[tuple[bytes, bytes]]:
    return [(name.encode("latin-1"), value.encode("latin-1")) for name, value in headers.items()]


VIEWS = (
    ("machine", "Machine"),
    ("resonance", "Resonance"),
    ("logs", "Logs"),
    ("control", "Control"),
    ("studies", "Studies"),
)
_OWN = resources.files("cabledrive.studio") / "templates"
_SCRIPTS = ("studio", "machine", "resonance", "curves", "logs", "control", "work", "response", "tour")
_FILES = {
    **{f"{name}.js": ("text/javascript", (_OWN, f"{name}.js")) for name in _SCRIPTS},
    "studio.css": ("text/css", (_OWN, "studio.css")),
    "uPlot.js": ("text/javascript", (UPLOT, "uPlot.iife.min.js")),
    "uPlot.css": ("text/css", (UPLOT, "uPlot.min.css")),
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
    environment = page_environment(lambda name: (_OWN / name).read_text(encoding="utf-8"))
    environment.filters |= {"number": number, "quantity": quantity}
    return environment
