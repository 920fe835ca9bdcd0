"""Studios for a test, ended after it."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from studio_here import Studio


@pytest.fixture
def make_studio(tmp_path: Path) -> Iterator[Callable[..., Studio]]:
    made: list[Studio] = []

    def _make(source: str | None = None) -> Studio:
        made.append(Studio(tmp_path / "folder", source))
        return made[-1]

    yield _make
    for studio in made:
        studio.run(studio.desk.jobs.end())
        studio.run(studio.loop.shutdown_asyncgens())  # a request refused half-read leaves its stream open
        studio.loop.close()


@pytest.fixture
def studio(make_studio: Callable[..., Studio]) -> Studio:
    return make_studio("dissertation-3")
