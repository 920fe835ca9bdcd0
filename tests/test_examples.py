"""Every script in examples/ runs on its own and asserts a number that a reader can look up."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPTS = sorted((Path(__file__).resolve().parent.parent / "examples").glob("*.py"))


def test_there_are_examples():
    assert SCRIPTS, "examples/ holds no script"


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.name)
def test_example_runs_in_an_empty_folder(script: Path, tmp_path: Path):
    environment = os.environ | {"MPLBACKEND": "Agg"}
    command = [sys.executable, "-W", "error::RuntimeWarning", str(script)]
    run = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, f"{script.name} ended with {run.returncode}:\n{run.stdout}{run.stderr}"


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.name)
def test_example_asserts_a_number(script: Path):
    asserts = [node for node in ast.walk(ast.parse(script.read_text())) if isinstance(node, ast.Assert)]
    numbers = [
        node.value
        for statement in asserts
        for node in ast.walk(statement)
        if isinstance(node, ast.Constant) and type(node.value) in (int, float)
    ]
    assert numbers, f"{script.name} asserts no number"
