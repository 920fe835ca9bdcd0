"""Where a module is tested: ``python tests/where_tested.py cabledrive.modal.band``.

A test file names a module when it imports from it, writes its path, or calls the command that it holds. A
module that none names is tested through the modules that use it: those of its own room first, followed to the
nearest named.
"""

import ast
import re
import sys
from collections import defaultdict
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DOTTED = re.compile(r"cabledrive(?:\.\w+)+")
CALLED = re.compile(r"\b(?:call|answer|run|started)\(\s*\"(\w+)\"")

BY_NAME = {
    "cabledrive.app.commands": "tests/app/test_shared_options.py",
    "cabledrive.dissertation": "tests/dissertation/test_reproduction.py",
    "cabledrive.report.chapters": "tests/report/test_chapters.py",
    "cabledrive.studio": "tests/studio/test_views.py",
}
"""Folders whose modules are found by name, with the test that goes through all of them."""


def imported(tree: ast.AST) -> set[str]:
    """Dotted paths that a file imports, with the names taken from them."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{name.name}" for name in node.names)}
        elif isinstance(node, ast.Import):
            found |= {name.name for name in node.names}
    return found


@cache
def modules() -> dict[str, Path]:
    """Every module of the package that is no ``__init__``, by its dotted path."""
    paths = (ROOT / "src" / "cabledrive").rglob("*.py")
    named = {".".join(p.relative_to(ROOT / "src").with_suffix("").parts): p for p in paths}
    return {name: path for name, path in named.items() if not path.name.startswith("__")}


@cache
def users() -> dict[str, set[str]]:
    """Modules that import each module; what a folder exports is used by those that import the folder."""
    found = defaultdict(set)
    for name in modules():
        found[name] |= {folder for folder in BY_NAME if name.startswith(f"{folder}.")}
    for path in (ROOT / "src" / "cabledrive").rglob("*.py"):
        dotted = ".".join(path.relative_to(ROOT / "src").with_suffix("").parts).removesuffix(".__init__")
        for name in imported(ast.parse(path.read_text(encoding="utf-8"))):
            found[name].add(dotted)
    return found


@cache
def tests_of() -> dict[str, set[str]]:
    """Test files by the dotted paths that they name."""
    found = defaultdict(set, {folder: {test} for folder, test in BY_NAME.items()})
    for path in sorted((ROOT / "tests").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        called = {f"cabledrive.app.commands.{name}" for name in CALLED.findall(text)}
        if path.stem.removeprefix("test_") != "where_tested":
            for name in imported(ast.parse(text)) | set(DOTTED.findall(text)) | called:
                found[name].add(path.relative_to(ROOT).as_posix())
    return found


def nearest(module: str, room: str) -> set[str]:
    """Test files nearest to a module among its users whose paths begin with a room."""
    seen, level = {module}, {module}
    while level:
        files = set().union(*(tests_of()[name] for name in level))
        if files:
            return files
        level = {user for name in level for user in users()[name] if user.startswith(room)} - seen
        seen |= level
    return set()


def where(module: str) -> set[str]:
    """Test files nearest to a module, in its own room where there are any."""
    room = ".".join(module.split(".")[:2])
    return nearest(module, room) or nearest(module, "cabledrive")


if __name__ == "__main__":
    for asked in sys.argv[1:]:
        print(asked, *sorted(where(asked)) or ["no test"], sep="\n  ")
