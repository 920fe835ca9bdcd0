"""What all folders of tests share: the figures that they measure and ``make verify`` keeps; the fast ones."""

import ast
import hashlib
import json
import re
from collections.abc import Callable
from datetime import date
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest

pytest_plugins = ["every_kernel"]

SLOW = 0.5
"""Seconds from which on a test is none of the fast ones."""
SECONDS_BY_TEST = "cabledrive/seconds"
HERE = Path(__file__).resolve().parent
KEPT, TABLE = HERE / "build" / "verify.jsonl", HERE / "tests" / "figures.md"
PATHS = (HERE, HERE / "tests", HERE / "tools")
PASSED = pytest.StashKey[frozenset[str]]()
"""Tests that `--resume` leaves out."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--figures", action="store_true", help="print what each test measured, at the end")
    parser.addoption(
        "--resume",
        action="store_true",
        help=f"leave out what passed before and imports the same sources, by {KEPT.relative_to(HERE)}; "
        f"write {TABLE.relative_to(HERE)}",
    )
    parser.addoption(
        "--fast", action="store_true", help=f"leave out what took {SLOW:.1g} s or more last time"
    )


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("--resume"):
        handed = getattr(config, "workerinput", {}).get("passed")
        config.stash[PASSED] = frozenset(
            handed
            if handed is not None
            else (one["test"] for one in kept_runs() if one["passed"] and one["now"])
        )


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """All workers leave out the same tests, those that begin late too."""
    node.workerinput["passed"] = sorted(node.config.stash.get(PASSED, ()))


@cache
def digest(file: str) -> str:
    """Of what a file of tests may depend on: all that it imports, or everything where it starts processes."""
    from cabledrive.mechanics.sources import digest_with_imports

    found: set[Path] = set()
    waiting = [HERE / file, HERE / "conftest.py", HERE / "tests" / "conftest.py"]
    while waiting:
        path = waiting.pop()
        found.add(path)
        waiting += [own for own in helpers_of(path) if own not in found]
    if any("subprocess" in path.read_text(encoding="utf-8") for path in found - {HERE / "conftest.py"}):
        found |= {path for name in ("src", "tests", "reproduction") for path in (HERE / name).rglob("*.py")}
    with TemporaryDirectory() as folder:
        parts = [digest_with_imports(plainly(path, Path(folder))) for path in sorted(found)]
    return hashlib.sha256("".join(parts).encode()).hexdigest()[:16]


def plainly(path: Path, folder: Path) -> Path:
    """A copy of a file that imports what it takes from ``cd``, the whole package, from where that is."""
    text = path.read_text(encoding="utf-8")
    used = set(re.findall(r"\bcd\.(\w+)", text))
    lines = [f"from {module} import {name}" for module, name in names_of_package() if name in used]
    copy = folder / path.name
    copy.write_text(text.replace("import cabledrive as cd", "\n".join(lines)), encoding="utf-8")
    return copy


@cache
def names_of_package() -> list[tuple[str, str]]:
    """Module and name of all that ``cd`` holds."""
    tree = ast.parse((HERE / "src" / "cabledrive" / "__init__.py").read_text(encoding="utf-8"))
    found = (node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom))
    return [(str(one.module), own.name) for one in found for own in one.names]


def helpers_of(path: Path) -> set[Path]:
    """Files of the tests and tools that a file imports."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {one.name for one in node.names}
        elif isinstance(node, ast.ImportFrom):
            names |= {f"{node.module}.{one.name}" for one in node.names} | {node.module or ""}
    places = (folder / f"{name.replace('.', '/')}.py" for name in names for folder in PATHS)
    return {place for place in places if place.is_file()}


def kept_runs() -> list[dict[str, Any]]:
    """The last run of each test, and whether its sources are as they were."""
    lines = KEPT.read_text(encoding="utf-8").splitlines() if KEPT.is_file() else []
    last = {one["test"]: one for one in map(json.loads, lines)}
    known = (one for one in last.values() if (HERE / file_of(one["test"])).is_file())
    return [one | {"now": one["sources"] == digest(file_of(one["test"]))} for one in known]


def file_of(test: str) -> str:
    return test.partition("::")[0]


@pytest.fixture
def measured(record_property: Callable[[str, object], None]) -> Callable[[str], None]:
    """Note a figure of tests/validation.md, before it is judged; ``make verify`` prints all of them."""
    return partial(record_property, "measured")


def figures_of(report: Any) -> list[str]:
    return [words for name, words in report.user_properties if name == "measured"]


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    ended = [*terminalreporter.getreports("passed"), *terminalreporter.getreports("failed")]
    ended = [report for report in ended if report.when == "call"]
    if config.getoption("--figures"):
        terminalreporter.section("figures measured")
        for report in sorted(ended, key=lambda one: one.nodeid):
            for words in figures_of(report):
                terminalreporter.line(f"{report.nodeid.removeprefix('tests/')}: {words}")
    if config.getoption("--resume"):
        TABLE.write_text(table(kept_runs()), encoding="utf-8")
        terminalreporter.line(f"written to {TABLE.relative_to(HERE)}")


class Keeper:
    """Writes down each test as it ends; with workers, in the controller alone."""

    def __init__(self) -> None:
        KEPT.parent.mkdir(exist_ok=True)
        self._file = KEPT.open("a", encoding="utf-8")

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if (report.when == "call" and not report.skipped) or report.failed:
            said: dict[str, Any] = {"passed": report.passed, "seconds": round(report.duration, 1)}
            said |= {"figures": figures_of(report), "day": str(date.today())}
            said |= {"sources": digest(file_of(report.nodeid))}
            self._file.write(json.dumps({"test": report.nodeid} | said) + "\n")
            self._file.flush()


def pytest_sessionstart(session: pytest.Session) -> None:
    if session.config.getoption("--resume") and not hasattr(session.config, "workerinput"):
        session.config.pluginmanager.register(Keeper())


def table(runs: list[dict[str, Any]]) -> str:
    """What the tests measured, a line each, when, and which failed."""
    failed = [f"- `{one['test']}`" for one in runs if not one["passed"]]
    hours, older = sum(one["seconds"] for one in runs) / 3600, sum(not one["now"] for one in runs)
    lines = [
        "# Figures of the last `make verify`",
        "",
        f"{len(runs) - len(failed)} of {len(runs)} tests passed, {hours:.1f} hours of one core. "
        f"Older: {older}, since a file has changed that they import.",
        "",
        *([*failed, ""] if failed else []),
        "| test | measured | on |",
        "|---|---|---|",
    ]
    lines += [
        f"| `{one['test'].removeprefix('tests/').replace('|', ' or ')}` | {words.replace('|', ' or ')} "
        f"| {one['day']}{'' if one['now'] else ', older'} |"
        for one in sorted(runs, key=lambda one: str(one["test"]))
        for words in one["figures"]
    ]
    return "\n".join(lines) + "\n"


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    passed = config.stash.get(PASSED, frozenset())
    known = config.cache.get(SECONDS_BY_TEST, {}) if config.getoption("--fast") else {}
    left_out = {item.nodeid for item in items if item.nodeid in passed or known.get(item.nodeid, 0.0) >= SLOW}
    config.hook.pytest_deselected(items=[item for item in items if item.nodeid in left_out])
    items[:] = [item for item in items if item.nodeid not in left_out]


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Keep how long each test took, its fixtures left out; with workers, the controller alone does."""
    reporter = session.config.pluginmanager.getplugin("terminalreporter")
    if reporter is None or hasattr(session.config, "workerinput"):
        return
    ended = [*reporter.getreports("passed"), *reporter.getreports("failed")]
    took = {report.nodeid: round(report.duration, 2) for report in ended if report.when == "call"}
    known = session.config.cache.get(SECONDS_BY_TEST, {})
    session.config.cache.set(SECONDS_BY_TEST, known | took)
