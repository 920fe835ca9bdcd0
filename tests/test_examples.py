"""Every script in examples/ runs as it stands and asserts a number that a reader can look up."""

import ast
import runpy
from pathlib import Path

import pytest

SCRIPTS = sorted((Path(__file__).resolve().parent.parent / "examples").glob("*.py"))
LONG = {"study_of_a_drive.py"}
"""Whole studies: run by ``make verify``."""


@pytest.mark.parametrize(
    "script",
    [pytest.param(one, id=one.name, marks=[pytest.mark.verify] * (one.name in LONG)) for one in SCRIPTS],
)
def test_example_runs_in_an_empty_folder(script, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(script.parent)
    runpy.run_path(str(script), run_name="__main__")


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.name)
def test_example_asserts_a_number(script):
    asserts = [node for node in ast.walk(ast.parse(script.read_text())) if isinstance(node, ast.Assert)]
    numbers = [
        node.value
        for statement in asserts
        for node in ast.walk(statement)
        if isinstance(node, ast.Constant) and type(node.value) in (int, float)
    ]
    assert numbers, f"{script.name} asserts no number"
