"""A studio inside the test's own process, ended after it, and a client that a browser could be."""

import asyncio

import httpx
import pytest

from cabledrive.studio.application import application
from cabledrive.studio.guard import Keys
from cabledrive.studio.library import Library
from cabledrive.studio.state import first_state

PORT = 5999
ORIGIN = f"http://127.0.0.1:{PORT}"


class Studio:
    """The application with its keys; every call runs in one event loop, as in the server."""

    def __init__(self, folder, source=None):
        self.folder, self.keys, self.library = folder, Keys(PORT), Library(folder)
        self.app = application(self.library, self.keys, first_state(self.library, source), warm=False)
        self.loop = asyncio.new_event_loop()

    @property
    def desk(self):
        return self.app._app.state.desk

    def run(self, work):
        return self.loop.run_until_complete(asyncio.wait_for(work, 120))

    def client(self, **options):
        return httpx.AsyncClient(transport=httpx.ASGITransport(self.app), base_url=ORIGIN, **options)

    def ask(self, method, address, *, key=True, **options):
        headers = {"cookie": f"{self.keys.cookie_name}={self.keys.cookie}"} if key else {}
        if method not in ("GET", "HEAD"):
            headers["origin"] = ORIGIN
        headers |= options.pop("headers", {})

        async def _ask():
            async with self.client() as client:
                return await client.request(method, address, headers=headers, **options)

        return self.run(_ask())

    def get(self, address, **options):
        return self.ask("GET", address, **options)

    def post(self, address, **options):
        return self.ask("POST", address, **options)


@pytest.fixture
def make_studio(tmp_path):
    made = []

    def _make(source=None):
        made.append(Studio(tmp_path / "folder", source))
        return made[-1]

    yield _make
    for studio in made:
        studio.run(studio.desk.jobs.end())
        studio.run(studio.loop.shutdown_asyncgens())  # a request refused half-read leaves its stream open
        studio.loop.close()


@pytest.fixture
def studio(make_studio):
    return make_studio("dissertation-3")
