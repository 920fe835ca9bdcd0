"""House rules that no other tool knows, and what the pages of the documentation name.

Prints each breach as ``path:line: what`` and ends with status 1 if there is one. `make lint` runs it.
"""

import ast
import importlib
import inspect
import pkgutil
import re
import shlex
import subprocess
import sys
import tomllib
import warnings
from collections.abc import Iterator
from functools import cache, cached_property
from importlib.metadata import packages_distributions
from pathlib import Path
from types import ModuleType

import click
from numpydoc.docscrape import NumpyDocString

import cabledrive
from cabledrive.app.main import main
from cabledrive.parameters import InputRefused
from cabledrive.parameters.version import __version__

ROOT = Path(__file__).resolve().parent.parent
DOCS, PACKAGE = ROOT / "docs", ROOT / "src" / "cabledrive"
SOURCES = sorted((ROOT / "src").rglob("*.py"))
BESIDE = ROOT / "reproduction"
PAGES = sorted(
    page
    for folder in (ROOT, DOCS, BESIDE, ROOT / "tests", ROOT / "benchmarks")
    for page in folder.glob("*.md")
)
ERRATA = BESIDE / "errata.md"
EQUATIONS = BESIDE / "equations.md"
sys.path.append(str(ROOT))  # the reproduction
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
LONGEST_FILE = 400  # lines

# Split, so that this file does not break the rule it states.
REGISTRIES = re.compile(
    r"pypi\.o"
    r"rg|pythonhosted\.o"
    r"rg|anaconda\.o"
    r"rg|npmjs\.o"
    r"rg|--(extra-)?index"
    r"-url|--find"
    r"-links"
)
MACHINE_PATHS = re.compile(r"(?<![\w.>}\]])(/(home|root|work|tmp|opt|Users)|[A-Z]:\\+\w+)(/|\\+)\w")
SPAN = re.compile(r"(?<!`)`([^`\n]+)`(?!`)")
SHOWN = re.compile(r"^\$ (.+?)(?:  +#.*)?$")
TEST = re.compile(r"((?:tests|reproduction|tools)/[\w/]+\.py)?(?:::(\w+))?")
REFUSED_ON_PURPOSE = {"modes elevator --belo 20"}
"""Commands that a page shows with the line that refuses them."""

Breach = tuple[Path, int, str]


@cache
def text_of(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(text_of(path))


@cache
def imports_of(path: Path) -> list[ast.Import | ast.ImportFrom]:
    return [node for node in ast.walk(tree_of(path)) if isinstance(node, ast.Import | ast.ImportFrom)]


def lines_of(path: Path) -> Iterator[tuple[int, str]]:
    return enumerate(text_of(path).splitlines(), start=1)


# --- every text file and every source ---------------------------------------------------------------------


def foreign_addresses() -> Iterator[Breach]:
    """Registries and paths of one machine, in any text file that the repository keeps or will keep."""
    listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    for path in (ROOT / name for name in names):
        try:
            lines = [*lines_of(path)] if path.is_file() else []
        except UnicodeDecodeError:  # a picture
            continue
        for number, line in lines:
            if REGISTRIES.search(line):
                yield path, number, "names a package registry"
            if found := MACHINE_PATHS.search(line):
                yield path, number, f"names a path of one machine, {found[0]}"


def sources() -> Iterator[Breach]:
    """Length, and imports from the package itself instead of from a room."""
    for path in SOURCES:
        if len(text_of(path).splitlines()) >= LONGEST_FILE:
            yield path, LONGEST_FILE, f"has {LONGEST_FILE} lines or more"
        if path.parent.name in ("cabledrive", "app"):
            continue
        for node in imports_of(path):
            whole = isinstance(node, ast.Import) and "cabledrive" in [name.name for name in node.names]
            part = isinstance(node, ast.ImportFrom) and (node.level or node.module == "cabledrive")
            if whole or (part and [name.name for name in node.names] != ["__version__"]):
                yield path, node.lineno, "imports from the package itself, not from a room"


def names_given_twice() -> Iterator[Breach]:
    """A name of a module that is assigned twice loses its first value for whoever meant that."""
    for path in SOURCES:
        given = [
            (target.id, node.lineno)
            for node in tree_of(path).body
            if isinstance(node, ast.Assign | ast.AnnAssign)
            for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
            if isinstance(target, ast.Name)
        ]
        seen = set[str]()
        for name, line in given:
            if name in seen:
                yield path, line, f"{name} is given a second time: call one of the two by another name"
            seen.add(name)


def tests() -> Iterator[Breach]:
    """What tests share stands in modules of its own; pytest finds a test by the name of its file."""
    names: dict[str, Path] = {}
    for path in [*(ROOT / "tests").rglob("*.py"), *(ROOT / "reproduction").rglob("*.py")]:
        if path.name.startswith("test_") and names.setdefault(path.name, path) != path:
            yield path, 1, f"has the name of {names[path.name].relative_to(ROOT)}"
        taken = [number for number, line in lines_of(path) if re.match(r"(from|import) test_", line)]
        if taken and any(node.lineno in taken for node in imports_of(path)):  # else in a string
            yield path, taken[0], "takes code out of another test"


def docstrings() -> Iterator[Breach]:
    """What a room exports tells its arguments, its result and its refusals."""
    public = {
        (node.module, name.name)
        for path in SOURCES
        if path.name == "__init__.py" and len(path.relative_to(ROOT).parts) <= 4  # of the package or a room
        for node in tree_of(path).body
        if isinstance(node, ast.ImportFrom)
        for name in node.names
        if re.search(rf'"{name.name}"', text_of(path))  # in __all__
    }
    for path in SOURCES:
        module = ".".join(path.relative_to(ROOT / "src").with_suffix("").parts)
        for node in tree_of(path).body:
            if (module, getattr(node, "name", "")) not in public or node.name.startswith("_"):
                continue
            inherited = set()  # what a base class tells holds for what overrides it
            if isinstance(node, ast.ClassDef):
                inherited = {
                    name for base in getattr(modules()[module], node.name).__mro__[1:] for name in vars(base)
                }
            for part in node.body if isinstance(node, ast.ClassDef) else [node]:
                if (
                    isinstance(part, ast.FunctionDef)
                    and not part.name.startswith("_")
                    and part.name not in inherited
                ):
                    yield from ((path, part.lineno, f"{part.name}: {gap}") for gap in docstring_gaps(part))


def docstring_gaps(function: ast.FunctionDef) -> Iterator[str]:
    calls = [one.func if isinstance(one, ast.Call) else one for one in function.decorator_list]
    decorators = {getattr(one, "attr", getattr(one, "id", "")) for one in calls}
    told_elsewhere = {"property", "cached_property", "setter", "command", "group", "overload"}
    compiled = any(name.startswith(("njit", "vectorize", "guvectorize")) for name in decorators)
    if compiled or decorators & told_elsewhere or function.name.endswith("_reference"):
        return
    doc = NumpyDocString(ast.get_docstring(function) or "None.")
    told = [*doc["Parameters"], *doc["Other Parameters"]]
    described = {part.strip().lstrip("*") for one in told for part in one.name.split(",")} | {"self", "cls"}
    a = function.args
    for argument in [*a.posonlyargs, *a.args, *a.kwonlyargs, *filter(None, [a.vararg, a.kwarg])]:
        if argument.arg not in described and not argument.arg.startswith("_"):
            yield f"no {argument.arg} under Parameters"
    returned = function.returns
    nothing = returned is None or (isinstance(returned, ast.Constant) and returned.value is None)
    if not nothing and not (doc["Returns"] or doc["Yields"]):
        yield "no Returns"
    if any(isinstance(node, ast.Raise) and node.exc for node in ast.walk(function)) and not doc["Raises"]:
        yield "no Raises"


@cache
def modules() -> dict[str, ModuleType]:
    names = ["cabledrive", *(one.name for one in pkgutil.walk_packages(cabledrive.__path__, "cabledrive."))]
    return {name: importlib.import_module(name) for name in names if not name.endswith("__main__")}


def hidden_modules() -> Iterator[Breach]:
    """``import cabledrive.modal.tuning as t`` follows attributes: each has to be the module."""
    for name, module in modules().items():
        found = cabledrive
        for part in name.split(".")[1:]:
            found = getattr(found, part)
        if found is not module:
            yield Path(module.__file__ or ""), 1, f"{name} is hidden by {found!r}"


# --- what pages name --------------------------------------------------------------------------------------


@cache
def functions_of(file: Path) -> dict[str, ast.FunctionDef]:
    return {node.name: node for node in tree_of(file).body if isinstance(node, ast.FunctionDef)}


def named_tests(page: Path) -> Iterator[tuple[int, str, str | None]]:
    """Line, file and function; one without a file is of the line's file, or of that named for its table."""
    common = re.search(r"`(tests/\S+)` unless another test is named", text_of(page))
    for number, line in lines_of(page):
        file = common[1] if common else ""
        for span in SPAN.findall(line):
            if (found := TEST.fullmatch(span)) and any(found.groups()):
                file = found[1] or file
                yield number, file, found[2]


def pages() -> Iterator[Breach]:
    """Tests, benchmark cases, targets, names and commands on a page are there; nothing is run."""
    targets = set(re.findall(r"^(\w+):", text_of(ROOT / "Makefile"), re.M))
    for page in PAGES:
        for number, file, name in named_tests(page):
            path = ROOT / file
            if not path.is_file() or (name and name not in functions_of(path)):
                yield page, number, f"no test {file}" + (f"::{name}" if name else "")
        for number, line in lines_of(page):
            spans = SPAN.findall(line)
            for span in [*spans, *SHOWN.findall(line)]:
                if (found := re.fullmatch(r"make (\w+)", span)) and found[1] not in targets:
                    yield page, number, f"no target {found[1]}"
                if (found := re.match(r"cabledrive ([a-z].*)", span)) and not reads(found[1]):
                    yield page, number, f"not a command: {span}"
                cases = re.fullmatch(r"python benchmarks/run\.py ([\w ]+)", span)
                for case in cases[1].split() if cases else ():
                    if not (ROOT / "benchmarks" / f"case_{case}.py").exists():
                        yield page, number, f"no case {case}"
            for name in (span for span in spans if re.fullmatch(r"cabledrive(\.\w+)+", span)):
                if found := unresolved(name):
                    yield page, number, found


def reads(shown: str) -> bool:
    """Whether a command knows the options and takes their values; a sentence may leave some out."""
    arguments = re.sub(r"[][]|\.{3}|<\w+>", "", shown)  # what stands in brackets may be left out
    name, *rest = shlex.split(arguments)
    command = main.get_command(click.Context(main), name)
    if command is None:
        return False
    try:
        command.make_context("cabledrive", rest)
    except click.MissingParameter:
        return True
    except (click.UsageError, InputRefused):
        return arguments in REFUSED_ON_PURPOSE
    return True


def unresolved(name: str) -> str:
    try:
        pkgutil.resolve_name(name)
    except (ImportError, AttributeError):
        return f"no {name}"
    return ""


def figures() -> Iterator[Breach]:
    """Each test that the table of claims names notes what it measures."""
    page = ROOT / "tests" / "validation.md"
    for number, file, name in named_tests(page):
        noting = {
            test
            for test, node in functions_of(ROOT / file).items()
            if "measured" in [argument.arg for argument in node.args.args]
        }
        if not noting or (name and name not in noting):
            yield page, number, f"{file}::{name or ''} does not take `measured`"


def errata() -> Iterator[Breach]:
    """Each entry has an anchor of a known kind and its lines; it and its tests and items name one another."""
    second = {"erratum": "Correct", "confirmed": "Correct", "convention": "Here", "number": "Computed"}
    found, seen = set(), set()
    rows = (row for entry in importlib.import_module("reproduction.items").entries() for row in entry.rows)
    reasons = {row.id: " ".join(row.words.values()) for row in rows}
    text = re.sub(r"<!--.*?-->", lambda one: "\n" * one[0].count("\n"), text_of(ERRATA), flags=re.S)
    for item in re.finditer(r"^(?:\(([\w-]+)\)=\n)?### .*\n((?:(?!^\(|^#).*\n?)*)", text, re.M):
        number, anchor = text.count("\n", 0, item.start()) + 1, item[1] or ""
        entries = dict(re.findall(r"^- ([A-Z][a-z ]+):\s+((?:.|\n  )+)", item[2], re.M))
        kind = second.get(anchor.partition("-")[0])
        if kind is None or anchor in seen:
            yield ERRATA, number, "an item needs an anchor of a known kind, used once"
        elif missing := [one for one in ("Printed", kind, "Why", "Checked by") if one not in entries]:
            yield ERRATA, number, f"{anchor} has no {', '.join(missing)}"
        seen.add(anchor)
        checks = entries.get("Checked by", "").strip()
        named = re.findall(r"`(reproduction/test_\w+\.py)::(test_\w+)`", checks)
        items = re.findall(r"item `([\w-]+)`", checks)
        for missing in (one for one in items if f"#{anchor}" not in reasons.get(one, "")):
            yield ERRATA, number, f"{anchor} names {missing}, which is no item or does not name it"
        if not named and not items and not checks.startswith("`tests/") and checks != "reading":
            yield ERRATA, number, f"{anchor} names no test and does not say reading"
        found |= {(anchor, file, name) for file, name in named}
    cited = set()
    for path in sorted((ROOT / "reproduction").glob("test_*.py")):
        for name, node in functions_of(path).items():
            file, words = path.relative_to(ROOT).as_posix(), ast.get_docstring(node) or ""
            cited |= {
                (one, file, name) for one in re.findall(rf"`((?:{'|'.join(second)})-[a-z0-9-]+)`", words)
            }
    for anchor, file, name in found ^ cited:
        yield ROOT / file, 1, f"{name} and {anchor} do not name one another"


# --- equations --------------------------------------------------------------------------------------------

NUMBER = r"\(\s*((?:\d+|[A-Z])\.\d+[a-z]?)\s*\)"
RANGE = re.compile(rf"{NUMBER}(?:\s*(?:-|–|to)\s*{NUMBER})?")
NAMED = re.compile(rf"Eqs?\.\s+({NUMBER}(?:(?:\s*[-–,]\s*|\s*,?\s+(?:and|to)\s+){NUMBER})*)")
LAST_IN_PRINT = {"2": 39, "3": 38, "4": 20, "5": 4, "6": 110}
LOST_IN_PRINT = {"2.14", "3.2", "6.97"}


def expand(text: str) -> list[str]:
    """Numbers in "(3.13)", "(3.29)-(3.32)", "(3.14a)-(3.14c)", each range written out."""
    found = []
    for first, last in RANGE.findall(text):
        chapter, start, a = re.fullmatch(r"(\w+)\.(\d+)([a-z]?)", first).groups()
        stop, b = re.fullmatch(r"\w+\.(\d+)([a-z]?)", last or first).groups()
        if a:
            found += [f"{chapter}.{start}{chr(letter)}" for letter in range(ord(a), ord(b or a) + 1)]
        else:
            found += [f"{chapter}.{number}" for number in range(int(start), int(stop) + 1)]
    return found


def named_equations(text: str) -> set[str]:
    return {number for found in NAMED.finditer(" ".join(text.split())) for number in expand(found[1])}


def table_rows(page: Path) -> Iterator[tuple[int, list[str], list[str]]]:
    """Line number, heads and cells of every row of every table."""
    heads: list[str] | None = None
    for number, line in lines_of(page):
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if not line.lstrip().startswith("|"):
            heads = None
        elif heads is None:
            heads = cells
        elif set(line) - set("|-: "):
            yield number, heads, cells


def equations() -> Iterator[Breach]:
    """One home an equation, which names it; every number of the print has a home or a reason for none."""
    homes: dict[str, str] = {}
    homeless: set[str] = set()
    documented = dict(documented_things())
    for number, heads, cells in table_rows(EQUATIONS):
        if heads == ["Equation", "What", "Why it has no home"]:
            homeless |= set(expand(cells[0]))
        elif heads == ["Equation", "What", "Home", "Checked by"]:
            path = cells[2].strip("`")
            thing = documented.get(path) or modules().get(path)
            message = named_equations(inspect.getdoc(thing) or "") if thing else set()
            for equation in expand(cells[0]):
                if equation in homes or equation not in message:
                    yield EQUATIONS, number, f"({equation}): two homes, or {path} does not name it"
                homes[equation] = path
            if not re.search(r"`(?:tests|reproduction)/\S+`", cells[3]):
                yield EQUATIONS, number, "no test"
    for path, thing in documented.items():
        for equation in named_equations((inspect.getdoc(thing) or "").split("\n\n")[0]):
            if homes.get(equation) != path:
                yield EQUATIONS, 1, f"{path} claims ({equation}), whose home is {homes.get(equation)}"
    printed = {f"{chapter}.{n}" for chapter, last in LAST_IN_PRINT.items() for n in range(1, last + 1)}
    known = {equation.rstrip("abcdefghijklmnopqrstuvwxyz") for equation in homes}
    for equation in sorted((known & homeless) | ((printed - LOST_IN_PRINT) - known - homeless)):
        yield EQUATIONS, 1, f"({equation}) needs either a home or a reason for none"


def documented_things() -> Iterator[tuple[str, object]]:
    """Functions, classes, methods and properties, the reproduction's too, by their dotted path."""
    beside = [one.name for one in pkgutil.iter_modules([str(ROOT / "reproduction")], "reproduction.")]
    names = [name for name in beside if not name.startswith(("reproduction.test_", "reproduction.__"))]
    for name, module in (modules() | {name: importlib.import_module(name) for name in names}).items():
        for key, thing in vars(module).items():
            thing = getattr(thing, "py_func", thing)  # a compiled kernel
            if not (inspect.isclass(thing) or inspect.isfunction(thing)):
                continue
            if thing.__module__ != name or thing.__name__ != key:
                continue
            yield f"{name}.{key}", thing
            for part, member in vars(thing).items() if inspect.isclass(thing) else ():
                member = getattr(member, "__func__", member)
                if inspect.isfunction(member) or isinstance(member, property | cached_property):
                    yield f"{name}.{key}.{part}", member


# --- what is packaged, and the pages that list it ---------------------------------------------------------


def packaging() -> Iterator[Breach]:
    """Every library imported is asked for; one version everywhere; what the README links to is shipped."""
    project, tool = PROJECT["project"], PROJECT["tool"]
    extras = project["optional-dependencies"]
    asked = [*project["dependencies"], *(one for extra in extras.values() for one in extra)]
    declared = {re.match(r"[\w.-]+", one)[0].replace("_", "-").lower() for one in asked}
    known = packages_distributions()
    for path in SOURCES:
        for node in imports_of(path):
            names = [one.name for one in node.names] if isinstance(node, ast.Import) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) and node.module else []
            for name in {one.partition(".")[0] for one in names} - sys.stdlib_module_names - {"cabledrive"}:
                if not {one.replace("_", "-").lower() for one in known.get(name, [name])} & declared:
                    yield path, node.lineno, f"{name} is in no dependency of pyproject.toml"
    cited = dict(re.findall(r"^(version|date-released): (.+)$", text_of(ROOT / "CITATION.cff"), re.M))
    newest = re.search(r"^## (\S+) - (\S+)$", text_of(ROOT / "CHANGELOG.md"), re.M)
    if (__version__, *newest.groups()) != (cited["version"], cited["version"], cited["date-released"]):
        yield ROOT / "CITATION.cff", 1, "version or date differ from the package or the newest changes"
    held = {*tool["hatch"]["build"]["targets"]["sdist"]["include"], "/LICENSE", "/README.md"}
    for number, line in lines_of(ROOT / "README.md"):
        for link in re.findall(r"\]\(([^)#:]+)\)", line):
            if "/" + link.split("/")[0] not in held or not (ROOT / link).exists():
                yield ROOT / "README.md", number, f"{link} is not there or not shipped"


def rooms() -> Iterator[Breach]:
    """The picture of the house has the rooms in the order of the import contract; symbols have names."""
    order = [one.strip("()") for one in reversed(PROJECT["tool"]["importlinter"]["contracts"][0]["layers"])]
    page = ROOT / "CONTRIBUTING.md"
    drawn = re.findall(r"^(\w+) +\S", re.search(r"```text\n(answers .*?)```", text_of(page), re.S)[1], re.M)
    if drawn != order:
        yield page, 1, f"the picture of the rooms is not {order}"
    parameters = importlib.import_module("cabledrive.parameters")
    for number, line in lines_of(DOCS / "machines.md"):
        for owner, name in re.findall(r"`([A-Z]\w+)\.(\w+)`", line):
            if not hasattr(getattr(parameters, owner, None), name):
                yield DOCS / "machines.md", number, f"no {owner}.{name}"


RULES = (
    *(foreign_addresses, sources, names_given_twice, tests, docstrings, hidden_modules),
    *(pages, figures, errata, equations, packaging, rooms),
)


if __name__ == "__main__":
    warnings.simplefilter("ignore", DeprecationWarning)  # old names are named where they are said to be old
    breaches = [breach for rule in RULES for breach in rule()]
    for place, at, words in breaches:
        print(f"{place.relative_to(ROOT)}:{at}: {words}")
    sys.exit(bool(breaches))
