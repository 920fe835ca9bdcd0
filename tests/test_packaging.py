"""What is packaged: every library imported is asked for, one version everywhere, no page left behind."""

import ast
import re
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

from cabledrive.parameters.version import __version__

ROOT = Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
SOURCES = sorted((ROOT / "src").rglob("*.py"))
EXTRAS = ("control", "studio", "camera", "mcap", "test")
"""Extras whose libraries are imported where they are needed; sympy, of the tests, writes laws anew."""


def distribution(name):
    return re.sub(r"[-_.]+", "-", re.match(r"[\w.-]+", name)[0]).lower()


def imported_libraries():
    """First names of all that the package imports, but for itself and the standard library."""
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) and node.module else []
            yield from (name.partition(".")[0] for name in names)


def test_every_library_that_is_imported_is_asked_for():
    project, extras = PROJECT["project"], PROJECT["project"]["optional-dependencies"]
    asked = project["dependencies"] + [one for name in EXTRAS for one in extras[name]]
    known = packages_distributions()
    names = set(imported_libraries()) - {"cabledrive", "__future__"} - sys.stdlib_module_names
    assert len(names) > 10, names
    found = {name: {distribution(one) for one in known.get(name, [name])} for name in names}
    declared = {distribution(one) for one in asked}
    assert {name: whose for name, whose in found.items() if not whose & declared} == {}


def test_version_and_date_are_the_same_everywhere():
    cited = dict(re.findall(r"^(version|date-released): (.+)$", (ROOT / "CITATION.cff").read_text(), re.M))
    newest = re.search(r"^## (\S+) - (\S+)$", (ROOT / "CHANGELOG.md").read_text(), re.M)
    assert newest.groups() == (cited["version"], cited["date-released"])
    assert cited["version"] == __version__


def test_the_source_distribution_holds_what_the_readme_links_to():
    held = {*PROJECT["tool"]["hatch"]["build"]["targets"]["sdist"]["include"], "/LICENSE", "/README.md"}
    links = re.findall(r"\]\(([^)#:]+)\)", (ROOT / "README.md").read_text())
    assert links
    assert [link for link in links if "/" + link.split("/")[0] not in held] == []
