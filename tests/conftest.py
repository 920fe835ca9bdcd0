"""What all tests share: measured logs, where they are present, a repeatable Hypothesis, and figures noted."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parent.parent
SHARED_DATA = ROOT.parent / "shared" / "data"

settings.register_profile("deterministic", derandomize=True, deadline=None, database=None, print_blob=True)
settings.load_profile("deterministic")


@pytest.fixture(scope="session")
def shared_data() -> Callable[[str], Path]:
    """Path of a measured log, by its name below ``../shared/data``; skips the test where it is absent."""

    def path_of(name: str) -> Path:
        path = SHARED_DATA / name
        if not path.exists():
            pytest.skip(f"needs the measured log ../shared/data/{name}, which is not here")
        return path

    return path_of


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--figures", action="store_true", help="print what each test measured, at the end")


@pytest.fixture
def measured(record_property: Callable[[str, object], None]) -> Callable[[str], None]:
    """Note a figure of docs/validation.md, before it is judged; ``make verify`` prints all of them."""
    return partial(record_property, "measured")


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    if not config.getoption("--figures"):
        return
    terminalreporter.section("figures measured")
    ended = [*terminalreporter.getreports("passed"), *terminalreporter.getreports("failed")]
    for report in sorted(ended, key=lambda one: one.nodeid):
        for name, words in report.user_properties:
            if name == "measured" and report.when == "call":
                terminalreporter.line(f"{report.nodeid.removeprefix('tests/')}: {words}")
