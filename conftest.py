"""What all folders of tests share: figures noted, printed by ``make verify``; the fast ones."""

from collections.abc import Callable
from functools import partial

import pytest

pytest_plugins = ["every_kernel"]

SLOW = 0.5
"""Seconds from which on a test is none of the fast ones."""
SECONDS_BY_TEST = "cabledrive/seconds"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--figures", action="store_true", help="print what each test measured, at the end")
    parser.addoption(
        "--fast", action="store_true", help=f"leave out what took {SLOW:.1g} s or more last time"
    )


@pytest.fixture
def measured(record_property: Callable[[str, object], None]) -> Callable[[str], None]:
    """Note a figure of tests/validation.md, before it is judged; ``make verify`` prints all of them."""
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


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if not config.getoption("--fast"):
        return
    known = config.cache.get(SECONDS_BY_TEST, {})
    slow = [item for item in items if known.get(item.nodeid, 0.0) >= SLOW]
    config.hook.pytest_deselected(items=slow)
    items[:] = [item for item in items if known.get(item.nodeid, 0.0) < SLOW]


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Keep how long each test took, its fixtures left out; with workers, the controller alone does."""
    reporter = session.config.pluginmanager.getplugin("terminalreporter")
    if reporter is None or hasattr(session.config, "workerinput"):
        return
    ended = [*reporter.getreports("passed"), *reporter.getreports("failed")]
    took = {report.nodeid: round(report.duration, 2) for report in ended if report.when == "call"}
    known = session.config.cache.get(SECONDS_BY_TEST, {})
    session.config.cache.set(SECONDS_BY_TEST, known | took)
