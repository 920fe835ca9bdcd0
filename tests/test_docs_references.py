"""Tests, benchmark cases, targets and commands that the documentation names are there.

Nothing is run: names are looked up, and the arguments of commands are read as the commands read them.
"""

import ast
import pkgutil
import re
import shlex
from functools import cache
from pathlib import Path

import click
import pytest

from cabledrive.app.main import main
from cabledrive.parameters import InputRefused
from named_tests import SPAN, named_tests

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])
SHOWN = re.compile(r"^\$ (.+?)(?:  +#.*)?$", re.M)
REFUSED_ON_PURPOSE = {"modes elevator --belo 20"}
"""Commands that a page shows with the line that refuses them."""


@cache
def functions_of(file):
    return {node.name for node in ast.parse(file.read_text()).body if isinstance(node, ast.FunctionDef)}


def unfound_tests(text):
    for file, function in named_tests(text):
        path = ROOT / file
        if not path.is_file() or (function and function not in functions_of(path)):
            yield f"{file}::{function}" if function else file


def unfound_cases(text):
    for names in re.findall(r"`python benchmarks/run\.py ([\w ]+)`", text):
        yield from (case for case in names.split() if not (ROOT / "benchmarks" / f"case_{case}.py").exists())


def unfound_targets(text):
    made = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(), re.M))
    commands = SPAN.findall(text) + SHOWN.findall(text)
    yield from (c for c in commands if (found := re.fullmatch(r"make (\w+)", c)) and found[1] not in made)


def unfound_names(text):
    """Dotted names of the package that lead nowhere."""
    for name in re.findall(r"`(cabledrive(?:\.\w+)+)`", text):
        try:
            pkgutil.resolve_name(name)
        except (ImportError, AttributeError):
            yield name


def named_commands(text):
    """Arguments of `cabledrive` that begin with the name of a command; those in brackets may be left out."""
    for command in SPAN.findall(text) + SHOWN.findall(text):
        if found := re.match(r"cabledrive ([a-z].*)", command):
            yield re.sub(r"[][]|\.{3}|<\w+>", "", found[1])


def unreadable_commands(text):
    for arguments in named_commands(text):
        name, *rest = shlex.split(arguments)
        command = main.get_command(click.Context(main), name)
        if command is None or (arguments not in REFUSED_ON_PURPOSE and not reads(command, rest)):
            yield arguments


def reads(command, arguments):
    """Whether a command knows the options and takes their values; a sentence may leave some out."""
    try:
        command.make_context("cabledrive", list(arguments))
    except click.MissingParameter:
        return True
    except (click.UsageError, InputRefused):
        return False
    return True


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
@pytest.mark.parametrize(
    "unfound", [unfound_tests, unfound_cases, unfound_targets, unfound_names, unreadable_commands]
)
def test_what_a_page_names_is_there(unfound, page):
    assert list(unfound(page.read_text(encoding="utf-8"))) == []


def test_the_page_on_validation_names_what_measures_its_figures():
    text = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
    assert len(list(named_tests(text))) > 100
    assert len(list(named_commands(text))) > 10


@pytest.mark.parametrize(
    ("unfound", "text"),
    [
        (unfound_tests, "`tests/test_nowhere.py`"),
        (unfound_tests, "`tests/test_docs.py::test_of_nothing`"),
        (unfound_tests, "`tests/test_docs.py` unless another test is named\n\n| a | `::test_of_nothing` |"),
        (unfound_cases, "`python benchmarks/run.py chain nothing`"),
        (unfound_targets, "`make nothing`"),
        (unfound_names, "`cabledrive.rig.nothing`"),
        (unreadable_commands, "`cabledrive nothing`"),
        (unreadable_commands, "`cabledrive modes elevator --belo 20 --json`"),
        (unreadable_commands, "`cabledrive track dissertation-3 --gains nothing`"),
    ],
)
def test_what_is_not_there_is_found(unfound, text):
    assert len(list(unfound(text))) == 1
