"""``--every-kernel``: marked tests, run without the compiler, enter every kernel, or the run ends red.

A function that `cabledrive.mechanics.compiled` would compile gets one statement more, which notes that it was
entered. Each worker hands over what it noted; the names of the kernels that nobody entered are printed.
"""

import ast
import builtins
import importlib
from functools import cache
from pathlib import Path

import pytest

from other_code import codes, place_of, text_of

SOURCES = Path(__file__).resolve().parent.parent / "src"
KNOWN: set[str] = set()
ENTERED: set[str] = set()


def pytest_addoption(parser):
    parser.addoption("--every-kernel", action="store_true", help="marked tests have to enter every kernel")


def pytest_configure(config):
    if config.getoption("--every-kernel"):
        compiled = importlib.import_module("cabledrive.mechanics.compiled")
        assert not compiled.numba_at_hand(), "--every-kernel needs NUMBA_DISABLE_JIT=1"
        builtins.__dict__["kernel_entered"] = ENTERED.add
        compiled._compile = noting


def noting(function, *options, **more):
    """A kernel as plain Python that notes when it is entered; those of tests are left as they are."""
    if SOURCES not in Path(function.__code__.co_filename).parents:
        return function
    KNOWN.add(name_of(function))
    function.__code__ = noting_codes(function.__code__.co_filename)[place_of(function)]
    return function


def name_of(function):
    return f"{function.__module__}.{function.__qualname__}"


@cache
def noting_codes(file):
    module = ".".join(Path(file).relative_to(SOURCES).with_suffix("").parts)
    tree = ast.parse(text_of(file))
    note_in(tree, f"{module}.")
    return codes(ast.fix_missing_locations(tree), file)


def note_in(tree, prefix):
    """Put the statement behind the docstring of each function, under its qualified name."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef):
            note = ast.parse(f"kernel_entered({prefix + node.name!r})").body
            for part in ast.walk(note[0]):
                ast.copy_location(part, node.body[0])
            start = 1 if ast.get_docstring(node) is not None else 0
            node.body[start:start] = note
            note_in(node, f"{prefix}{node.name}.<locals>.")
        else:
            note_in(node, f"{prefix}{node.name}." if isinstance(node, ast.ClassDef) else prefix)


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    """In the controller: a worker has ended."""
    known, entered = getattr(node, "workeroutput", {}).get("kernels", ((), ()))
    KNOWN.update(known)
    ENTERED.update(entered)


@pytest.hookimpl(tryfirst=True)
def pytest_sessionfinish(session):
    config = session.config
    if not config.getoption("--every-kernel"):
        return
    if hasattr(config, "workeroutput"):
        config.workeroutput["kernels"] = (sorted(KNOWN), sorted(ENTERED))
        return
    for path in sorted(SOURCES.rglob("*.py")):
        if "mechanics.compiled import" in text_of(str(path)):
            importlib.import_module(".".join(path.relative_to(SOURCES).with_suffix("").parts))
    if KNOWN - ENTERED and not session.exitstatus:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter, config):
    if config.getoption("--every-kernel"):
        for name in sorted(KNOWN - ENTERED):
            terminalreporter.line(f"no test with the marker kernel enters {name}", red=True)
        terminalreporter.line(f"kernels entered: {len(KNOWN & ENTERED)} of {len(KNOWN)}")
