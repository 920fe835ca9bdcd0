"""A studio inside the test's own process, and a client that a browser could be."""

import asyncio
from collections.abc import Coroutine
from pathlib import Path
from typing import Any

import httpx

from cabledrive.studio.application import application
from cabledrive.studio.guard import Guard, Keys
from cabledrive.studio.library import Library
from cabledrive.studio.state import first_state

PORT = 5999
ORIGIN = f"http://127.0.0.1:{PORT}"


class Studio:
    """The application with its keys; every call runs in one event loop, as in the server."""

    def __init__(self, folder: Path, source: str | None = None) -> None:
        self.folder, self.keys, self.library = folder, Keys(PORT), Library(folder)
        self.app: Guard = application(self.library, self.keys, first_state(self.library, source), warm=False)
        self.loop = asyncio.new_event_loop()

    @property
    def desk(self) -> Any:
        return self.app._app.state.desk

    def run(self, work: Coroutine[Any, Any, Any]) -> Any:
        return self.loop.run_until_complete(asyncio.wait_for(work, 120))

    def client(self, **options: Any) -> httpx.AsyncClient:
        return httpx.AsyncClient(transport=httpx.ASGITransport(self.app), base_url=ORIGIN, **options)

    def ask(self, method: str, address: str, *, key: bool = True, **options: Any) -> httpx.Response:
        headers = ({"cookie": f"{self.keys.cookie_name}={self.keys.cookie}"} if key else {}) | options.pop(
            "headers", {}
        )
        if method not in ("GET", "HEAD"):
            headers = {"origin": ORIGIN} | headers

        async def _ask() -> httpx.Response:
            async with self.client() as client:
                return await client.request(method, address, headers=headers, **options)

        return self.run(_ask())

    def get(self, address: str, **options: Any) -> httpx.Response:
        return self.ask("GET", address, **options)

    def post(self, address: str, **options: Any) -> httpx.Response:
        return self.ask("POST", address, **options)
