"""Each test named on the page on validation notes what it measures, and `make verify` prints it again."""

import ast
from functools import cache
from pathlib import Path

from named_tests import named_tests

ROOT = Path(__file__).resolve().parent.parent


@cache
def noting_tests(file):
    """Tests of a file that take the fixture `measured`."""
    functions = (node for node in ast.parse(file.read_text()).body if isinstance(node, ast.FunctionDef))
    return {one.name for one in functions if "measured" in {argument.arg for argument in one.args.args}}


def silent_tests(text):
    for file, function in named_tests(text):
        noting = noting_tests(ROOT / file)
        if not noting or (function and function not in noting):
            yield f"{file}::{function}" if function else file


def test_every_named_test_notes_its_figure():
    assert sorted(set(silent_tests((ROOT / "docs" / "validation.md").read_text(encoding="utf-8")))) == []


def test_a_test_that_notes_nothing_is_found():
    silent = "`tests/test_docs_figures.py::test_a_test_that_notes_nothing_is_found`"
    assert len(list(silent_tests(silent))) == 1
