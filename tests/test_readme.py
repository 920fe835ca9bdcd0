"""What the README shows is what the code gives."""

import contextlib
import io
import re
import subprocess
import sys
from pathlib import Path

import pytest

from command import call

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
PICTURE = ROOT / "docs" / "_static" / "elevator-modes.svg"
COMMANDS = re.findall(r"^\$ cabledrive (.+)\n((?:(?!\$|```).*\n)+)", README, re.M)


def words_of(picture: Path) -> list[str]:
    """The texts of a drawing; matplotlib writes each as a comment above its outlines."""
    return re.findall(r"<!-- (.*?) -->", picture.read_text(encoding="utf-8"))


def test_python_of_the_readme_prints_what_stands_below_it():
    code, shown = re.search(r"```python\n(.*?)```\n\n```text\n(.*?)```", README, re.S).groups()
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(code, {})
    assert printed.getvalue() == shown


def test_readme_shows_a_command_with_its_output():
    assert COMMANDS


@pytest.mark.parametrize(("arguments", "shown"), COMMANDS)
def test_command_of_the_readme_prints_what_stands_below_it(arguments, shown):
    assert call(*arguments.split()).stdout == shown


def test_picture_of_the_readme_is_what_the_code_draws(tmp_path):
    again = tmp_path / "again.svg"
    script = [sys.executable, ROOT / "docs" / "readme_picture.py", again]
    drawn = subprocess.run(script, cwd=tmp_path, capture_output=True, text=True)
    assert drawn.returncode == 0, drawn.stderr
    assert words_of(again) == words_of(PICTURE), (
        "draw it again: docs/readme_picture.py docs/_static/elevator-modes.svg"
    )
    assert "3.51452 Hz" in words_of(PICTURE)
