"""Reads docs/equations.md and the docstrings, and says where the two disagree.

An equation is known by its number: "3.13", "3.14a", "M.2". A docstring claims to be the home of an equation
by naming it in its summary, "Natural frequencies of a span, Eq. (3.13)."; further down it is only mentioned.
"""

import importlib
import inspect
import pkgutil
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

NUMBER = r"\(\s*((?:\d+|[A-Z])\.\d+[a-z]?)\s*\)"
RANGE = re.compile(rf"{NUMBER}(?:\s*(?:-|–|to)\s*{NUMBER})?")
NAMED = re.compile(rf"Eqs?\.\s+({NUMBER}(?:(?:\s*[-–,]\s*|\s*,?\s+(?:and|to)\s+){NUMBER})*)")
HEADER = ["Equation", "What", "Home", "Checked by"]
HOMELESS = ["Equation", "What", "Why it has no home"]


@dataclass(frozen=True)
class Row:
    """One line of the table: the equations, the dotted path of their home, the tests that check them."""

    equations: tuple[str, ...]
    home: str
    tests: tuple[str, ...]


def expand(text: str) -> tuple[str, ...]:
    """Numbers in "(3.13)", "(3.29)-(3.32)", "(3.14a), (3.20)", each range written out."""
    return tuple(number for first, last in RANGE.findall(text) for number in _between(first, last or first))


def _between(first: str, last: str) -> Iterator[str]:
    (chapter, i, a), (same, j, b) = (re.fullmatch(r"(\w+)\.(\d+)([a-z]?)", n).groups() for n in (first, last))
    if chapter != same or bool(a) != bool(b) or (a and i != j) or (int(i), a) > (int(j), b):
        raise ValueError(f"({first})-({last}) is not a range of equations")
    if a:
        yield from (f"{chapter}.{i}{chr(letter)}" for letter in range(ord(a), ord(b) + 1))
    else:
        yield from (f"{chapter}.{number}" for number in range(int(i), int(j) + 1))


def named(text: str) -> set[str]:
    """Equations that a docstring names after "Eq." or "Eqs."."""
    flat = " ".join(text.split())
    return {number for found in NAMED.finditer(flat) for number in expand(found[1])}


def rows(markdown: str) -> list[Row]:
    """Lines of every table with the four columns."""
    found, inside = [], False
    for line in markdown.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if cells == HEADER:
            inside = True
        elif not line.lstrip().startswith("|"):
            inside = False
        elif inside and not set(line) <= set("|-: "):
            found.append(_row(cells, line))
    return found


def without_home(markdown: str) -> list[tuple[str, str]]:
    """Number, without its letter, and reason of each equation in the table of those that need no home."""
    found, inside = [], False
    for line in markdown.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if cells == HOMELESS:
            inside = True
        elif not line.lstrip().startswith("|"):
            inside = False
        elif inside and not set(line) <= set("|-: "):
            found += [(number, cells[2] if len(cells) == 3 else "") for number in expand(cells[0])]
    return found


def numbered(counts: dict[str, int], lost: set[str]) -> set[str]:
    """Numbers of a print: so many in each chapter, but for those that its text does not hold."""
    every = {f"{chapter}.{number}" for chapter, last in counts.items() for number in range(1, last + 1)}
    return every - lost


def without_letter(number: str) -> str:
    """The number of an equation without the letter of its line."""
    return number.rstrip("abcdefghijklmnopqrstuvwxyz")


def _row(cells: list[str], line: str) -> Row:
    if len(cells) != len(HEADER):
        raise ValueError(f"{len(cells)} columns instead of {len(HEADER)}: {line}")
    equations, home, tests = expand(cells[0]), cells[2].strip("`"), re.findall(r"`([^`]+)`", cells[3])
    if not equations or not home or not tests:
        raise ValueError(f"an equation number, a home or a test in `backticks` is missing: {line}")
    return Row(equations, home, tuple(tests))


def resolve(path: str) -> object:
    """What a dotted path names: a function, a class, a property."""
    parts = path.split(".")
    for split in range(len(parts), 0, -1):
        name = ".".join(parts[:split])
        try:
            found = importlib.import_module(name)
        except ModuleNotFoundError as error:
            if error.name is None or not name.startswith(error.name):
                raise
            continue
        for attribute in parts[split:]:
            found = inspect.getattr_static(found, attribute)
        return found
    raise ModuleNotFoundError(path)


def claims(package: str) -> list[tuple[str, str]]:
    """Pairs of equation and dotted path, one for each equation that the summary of something names."""
    return [
        (equation, path)
        for module in _modules(package)
        for path, thing in _documented(module)
        for equation in sorted(named((inspect.getdoc(thing) or "").split("\n\n")[0]))
    ]


def _modules(package: str) -> Iterator[object]:
    root = importlib.import_module(package)
    yield root
    for found in pkgutil.walk_packages(root.__path__, prefix=f"{package}."):
        if not found.name.endswith("__main__"):
            yield importlib.import_module(found.name)


def _documented(module: object) -> Iterator[tuple[str, object]]:
    for name, thing in vars(module).items():
        if getattr(thing, "__module__", None) != module.__name__:
            continue
        thing = getattr(thing, "py_func", thing)  # a compiled kernel
        if inspect.isclass(thing):
            yield f"{module.__name__}.{name}", thing
            members = ((key, getattr(member, "__func__", member)) for key, member in vars(thing).items())
            kinds = (property, cached_property)
            yield from (
                (f"{module.__name__}.{name}.{key}", member)
                for key, member in members
                if inspect.isfunction(member) or isinstance(member, kinds)
            )
        elif inspect.isfunction(thing) and thing.__name__ == name:  # not the compiled one under another name
            yield f"{module.__name__}.{name}", thing


def disagreements(table: list[Row], claimed: list[tuple[str, str]], root: Path) -> list[str]:
    """Every way in which the table, the docstrings and the tests do not fit together."""
    found, homes = [], {}
    for row in table:
        found += [f"({n}) has two homes: {homes[n]} and {row.home}" for n in row.equations if n in homes]
        homes |= dict.fromkeys(row.equations, row.home)
        found += _home_faults(row) + [fault for test in row.tests for fault in _test_faults(test, root)]
    for number, path in claimed:
        if homes.get(number) != path:
            found.append(f"{path} claims ({number}); the table says {homes.get(number, 'nothing about it')}")
    return found


def _home_faults(row: Row) -> list[str]:
    try:
        home = resolve(row.home)
    except (ModuleNotFoundError, AttributeError):
        return [f"{row.home} does not exist"]
    message = named(inspect.getdoc(getattr(home, "py_func", home)) or "")
    return [
        f"the docstring of {row.home} does not name ({number})"
        for number in row.equations
        if number not in message
    ]


def _test_faults(test: str, root: Path) -> list[str]:
    file, _, name = test.partition("::")
    if not (root / file).is_file():
        return [f"{file} does not exist"]
    if name and f"def {name}(" not in (root / file).read_text():
        return [f"{file} has no {name}"]
    return []
