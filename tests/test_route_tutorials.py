"""The tutorials of machines with routes run as they are written, from an empty folder."""

import re
import shlex
from pathlib import Path

import pytest

from command import call

DOCS = Path(__file__).resolve().parent.parent / "docs"
STEP = re.compile(r"^\$ cabledrive (?P<line>[^\n]+)$|^```python\n(?P<block>.*?)^```", re.M | re.S)


@pytest.mark.verify
@pytest.mark.parametrize("name", ["tutorial_printer", "tutorial_lift", "tutorial_tendon_arm"])
def test_the_tutorial_runs_from_an_empty_folder(name, tmp_path, monkeypatch):
    """Commands and Python in the order of the page; its assertions are those of the blocks."""
    monkeypatch.chdir(tmp_path)
    names, steps = {}, 0
    for step in STEP.finditer((DOCS / f"{name}.md").read_text()):
        steps += 1
        if step["line"]:
            done = call(*shlex.split(step["line"]))
            assert done.exit_code == 0, f"{step['line']}: {done.stderr}"
        else:
            exec(step["block"], names)
    assert steps >= 6
