"""The house rules hold for every file, and each check finds a sample that breaks its rule."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest

import house_rules

ROOT = Path(__file__).resolve().parent.parent
SOURCES = sorted((ROOT / "src").rglob("*.py"))
LONGEST_FILE = 300  # lines
MADE = {"build", "dist", "reference", "__pycache__"}
KEPT = {".ci", ".github"}  # hidden folders of the repository; git's own and those of tools are none


@cache
def texts() -> tuple[tuple[Path, str], ...]:
    """Every text file of the repository, without what the Makefile makes."""
    return tuple(_texts())


def _texts() -> Iterator[tuple[Path, str]]:
    for path in sorted(ROOT.rglob("*")):
        parts = path.relative_to(ROOT).parts
        made = any(part in MADE or (part.startswith(".") and part not in KEPT) for part in parts[:-1])
        if not made and path.name != ".git" and path.is_file():  # a file where the clone is a worktree
            try:
                yield path, path.read_text(encoding="utf-8")
            except UnicodeDecodeError:  # a picture
                continue


@cache
def tree_of(path: Path) -> ast.Module:
    """A file of the package, parsed."""
    return ast.parse(path.read_text(encoding="utf-8"))


def in_files(pattern: re.Pattern[str]) -> list[str]:
    return [
        f"{path.relative_to(ROOT)}:{hit}"
        for path, text in texts()
        for hit in house_rules.places(pattern, text)
    ]


def functions_of(sample: str) -> dict[str, house_rules.Function]:
    return dict(house_rules.public_functions(ast.parse(sample)))


def test_no_file_names_a_package_registry():
    assert in_files(house_rules.REGISTRIES) == []


def test_no_file_names_a_path_of_one_machine():
    assert in_files(house_rules.MACHINE_PATHS) == []


def test_source_files_stay_short():
    lengths = {path.relative_to(ROOT): len(path.read_text().splitlines()) for path in SOURCES}
    assert {path: n for path, n in lengths.items() if n >= LONGEST_FILE} == {}


def test_docstrings_give_arguments_results_and_refusals_where_a_room_exports_the_name():
    """Elsewhere one sentence is enough."""
    trees = {path: tree_of(path) for path in SOURCES}
    rooms = [tree for path, tree in trees.items() if path.name == "__init__.py"]
    public = set().union(*map(house_rules.exports, rooms))
    assert ("cabledrive.modal.natural", "modes") in public
    gaps = [
        f"{path.relative_to(ROOT)}: {gap}"
        for path, tree in trees.items()
        for name, function in house_rules.public_functions(tree)
        for gap in house_rules.docstring_gaps(
            name, function, (module_of(path), name.partition(".")[0]) in public
        )
    ]
    assert not gaps, "\n".join(gaps)


def module_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT / "src").with_suffix("").parts)


def headings(source: str) -> list[str]:
    """Lines of a module's docstring that are underlined: a page of two modules has them twice."""
    lines = (ast.get_docstring(ast.parse(source)) or "").splitlines()
    return [above for above, line in pairwise(lines) if re.fullmatch(r"[-=]{3,}", line)]


def test_docstrings_of_modules_have_no_headings():
    assert [path.name for path in SOURCES if headings(path.read_text(encoding="utf-8"))] == []
    assert headings('"""What it holds.\n\nReferences\n----------\n.. [1] A book.\n"""') == ["References"]


def test_type_variables_and_aliases_have_comments_where_the_reference_cannot_format_a_string():
    found = [(path.name, house_rules.documented_types(tree_of(path))) for path in SOURCES]
    assert [(name, types) for name, types in found if types] == []
    sample = 'A = TypeVar("A")\n"""One."""\nB = tuple[int, str]\n"""Two."""\n_C = list[int]\n"""Three."""\n'
    assert house_rules.documented_types(ast.parse(sample)) == ["A", "B"]


def test_rooms_import_from_rooms_and_not_from_the_package():
    rooms = [path for path in SOURCES if path.parent.name not in ("cabledrive", "app")]
    found = {path.name: house_rules.imports_of_the_root(tree_of(path)) for path in rooms}
    assert {name: lines for name, lines in found.items() if lines} == {}


def test_every_compiled_kernel_is_run_without_the_compiler():
    """A module that compiles kernels is named in a test file that carries the marker ``kernel``."""
    tests = [path.read_text() for path in ROOT.glob("tests/**/test_*.py")]
    marked = "".join(text for text in tests if "mark.kernel" in text)
    for path in SOURCES:
        if house_rules.compiles(tree_of(path)):
            module = ".".join(path.relative_to(ROOT / "src").with_suffix("").parts)
            assert module in marked, f"{module}: no test with the marker kernel names it"


@pytest.mark.parametrize(
    "line, compiled",
    [("@numba.njit(cache=True)\ndef f(): ...", True), ("g = njit(f)", True), ("def f(): ...", False)],
)
def test_a_module_that_compiles_is_found(line, compiled):
    assert house_rules.compiles(ast.parse(line)) == compiled


@pytest.mark.parametrize(
    "line",
    ["see https://py" + "pi.org/project", "pip install --index" + "-url x", "--find" + "-links wheels"],
)
def test_a_registry_is_found(line):
    assert house_rules.places(house_rules.REGISTRIES, line)


@pytest.mark.parametrize(
    "folder", ["ho" + "me/a", "ro" + "ot/x", "wo" + "rk/a", "tm" + "p/x", "Us" + "ers/a"]
)
def test_a_path_of_one_machine_is_found(folder):
    assert house_rules.places(house_rules.MACHINE_PATHS, f'open("/{folder}")')


@pytest.mark.parametrize(
    "text", ["../shared/data/x", "#!/usr/bin/env bash", "https://a.org/home/page", "1/work/2"]
)
def test_other_paths_are_let_pass(text):
    assert house_rules.places(house_rules.MACHINE_PATHS, text) == []


SAMPLE = '''
def told(x: float) -> float:
    """Double.

    Parameters
    ----------
    x : float
        Length [m].

    Returns
    -------
    float
        Twice the length [m].
    """
    return 2 * x

def untold(x: float) -> float:
    """Double."""
    if x < 0:
        raise ValueError(x)
    return 2 * x

def bare(): ...

@njit(cache=True)
def kernel(x, out):
    """Compiled twin of `told`."""

class Span:
    @property
    def wave_speed(self) -> float:
        """Wave speed [m/s]."""

    def half(self) -> float:
        """Half of it."""
'''


@pytest.mark.parametrize(
    "name, gaps",
    [
        ("told", []),
        ("untold", ["untold: no x under Parameters", "untold: no Returns", "untold: no Raises"]),
        ("bare", ["bare has no docstring"]),
        ("kernel", []),
        ("Span.wave_speed", []),
        ("Span.half", ["Span.half: no Returns"]),
    ],
)
def test_gaps_of_a_docstring_are_found(name, gaps):
    assert house_rules.docstring_gaps(name, functions_of(SAMPLE)[name]) == gaps


@pytest.mark.parametrize(
    "line, taken",
    [
        ("import cabledrive", True),
        ("from cabledrive import natural_frequencies", True),
        ("from .cable import Cable", True),
        ("from cabledrive import __version__", False),
        ("from cabledrive.parameters.cable import Cable", False),
    ],
)
def test_imports_of_the_package_itself_are_found(line, taken):
    assert bool(house_rules.imports_of_the_root(ast.parse(line))) == taken
