"""What all folders of tests share: figures noted, and printed by ``make verify``."""

from collections.abc import Callable
from functools import partial

import pytest


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
